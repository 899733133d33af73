//! `isoray build`.

use std::time::Instant;

use anyhow::{Result, bail};
use isoray_build::build_file;
use isoray_grid::{Scalar, ScalarType};
use isoray_io::Dataset;
use isoray_octree::{Meta, OctreeVolume, VolumeVisitor};

use super::{bytes, use_threads};
use crate::cli::BuildArgs;
use crate::failure::warn;
use crate::load::{build_error, is_octree_volume, open_dataset, warn_about};
use crate::memory::memory_of_machine;
use crate::output::{check_output, to_stdout};
use crate::progress::Progress;

pub(crate) fn run(args: &BuildArgs) -> Result<()> {
    use_threads(args.threads)?;
    check_output(&args.output, &[&args.input])?;
    if is_octree_volume(&args.input, &args.source)? {
        bail!("{}: is an octree volume already", args.input.display());
    }
    let begin = Instant::now();
    let dataset = open_dataset(&args.input, &args.source)?;
    let built = match dataset.scalar() {
        ScalarType::U8 => convert::<u8>(&dataset, args)?,
        ScalarType::I8 => convert::<i8>(&dataset, args)?,
        ScalarType::U16 => convert::<u16>(&dataset, args)?,
        ScalarType::I16 => convert::<i16>(&dataset, args)?,
        ScalarType::F32 => convert::<f32>(&dataset, args)?,
    };
    let seconds = begin.elapsed().as_secs_f64();
    warn_about(&args.input, &built.meta);
    let (raw, dims) = (dataset.raw_bytes(), built.meta.dims);
    to_stdout(|out| {
        writeln!(
            out,
            "{}: {dims} {} samples, {} of {} ({:.1} %), {seconds:.2} s, {:.1} million voxels/s",
            args.output.display(),
            dataset.scalar(),
            bytes(built.length),
            bytes(raw),
            100.0 * built.length as f64 / raw as f64,
            dims.samples() as f64 / seconds / 1e6,
        )
    })
}

struct Built {
    /// Bytes of the file.
    length: u64,
    meta: Meta,
}

fn convert<T: Scalar>(dataset: &Dataset, args: &BuildArgs) -> Result<Built> {
    let mut slabs = dataset.slabs::<T>()?;
    let mut bar = Progress::new("building");
    let limit = args.memory.unwrap_or_else(|| memory_of_machine() / 4);
    let affine = dataset.index_to_world();
    let (length, meta) =
        build_file(&mut slabs, affine, &args.output, Some(limit), |p| bar.update(p.done, p.total))
            .map_err(|e| build_error(e, dataset.path()))?;
    drop(bar);
    slabs.warnings().iter().for_each(warn);
    Ok(Built { length, meta })
}

/// Bytes as a plain array, and as an `.ovol` file.
pub(crate) struct Sizes;

impl VolumeVisitor for Sizes {
    type Output = (u64, u64);
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> (u64, u64) {
        (volume.raw_bytes() as u64, volume.file_bytes() as u64)
    }
}
