//! `isoray build`.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use glam::DAffine3;
use isoray_build::build_file;
use isoray_grid::{Scalar, ScalarType, SlabSource};
use isoray_io::Dataset;
use isoray_octree::{Meta, OctreeVolume, VolumeVisitor};

use super::{bytes, use_threads};
use crate::cli::BuildArgs;
use crate::failure::warn;
use crate::load::{build_error, is_octree_volume, open_dataset, open_octree_volume, warn_about};
use crate::memory::memory_of_machine;
use crate::output::{check_output, to_stdout};
use crate::progress::Progress;

pub(crate) fn run(args: &BuildArgs) -> Result<()> {
    use_threads(args.threads)?;
    check_output(&args.output, &[&args.input])?;
    let begin = Instant::now();
    let built = convert(&args.input, &args.output, args)?;
    let seconds = begin.elapsed().as_secs_f64();
    warn_about(&args.input, &built.meta);
    let dims = built.meta.dims;
    let raw = dims.samples() as u64 * built.scalar.size() as u64;
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

/// What was made of a volume.
struct Built {
    scalar: ScalarType,
    /// Bytes of the file.
    length: u64,
    meta: Meta,
}

/// Builds one volume of any type.
fn convert(input: &Path, output: &Path, args: &BuildArgs) -> Result<Built> {
    let conversion = Conversion { input, output, args };
    if is_octree_volume(input, &args.source)? {
        return open_octree_volume(input, &args.source)?.visit(conversion);
    }
    let dataset = open_dataset(input, &args.source)?;
    match dataset.scalar() {
        ScalarType::U8 => conversion.of_dataset::<u8>(&dataset),
        ScalarType::I8 => conversion.of_dataset::<i8>(&dataset),
        ScalarType::U16 => conversion.of_dataset::<u16>(&dataset),
        ScalarType::I16 => conversion.of_dataset::<i16>(&dataset),
        ScalarType::F32 => conversion.of_dataset::<f32>(&dataset),
    }
}

struct Conversion<'a> {
    input: &'a Path,
    output: &'a Path,
    args: &'a BuildArgs,
}

impl Conversion<'_> {
    fn of_dataset<T: Scalar>(&self, dataset: &Dataset) -> Result<Built> {
        let mut slabs = dataset.slabs::<T>()?;
        let built = self.of_source(&mut slabs, dataset.index_to_world())?;
        slabs.warnings().iter().for_each(warn);
        Ok(built)
    }

    fn of_source<T: Scalar, S: SlabSource<T> + Send>(
        &self,
        source: &mut S,
        index_to_world: DAffine3,
    ) -> Result<Built> {
        let mut bar = Progress::new("building");
        let limit = self.args.memory.unwrap_or_else(|| memory_of_machine() / 4);
        let progress = |p: isoray_build::Progress| bar.update(p.done, p.total);
        let (length, meta) = build_file(source, index_to_world, self.output, Some(limit), progress)
            .map_err(|e| build_error(e, self.input))?;
        Ok(Built { scalar: T::TYPE, length, meta })
    }
}

impl VolumeVisitor for Conversion<'_> {
    type Output = Result<Built>;
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Result<Built> {
        self.of_source(&mut volume.view(), volume.meta().index_to_world)
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
