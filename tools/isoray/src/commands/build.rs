//! `isoray build`.

use std::time::Instant;

use anyhow::Result;
use isoray_grid::Scalar;
use isoray_octree::{OctreeVolume, VolumeVisitor};

use super::{bytes, use_threads};
use crate::cli::BuildArgs;
use crate::conversion::convert;
use crate::output::{check_output, to_stdout};

pub(crate) fn run(args: &BuildArgs) -> Result<()> {
    use_threads(args.threads)?;
    check_output(&args.output, &[&args.input])?;
    let begin = Instant::now();
    let built = convert(&args.input, &args.output, args)?;
    let seconds = begin.elapsed().as_secs_f64();
    let (dims, raw) = (built.meta.dims, built.raw());
    to_stdout(|out| {
        writeln!(
            out,
            "{}: {dims} {} samples, {} of {} ({:.1} %), {seconds:.2} s, {:.1} million voxels/s",
            args.output.display(),
            built.scalar,
            bytes(built.length),
            bytes(raw),
            100.0 * built.length as f64 / raw as f64,
            dims.samples() as f64 / seconds / 1e6,
        )
    })
}

/// Bytes as a plain array, and as an `.ovol` file.
pub(crate) struct Sizes;

impl VolumeVisitor for Sizes {
    type Output = (u64, u64);
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> (u64, u64) {
        (volume.raw_bytes() as u64, volume.file_bytes() as u64)
    }
}
