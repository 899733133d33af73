//! Where a block lies in its domain.

use isoray_grid::Dims;

use super::detail::Detail;
use super::resolve::{BLOCK_EDGE, BLOCK_SAMPLES, each_sample};
use crate::geometry::{CAP_EDGE, CAP_SAMPLES};

/// Where a block is, and what is around it.
pub(super) struct Frame {
    pub(super) level: u32,
    pub(super) corner: [u32; 3],
    pub(super) last: [u32; 3],
    /// By axis: the index from which on samples are beyond the last place of the lattice within it, if there are such.
    pub(super) beyond: [Option<usize>; 3],
    pub(super) short: u64,
}

/// By direction: the level of the cells next to the block there; none outside the domain.
pub(super) type Levels = [Option<u32>; 27];

impl Frame {
    pub(super) fn new(dims: Dims, level: u32, corner: [u32; 3]) -> Self {
        let last = dims.axes().map(|n| n - 1);
        let beyond = [0, 1, 2].map(|a| {
            let whole = (last[a] >> level).saturating_sub(corner[a]) as usize + 1;
            (whole < BLOCK_EDGE).then_some(whole)
        });
        let mut short = 0;
        if beyond != [None; 3] {
            for n in 0..CAP_SAMPLES {
                let is_short = |a: usize| beyond[a] == Some((n >> (2 * a) & 3) + 1);
                short |= u64::from((0..3).any(is_short)) << n;
            }
        }
        Self { level, corner, last, beyond, short }
    }

    /// The sample's place on the finest lattice; beyond the last, that one's.
    pub(super) fn place(&self, index: [usize; 3]) -> [u32; 3] {
        std::array::from_fn(|a| {
            let c = (u64::from(self.corner[a]) + index[a] as u64) << self.level;
            c.min(self.last[a].into()) as u32
        })
    }

    /// Puts in what is `at` the last place along an axis.
    pub(super) fn take_border(&self, at: impl Fn([u32; 3]) -> f32, samples: &mut [f32; BLOCK_SAMPLES]) {
        if self.beyond == [None; 3] {
            return;
        }
        each_sample(|n, index| {
            if (0..3).any(|a| self.beyond[a].is_some_and(|beyond| index[a] >= beyond)) {
                samples[n] = at(self.place(index));
            }
        });
    }

    /// Makes the last cells whole.
    pub(super) fn extend(&self, samples: &mut [f32; BLOCK_SAMPLES]) {
        for a in 0..3 {
            let Some(beyond) = self.beyond[a] else { continue };
            let before = (self.corner[a] + beyond as u32 - 1) << self.level;
            let length = f64::from(self.last[a].saturating_sub(before)) / (1u64 << self.level) as f64;
            if length <= 0.0 {
                continue;
            }
            let stride = BLOCK_EDGE.pow(a as u32);
            each_sample(|n, index| {
                if index[a] == beyond {
                    let from = f64::from(samples[n - stride]);
                    samples[n] = (from + (f64::from(samples[n]) - from) / length) as f32;
                }
            });
        }
    }

    pub(super) fn levels_around(&self, detail: &Detail) -> Levels {
        std::array::from_fn(|n| self.cell_towards(n).map(|cell| detail.level(cell)))
    }

    /// The lowest cell of the finest lattice in the cube of the block's size next to it, in a direction.
    pub(super) fn cell_towards(&self, n: usize) -> Option<[u32; 3]> {
        let step = [n % 3, n / 3 % 3, n / 9];
        let mut cell = [0; 3];
        for a in 0..3 {
            let at = i64::from(self.corner[a]) + i64::from(CAP_EDGE) * (step[a] as i64 - 1);
            cell[a] = u32::try_from(at << self.level).ok()?;
            if cell[a] >= self.last[a] {
                return None;
            }
        }
        Some(cell)
    }

    /// The number of the sample at `p`, on the lattice and in the block.
    pub(super) fn number(&self, p: [u32; 3]) -> usize {
        // Only the last place need not be a multiple of the step.
        let along = |a: usize| p[a].div_ceil(1 << self.level) as usize - self.corner[a] as usize;
        along(0) + BLOCK_EDGE * (along(1) + BLOCK_EDGE * along(2))
    }
}
