//! First roots in cells.

use std::hint::black_box;

use isoray_cell::root::{BernsteinSeries, FirstRoot};
use isoray_cell::{Mask, Real, Segment};

use super::Answer;
use crate::cells::{packed, random};

/// Random corners and stretches of rays, in lanes of `R`.
#[derive(Clone, Debug)]
pub struct Roots<R: Real<Scalar = f32>> {
    cells: Vec<([R; 8], Segment<R>)>,
}

impl<R: Real<Scalar = f32>> Roots<R> {
    /// Cells; a multiple of all numbers of lanes.
    pub const CELLS: usize = 1 << 14;

    /// The same cells in lanes of any number.
    pub fn generate() -> Self {
        Self { cells: packed(&random(Self::CELLS, 1)) }
    }

    /// Finds them by [`BernsteinSeries`], which all else uses.
    #[inline(never)]
    pub fn find(&self) -> Answer {
        Answer::of(black_box(&self.cells).iter().flat_map(|(corners, segment)| {
            let root = BernsteinSeries::first_root(corners, segment);
            let found = root.found.bits();
            (0..R::LANES).filter(move |n| found >> n & 1 == 1).map(move |n| f64::from(root.s.lane(n)))
        }))
    }
}
