//! First roots in cells.

use std::hint::black_box;

use isoray_cell::root::{BernsteinSeries, FirstRoot};
use isoray_cell::{Mask, Real, Segment};

use super::Answer;
use crate::cells::{Pair, packed, random};

/// Corners and stretches of rays, in lanes of `R`.
#[derive(Clone, Debug)]
pub struct Roots<R: Real<Scalar = f32>> {
    cells: Vec<([R; 8], Segment<R>)>,
}

impl<R: Real<Scalar = f32>> Roots<R> {
    /// Cells; a multiple of all numbers of lanes.
    pub const CELLS: usize = 1 << 14;

    /// Random ones: the same cells in lanes of any number.
    pub fn generate() -> Self {
        Self::of(&random(Self::CELLS, 1))
    }

    /// Those of pairs. What does not fill the lanes is dropped.
    pub fn of(pairs: &[Pair]) -> Self {
        Self { cells: packed(pairs) }
    }

    /// Finds them by [`BernsteinSeries`], which all else uses.
    #[inline(never)]
    pub fn find(&self) -> Answer {
        self.by::<BernsteinSeries>()
    }

    /// The same by any method.
    #[inline(never)]
    pub fn find_by<F: FirstRoot>(&self) -> Answer {
        self.by::<F>()
    }

    #[inline(always)]
    fn by<F: FirstRoot>(&self) -> Answer {
        Answer::of(black_box(&self.cells).iter().flat_map(|(corners, segment)| {
            let root = F::first_root(corners, segment);
            let found = root.found.bits();
            (0..R::LANES).filter(move |n| found >> n & 1 == 1).map(move |n| f64::from(root.s.lane(n)))
        }))
    }
}
