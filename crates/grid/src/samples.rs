//! Samples in any order.

use crate::{Dims, Scalar};

/// A lattice of samples that is read at any point: an array, bricks, or a compressed volume.
pub trait Samples: Sync {
    /// Type of a sample.
    type Sample: Scalar;

    /// Size of the lattice.
    fn dims(&self) -> Dims;

    /// The sample at lattice point `p`, which must be inside.
    fn sample(&self, p: [u32; 3]) -> Self::Sample;

    /// The samples at the corners of the cell at `cell`, which must be inside, x fastest.
    #[inline]
    fn corners(&self, cell: [u32; 3]) -> [Self::Sample; 8] {
        std::array::from_fn(|n| self.sample(std::array::from_fn(|a| cell[a] + (n >> a & 1) as u32)))
    }

    /// Of the 4³ samples around the cell at `cell`, which must be inside, those of [`STENCIL`] that are in the domain.
    fn stencil(&self, cell: [u32; 3]) -> Stencil<Self::Sample> {
        let dims = self.dims();
        Stencil::new(|index| {
            let p = std::array::from_fn(|a| (cell[a] + index[a]).wrapping_sub(1));
            dims.contains(p).then(|| self.sample(p))
        })
    }

    /// Fills `out` with rows of layer `layer`, from row `first` on; its length is a whole number of rows, all of them inside.
    fn read_rows(&self, layer: u32, first: u32, out: &mut [Self::Sample]) {
        let nx = self.dims().axes()[0];
        for (row, out) in (first..).zip(out.chunks_mut(nx as usize)) {
            for (x, out) in (0..nx).zip(out) {
                *out = self.sample([x, row, layer]);
            }
        }
    }
}

/// The corners of a cell, and the samples next to them along one axis: what central differences take.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<T> {
    /// `x + 4y + 16z`, from one before the cell on.
    pub samples: [T; 64],
    /// Bit by bit, those that there are: of [`STENCIL`]; all others mean nothing.
    pub exists: u64,
}

impl<T: Scalar> Stencil<T> {
    /// Of the samples of [`STENCIL`] that `at` gives for their indices, from 0 to 3 along each axis.
    #[inline(always)]
    pub fn new(mut at: impl FnMut([u32; 3]) -> Option<T>) -> Self {
        let mut stencil = Self { samples: [T::default(); 64], exists: 0 };
        for n in (0..64).filter(|n| STENCIL >> n & 1 == 1) {
            if let Some(sample) = at([n & 3, n >> 2 & 3, n >> 4]) {
                stencil.samples[n as usize] = sample;
                stencil.exists |= 1 << n;
            }
        }
        stencil
    }
}

/// The numbers of the samples of a [`Stencil`], as bits: those between the outer ones along two axes at least.
pub const STENCIL: u64 = {
    let (mut all, mut n) = (0, 0);
    while n < 64 {
        let mut outer = 0;
        let mut a = 0;
        while a < 3 {
            outer += (n >> (2 * a) & 1 == n >> (2 * a + 1) & 1) as u32;
            a += 1;
        }
        if outer <= 1 {
            all |= 1 << n;
        }
        n += 1;
    }
    all
};

impl<S: Samples + ?Sized> Samples for &S {
    type Sample = S::Sample;

    fn dims(&self) -> Dims {
        (**self).dims()
    }

    #[inline(always)]
    fn sample(&self, p: [u32; 3]) -> S::Sample {
        (**self).sample(p)
    }

    #[inline(always)]
    fn corners(&self, cell: [u32; 3]) -> [S::Sample; 8] {
        (**self).corners(cell)
    }

    fn stencil(&self, cell: [u32; 3]) -> Stencil<S::Sample> {
        (**self).stencil(cell)
    }

    fn read_rows(&self, layer: u32, first: u32, out: &mut [S::Sample]) {
        (**self).read_rows(layer, first, out);
    }
}
