//! Central-difference gradients.

use isoray_cell::{central_gradients, corner_gradients, interpolate_gradients};
use isoray_grid::{STENCIL, Samples, Scalar, Stencil};

use crate::hit::Hit;

/// A cell, and its level.
type Key = ([u32; 3], u32);

/// The central differences at the corners of cells, kept for the next hit: of rays through neighbouring pixels many hit the same cell.
#[derive(Clone, Debug, Default)]
pub struct CornerGradients {
    /// Direct-mapped; none until the first is asked for.
    known: Vec<(Key, [[f32; 3]; 8])>,
}

impl CornerGradients {
    /// Cells that are remembered, those of a window of 8 by 8 by 4: 28 KB.
    const SLOTS: usize = 256;
    /// No cell is at such a level.
    const NOTHING: (Key, [[f32; 3]; 8]) = (([0; 3], u32::MAX), [[0.0; 3]; 8]);

    /// The gradient at a hit, for which `stencil` gives the samples around its cell.
    pub fn at(&mut self, hit: &Hit, stencil: impl FnOnce() -> Stencil<f32>) -> [f32; 3] {
        if self.known.is_empty() {
            self.known.resize(Self::SLOTS, Self::NOTHING);
        }
        let key = (hit.cell, hit.level);
        let [x, y, z] = hit.cell.map(|c| (c >> hit.level) as usize);
        let slot = (x & 7 | (y & 7) << 3 | (z & 3) << 6) % self.known.len();
        let known = &mut self.known[slot];
        if known.0 != key {
            *known = (key, gradients_of(&stencil()));
        }
        interpolate_gradients(&known.1, hit.local)
    }

    /// The gradient at a hit on the lattice itself.
    pub(crate) fn of(&mut self, samples: &impl Samples, hit: &Hit) -> [f32; 3] {
        self.at(hit, || as_f32(&samples.stencil(hit.cell)))
    }
}

fn as_f32<T: Scalar>(stencil: &Stencil<T>) -> Stencil<f32> {
    Stencil { samples: stencil.samples.map(T::to_f32), exists: stencil.exists }
}

/// At the corners. Samples that are not finite do not count.
fn gradients_of(Stencil { samples, exists }: &Stencil<f32>) -> [[f32; 3]; 8] {
    let is_there = |n: usize| exists >> n & 1 == 1 && samples[n].is_finite();
    let exists: [bool; 64] = std::array::from_fn(is_there);
    let are_all_there = (0..64).fold(true, |all, n| all & (exists[n] | (STENCIL >> n & 1 == 0)));
    if are_all_there {
        return central_gradients(samples);
    }
    corner_gradients(&std::array::from_fn(|n| if exists[n] { samples[n] } else { 0.0 }), &exists)
}

/// The gradient at a hit, interpolated between central differences at the cell's corners, per unit of index space
/// (*central* normals): continuous across cells, where the forward gradient jumps.
///
/// At the border of the domain, and beside samples that are not finite, differences are one-sided of second order.
pub fn central_gradient(samples: &impl Samples, hit: &Hit) -> [f32; 3] {
    interpolate_gradients(&gradients_of(&as_f32(&samples.stencil(hit.cell))), hit.local)
}
