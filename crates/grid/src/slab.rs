//! Streaming a volume layer by layer.

use crate::{Dims, Scalar};

/// A volume that is read in order, some layers of constant `k` at a time.
///
/// A consumer calls [`read_layers`](Self::read_layers) with `first = 0` and then continues where the last
/// call ended; an implementor that can only go forward (a compressed stream) may rely on that, and must
/// accept `first = 0` again to start over.
pub trait SlabSource<T: Scalar> {
    /// What a failed read says.
    type Error: std::error::Error + Send + Sync + 'static;

    /// Size of the lattice.
    fn dims(&self) -> Dims;

    /// Fills `out` with the layers `first, first + 1, …`; its length is a whole number of layers.
    ///
    /// # Errors
    /// What kept the samples from being read.
    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), Self::Error>;

    /// Bytes that the source itself holds while it is read, if they are many.
    fn memory(&self) -> u64 {
        0
    }

    /// The same samples in any order and for several threads at once, if the source can hand them out so; a consumer then
    /// need not call [`read_layers`](Self::read_layers).
    fn rows(&self) -> Option<&dyn RowSource<T, Error = Self::Error>> {
        None
    }
}

impl<T: Scalar, S: SlabSource<T> + ?Sized> SlabSource<T> for &mut S {
    type Error = S::Error;

    fn dims(&self) -> Dims {
        (**self).dims()
    }

    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), Self::Error> {
        (**self).read_layers(first, out)
    }

    fn memory(&self) -> u64 {
        (**self).memory()
    }

    fn rows(&self) -> Option<&dyn RowSource<T, Error = Self::Error>> {
        (**self).rows()
    }
}

/// A volume that is read in any order, by any number of threads.
pub trait RowSource<T: Scalar>: Sync {
    /// What a failed read says.
    type Error: std::error::Error + Send + Sync + 'static;

    /// Fills `out` with rows of layer `layer`, from row `first` on; its length is a whole number of rows.
    ///
    /// # Errors
    /// What kept the samples from being read.
    fn read_rows(&self, layer: u32, first: u32, out: &mut [T]) -> Result<(), Self::Error>;
}
