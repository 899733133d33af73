//! The volumes that checks and benchmarks run on, and the views of them.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use glam::{DAffine3, DQuat, DVec3};
use isoray_benches::volumes::{marschner_lobb, turbulence};
use isoray_build::build;
use isoray_grid::{DenseVolume, Dims, Scalar, ScalarType, SlabSource};
use isoray_io::{Dataset, Endian, OpenOptions, RawLayout, SampleType};
use isoray_octree::OctreeVolume;
use isoray_render::{Camera, Projection, View};
use isoray_synth::{Mixing, MixingParams};

use crate::root;

/// Where a volume comes from.
#[derive(Clone, Debug)]
enum Source {
    File { path: PathBuf, raw: Option<RawLayout> },
    MarschnerLobb(u32),
    Turbulence(u32),
    Mixing(u32, f64),
}

/// A volume with the isovalues worth looking at.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) name: String,
    pub(crate) isovalues: Vec<f32>,
    source: Source,
}

/// A volume of any type, dense, with its placement.
pub(crate) struct Dense<T> {
    pub(crate) dims: Dims,
    pub(crate) samples: Vec<T>,
    pub(crate) index_to_world: DAffine3,
}

/// The folder of real volumes: the one that was given, which has to be there, or the one beside the repository, which need not.
pub(crate) fn data_folder(given: Option<&Path>) -> Result<PathBuf> {
    if let Some(folder) = given {
        ensure!(folder.is_dir(), "--data {}: expected a folder, found none", folder.display());
    }
    Ok(given.map_or_else(|| root().join("../shared/data"), Path::to_owned))
}

/// Something to do with a volume in its own type.
pub(crate) trait DenseVisitor {
    type Output;
    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output;
}

impl Entry {
    /// The bundled scan.
    pub(crate) fn fixture() -> Self {
        Self::file("tooth (fixture)", root().join("fixtures/tooth/tooth.nrrd"), &[600.0, 1050.0])
    }

    /// The volume of Marschner and Lobb, `n`³.
    pub(crate) fn marschner_lobb(n: u32) -> Self {
        let source = Source::MarschnerLobb(n);
        Self { name: format!("Marschner-Lobb {n}"), isovalues: vec![127.5], source }
    }

    /// Two fluids and a turbulent layer between them, `n`³.
    pub(crate) fn turbulence(n: u32) -> Self {
        Self { name: format!("turbulence {n}"), isovalues: vec![100.0], source: Source::Turbulence(n) }
    }

    /// A mixing layer of two fluids, `n`³, at a time from 0 to 1.
    pub(crate) fn mixing(n: u32, time: f64, isovalue: f32) -> Self {
        let source = Source::Mixing(n, time);
        Self { name: format!("mixing {n}, t = {time:.2}"), isovalues: vec![isovalue], source }
    }

    /// Whether it was measured or simulated, not generated here.
    pub(crate) fn is_real(&self) -> bool {
        matches!(self.source, Source::File { .. })
    }

    fn file(name: &str, path: PathBuf, isovalues: &[f32]) -> Self {
        Self {
            name: name.to_owned(),
            isovalues: isovalues.to_vec(),
            source: Source::File { path, raw: None },
        }
    }

    /// The structured volumes of the data folder that are there.
    pub(crate) fn real(data: &Path) -> Vec<Self> {
        let mut known = Self::known(data);
        known.retain(Self::is_there);
        known
    }

    fn is_there(&self) -> bool {
        match &self.source {
            Source::File { path, .. } => path.is_file(),
            _ => true,
        }
    }

    /// Says which of the known volumes the data folder lacks.
    pub(crate) fn tell_missing(data: &Path) {
        if !data.is_dir() {
            return println!("SKIPPED: the real volumes; there is no folder {}", data.display());
        }
        for entry in Self::known(data).iter().filter(|entry| !entry.is_there()) {
            if let Source::File { path, .. } = &entry.source {
                println!("SKIPPED: {}; there is no file {}", entry.name, path.display());
            }
        }
    }

    /// Every structured volume that a data folder may have; the suggested isovalues are those of its README.
    fn known(data: &Path) -> Vec<Self> {
        let volumes = data.join("volumes");
        let file =
            |name: &str, file: &str, isovalues: &[f32]| Self::file(name, volumes.join(file), isovalues);
        let raw = |mut entry: Self, dims, sample, spacing| {
            if let Source::File { raw, .. } = &mut entry.source {
                *raw =
                    Some(RawLayout { dims, sample, endian: Endian::Little, skip: 0, spacing, origin: None });
            }
            entry
        };
        vec![
            file("heptane", "csafe_heptane.nrrd", &[42.0, 30.0, 100.0]),
            file("CT head", "cthead/cthead.mhd", &[600.0, 1400.0]),
            file("Visible Human head", "visible_human_head.nrrd", &[25.0, 80.0]),
            file("chest CT", "lidc_0314.nrrd", &[-400.0, 250.0]),
            raw(
                file("cranium", "cranium/cranium_256x256x108_i16le.raw", &[-300.0, 300.0]),
                [256, 256, 108],
                SampleType::I16,
                Some([0.957, 0.957, 1.5]),
            ),
            file("tooth", "tooth/tooth.nhdr", &[600.0, 1050.0]),
            file("bonsai", "bonsai.nii.gz", &[40.0, 150.0]),
            file("engine", "engine.nii.gz", &[80.0, 180.0]),
            file("stent", "stent.nrrd", &[0.15, 0.5]),
            raw(file("nucleon", "nucleon_41x41x41_u8.raw", &[90.0, 160.0]), [41; 3], SampleType::U8, None),
        ]
    }

    /// The bundled volume, those generated, and the real ones that are there.
    pub(crate) fn all(generated: &[Self], data: &Path) -> Vec<Self> {
        let mut entries = vec![Self::fixture()];
        entries.extend_from_slice(generated);
        entries.extend(Self::real(data));
        entries
    }

    /// Of the volumes named like `only`, or else of those with one of these names; of the bundled one, where none of these is there.
    pub(crate) fn chosen(entries: Vec<Self>, only: Option<&str>, names: &[&str]) -> Vec<Self> {
        let is_chosen = |entry: &Self| match only {
            Some(only) => entry.name.contains(only),
            None => names.contains(&entry.name.as_str()),
        };
        let chosen: Vec<_> = entries.into_iter().filter(is_chosen).collect();
        if chosen.is_empty() && only.is_none() { vec![Self::fixture()] } else { chosen }
    }

    /// Those whose name contains `only`; an error if there are none.
    pub(crate) fn named_like(mut entries: Vec<Self>, only: Option<&str>) -> Result<Vec<Self>> {
        let only = only.unwrap_or_default();
        entries.retain(|e| e.name.contains(only));
        ensure!(!entries.is_empty(), "no volume is named like {only:?}");
        Ok(entries)
    }

    /// Reads or generates the volume and hands it to `visitor`.
    pub(crate) fn visit<V: DenseVisitor>(&self, visitor: V) -> Result<V::Output> {
        match &self.source {
            Source::MarschnerLobb(n) => Ok(visitor.visit(&generated(*n, marschner_lobb(*n as usize))?)),
            Source::Turbulence(n) => Ok(visitor.visit(&generated(*n, turbulence(*n as usize))?)),
            Source::Mixing(n, time) => {
                let params = MixingParams { time: *time, ..MixingParams::default() };
                let dims = Dims::new([*n; 3])?;
                let mut samples = vec![0; dims.samples()];
                Mixing::new(dims, params)?.read_layers(0, &mut samples)?;
                Ok(visitor.visit(&generated(*n, samples)?))
            }
            Source::File { path, raw } => {
                let options = OpenOptions { raw: raw.clone(), ..Default::default() };
                let dataset = Dataset::open(path, &options)?;
                Ok(match dataset.scalar() {
                    ScalarType::U8 => visitor.visit(&read::<u8>(&dataset)?),
                    // None of them is, and everything would be compiled once more.
                    ScalarType::I8 => {
                        bail!("{}: expected samples of u8, u16, i16 or f32, found i8", path.display())
                    }
                    ScalarType::U16 => visitor.visit(&read::<u16>(&dataset)?),
                    ScalarType::I16 => visitor.visit(&read::<i16>(&dataset)?),
                    ScalarType::F32 => visitor.visit(&read::<f32>(&dataset)?),
                })
            }
        }
    }
}

fn generated(n: u32, samples: Vec<u8>) -> Result<Dense<u8>> {
    Ok(Dense { dims: Dims::new([n; 3])?, samples, index_to_world: DAffine3::IDENTITY })
}

fn read<T: Scalar>(dataset: &Dataset) -> Result<Dense<T>> {
    let mut slabs = dataset.slabs::<T>()?;
    let mut samples = vec![T::default(); dataset.dims().samples()];
    slabs.read_layers(0, &mut samples)?;
    Ok(Dense { dims: dataset.dims(), samples, index_to_world: dataset.index_to_world() })
}

impl<T: Scalar> Dense<T> {
    pub(crate) fn octree(&self) -> Result<OctreeVolume<T>> {
        let mut source = DenseVolume::new(self.dims, &self.samples)?;
        build(&mut source, self.index_to_world, |_| {}).context("cannot build the octree")
    }

    /// A camera that stands at `place` and makes `size²` pixels.
    pub(crate) fn camera(&self, place: Place, size: u32) -> Result<Camera> {
        Ok(Camera::new(&place.view(self.dims, &self.index_to_world), [size; 2])?)
    }

    /// The far camera, gone round the upright axis through the volume's centre by an angle in degrees.
    pub(crate) fn orbiting_camera(&self, degrees: f64, size: u32) -> Result<Camera> {
        let view = Place::Far.view(self.dims, &self.index_to_world);
        let turn = DQuat::from_axis_angle(view.up, degrees.to_radians());
        let eye = view.look_at + turn * (view.eye - view.look_at);
        Ok(Camera::new(&View { eye, ..view }, [size; 2])?)
    }
}

/// Where cameras stand, relative to the volume's centre and its longest side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Far,
    Close,
    Inside,
    /// Orthographic along z, rays exactly in lattice planes where a pixel's size divides a voxel's.
    Along,
}

impl Place {
    pub(crate) const ALL: [Self; 4] = [Self::Far, Self::Close, Self::Inside, Self::Along];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Far => "far",
            Self::Close => "close",
            Self::Inside => "inside",
            Self::Along => "along z",
        }
    }

    pub(crate) fn view(self, dims: Dims, index_to_world: &DAffine3) -> View {
        let last = DVec3::from_array(dims.axes().map(|n| f64::from(n - 1)));
        let centre = index_to_world.transform_point3(last / 2.0);
        let sides = (0..3).map(|a| index_to_world.matrix3.col(a).length() * f64::from(dims.axes()[a]));
        let longest = sides.fold(0.0, f64::max);
        let perspective = Projection::Perspective { fov: 45.0 };
        let from = |offset: DVec3| View {
            eye: centre + longest * offset,
            look_at: centre,
            up: DVec3::Y,
            projection: perspective,
        };
        match self {
            Self::Far => from(DVec3::new(1.1, 0.9, 1.3)),
            Self::Close => from(DVec3::new(0.25, 0.2, 0.3)),
            Self::Inside => {
                let eye = centre + longest * DVec3::new(0.031, -0.023, 0.017);
                View { look_at: eye + DVec3::new(-0.7, 0.4, 0.6), ..View { eye, ..from(DVec3::X) } }
            }
            Self::Along => {
                let eye = centre - longest * DVec3::Z;
                View {
                    projection: Projection::Orthographic { height: longest },
                    ..View { eye, ..from(DVec3::X) }
                }
            }
        }
    }
}
