//! Reading slab by slab.

use glam::DAffine3;
use isoray_grid::{Dims, Scalar, SlabSource};
use isoray_octree::{HISTOGRAM_BINS, Meta, OctreeVolume, Range, cap_reach, cap_unit};
use rayon::prelude::*;

use crate::block::{BLOCK_EDGE, Layers};
use crate::consolidate::{Consolidation, Layer, Region};

/// How far a build has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Layers done.
    pub layers: u32,
    /// Layers in all.
    pub total: u32,
}

/// A build that could not be finished.
#[derive(Debug, thiserror::Error)]
pub enum BuildError<E: std::error::Error + 'static> {
    /// The source failed.
    #[error(transparent)]
    Source(E),
    /// More samples in caps than 32-bit links can address.
    #[error("the volume is too large and too noisy: {0} samples in caps, expected at most {max}", max = u64::from(u32::MAX) * 8)]
    TooLarge(u64),
    /// The operating system gives no memory for what has to be held at once.
    #[error("a {dims} volume needs {bytes} bytes of memory for its {what}, more than can be had")]
    Memory {
        /// Size of the lattice.
        dims: Dims,
        /// What was to be held.
        what: &'static str,
        /// Bytes of it.
        bytes: u128,
    },
}

/// Makes room for `additional` elements more; beyond what is asked for only where that can be had.
fn reserve<S, E: std::error::Error>(
    vec: &mut Vec<S>,
    additional: usize,
    dims: Dims,
    what: &'static str,
) -> Result<(), BuildError<E>> {
    vec.try_reserve(additional).or_else(|_| vec.try_reserve_exact(additional)).map_err(|_| {
        let bytes = (vec.len() as u128 + additional as u128) * size_of::<S>() as u128;
        BuildError::Memory { dims, what, bytes }
    })
}

/// Builds the octree volume of `source`, losslessly. `index_to_world` is stored with it; `progress` is called after every slab.
///
/// # Errors
/// A source that fails, a volume whose caps are too many for the format's links, or too little memory.
pub fn build<T: Scalar, S: SlabSource<T>>(
    source: &mut S,
    index_to_world: DAffine3,
    mut progress: impl FnMut(Progress),
) -> Result<OctreeVolume<T>, BuildError<S::Error>> {
    let dims = source.dims();
    let total = dims.axes()[2];
    let layer = dims.layer();
    let mut samples: Vec<T> = Vec::new();
    let mut consolidation = Consolidation::new(dims);
    let mut caps = Vec::new();
    let mut summary = Summary { range: Range::EMPTY, non_finite: 0 };
    for first in (0..total).step_by(BLOCK_EDGE) {
        // The slab's layers and the one after them, of which the last slab's reading brought the first.
        let kept = samples.len() / layer.max(1);
        let wanted = (BLOCK_EDGE + 1).min((total - first) as usize);
        reserve(&mut samples, (wanted - kept) * layer, dims, "layers")?;
        samples.resize(wanted * layer, T::default());
        source.read_layers(first + kept as u32, &mut samples[kept * layer..]).map_err(BuildError::Source)?;

        let own = BLOCK_EDGE.min((total - first) as usize);
        summary = summary.join(Summary::of(&samples[..own * layer]));
        consolidation.push(slab(Layers { dims, first, samples: &samples }, &mut caps)?);

        samples.drain(..own * layer);
        progress(Progress { layers: first + own as u32, total });
    }
    caps.resize(caps.len() + cap_reach::<T>(), 0);
    caps.shrink_to_fit();
    Ok(finish(dims, index_to_world, summary, consolidation, caps))
}

fn finish<T: Scalar>(
    dims: Dims,
    index_to_world: DAffine3,
    summary: Summary<T>,
    consolidation: Consolidation<T>,
    caps: Vec<u8>,
) -> OctreeVolume<T> {
    let Summary { range, non_finite } = summary;
    let range = (range.min <= range.max).then(|| [range.min, range.max].map(|s| f64::from(s.to_f32())));
    let empty = Meta { dims, index_to_world, range, non_finite, histogram: Box::new([0; HISTOGRAM_BINS]) };
    let volume = OctreeVolume::from_parts(empty, consolidation.finish(caps));
    match range {
        Some(range) => {
            let histogram = volume.view().histogram(range);
            volume.with_histogram(histogram)
        }
        None => volume,
    }
}

/// One layer of blocks, their caps appended to `caps`; rows of blocks in parallel.
fn slab<T: Scalar, E: std::error::Error>(
    layers: Layers<'_, T>,
    caps: &mut Vec<u8>,
) -> Result<Layer<T>, BuildError<E>> {
    let [nx, ny, _] = layers.dims.axes();
    let size = [nx, ny].map(|n| (n as usize).div_ceil(BLOCK_EDGE));
    let row = |y: usize| {
        let mut caps = Vec::new();
        let blocks = (0..size[0]).map(|x| {
            let origin = [(x * BLOCK_EDGE) as u32, (y * BLOCK_EDGE) as u32, layers.first];
            layers.block(origin, &mut caps)
        });
        let regions: Vec<Region<T>> = blocks.collect();
        (regions, caps)
    };
    let rows: Vec<_> = (0..size[1]).into_par_iter().map(row).collect();
    let mut regions = Vec::with_capacity(size[0] * size[1]);
    for (row, row_caps) in rows {
        reserve(caps, row_caps.len() + cap_unit::<T>(), layers.dims, "caps")?;
        caps.resize(caps.len().next_multiple_of(cap_unit::<T>()), 0);
        let base = (caps.len() / cap_unit::<T>()) as u64;
        let end = base + row_caps.len().div_ceil(cap_unit::<T>()) as u64;
        if end > u64::from(u32::MAX) {
            return Err(BuildError::TooLarge(end * cap_unit::<T>() as u64));
        }
        caps.extend_from_slice(&row_caps);
        regions.extend(row.into_iter().map(|mut region| {
            if region.node.mask != 0 {
                region.node.first += base as u32;
            }
            region
        }));
    }
    Ok(Layer { size, regions })
}

/// What the header says of all samples.
#[derive(Clone, Copy, Debug)]
struct Summary<T> {
    range: Range<T>,
    non_finite: u64,
}

/// Samples that one task summarises.
const SUMMARY_CHUNK: usize = 1 << 14;

impl<T: Scalar> Summary<T> {
    fn of(samples: &[T]) -> Self {
        let neutral = Self { range: Range::EMPTY, non_finite: 0 };
        let chunk = |chunk: &[T]| {
            let mut min = T::HIGHEST;
            let mut max = T::LOWEST;
            let mut non_finite = 0;
            for &s in chunk {
                let finite = s.is_finite();
                non_finite += u64::from(!finite);
                min = if finite && s < min { s } else { min };
                max = if finite && s > max { s } else { max };
            }
            Self { range: Range { min, max }, non_finite }
        };
        samples.par_chunks(SUMMARY_CHUNK).map(chunk).reduce(|| neutral, Self::join)
    }

    fn join(self, other: Self) -> Self {
        Self { range: self.range.union(other.range), non_finite: self.non_finite + other.non_finite }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A source that claims to hold the largest layers there can be.
    struct Claim(Dims);

    impl SlabSource<f32> for Claim {
        type Error = std::convert::Infallible;

        fn dims(&self) -> Dims {
            self.0
        }

        fn read_layers(&mut self, _: u32, _: &mut [f32]) -> Result<(), Self::Error> {
            Ok(())
        }
    }

    #[test]
    fn layers_that_no_memory_holds_are_an_error() {
        // More than the 2⁴⁷ bytes that a process can address, so that no operating system promises them.
        let dims = Dims::new([1 << 21, 1 << 21, 9]).unwrap();
        let error = build(&mut Claim(dims), DAffine3::IDENTITY, |_| {}).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a 2097152x2097152x9 volume needs 158329674399744 bytes of memory for its layers, more than can be had"
        );
    }
}
