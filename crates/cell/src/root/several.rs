//! All crossings in a cell, of one isovalue or several.

use super::bernstein_series::{root_by_series, start_in_part, start_of_whole};
use super::sign_count::{is_number, sign_changes};
use super::split::ends_of_pieces;
use super::{Piece, Polynomial};
use crate::{Cubic, Segment, relative};

/// The crossings of one cubic, ascending: a slice of up to three numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Roots {
    roots: [f32; 3],
    count: usize,
}

impl Roots {
    /// At most three.
    pub(crate) fn new(ascending: &[f32]) -> Self {
        let mut all = Self::default();
        for &root in ascending.iter().take(3) {
            all.roots[all.count] = root;
            all.count += 1;
        }
        all
    }
}

impl std::ops::Deref for Roots {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.roots[..self.count]
    }
}

/// A crossing of one of several isovalues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Where on the segment.
    pub s: f32,
    /// Which of the isovalues.
    pub surface: usize,
    /// From outside (below the isovalue) to inside.
    pub is_entering: bool,
}

/// The crossings of all monotone pieces.
pub(crate) fn all_roots(cubic: &Cubic) -> Roots {
    let changes = sign_changes(cubic);
    let mut found = Roots::default();
    let mut add = |piece, start| {
        if let Some(s) = root_by_series(cubic, piece, start).get() {
            found.roots[found.count] = s;
            found.count += 1;
        }
    };
    match changes.iter().filter(|&&change| change).count() {
        _ if !is_number(cubic) => {}
        0 => {}
        1 => add(Piece::whole(cubic.ends(), true), start_of_whole(cubic, changes)),
        _ => {
            let ends = [0, 1, 2, 3].map(ends_of_pieces(cubic));
            for ends in ends.windows(2) {
                let piece = Piece::between(ends[0], ends[1]);
                if piece.found {
                    add(piece, start_in_part(&piece));
                }
            }
        }
    }
    found
}

/// All crossings of several isovalues on a segment, in order along it, in a cell with these samples; replaces what `into` holds.
///
/// Each isovalue's are what [`Cubic::roots`] gives for it alone, bit for bit. At one parameter, surfaces keep the order that the field
/// passes them in.
pub fn crossings(samples: &[f32; 8], isovalues: &[f32], segment: &Segment, into: &mut Vec<Crossing>) {
    into.clear();
    for (surface, &isovalue) in isovalues.iter().enumerate() {
        let cubic = Cubic::along(&relative(samples, isovalue), segment);
        let mut is_entering = !cubic.starts_inside();
        for &s in cubic.roots().iter() {
            into.push(Crossing { s, surface, is_entering });
            is_entering = !is_entering;
        }
    }
    into.sort_by(|a, b| {
        let rising = isovalues[a.surface].total_cmp(&isovalues[b.surface]);
        let passed = if a.is_entering { rising } else { rising.reverse() };
        a.s.total_cmp(&b.s).then(passed)
    });
}
