//! From a volume of any kind to an octree volume in a file.

use std::path::Path;

use anyhow::{Context, Result};
use glam::DAffine3;
use isoray_build::{FileOptions, Isovalues, Loss, Lossy, SurfaceTolerance, build_file};
use isoray_grid::{Scalar, ScalarType, SlabSource};
use isoray_io::Dataset;
use isoray_octree::{Coarse, Fidelity, Meta, OctreeVolume, SurfaceFidelity, VolumeVisitor};

use crate::cli::{BuildArgs, CoarseArg, LevelArgs, LossArgs, Surfaces};
use crate::failure::{usage, warn};
use crate::load::{build_error, is_octree_volume, open_dataset, open_octree_volume, warn_about};
use crate::memory::memory_of_machine;
use crate::progress::Progress;

/// What was made of a volume.
pub(crate) struct Built {
    pub(crate) scalar: ScalarType,
    /// Bytes of the file.
    pub(crate) length: u64,
    pub(crate) meta: Meta,
}

impl Built {
    /// Bytes of the samples as a plain array.
    pub(crate) fn raw(&self) -> u64 {
        self.meta.dims.samples() as u64 * self.scalar.size() as u64
    }
}

/// Builds one volume of any type from a file or a folder of slices.
pub(crate) fn convert(input: &Path, output: &Path, args: &BuildArgs) -> Result<Built> {
    if !is_octree_volume(input, &args.source)? {
        return convert_dataset(&open_dataset(input, &args.source)?, output, args);
    }
    let conversion = Conversion { input, output, args, loss: args.loss.loss()? };
    let built = open_octree_volume(input, &args.source)?.visit(conversion)?;
    warn_about(input, &built.meta);
    Ok(built)
}

/// Builds one volume of any type from an open file.
pub(crate) fn convert_dataset(dataset: &Dataset, output: &Path, args: &BuildArgs) -> Result<Built> {
    let conversion = Conversion { input: dataset.path(), output, args, loss: args.loss.loss()? };
    let built = match dataset.scalar() {
        ScalarType::U8 => conversion.of_dataset::<u8>(dataset)?,
        ScalarType::I8 => conversion.of_dataset::<i8>(dataset)?,
        ScalarType::U16 => conversion.of_dataset::<u16>(dataset)?,
        ScalarType::I16 => conversion.of_dataset::<i16>(dataset)?,
        ScalarType::F32 => conversion.of_dataset::<f32>(dataset)?,
    };
    warn_about(dataset.path(), &built.meta);
    Ok(built)
}

struct Conversion<'a> {
    input: &'a Path,
    output: &'a Path,
    args: &'a BuildArgs,
    loss: Option<Loss>,
}

impl Conversion<'_> {
    fn of_dataset<T: Scalar>(&self, dataset: &Dataset) -> Result<Built> {
        let mut slabs = dataset.slabs::<T>()?;
        let built = self.of_source(&mut slabs, dataset.index_to_world(), Fidelity::LOSSLESS)?;
        slabs.warnings().iter().for_each(warn);
        Ok(built)
    }

    /// `fidelity` is that of the source itself.
    fn of_source<T: Scalar, S: SlabSource<T> + Send>(
        &self,
        source: &mut S,
        index_to_world: DAffine3,
        fidelity: Fidelity,
    ) -> Result<Built> {
        let options = FileOptions {
            index_to_world,
            fidelity,
            coarse: self.args.levels.coarse(),
            memory: Some(self.args.memory.unwrap_or_else(|| memory_of_machine() / 4)),
        };
        let Some(loss) = &self.loss else { return self.write(source, &options) };
        if !fidelity.is_lossless() {
            let input = self.input.display();
            return Err(usage(format!(
                "{input}: has lost something already, and bounds would not be those of the original"
            )));
        }
        let mut lossy = Lossy::new(source, loss).context("a loss that cannot be meant")?;
        self.write(&mut lossy, &FileOptions { fidelity: promise(loss), ..options })
    }

    fn write<T: Scalar, S: SlabSource<T> + Send>(
        &self,
        source: &mut S,
        options: &FileOptions,
    ) -> Result<Built> {
        let mut bar = Progress::of_voxels("building");
        let progress = |p: isoray_build::Progress| bar.update(p.done, p.total);
        let (length, meta) =
            build_file(source, self.output, options, progress).map_err(|e| build_error(e, self.input))?;
        Ok(Built { scalar: T::TYPE, length, meta })
    }
}

impl VolumeVisitor for Conversion<'_> {
    type Output = Result<Built>;
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Result<Built> {
        let meta = volume.meta();
        self.of_source(&mut volume.view(), meta.index_to_world, meta.fidelity)
    }
}

impl LevelArgs {
    fn coarse(&self) -> Coarse {
        match self.lod {
            _ if self.no_lod => Coarse::None,
            None | Some(CoarseArg::Injected) => Coarse::Injected,
            Some(CoarseArg::Mean) => Coarse::Mean,
            Some(CoarseArg::Filtered) => Coarse::Filtered,
        }
    }
}

impl LossArgs {
    /// What the flags allow to be lost, if anything.
    pub(crate) fn loss(&self) -> Result<Option<Loss>> {
        let surface = self.surface_tolerance.zip(self.surfaces.clone());
        if self.tolerance.is_none() && surface.is_none() && self.range.is_none() {
            return Ok(None);
        }
        let surface = surface.map(|(displacement, surfaces)| SurfaceTolerance {
            displacement,
            isovalues: match surfaces {
                Surfaces::List(values) => Isovalues::List(values),
                Surfaces::Range(ends) => Isovalues::Range(ends),
            },
        });
        let loss = Loss { tolerance: self.tolerance.unwrap_or(f64::INFINITY), surface, range: self.range };
        loss.check().map_err(|e| usage(e.to_string()))?;
        Ok(Some(loss))
    }
}

/// What a loss leaves.
fn promise(loss: &Loss) -> Fidelity {
    let surface = loss.surface.as_ref().map(|surface| {
        let (isovalues, is_range) = match &surface.isovalues {
            Isovalues::Range(ends) => (*ends, true),
            Isovalues::List(values) => {
                let least = values.iter().copied().fold(f32::INFINITY, f32::min);
                ([least, values.iter().copied().fold(f32::NEG_INFINITY, f32::max)], false)
            }
        };
        let isovalues = isovalues.map(f64::from);
        SurfaceFidelity { displacement: surface.displacement, isovalues, is_range }
    });
    Fidelity { tolerance: loss.tolerance, surface, range: loss.range }
}
