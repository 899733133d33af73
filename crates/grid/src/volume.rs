//! Borrowed dense arrays.

use std::convert::Infallible;

use crate::{Dims, RowSource, Samples, Scalar, SlabSource};

/// A dense volume borrowed from the caller, `i` (x) fastest.
#[derive(Clone, Copy, Debug)]
pub struct DenseVolume<'a, T> {
    dims: Dims,
    samples: &'a [T],
}

/// An array whose length is not that of its lattice.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an array of {found} samples for a {dims} volume: expected {expected}")]
pub struct LengthError {
    dims: Dims,
    expected: usize,
    found: usize,
}

impl<'a, T: Scalar> DenseVolume<'a, T> {
    /// Borrows `samples` as a volume of size `dims`.
    ///
    /// # Errors
    /// A slice that does not hold exactly `dims.samples()` samples.
    pub fn new(dims: Dims, samples: &'a [T]) -> Result<Self, LengthError> {
        if samples.len() == dims.samples() {
            Ok(Self { dims, samples })
        } else {
            Err(LengthError { dims, expected: dims.samples(), found: samples.len() })
        }
    }

    /// Size of the lattice.
    pub fn dims(&self) -> Dims {
        self.dims
    }

    /// All samples, `i` fastest.
    pub fn samples(&self) -> &'a [T] {
        self.samples
    }

    /// The sample at lattice point `p`, which must be inside.
    pub fn sample(&self, p: [u32; 3]) -> T {
        self.samples[self.dims.linear(p)]
    }
}

impl<T: Scalar> SlabSource<T> for DenseVolume<'_, T> {
    type Error = Infallible;

    fn dims(&self) -> Dims {
        self.dims
    }

    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), Infallible> {
        let start = first as usize * self.dims.layer();
        out.copy_from_slice(&self.samples[start..start + out.len()]);
        Ok(())
    }

    fn rows(&self) -> Option<&dyn RowSource<T, Error = Infallible>> {
        Some(self)
    }
}

impl<T: Scalar> RowSource<T> for DenseVolume<'_, T> {
    type Error = Infallible;

    fn read_rows(&self, layer: u32, first: u32, out: &mut [T]) -> Result<(), Infallible> {
        let start = self.dims.linear([0, first, layer]);
        out.copy_from_slice(&self.samples[start..start + out.len()]);
        Ok(())
    }
}

impl<T: Scalar> Samples for DenseVolume<'_, T> {
    type Sample = T;

    fn dims(&self) -> Dims {
        self.dims
    }

    #[inline(always)]
    fn sample(&self, p: [u32; 3]) -> T {
        DenseVolume::sample(self, p)
    }

    #[inline(always)]
    fn corners(&self, cell: [u32; 3]) -> [T; 8] {
        let nx = self.dims.axes()[0] as usize;
        let low = self.dims.linear(cell);
        // Two neighbours along x in each of four rows.
        let rows = [low, low + nx, low + self.dims.layer(), low + self.dims.layer() + nx];
        let rows = rows.map(|row| [self.samples[row], self.samples[row + 1]]);
        std::array::from_fn(|n| rows[n / 2][n % 2])
    }

    fn read_rows(&self, layer: u32, first: u32, out: &mut [T]) {
        let start = self.dims.linear([0, first, layer]);
        out.copy_from_slice(&self.samples[start..start + out.len()]);
    }
}
