//! Boxes of whole cells, and the levels that they make.

use std::fmt;
use std::path::Path;

use crate::error::ReadError;

/// How far, relative to their size, two statements of a length may differ: both may be printed with six digits, each off by
/// 5 in 10⁶ at most.
pub(super) const PRINTED: f64 = 1e-5;
/// Largest coordinate of a cell, of either sign; no sum or difference of two leaves 32 bits.
const MOST_INDEX: i32 = 1 << 30;
/// Most levels; cells of level 30 cannot be counted with [`MOST_INDEX`].
pub(crate) const MOST_LEVELS: usize = 30;

/// A box of cells of one level; both corners belong to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct IndexBox {
    low: [i32; 3],
    high: [i32; 3],
}

impl IndexBox {
    /// `None` if it is empty or has coordinates beyond [`MOST_INDEX`].
    pub(crate) fn new(low: [i64; 3], high: [i64; 3]) -> Option<Self> {
        let small = |c: [i64; 3]| c.iter().all(|c| c.unsigned_abs() <= u64::from(MOST_INDEX.unsigned_abs()));
        let filled = (0..3).all(|i| low[i] <= high[i]);
        (small(low) && small(high) && filled)
            .then(|| Self { low: low.map(|c| c as i32), high: high.map(|c| c as i32) })
    }

    /// The lowest cell.
    pub(crate) fn low(&self) -> [i32; 3] {
        self.low
    }

    /// Cells along each axis.
    pub(crate) fn size(&self) -> [u32; 3] {
        [0, 1, 2].map(|i| (self.high[i] - self.low[i]) as u32 + 1)
    }

    pub(crate) fn cells(&self) -> u64 {
        let [x, y, z] = self.size().map(u128::from);
        u64::try_from(x * y * z).unwrap_or(u64::MAX)
    }

    pub(crate) fn contains(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.low[i] && other.high[i] <= self.high[i])
    }

    /// The same box in cells whose edges are shorter by `ratio`.
    pub(crate) fn refine(&self, ratio: u32) -> Option<Self> {
        let ratio = i64::from(ratio);
        Self::new(self.low.map(|c| i64::from(c) * ratio), self.high.map(|c| (i64::from(c) + 1) * ratio - 1))
    }

    /// The smallest box that holds both.
    pub(crate) fn union(self, other: &Self) -> Self {
        let low = [0, 1, 2].map(|i| self.low[i].min(other.low[i]));
        let high = [0, 1, 2].map(|i| self.high[i].max(other.high[i]));
        Self { low, high }
    }
}

impl fmt::Display for IndexBox {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([a, b, c], [x, y, z]) = (self.low, self.high);
        write!(f, "({a},{b},{c}) to ({x},{y},{z})")
    }
}

/// Checks that a level is refined by a ratio that meshes can have.
pub(crate) fn check_ratio(path: &Path, level: usize, found: &[f64]) -> Result<u32, ReadError> {
    match found {
        [first, rest @ ..] if (*first == 2.0 || *first == 4.0) && rest.iter().all(|r| r == first) => {
            Ok(*first as u32)
        }
        _ => {
            let what = format!("refinement ratio of level {level}");
            let shown: Vec<_> = found.iter().map(ToString::to_string).collect();
            Err(ReadError::mesh(path, what, "2 or 4, the same along each axis", shown.join(",")))
        }
    }
}

/// Checks that box `number` of `level` lies in the domain of that level.
pub(crate) fn check_inside(
    path: &Path,
    level: usize,
    number: usize,
    cells: &IndexBox,
    domain: &IndexBox,
) -> Result<(), ReadError> {
    if domain.contains(cells) {
        return Ok(());
    }
    let what = format!("level {level}, box {number}");
    Err(ReadError::mesh(path, what, format!("cells within the domain, {domain}"), cells))
}
