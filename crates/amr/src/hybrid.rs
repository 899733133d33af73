//! Cells that finer ones touch (Marchesin and Colin de Verdière 2009, section 3.3; by another rule, which is continuous).

use crate::block::Block;
use crate::bricks::{OfBlock, corners_at};
use crate::cuboid::Cuboid;
use crate::vertices::owned;
use crate::visit::BrickAt;

/// A cell that is taken apart into eight, in each of which the field is trilinear, or which are taken apart again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Split {
    /// At the corners of the parts, 3³, x fastest.
    pub(crate) values: [f32; 27],
    /// The parts that are taken apart, one bit each.
    pub(crate) split: u8,
    /// Where the first of them is among all splits; the others follow it.
    pub(crate) first: u32,
}

/// The middles of edges: the numbers among 3³ of each and of its ends.
const EDGES: [[usize; 3]; 12] = {
    let mut edges = [[0; 3]; 12];
    let (mut n, mut count) = (0, 0);
    while n < 27 {
        let (at, strides) = ([n % 3, n / 3 % 3, n / 9], [1, 3, 9]);
        let mut axis = 0;
        while axis < 3 {
            if at[axis] == 1 && at[(axis + 1) % 3] != 1 && at[(axis + 2) % 3] != 1 {
                edges[count] = [n, n - strides[axis], n + strides[axis]];
                count += 1;
            }
            axis += 1;
        }
        n += 1;
    }
    edges
};

/// The middles of faces.
const FACES: [usize; 6] = [4, 10, 12, 14, 16, 22];

/// That of the cell.
const CENTER: usize = 13;

/// How many of the coordinates of point `n` of 3³ are in the middle.
fn middles(n: usize) -> usize {
    [n % 3, n / 3 % 3, n / 9].iter().filter(|&&c| c == 1).count()
}

/// The points of 3³ around that in the middle of a face, with how many coordinates each has in the middle, x fastest.
fn on_face(face: usize) -> impl Iterator<Item = (usize, usize)> {
    let of = |n: usize| [n % 3, n / 3 % 3, n / 9];
    let center = of(face);
    let is_on = move |n: &usize| (0..3).all(|a| center[a] == 1 || of(*n)[a] == center[a]);
    (0..27).filter(is_on).map(|n| (n, middles(n)))
}

/// From one corner of a part to the next along y and z, among 3³.
pub(crate) const PART_STRIDES: [u32; 2] = [3, 9];

/// The first corner of part `octant` among 3³.
#[inline(always)]
pub(crate) fn part_corner(octant: u32) -> usize {
    ((octant & 1) + 3 * (octant >> 1 & 1) + 9 * (octant >> 2)) as usize
}

/// The corners of part `octant` of a cell, x fastest.
pub(crate) fn part_corners(values: &[f32; 27], octant: u32) -> [f32; 8] {
    corners_at(values, part_corner(octant), PART_STRIDES.map(|stride| stride as usize))
}

impl Split {
    /// That of a cell, the edge of which is `1 << exponent`, with these values at its corners; `None` unless a finer leaf that is not empty touches it, be it with an
    /// edge only, but not with a vertex. `finer` are the blocks of such leaves that touch the cell, and `splits` takes those of its parts.
    ///
    /// Owned points have the value of the finest leaf whose corner they are. Others: the middle of an edge has the mean of its ends; that of a face, from the middles m
    /// of its edges and its corners c, Σm/2 − Σc/4, but no more and no less than all of these; that of the cell, from the middles f of its faces, those of its edges and
    /// its corners, Σf/2 − Σm/4 + Σc/8, likewise. Both are what Coons's patches have there: so faces of two cells agree, and linear fields are exact.
    pub(crate) fn new(
        of: &OfBlock<'_>,
        (low, exponent): ([u32; 3], u32),
        corners: &[f32; 8],
        finer: &[Block],
        splits: &mut Vec<Self>,
    ) -> Option<Self> {
        let half = exponent.checked_sub(1)?;
        let point = |n: usize| -> [u32; 3] {
            let at = [n % 3, n / 3 % 3, n / 9];
            std::array::from_fn(|a| low[a] + ((at[a] as u32) << half))
        };
        let is_touched = |n: usize| {
            let point = Cuboid { low: point(n), high: point(n) };
            finer.iter().any(|block| block.place.touches(&point))
        };
        // What is finer fills cubes of this size, so that it is at the middle of an edge.
        if !EDGES.iter().any(|&[n, ..]| is_touched(n)) {
            return None;
        }
        let mut is_owned = false;
        let mut value = |n: usize| {
            let value = is_touched(n).then(|| owned(of.skeleton, of.values, of.empty, point(n))).flatten();
            is_owned |= value.is_some();
            value
        };
        let mut values = [0.0; 27];
        for (n, &corner) in corners.iter().enumerate() {
            values[2 * (n & 1) + 6 * (n >> 1 & 1) + 18 * (n >> 2)] = corner;
        }
        for [n, begin, end] in EDGES {
            let mean = || (0.5 * (f64::from(values[begin]) + f64::from(values[end]))) as f32;
            values[n] = value(n).unwrap_or_else(mean);
        }
        for face in FACES {
            values[face] = value(face).unwrap_or_else(|| {
                let around = on_face(face).filter(|&(n, _)| n != face);
                blend(around.map(|(n, middles)| (values[n], [-0.25, 0.5][middles])))
            });
        }
        let around = (0..27).filter(|&n| n != CENTER);
        values[CENTER] = blend(around.map(|n| (values[n], [0.125, -0.25, 0.5][middles(n)])));
        let mut parts = Vec::new();
        let mut split = 0;
        for octant in 0..8 {
            let low: [u32; 3] = std::array::from_fn(|a| low[a] + ((octant >> a & 1) << half));
            let place = Cuboid { low, high: low.map(|c| c + (1 << half)) };
            let finer = finer.iter().filter(|other| other.exponent < half && other.place.touches(&place));
            let finer: Vec<_> = finer.copied().collect();
            let corners = part_corners(&values, octant);
            if let Some(part) = Self::new(of, (low, half), &corners, &finer, splits) {
                split |= 1 << octant;
                parts.push(part);
            }
        }
        if !is_owned && parts.is_empty() {
            return None;
        }
        let first = splits.len() as u32;
        splits.append(&mut parts);
        Some(Self { values, split, first })
    }

    /// Those of a brick, with the offsets of their cells.
    pub(crate) fn of_brick<'m>(at: &BrickAt<'m>) -> impl Iterator<Item = (u32, &'m Self)> {
        let (brick, splits) = (at.brick(), &at.mesh.bricks.splits);
        let cells = (0..64).filter(move |offset| brick.split >> offset & 1 == 1);
        cells.zip(&splits[brick.first as usize..])
    }

    /// Whether `is` any of the values at the corners of its parts, or of theirs.
    pub(crate) fn any(&self, splits: &[Self], is: &impl Fn(&[f32]) -> bool) -> bool {
        is(&self.values)
            || (0..8).filter_map(|octant| self.part(octant, splits)).any(|part| part.any(splits, is))
    }

    /// The split of part `octant`, among all `splits`, if it is taken apart.
    pub(crate) fn part<'s>(&self, octant: u32, splits: &'s [Self]) -> Option<&'s Self> {
        let before = self.split & ((1u16 << octant) - 1) as u8;
        (self.split >> octant & 1 == 1).then(|| &splits[self.first as usize + before.count_ones() as usize])
    }
}

/// The sum of values by their weights, within their range.
fn blend(weighted: impl Iterator<Item = (f32, f64)>) -> f32 {
    let (mut sum, mut least, mut largest) = (0.0, f32::INFINITY, f32::NEG_INFINITY);
    for (value, weight) in weighted {
        sum += weight * f64::from(value);
        least = least.min(value);
        largest = largest.max(value);
    }
    // Also if one is not a number.
    let sum = sum as f32;
    if sum < least {
        least
    } else if sum > largest {
        largest
    } else {
        sum
    }
}
