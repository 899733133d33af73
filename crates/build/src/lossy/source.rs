//! The adaptor: reads ahead, and hands out what becomes of the samples.

use isoray_grid::{Dims, Scalar, SlabSource};
use rayon::prelude::*;

use super::BLOCK_EDGE;
use super::layers::Layers;
use super::loss::{Loss, LossError};
use super::merge::{Changes, Row, Scratch};
use super::rules::Rules;

/// A source of samples that may differ from those of another one, within bounds, so that more of them are equal.
///
/// See [the module](crate::lossy) for what the bounds guarantee. Memory holds up to 22 layers beside what the other source needs.
#[derive(Clone, Debug)]
pub struct Lossy<T, S> {
    source: S,
    rules: Rules,
    dims: Dims,
    /// Layers of the source, and the index of the first.
    raw: Vec<T>,
    raw_first: usize,
    /// The slab made last, row of blocks after row of blocks, and where it lies.
    slab: Vec<T>,
    made: std::ops::Range<usize>,
    changes: Changes,
}

/// Layers that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum LossyError<E: std::error::Error + 'static> {
    /// The source failed.
    #[error(transparent)]
    Source(E),
    /// What is asked for is no layers of the volume.
    #[error("{samples} samples from layer {first} of a {dims} volume: expected whole layers inside it")]
    Layers {
        /// Size of the lattice.
        dims: Dims,
        /// The first layer asked for.
        first: u32,
        /// Samples asked for.
        samples: usize,
    },
    /// The operating system gives no memory for the layers.
    #[error("{layers} layers of a {dims} volume need more memory than can be had")]
    Memory {
        /// Size of the lattice.
        dims: Dims,
        /// Layers to be held at once.
        layers: usize,
    },
}

/// Layers that are held at most: those read, and the slab made of them.
const LAYERS: usize = 22;

impl<T: Scalar, S: SlabSource<T>> Lossy<T, S> {
    /// The samples of `source`, with this loss.
    ///
    /// # Errors
    /// Bounds that make no sense.
    pub fn new(source: S, loss: &Loss) -> Result<Self, LossError> {
        loss.check()?;
        let dims = source.dims();
        Ok(Self {
            source,
            rules: Rules::new::<T>(loss),
            dims,
            raw: Vec::new(),
            raw_first: 0,
            slab: Vec::new(),
            made: 0..0,
            changes: Changes::default(),
        })
    }

    /// What has changed in the layers made since reading began; after a build, in the volume.
    pub fn changes(&self) -> Changes {
        self.changes
    }

    /// The source.
    pub fn into_inner(self) -> S {
        self.source
    }

    fn start_over(&mut self) {
        self.raw.clear();
        self.raw_first = 0;
        self.made = 0..0;
        self.changes = Changes::default();
    }

    /// Makes the slab after the one made last.
    fn make_slab(&mut self) -> Result<(), LossyError<S::Error>> {
        let [nx, ny, nz] = self.dims.axes().map(|n| n as usize);
        let first = self.made.end;
        let last = nz.min(first + BLOCK_EDGE);
        self.read_around(first..last)?;
        let length = (last - first) * self.dims.layer();
        reserve(&mut self.slab, length, self.dims)?;
        self.slab.resize(length, T::default());
        let Self { rules, dims, raw, raw_first, slab, .. } = self;
        let layers = Layers { dims: *dims, first: *raw_first, samples: raw };
        let depth = last - first;
        let row = |scratch: &mut Scratch, (n, out): (usize, &mut [T])| {
            let y = n * BLOCK_EDGE;
            let size = [nx, BLOCK_EDGE.min(ny - y), depth];
            Row { rules, layers, origin: [y, first], size, out }.fill(scratch)
        };
        let rows = slab.par_chunks_mut(nx * BLOCK_EDGE * depth).enumerate();
        let changes = rows.map_init(Scratch::default, row).reduce(Changes::default, Changes::join);
        self.changes = self.changes.join(changes);
        self.made = first..last;
        Ok(())
    }

    /// Holds the layers that bear on `layers`, and no others.
    fn read_around(&mut self, layers: std::ops::Range<usize>) -> Result<(), LossyError<S::Error>> {
        let halo = self.rules.halo();
        let first = layers.start.saturating_sub(halo);
        let end = (self.dims.axes()[2] as usize).min(layers.end + halo);
        let layer = self.dims.layer();
        self.raw.drain(..(first - self.raw_first) * layer);
        self.raw_first = first;
        let held = self.raw.len();
        let wanted = (end - first) * layer;
        reserve(&mut self.raw, wanted, self.dims)?;
        self.raw.resize(wanted, T::default());
        let next = (first + held / layer) as u32;
        self.source.read_layers(next, &mut self.raw[held..]).map_err(LossyError::Source)
    }

    /// Copies layer `z`, which is made.
    fn copy_layer(&self, z: usize, out: &mut [T]) {
        let nx = self.dims.axes()[0] as usize;
        let row = nx * BLOCK_EDGE;
        let depth = self.made.len();
        for (out, row) in out.chunks_mut(row).zip(self.slab.chunks(row * depth)) {
            let length = out.len();
            out.copy_from_slice(&row[(z - self.made.start) * length..][..length]);
        }
    }
}

impl<T: Scalar, S: SlabSource<T>> SlabSource<T> for Lossy<T, S> {
    type Error = LossyError<S::Error>;

    fn dims(&self) -> Dims {
        self.dims
    }

    fn memory(&self) -> u64 {
        (LAYERS * self.dims.layer() * size_of::<T>()) as u64 + self.source.memory()
    }

    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), Self::Error> {
        let (layer, total) = (self.dims.layer(), self.dims.axes()[2] as usize);
        let begin = first as usize;
        if !out.len().is_multiple_of(layer) || begin + out.len() / layer > total {
            return Err(LossyError::Layers { dims: self.dims, first, samples: out.len() });
        }
        if first == 0 || begin < self.made.start {
            self.start_over();
        }
        for (z, out) in (begin..).zip(out.chunks_mut(layer)) {
            while self.made.end <= z {
                if let Err(error) = self.make_slab() {
                    self.start_over();
                    return Err(error);
                }
            }
            self.copy_layer(z, out);
        }
        Ok(())
    }
}

/// Makes room for `length` elements.
fn reserve<T, E: std::error::Error>(
    vec: &mut Vec<T>,
    length: usize,
    dims: Dims,
) -> Result<(), LossyError<E>> {
    let additional = length.saturating_sub(vec.len());
    vec.try_reserve_exact(additional).map_err(|_| LossyError::Memory { dims, layers: length / dims.layer() })
}
