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
}
