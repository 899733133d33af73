//! Some layers of the source.

use isoray_grid::{Dims, Scalar};

/// Consecutive layers.
#[derive(Clone, Copy)]
pub(super) struct Layers<'a, T> {
    pub(super) dims: Dims,
    /// Index of the first.
    pub(super) first: usize,
    pub(super) samples: &'a [T],
}

impl<T: Scalar> Layers<'_, T> {
    /// The `length` samples from lattice point `at` on, along x.
    pub(super) fn row(&self, [x, y, z]: [usize; 3], length: usize) -> &[T] {
        let nx = self.dims.axes()[0] as usize;
        &self.samples[(z - self.first) * self.dims.layer() + y * nx + x..][..length]
    }
}
