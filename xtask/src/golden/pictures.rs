//! Pictures of every feature: against the oracle, and by ꟻLIP against stored ones.

use anyhow::{Context, Result};
use glam::DAffine3;
use isoray_grid::{DenseVolume, Dims, GridVolume, Scalar};
use isoray_octree::lod::{Detail, DetailRequest, DetailView, DistanceMeasure};
use isoray_octree::{Coarse, OctreeView};
use isoray_oracle::{DenseLattice, Lattice};
use isoray_render::{Camera, FarShadowed, Image, SURFACE_COLOR, Scene, Surface, SurfaceSource, render};

use super::compared::{Compared, over_background};
use super::glow;
use super::picture::Difference;
use super::reference::References;
use super::scenes::{Levels, Look, Of, PictureScene, SCENES, Surfaces};
use super::subjects::Extent;
use super::truth::{ByPlace, Truth};
use super::verify::{differing_traversals, is_same};
use crate::catalog::{Dense, DenseVisitor};

/// Titles of the columns.
pub(crate) const HEADER: &str = "pictures                                              compared doubtful  unlit  wrong | voxels max  degrees 99% | colours: 99%       max | FLIP: mean      max  pixels steps";

/// Pixels along each side.
pub(crate) const SIZE: u32 = 64;

/// Mean and largest ꟻLIP of a picture and the stored one. Builds for plain x86-64, x86-64-v3 and the machine's own instructions give the stored pictures, to the byte. What may
/// differ elsewhere is a colour next to the border of two steps of 8 bits, 5·10⁻² at most in a pixel and 9·10⁻⁴ in the mean if 1 % of the pixels do, and a ray that grazes: a
/// pixel that changes side is 0.3 at most, and 1.5·10⁻³ in the mean. Half a voxel in all rays is
/// 3.4·10⁻³ in the mean or more.
const FLIP_MEAN: f64 = 1.5e-3;
const FLIP_MAX: f64 = 0.3;

/// Roundings to 32 bits of a value of a field with levels of detail.
const ROUNDINGS: f64 = 8.0;

/// The volume's own samples.
const EXACT: Precision = Precision { scale: 1.0, rounding: 0.0, has_colors: true };

/// Scenes of one volume, in turn.
pub(crate) struct Pictures<'r> {
    pub(crate) scenes: Vec<&'static PictureScene>,
    pub(crate) references: &'r mut References,
}

impl PictureScene {
    pub(crate) fn title(&self) -> String {
        format!("{}, {}", self.of.name(), self.name)
    }

    /// What tells it from others of the same picture.
    fn long_title(&self) -> String {
        match self.of {
            Of::Rings(scalar) => format!("{}, {scalar}", self.title()),
            _ => self.title(),
        }
    }
}

/// Checks all whose names contain `only`; the bounds that are broken.
pub(crate) fn check(only: Option<&str>, references: &mut References) -> Result<Vec<String>> {
    let mut failures = Vec::new();
    for scenes in SCENES.chunk_by(|a, b| a.of == b.of) {
        let is_wanted = |scene: &&PictureScene| only.is_none_or(|only| scene.title().contains(only));
        let scenes: Vec<_> = scenes.iter().filter(is_wanted).collect();
        let Some(first) = scenes.first() else { continue };
        let of = first.of;
        let pictures = Pictures { scenes, references: &mut *references };
        failures.extend(match of {
            Of::Mesh(number) => super::mesh_pictures::pictures(number, pictures)?,
            _ => of.visit(pictures)??,
        });
    }
    Ok(failures)
}

impl DenseVisitor for Pictures<'_> {
    type Output = Result<Vec<String>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let samples = volume.samples.iter().map(|sample| sample.to_f32()).collect();
        let lattice = DenseLattice::from_vec(volume.dims.axes(), samples)
            .context("the samples do not fill the lattice")?;
        let grid = GridVolume::new(DenseVolume::new(volume.dims, &volume.samples)?);
        let mut failures = Vec::new();
        for scene in self.scenes {
            let camera = volume.camera(scene.from, SIZE)?;
            let (image, compared, mut broken) = match &scene.look {
                Look::Volume(look) => glow::dense(look, scene.of, &octree, &lattice, &camera)?,
                Look::Surfaces(look) => {
                    let subject =
                        Subject { dims: volume.dims, to_world: volume.index_to_world, camera: &camera };
                    let colors = ByPlace(volume.dims.axes());
                    let drawn = subject.scene(look, scene.of, look.by_place.then_some(&colors));
                    match look.levels {
                        Some(levels) => {
                            subject.levels(&octree.view(), levels, &drawn, &scene.long_title())?
                        }
                        None => {
                            let (image, compared, mut broken) = subject.compared(
                                &octree.view(),
                                &lattice,
                                EXACT,
                                &drawn,
                                &scene.long_title(),
                            )?;
                            let of_grid = render(&grid, subject.to_world, &camera, &drawn);
                            if !is_same(&of_grid, &image) {
                                broken.push("another picture by the grid".to_owned());
                            }
                            (image, compared, broken)
                        }
                    }
                }
            };
            broken.extend(against_reference(scene, &image, compared.as_ref(), self.references)?);
            let title = scene.long_title();
            failures.extend(broken.into_iter().map(|what| format!("{title}: {what}")));
        }
        Ok(failures)
    }
}

/// A picture, how it compares with the oracle, if the oracle has something to say, and what is wrong.
pub(crate) type Outcome = (Image, Option<Compared>, Vec<String>);

/// What the oracle's lattice is to the volume; see [`Truth`].
#[derive(Clone, Copy)]
pub(crate) struct Precision {
    pub(crate) scale: f32,
    pub(crate) rounding: f64,
    pub(crate) has_colors: bool,
}

/// A volume that is looked at.
pub(crate) struct Subject<'a> {
    pub(crate) dims: Dims,
    pub(crate) to_world: DAffine3,
    pub(crate) camera: &'a Camera,
}

impl Subject<'_> {
    pub(crate) fn scene<'c>(&self, look: &Surfaces, of: Of, colors: Option<&'c ByPlace>) -> Scene<'c> {
        let extent = Extent::new(self.dims, &self.to_world);
        const COLORS: [[f32; 3]; 2] = [[0.85, 0.35, 0.2], [0.3, 0.5, 0.85]];
        let last = look.surfaces.len() - 1;
        let surface = |(n, &(value, opacity)): (usize, &(f32, f32))| Surface {
            isovalue: of.own(value),
            color: if n == last { SURFACE_COLOR } else { COLORS[n % 2].into() },
            opacity,
        };
        Scene {
            surfaces: look.surfaces.iter().enumerate().map(surface).collect(),
            normals: look.normals,
            lights: look.lamps.iter().map(|&lamp| extent.light(lamp)).collect(),
            specular: look.specular,
            shadows: look.shadows,
            sky_samples: look.sky_samples,
            clip: extent.clip(look.cuts),
            cap: look.cap,
            colors: colors.map(|colors| colors as _),
            level_colors: look.by_level,
            ..Scene::of(0.0)
        }
    }

    /// Renders a scene by all ways that rays can go, and compares it with the oracle.
    pub(crate) fn compared<S: SurfaceSource, L: Lattice>(
        &self,
        source: &S,
        lattice: &L,
        Precision { scale, rounding, has_colors }: Precision,
        scene: &Scene<'_>,
        title: &str,
    ) -> Result<Outcome> {
        let image = render(source, self.to_world, self.camera, scene);
        let mut broken = differing_traversals(source, self.to_world, self.camera, scene, &image);
        let truth = Truth {
            lattice,
            scale,
            rounding,
            index_to_world: self.to_world,
            camera: self.camera,
            scene,
            has_colors,
        };
        let (compared, shown) = Compared::surfaces(&truth, &image, title)?;
        broken.extend(compared.failures());
        broken.extend(shown.map(|path| format!("the oracle's picture beside it: {}", path.display())));
        Ok((image, Some(compared), broken))
    }

    /// Levels of detail: the oracle has the field that they make together, sample by sample of the finest lattice, on which each coarser cell's interpolant is the same.
    fn levels<T: Scalar>(
        &self,
        octree: &OctreeView<'_, T>,
        levels: Levels,
        scene: &Scene<'_>,
        title: &str,
    ) -> Result<Outcome> {
        let measure = match levels.by_slices {
            true => DistanceMeasure::Slices(self.camera.forward()),
            false => DistanceMeasure::True,
        };
        let Levels { ratio, blend, .. } = levels;
        let request = DetailRequest { pixel: self.camera.pixel_width(), ratio, measure, blend };
        let view =
            DetailView::new(octree, Coarse::Injected, Detail::new(self.dims, &self.to_world, &request));
        let lattice = DenseLattice::from_fn(self.dims.axes(), |p| view.vertex(p));
        let largest = lattice.samples().iter().fold(0f32, |m, v| m.max(v.abs()));
        let fine = Precision {
            rounding: ROUNDINGS * f64::from(f32::EPSILON) / 2.0 * f64::from(largest),
            has_colors: !(scene.level_colors || levels.far_shadows),
            ..EXACT
        };
        if levels.far_shadows {
            return self.compared(&FarShadowed { picture: &view, far: &view }, &lattice, fine, scene, title);
        }
        self.compared(&view, &lattice, fine, scene, title)
    }
}

/// Compares a picture with the stored one, and prints its row; what is wrong.
pub(crate) fn against_reference(
    scene: &PictureScene,
    image: &Image,
    compared: Option<&Compared>,
    references: &mut References,
) -> Result<Option<String>> {
    let is_allowed = |d: &Difference| d.mean <= FLIP_MEAN && d.max <= FLIP_MAX;
    let outcome = references.picture(&scene.title(), &over_background(image), is_allowed)?;
    let flip = outcome.as_ref().map_or([0.0; 2], |(d, _)| [d.mean, d.max]);
    let (pixels, steps) = outcome.as_ref().map_or((0, 0), |(d, _)| (d.pixels, d.steps));
    let left = match compared {
        None => format!("{:>96}", ""),
        Some(c) => {
            let [voxels, degrees, color, largest] = c.errors();
            format!(
                "{:>8} {:>8} {:>6} {:>6} | {voxels:>10.1e} {degrees:>12.1e} | {color:>12.1e} {largest:>9.1e}",
                c.pixels - c.doubtful,
                c.doubtful,
                c.unlit,
                c.wrong.len()
            )
        }
    };
    println!(
        "{:<53} {left} | {:>10.1e} {:>8.1e} {pixels:>7} {steps:>5}",
        scene.long_title(),
        flip[0],
        flip[1]
    );
    let Some((d, Some(shown))) = outcome else { return Ok(None) };
    Ok(Some(format!(
        "{} pixels differ from the stored picture, the first at {:?}, the worst at {:?}: FLIP of {:.2e} in the mean, expected {FLIP_MEAN}, and of {:.2e} at most, expected {FLIP_MAX}; {}",
        d.pixels,
        d.first,
        d.worst,
        d.mean,
        d.max,
        shown.display()
    )))
}
