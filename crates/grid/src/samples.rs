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

    /// The 4³ samples around the cell at `cell`, which must be inside, x fastest: its corners and their neighbours. `None` outside the
    /// domain.
    fn stencil(&self, cell: [u32; 3]) -> [Option<Self::Sample>; 64] {
        let dims = self.dims();
        std::array::from_fn(|n| {
            let p = [0, 1, 2].map(|a| (cell[a] + (n as u32 >> (2 * a) & 3)).wrapping_sub(1));
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

    fn stencil(&self, cell: [u32; 3]) -> [Option<S::Sample>; 64] {
        (**self).stencil(cell)
    }

    fn read_rows(&self, layer: u32, first: u32, out: &mut [S::Sample]) {
        (**self).read_rows(layer, first, out);
    }
}
