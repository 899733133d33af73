//! The ways to build.

use std::path::Path;

use glam::DAffine3;
use isoray_grid::{Scalar, SlabSource};
use isoray_octree::{
    Coarse, Fidelity, HISTOGRAM_BINS, Meta, NODE_LEVEL, Node, OctreeVolume, Parts, VolumeWriter, cap_reach,
    fill_coarse, root_level,
};

use crate::error::{BuildError, Progress, StoreError, reserve};
use crate::levels::{need_a_pass, needed};
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
    progress: impl FnMut(Progress) + Send,
) -> Result<OctreeVolume<T>, BuildError<S::Error>> {
    build_with(source, &FileOptions { index_to_world, ..FileOptions::default() }, progress)
}

/// As [`build`], of a volume of which more is said; [`FileOptions::memory`] is what building may take beside the volume.
///
/// # Errors
/// As [`build`], and a limit that is too low.
pub fn build_with<T: Scalar, S: SlabSource<T> + Send>(
    source: &mut S,
    options: &FileOptions,
    mut progress: impl FnMut(Progress) + Send,
) -> Result<OctreeVolume<T>, BuildError<S::Error>> {
    let dims = source.dims();
    let plan = plan::<T, S>(source, options.memory)?;
    let levels = (NODE_LEVEL..=root_level(dims)).map(|_| Vec::new()).collect();
    let mut parts = Parts { levels, caps: Vec::new() };
    let summary = run(source, &mut parts, plan, &mut progress)?;
    let Parts { levels, caps } = &mut parts;
    caps.resize(caps.len() + cap_reach::<T>(), 0);
    caps.shrink_to_fit();
    levels.iter_mut().for_each(Vec::shrink_to_fit);
    fill_coarse::<T>(dims, levels, caps, options.coarse);
    Ok(OctreeVolume::from_parts(summary.meta(source, options), parts))
}

/// What is said of a volume, and what building it may take.
#[derive(Clone, Copy, Debug)]
pub struct FileOptions {
    /// World position of an index position.
    pub index_to_world: DAffine3,
    /// What the source's samples are true to; the build itself is lossless.
    pub fidelity: Fidelity,
    /// What coarse samples are to be.
    pub coarse: Coarse,
    /// Most bytes of memory that may be held; `None` for as many as it takes.
    pub memory: Option<u64>,
}

impl Default for FileOptions {
    fn default() -> Self {
        let (fidelity, coarse) = (Fidelity::LOSSLESS, Coarse::default());
        Self { index_to_world: DAffine3::IDENTITY, fidelity, coarse, memory: None }
    }
}

/// Builds the octree volume of `source` into the file at `path`.
///
/// What is held in memory is less than the limit: samples being worked on, a layer of unfinished nodes of each level, and finished
/// nodes, which go to a temporary file beyond a part of the limit. Coarse samples that are means need all nodes in memory in the end.
///
/// The file appears under its name when it is complete; see [`OutputFile`](isoray_grid::OutputFile). Its bytes depend
/// neither on the limit nor on the number of threads. Returns its length in bytes, and what is known of the volume.
///
/// # Errors
/// As [`build`], and a limit that is too low, or a file that cannot be written.
pub fn build_file<T: Scalar, S: SlabSource<T> + Send>(
    source: &mut S,
    path: &Path,
    options: &FileOptions,
    mut progress: impl FnMut(Progress) + Send,
) -> Result<(u64, Meta), BuildError<S::Error>> {
    let plan = plan::<T, S>(source, options.memory)?;
    let create = || VolumeWriter::<T>::create(path, source.dims(), plan.nodes);
    let mut writer = create().map_err(StoreError::from)?;
    let summary = run(source, &mut writer, plan, &mut progress)?;
    if need_a_pass(options.coarse) {
        let (dims, threads) = (source.dims(), rayon::current_num_threads());
        let (limit, needed) = (options.memory.unwrap_or(u64::MAX), needed(writer.node_bytes(), threads));
        if needed > limit {
            return Err(BuildError::Limit { dims, limit, needed, threads });
        }
        writer.fill_coarse(options.coarse).map_err(StoreError::from)?;
    }
    let meta = summary.meta(source, options);
    let length = writer.finish(&meta).map_err(StoreError::from)?;
    Ok((length, meta))
}

fn plan<T: Scalar, S: SlabSource<T>>(source: &S, limit: Option<u64>) -> Result<Plan, BuildError<S::Error>> {
    let (dims, threads) = (source.dims(), rayon::current_num_threads());
    Plan::new::<T>(dims, threads, limit, source.rows().is_none(), source.memory()).map_err(
        |TooLow(needed)| BuildError::Limit { dims, limit: limit.unwrap_or(u64::MAX), needed, threads },
    )
}

impl<T: Scalar> Summary<T> {
    fn meta<S: SlabSource<T>>(&self, source: &S, options: &FileOptions) -> Meta {
        let Self { range, counts } = self;
        let range = (range.min <= range.max).then(|| [range.min, range.max].map(|s| f64::from(s.to_f32())));
        let histogram = range.map_or_else(|| Box::new([0; HISTOGRAM_BINS]), |range| counts.histogram(range));
        let FileOptions { index_to_world, fidelity, coarse, .. } = *options;
        let (dims, non_finite) = (source.dims(), counts.non_finite());
        Meta { dims, index_to_world, range, non_finite, histogram, fidelity, coarse }
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
