//! `isoray build`.

use std::time::Instant;

use anyhow::Result;
use isoray_grid::Scalar;
use isoray_octree::{OctreeVolume, SaveError, VolumeVisitor};

use super::{bytes, use_threads};
use crate::cli::BuildArgs;
use crate::load::load;
use crate::output::{check_output, to_stdout};

pub(crate) fn run(args: &BuildArgs) -> Result<()> {
    use_threads(args.threads)?;
    check_output(&args.output, &[&args.input])?;
    let begin = Instant::now();
    let loaded = load(&args.input, &args.source)?;
    loaded.volume.visit(Save { path: &args.output })?;
    let (raw, stored) = loaded.volume.visit(Sizes);
    let seconds = begin.elapsed().as_secs_f64();
    let meta = loaded.volume.meta();
    to_stdout(|out| {
        writeln!(
            out,
            "{}: {} {} samples, {} of {} ({:.1} %), {seconds:.2} s, {:.1} million voxels/s",
            args.output.display(),
            meta.dims,
            loaded.volume.scalar(),
            bytes(stored),
            bytes(raw),
            100.0 * stored as f64 / raw as f64,
            meta.dims.samples() as f64 / seconds / 1e6,
        )
    })
}

struct Save<'a> {
    path: &'a std::path::Path,
}

impl VolumeVisitor for Save<'_> {
    type Output = Result<(), SaveError>;
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Self::Output {
        volume.save(self.path)
    }
}

/// Bytes as a plain array, and as an `.ovol` file.
pub(crate) struct Sizes;

impl VolumeVisitor for Sizes {
    type Output = (u64, u64);
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> (u64, u64) {
        (volume.raw_bytes() as u64, volume.file_bytes() as u64)
    }
}
