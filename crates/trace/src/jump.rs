//! Crossings between two cells that see their common face in different arithmetic.
//!
//! Where cells of different levels of detail meet, both give the same values on the common face but for rounding, so that the field can be inside at the end of the one and
//! outside at the beginning of the other. That is a crossing at the face. If all corners of one cell are on one side, so are the values on its face, however rounded, and the other cell
//! has corners on both: so all such crossings are found by looking beyond the cells that are visited anyway. Of two that are, the earlier one tells.

use isoray_cell::Cubic;

use crate::content::Beyond;
use crate::hit::{Candidate, Hit};

/// The crossings before and behind the stretch.
#[cold]
pub(crate) fn jumps(candidate: &Candidate, beyond: &[Option<Beyond>; 2], isovalue: f32) -> [Option<Hit>; 2] {
    let cubic = Cubic::along(&candidate.corners, &candidate.segment);
    let [before, behind] = beyond;
    let enters = |from: bool, to: bool| (from != to).then_some(to);
    let before = before.filter(|before| !before.is_mixed(isovalue));
    let before = before.and_then(|before| enters(before.sides(isovalue)[1], cubic.starts_inside()));
    let behind = behind.and_then(|behind| enters(cubic.ends_inside(), behind.sides(isovalue)[0]));
    let hit = |is_entering: bool, at: usize| Hit {
        t: candidate.interval[at] as f32,
        level: candidate.level,
        cell: candidate.cell,
        local: [candidate.segment.entry, candidate.segment.exit][at],
        corners: candidate.corners,
        is_entering,
    };
    [before.map(|is_entering| hit(is_entering, 0)), behind.map(|is_entering| hit(is_entering, 1))]
}
