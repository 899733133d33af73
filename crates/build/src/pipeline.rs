//! Reading, folding and storing, at the same time.

use std::sync::{Mutex, PoisonError};

use isoray_grid::{Dims, RowSource, Scalar, SlabSource};
use isoray_octree::{Counts, Node, Range, cap_unit};
use rayon::prelude::*;

use crate::block::Blocks;
use crate::consolidate::{Consolidation, Layer};
use crate::error::{BuildError, Progress, StoreError};
use crate::plan::Plan;
use crate::slab::Slab;
use crate::strip::{BLOCK_EDGE, Place, Strip, strips};

/// Where the parts of a structure go.
pub(crate) trait Sink<T: Scalar>: Send {
    /// The next caps, a whole number of units of links.
    fn caps(&mut self, bytes: &[u8]) -> Result<(), StoreError>;
    /// The next nodes of a level.
    fn nodes(&mut self, level: u32, nodes: &[Node<T::Stored>]) -> Result<(), StoreError>;
}

/// What was found out about all samples.
#[derive(Clone, Debug)]
pub(crate) struct Summary<T> {
    pub(crate) range: Range<T>,
    pub(crate) counts: Counts<T>,
}

/// Takes all of `source` to `sink`.
pub(crate) fn run<T: Scalar, S: SlabSource<T> + Send, K: Sink<T>>(
    source: &mut S,
    sink: &mut K,
    plan: Plan,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<Summary<T>, BuildError<S::Error>> {
    let dims = source.dims();
    let [nx, ny, depth] = dims.axes();
    let size = [nx, ny].map(|n| (n as usize).div_ceil(BLOCK_EDGE));
    let store = Store {
        sink,
        caps: 0,
        layer: Layer { size, regions: Vec::new() },
        consolidation: Consolidation::new(dims),
        range: Range::EMPTY,
    };
    let mut pipeline = Pipeline {
        dims,
        band: plan.band,
        progress,
        samples: 0,
        work: Pool::new(),
        blocks: Pool::new(),
        store,
        done: Vec::new(),
    };
    let layers = (0..depth).step_by(BLOCK_EDGE);
    if let Some(rows) = source.rows() {
        let places: Vec<_> = layers.flat_map(|layer| strips(dims, layer)).collect();
        pipeline.strips(&places, rows)?;
        return pipeline.finish();
    }
    let mut slab = Slab::first(source)?;
    for layer in layers {
        let places: Vec<_> = strips(dims, layer).collect();
        if plan.reads_ahead {
            let (next, worked) = rayon::join(|| slab.next(source), || pipeline.strips(&places, &slab));
            worked?;
            slab = next?;
        } else {
            pipeline.strips(&places, &slab)?;
            slab = slab.into_next(source)?;
        }
    }
    pipeline.finish()
}

/// The state of a build.
struct Pipeline<'p, T: Scalar, K> {
    dims: Dims,
    /// Strips that are worked on at once.
    band: usize,
    progress: &'p mut (dyn FnMut(Progress) + Send),
    /// Samples worked on.
    samples: u64,
    work: Pool<Work<T>>,
    blocks: Pool<Blocks<T>>,
    store: Store<'p, T, K>,
    /// Strips that have been worked on and are not stored.
    done: Vec<Blocks<T>>,
}

/// What a thread works with.
struct Work<T> {
    strip: Strip<T>,
    counts: Counts<T>,
}

/// What is used again and again, by whichever thread.
struct Pool<W>(Mutex<Vec<W>>);

impl<W> Pool<W> {
    fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    fn take(&self) -> Option<W> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop()
    }

    fn give(&self, what: W) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(what);
    }
}

impl<T: Scalar, K: Sink<T>> Pipeline<'_, T, K> {
    /// Works on strips, a band at a time, and stores those of the band before meanwhile.
    fn strips<E: std::error::Error + Send + Sync + 'static>(
        &mut self,
        places: &[Place],
        rows: &(dyn RowSource<T, Error = E> + '_),
    ) -> Result<(), BuildError<E>> {
        for band in places.chunks(self.band) {
            let done = std::mem::take(&mut self.done);
            let Self { dims, work, blocks, store, .. } = &mut *self;
            let strip = |&place: &Place| {
                let new = || Work { strip: Strip::new(*dims), counts: Counts::default() };
                let mut with = work.take().unwrap_or_else(new);
                let mut out = blocks.take().unwrap_or_else(Blocks::new);
                with.strip.read(place, rows)?;
                out.take(&with.strip, &mut with.counts);
                work.give(with);
                Ok(out)
            };
            let (stored, worked) = rayon::join(
                || done.iter().try_for_each(|blocks| store.take(blocks)),
                || band.par_iter().map(strip).collect::<Result<Vec<_>, E>>(),
            );
            stored?;
            done.into_iter().for_each(|blocks| self.blocks.give(blocks));
            self.done = worked.map_err(BuildError::Source)?;
            self.samples += band.iter().map(|place| place.samples()).sum::<u64>();
            (self.progress)(Progress { done: self.samples, total: self.dims.samples() as u64 });
        }
        Ok(())
    }

    fn finish<E: std::error::Error + 'static>(mut self) -> Result<Summary<T>, BuildError<E>> {
        self.done.iter().try_for_each(|blocks| self.store.take(blocks))?;
        let range = self.store.finish()?;
        let mut counts: Option<Counts<T>> = None;
        while let Some(work) = self.work.take() {
            match &mut counts {
                Some(counts) => counts.join(&work.counts),
                None => counts = Some(work.counts),
            }
        }
        Ok(Summary { range, counts: counts.unwrap_or_default() })
    }
}

/// What is stored in order, by one thread at a time.
struct Store<'p, T: Scalar, K> {
    sink: &'p mut K,
    /// Bytes of caps so far.
    caps: u64,
    /// The layer of blocks at hand, as far as it is known.
    layer: Layer<T>,
    consolidation: Consolidation<T>,
    range: Range<T>,
}

impl<T: Scalar, K: Sink<T>> Store<'_, T, K> {
    fn take(&mut self, blocks: &Blocks<T>) -> Result<(), StoreError> {
        let unit = cap_unit::<T>() as u64;
        let base = self.caps / unit;
        self.caps += blocks.caps.len() as u64;
        if self.caps / unit > u64::from(u32::MAX) {
            return Err(StoreError::TooLarge { found: self.caps, most: u64::from(u32::MAX) * unit });
        }
        self.sink.caps(&blocks.caps)?;
        self.range = self.range.union(blocks.range);
        self.layer.regions.extend(blocks.regions.iter().map(|region| region.moved(base as u32)));
        let size = self.layer.size;
        if self.layer.regions.len() == size[0] * size[1] {
            let full = std::mem::replace(&mut self.layer, Layer { size, regions: Vec::new() });
            self.consolidation.push(full);
            self.drain()?;
        }
        Ok(())
    }

    fn drain(&mut self) -> Result<(), StoreError> {
        self.consolidation.drain(|level, nodes| self.sink.nodes(level, nodes))
    }

    fn finish(&mut self) -> Result<Range<T>, StoreError> {
        self.consolidation.finish();
        self.drain()?;
        Ok(self.range)
    }
}
