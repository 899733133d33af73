//! Sources that are read in order.

use isoray_grid::{Dims, RowSource, Scalar, SlabSource};

use crate::error::{BuildError, reserve};
use crate::strip::BLOCK_EDGE;

/// The layers that one layer of blocks needs: eight, and the one after them, as far as there are any.
pub(crate) struct Slab<T, E> {
    dims: Dims,
    first: u32,
    samples: Vec<T>,
    error: std::marker::PhantomData<fn() -> E>,
}

impl<T: Scalar, E: std::error::Error + Send + Sync + 'static> Slab<T, E> {
    pub(crate) fn first<S: SlabSource<T, Error = E>>(source: &mut S) -> Result<Self, BuildError<E>> {
        let dims = source.dims();
        Self { dims, first: 0, samples: Vec::new(), error: std::marker::PhantomData }.filled(source)
    }

    /// The next one, empty beyond the end.
    pub(crate) fn next<S: SlabSource<T, Error = E>>(&self, source: &mut S) -> Result<Self, BuildError<E>> {
        let samples = self.samples[self.own()..].to_vec();
        Self { first: self.first + BLOCK_EDGE as u32, samples, ..*self }.filled(source)
    }

    /// The next one in the memory of this one.
    pub(crate) fn into_next<S: SlabSource<T, Error = E>>(
        mut self,
        source: &mut S,
    ) -> Result<Self, BuildError<E>> {
        self.samples.drain(..self.own());
        Self { first: self.first + BLOCK_EDGE as u32, ..self }.filled(source)
    }

    /// Samples of its own layers.
    fn own(&self) -> usize {
        self.samples.len().min(BLOCK_EDGE * self.dims.layer())
    }

    /// Reads the layers that are missing.
    fn filled<S: SlabSource<T, Error = E>>(mut self, source: &mut S) -> Result<Self, BuildError<E>> {
        let layer = self.dims.layer();
        let left = self.dims.axes()[2].saturating_sub(self.first) as usize;
        let wanted = left.min(BLOCK_EDGE + 1) * layer;
        let known = self.samples.len();
        if wanted > known {
            reserve(&mut self.samples, wanted - known, "layers")?;
            self.samples.resize(wanted, T::default());
            let at = self.first + (known / layer) as u32;
            source.read_layers(at, &mut self.samples[known..]).map_err(BuildError::Source)?;
        }
        Ok(self)
    }
}

impl<T: Scalar, E: std::error::Error + Send + Sync + 'static> RowSource<T> for Slab<T, E> {
    type Error = E;

    fn read_rows(&self, layer: u32, first: u32, out: &mut [T]) -> Result<(), E> {
        let start = self.dims.linear([0, first, layer - self.first]);
        out.copy_from_slice(&self.samples[start..start + out.len()]);
        Ok(())
    }
}
