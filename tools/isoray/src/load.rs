//! From a file name to an octree volume in memory.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use isoray_build::{BuildError, StoreError, build};
use isoray_grid::{Scalar, ScalarType};
use isoray_io::{AmrDataset, Dataset, OpenOptions, RawLayout};
use isoray_octree::{AnyVolume, Meta, OctreeVolume, Series, is_ovol, is_series};

use crate::cli::{Endian, InputArgs};
use crate::failure::{usage, warn};
use crate::mesh::{self, MeshDetail, MeshVolume, Prepare};
use crate::progress::Progress;

/// A volume, as it is traced.
pub(crate) enum Data {
    Octree(Box<AnyVolume>),
    Mesh(Box<MeshVolume>),
}

impl Data {
    pub(crate) fn meta(&self) -> &Meta {
        match self {
            Self::Octree(volume) => volume.meta(),
            Self::Mesh(mesh) => &mesh.meta,
        }
    }

    /// What level of detail leaves of a mesh.
    pub(crate) fn mesh_detail(&self) -> Option<MeshDetail> {
        match self {
            Self::Octree(_) => None,
            Self::Mesh(mesh) => mesh.detail,
        }
    }

    /// The octree, for what adaptive meshes do not have.
    pub(crate) fn octree(self, path: &Path) -> Result<AnyVolume> {
        match self {
            Self::Octree(volume) => Ok(*volume),
            Self::Mesh(_) => {
                let path = path.display();
                Err(usage(format!("{path}: expected a structured volume, found an adaptive mesh")))
            }
        }
    }
}

/// A volume that is ready, and what it took.
pub(crate) struct Loaded {
    pub(crate) volume: Data,
    /// Name of the file's format.
    pub(crate) format: String,
    /// Seconds until the header was read.
    pub(crate) open_s: f64,
    /// Seconds of compressing it; zero for an `.ovol` file.
    pub(crate) build_s: f64,
}

/// Opens an octree volume, or reads and compresses any other volume; warnings go to stderr.
pub(crate) fn load(path: &Path, args: &InputArgs) -> Result<Loaded> {
    load_prepared(path, args, None)
}

/// [`load`]; a mesh is made of what `prepare` leaves of its patches.
pub(crate) fn load_prepared(path: &Path, args: &InputArgs, prepare: Option<Prepare<'_>>) -> Result<Loaded> {
    if is_series(path) && path.is_dir() {
        let (path, count) = (path.display(), Series::open(path)?.len());
        return Err(usage(format!(
            "{path}: a series of {count} volumes: expected a single one, like a file in it"
        )));
    }
    let begin = Instant::now();
    let loaded = if AmrDataset::recognises(path) {
        return load_mesh(path, args, prepare);
    } else if args.border.is_some() {
        return Err(usage(format!("--border: expected an adaptive mesh, found {}", path.display())));
    } else if is_octree_volume(path, args)? {
        let (volume, format) = (open_octree_volume(path, args)?, "octree volume".to_owned());
        Loaded {
            volume: Data::Octree(Box::new(volume)),
            format,
            open_s: begin.elapsed().as_secs_f64(),
            build_s: 0.0,
        }
    } else {
        convert(path, args)?
    };
    warn_about(path, loaded.volume.meta());
    Ok(loaded)
}

fn load_mesh(path: &Path, args: &InputArgs, prepare: Option<Prepare<'_>>) -> Result<Loaded> {
    let begin = Instant::now();
    let dataset = mesh::open(path, args)?;
    let open_s = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let volume = Data::Mesh(Box::new(mesh::read(&dataset, args, prepare)?));
    let format = dataset.format().to_owned();
    Ok(Loaded { volume, format, open_s, build_s: begin.elapsed().as_secs_f64() })
}

/// Whether the file is an octree volume, or is called one and nothing else is said of it.
pub(crate) fn is_octree_volume(path: &Path, args: &InputArgs) -> Result<bool> {
    // A folder, which not every system can open, is a stack of slices.
    if path.is_dir() {
        return Ok(false);
    }
    let mut start = [0; 8];
    let mut file = File::open(path).with_context(|| format!("{}: cannot be opened", path.display()))?;
    let mut filled = 0;
    while let Ok(n @ 1..) = file.read(&mut start[filled..]) {
        filled += n;
    }
    let is_named_ovol = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ovol"));
    Ok(is_ovol(&start[..filled]) || (is_named_ovol && args.is_empty()))
}

pub(crate) fn open_octree_volume(path: &Path, args: &InputArgs) -> Result<AnyVolume> {
    if !args.is_empty() {
        return Err(usage(format!(
            "{}: an octree volume needs no --dims, --type, --endian, --skip, --spacing, --origin, --component or --field",
            path.display()
        )));
    }
    Ok(AnyVolume::open(path)?)
}

fn convert(path: &Path, args: &InputArgs) -> Result<Loaded> {
    let begin = Instant::now();
    let dataset = open_dataset(path, args)?;
    let open_s = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let volume: AnyVolume = match dataset.scalar() {
        ScalarType::U8 => compress::<u8>(&dataset)?.into(),
        ScalarType::I8 => compress::<i8>(&dataset)?.into(),
        ScalarType::U16 => compress::<u16>(&dataset)?.into(),
        ScalarType::I16 => compress::<i16>(&dataset)?.into(),
        ScalarType::F32 => compress::<f32>(&dataset)?.into(),
    };
    let (volume, format) = (Data::Octree(Box::new(volume)), dataset.format().to_owned());
    Ok(Loaded { volume, format, open_s, build_s: begin.elapsed().as_secs_f64() })
}

/// Opens a file that is no octree volume; warnings go to stderr.
pub(crate) fn open_dataset(path: &Path, args: &InputArgs) -> Result<Dataset> {
    if AmrDataset::recognises(path) {
        let path = path.display();
        return Err(usage(format!(
            "{path}: expected a structured volume, found an adaptive mesh, which is rendered as it is"
        )));
    }
    let dataset = Dataset::open(path, &args.options()?)?;
    dataset.warnings().iter().for_each(warn);
    Ok(dataset)
}

fn compress<T: Scalar>(dataset: &Dataset) -> Result<OctreeVolume<T>> {
    let mut slabs = dataset.slabs::<T>()?;
    let mut bar = Progress::of_voxels("building");
    let volume = build(&mut slabs, dataset.index_to_world(), |p| bar.update(p.done, p.total))
        .map_err(|e| build_error(e, dataset.path()))?;
    slabs.warnings().iter().for_each(warn);
    Ok(volume)
}

/// With the name of the input, unless the error names its file itself.
pub(crate) fn build_error<E: std::error::Error + Send + Sync + 'static>(
    error: BuildError<E>,
    input: &Path,
) -> anyhow::Error {
    match error {
        BuildError::Source(e) => e.into(),
        BuildError::Store(StoreError::Save(e)) => e.into(),
        e => anyhow::Error::new(e)
            .context(format!("{}: cannot be built into an octree volume", input.display())),
    }
}

/// Warns of what a volume has or lacks.
pub(crate) fn warn_about(path: &Path, meta: &Meta) {
    if meta.non_finite > 0 {
        let (count, samples) = (meta.non_finite, meta.dims.samples());
        warn(format!(
            "{}: {count} of {samples} samples are NaN or infinite; the cells that touch them are empty",
            path.display()
        ));
    }
    if meta.dims.cells() == 0 {
        warn(format!("{}: a {} volume has no cells, and so no surface", path.display(), meta.dims));
    }
}

impl InputArgs {
    /// Whether none of the flags was given.
    pub(crate) fn is_empty(&self) -> bool {
        self.component.is_none() && self.field.is_none() && self.border.is_none() && !self.describes_raw()
    }

    pub(crate) fn describes_raw(&self) -> bool {
        self.dims.is_some()
            || self.sample.is_some()
            || self.endian.is_some()
            || self.skip.is_some()
            || self.spacing.is_some()
            || self.origin.is_some()
    }

    /// The layout that the flags describe, if they describe one.
    pub(crate) fn options(&self) -> Result<OpenOptions> {
        let raw = match (self.dims, self.sample) {
            (Some(dims), Some(sample)) => Some(RawLayout {
                dims,
                sample,
                endian: match self.endian {
                    Some(Endian::Big) => isoray_io::Endian::Big,
                    Some(Endian::Little) | None => isoray_io::Endian::Little,
                },
                skip: self.skip.unwrap_or(0),
                spacing: self.spacing.map(|s| s.to_array()),
                origin: self.origin.map(|o| o.to_array()),
            }),
            (dims, _) if self.describes_raw() => {
                let missing = match dims {
                    None => "--dims X,Y,Z",
                    Some(_) => "--type TYPE",
                };
                return Err(usage(format!(
                    "{missing} is missing: the layout of a raw file needs --dims and --type, and may have --endian, --skip, --spacing and --origin"
                )));
            }
            _ => None,
        };
        Ok(OpenOptions { raw, component: self.component, field: self.field.clone() })
    }
}
