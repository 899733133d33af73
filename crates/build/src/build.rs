//! The ways to build.

use std::path::Path;

use glam::DAffine3;
use isoray_grid::{Scalar, SlabSource};
use isoray_octree::{
    HISTOGRAM_BINS, Meta, NODE_LEVEL, Node, OctreeVolume, Parts, VolumeWriter, cap_reach, root_level,
};

use crate::error::{BuildError, Progress, StoreError, reserve};
use crate::pipeline::{Sink, Summary, run};
use crate::plan::{Plan, TooLow};

/// Builds the octree volume of `source` in memory, losslessly. `index_to_world` is stored with it; `progress` is called now
/// and then.
///
/// # Errors
/// A source that fails, a volume whose caps are too many for the format's links, or too little memory.
pub fn build<T: Scalar, S: SlabSource<T> + Send>(
    source: &mut S,
    index_to_world: DAffine3,
    mut progress: impl FnMut(Progress) + Send,
) -> Result<OctreeVolume<T>, BuildError<S::Error>> {
    let dims = source.dims();
    let plan = plan::<T, S>(source, None)?;
    let levels = (NODE_LEVEL..=root_level(dims)).map(|_| Vec::new()).collect();
    let mut parts = Parts { levels, caps: Vec::new() };
    let summary = run(source, &mut parts, plan, &mut progress)?;
    let Parts { levels, caps } = &mut parts;
    caps.resize(caps.len() + cap_reach::<T>(), 0);
    caps.shrink_to_fit();
    levels.iter_mut().for_each(Vec::shrink_to_fit);
    Ok(OctreeVolume::from_parts(summary.meta(source, index_to_world), parts))
}

/// Builds the octree volume of `source` into the file at `path`, losslessly, and holds no more than `limit` bytes in memory meanwhile.
///
/// The file appears under its name when it is complete; see [`OutputFile`](isoray_grid::OutputFile). Its bytes depend
/// neither on the limit nor on the number of threads. Returns its length in bytes, and what is known of the volume.
///
/// # Errors
/// As [`build`], and a limit that is too low, or a file that cannot be written.
pub fn build_file<T: Scalar, S: SlabSource<T> + Send>(
    source: &mut S,
    index_to_world: DAffine3,
    path: &Path,
    limit: Option<u64>,
    mut progress: impl FnMut(Progress) + Send,
) -> Result<(u64, Meta), BuildError<S::Error>> {
    let plan = plan::<T, S>(source, limit)?;
    let create = || VolumeWriter::<T>::create(path, source.dims(), plan.nodes);
    let mut writer = create().map_err(StoreError::from)?;
    let summary = run(source, &mut writer, plan, &mut progress)?;
    let meta = summary.meta(source, index_to_world);
    let length = writer.finish(&meta).map_err(StoreError::from)?;
    Ok((length, meta))
}

fn plan<T: Scalar, S: SlabSource<T>>(source: &S, limit: Option<u64>) -> Result<Plan, BuildError<S::Error>> {
    let (dims, threads) = (source.dims(), rayon::current_num_threads());
    Plan::new::<T>(dims, threads, limit, source.rows().is_none()).map_err(|TooLow(needed)| {
        BuildError::Limit { dims, limit: limit.unwrap_or(u64::MAX), needed, threads }
    })
}

impl<T: Scalar> Summary<T> {
    fn meta<S: SlabSource<T>>(&self, source: &S, index_to_world: DAffine3) -> Meta {
        let Self { range, counts } = self;
        let range = (range.min <= range.max).then(|| [range.min, range.max].map(|s| f64::from(s.to_f32())));
        let histogram = range.map_or_else(|| Box::new([0; HISTOGRAM_BINS]), |range| counts.histogram(range));
        Meta { dims: source.dims(), index_to_world, range, non_finite: counts.non_finite(), histogram }
    }
}

impl<T: Scalar> Sink<T> for Parts<T> {
    fn caps(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        reserve(&mut self.caps, bytes.len(), "caps")?;
        self.caps.extend_from_slice(bytes);
        Ok(())
    }

    fn nodes(&mut self, level: u32, nodes: &[Node<T::Stored>]) -> Result<(), StoreError> {
        if let Some(all) = self.levels.get_mut((level - NODE_LEVEL) as usize) {
            reserve(all, nodes.len(), "nodes")?;
            all.extend_from_slice(nodes);
        }
        Ok(())
    }
}

impl<T: Scalar> Sink<T> for VolumeWriter<T> {
    fn caps(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        Ok(self.push_caps(bytes)?)
    }

    fn nodes(&mut self, level: u32, nodes: &[Node<T::Stored>]) -> Result<(), StoreError> {
        Ok(self.push_nodes(level, nodes)?)
    }
}
