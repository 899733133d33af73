//! `isoray build`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use isoray_grid::Scalar;
use isoray_octree::{OctreeVolume, VolumeVisitor};

use super::{bytes, use_threads};
use crate::cli::BuildArgs;
use crate::conversion::{Built, convert};
use crate::output::{check_output, to_stdout};
use crate::series::{self, Inputs, expand};

pub(crate) fn run(args: &BuildArgs) -> Result<()> {
    use_threads(args.threads)?;
    match expand(&args.inputs, &args.output)? {
        Inputs::One(input) => one(args, &[&input], || convert(&input, &args.output, args)),
        Inputs::Slices(inputs) => {
            let paths: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
            one(args, &paths, || of_slices(args, &inputs))
        }
        Inputs::Series(inputs) => series::build(args, &inputs),
    }
}

/// Builds one volume and tells what it took.
fn one(args: &BuildArgs, inputs: &[&Path], convert: impl FnOnce() -> Result<Built>) -> Result<()> {
    check_output(&args.output, inputs)?;
    let begin = Instant::now();
    let built = convert()?;
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

/// Builds one volume of files with a layer each.
#[cfg(feature = "tiff")]
fn of_slices(args: &BuildArgs, inputs: &[PathBuf]) -> Result<Built> {
    let dataset = isoray_io::Dataset::open_slices(inputs, &args.source.options()?)?;
    dataset.warnings().iter().for_each(crate::failure::warn);
    crate::conversion::convert_dataset(&dataset, &args.output, args)
}

/// Never called: without readers of TIFF no files are taken for slices.
#[cfg(not(feature = "tiff"))]
fn of_slices(_: &BuildArgs, _: &[PathBuf]) -> Result<Built> {
    anyhow::bail!("TIFF files cannot be read: isoray was built without the feature tiff")
}

/// Bytes as a plain array, and as an `.ovol` file.
pub(crate) struct Sizes;

impl VolumeVisitor for Sizes {
    type Output = (u64, u64);
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> (u64, u64) {
        (volume.raw_bytes() as u64, volume.file_bytes() as u64)
    }
}
