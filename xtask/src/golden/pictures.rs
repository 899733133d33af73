//! Pictures of every feature: against the oracle, and by ꟻLIP against stored ones.

use anyhow::{Context, Result, ensure};
use isoray_build::{FileOptions, build_with};
use isoray_grid::{DenseVolume, GridVolume, Scalar};
use isoray_octree::lod::{Detail, DetailRequest, DetailView, DistanceMeasure};
use isoray_octree::{Coarse, OctreeVolume};
use isoray_oracle::DenseLattice;
use isoray_render::{FarShadowed, Image, Scene, render};
use rayon::prelude::*;

use super::compared::{Compared, over_background};
use super::detail_cells::DetailCells;
use super::detail_field::DetailField;
use super::eye::Eye;
use super::glow;
use super::isosurfaces::{Precision, Subject};
use super::off;
use super::reference::References;
use super::scenes::{Levels, Look, Of, PictureScene, SCENES, Surfaces};
use super::selection::Selection;
use super::truth::ByPlace;
use super::unlike::unlike;
use crate::catalog::{Dense, DenseVisitor};
use crate::for_oracle::{apart, breaks};

/// Titles of the columns.
pub(crate) const HEADER: &str = "pictures                                              compared doubtful  wrong  unlit %  vague   lit % | voxels max  degrees max   colours max | FLIP: mean      max  pixels steps | least seen: %, of";

/// Pixels along each side.
pub(crate) const SIZE: u32 = 64;

/// Roundings to 32 bits of a value of a field with levels of detail: one at each of up to four coarser levels that it is taken over from, and where these go over into the next level,
/// one each more.
const ROUNDINGS: f64 = 8.0;

/// The volume's own samples.
const EXACT: Precision<'_> = Precision { scale: 1.0, rounding: 0.0, cells: None, far_shadows: false };

/// Scenes of one volume, in turn.
pub(crate) struct Pictures<'r> {
    pub(crate) scenes: Vec<&'static PictureScene>,
    pub(crate) references: &'r mut References,
}

impl PictureScene {
    /// What it is stored as.
    pub(crate) fn title(&self) -> String {
        format!("{}, {}", self.of.name(), self.name)
    }

    /// What tells it from others of the same picture.
    pub(crate) fn long_title(&self) -> String {
        match self.of {
            Of::Rings(scalar) => format!("{}, {scalar}", self.title()),
            _ => self.title(),
        }
    }
}

/// Checks all that are wanted; the bounds that are broken.
pub(crate) fn check(selection: &Selection, references: &mut References) -> Result<Vec<String>> {
    let mut failures = Vec::new();
    for scenes in SCENES.chunk_by(|a, b| a.of == b.of) {
        let is_wanted = |scene: &&PictureScene| selection.wants(&scene.long_title());
        let scenes: Vec<_> = scenes.iter().filter(is_wanted).collect();
        let Some(first) = scenes.first() else { continue };
        let of = first.of;
        let pictures = Pictures { scenes, references: &mut *references };
        failures.extend(match of {
            Of::Mesh(number) | Of::ObliqueMesh(number) => super::mesh_pictures::pictures(number, pictures)?,
            _ => of.visit(pictures)??,
        });
    }
    Ok(failures)
}

impl DenseVisitor for Pictures<'_> {
    type Output = Result<Vec<String>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let samples: Vec<f32> = volume.samples.iter().map(|sample| sample.to_f32()).collect();
        let lattice = DenseLattice::from_vec(volume.dims.axes(), samples)
            .context("the samples do not fill the lattice")?;
        let mut failures = Vec::new();
        for scene in self.scenes {
            let title = scene.long_title();
            let eye = Eye::new(scene.from.view(volume.dims, &volume.index_to_world), SIZE)?;
            let seen = DenseScene { scene, volume, octree: &octree, lattice: &lattice, eye: &eye };
            let outcome = seen.outcome().with_context(|| title.clone())?;
            failures.extend(finished(scene, outcome, self.references, &volume.index_to_world, &eye)?);
        }
        Ok(failures)
    }
}

/// A picture, how it compares with the oracle, what is wrong, and what of it can be left out: pictures that ought to be others.
pub(crate) struct Outcome {
    pub(crate) image: Image,
    pub(crate) compared: Compared,
    pub(crate) broken: Vec<String>,
    pub(crate) without: Vec<(&'static str, Image)>,
}

/// A scene of a volume that is no mesh.
pub(crate) struct DenseScene<'a, T: Scalar> {
    pub(crate) scene: &'a PictureScene,
    pub(crate) volume: &'a Dense<T>,
    pub(crate) octree: &'a OctreeVolume<T>,
    pub(crate) lattice: &'a DenseLattice<f32>,
    pub(crate) eye: &'a Eye,
}

impl<T: Scalar + Into<f64>> DenseScene<'_, T> {
    fn outcome(&self) -> Result<Outcome> {
        let look = match &self.scene.look {
            Look::Volume(look) => return glow::dense(self, look),
            Look::Surfaces(look) => look,
        };
        let mut outcome = match look.levels {
            Some(levels) => self.levels(look, levels)?,
            None => {
                let colors = ByPlace(self.volume.dims.axes());
                let subject = self.subject(self.eye);
                let drawn = self.drawn(look, &colors);
                let title = self.scene.long_title();
                let view = self.octree.view();
                let mut outcome = subject.compared(&view, self.lattice, EXACT, &drawn, &title)?;
                let grid = GridVolume::new(DenseVolume::new(self.volume.dims, &self.volume.samples)?);
                let of_grid = render(&grid, subject.to_world, &self.eye.camera, &drawn);
                outcome.broken.extend(unlike(&of_grid, &outcome.image, "the grid", &title)?);
                outcome
            }
        };
        for (what, look) in off::surfaces(look) {
            outcome.without.push((what, self.image(&look, self.eye)?));
        }
        let moved = self.eye.moved(off::half_a_voxel(&self.volume.index_to_world))?;
        outcome.without.push((off::MOVED, self.image(look, &moved)?));
        Ok(outcome)
    }

    fn subject<'e>(&self, eye: &'e Eye) -> Subject<'e> {
        Subject { dims: self.volume.dims, to_world: self.volume.index_to_world, eye }
    }

    fn drawn<'c>(&self, look: &Surfaces, colors: &'c ByPlace) -> Scene<'c> {
        self.subject(self.eye).scene(look, self.scene.of, look.by_place.then_some(colors))
    }

    /// The picture alone.
    fn image(&self, look: &Surfaces, eye: &Eye) -> Result<Image> {
        let colors = ByPlace(self.volume.dims.axes());
        let drawn = self.drawn(look, &colors);
        let to_world = self.volume.index_to_world;
        let Some(levels) = look.levels else {
            return Ok(render(&self.octree.view(), to_world, &eye.camera, &drawn));
        };
        let octree = self.coarse(levels.coarse)?;
        let view = DetailView::new(&octree.view(), levels.coarse, self.detail(&levels, eye));
        Ok(match levels.far_shadows {
            true => render(&FarShadowed { picture: &view, far: &view }, to_world, &eye.camera, &drawn),
            false => render(&view, to_world, &eye.camera, &drawn),
        })
    }

    /// With coarse samples of a kind.
    fn coarse(&self, coarse: Coarse) -> Result<OctreeVolume<T>> {
        let mut source = DenseVolume::new(self.volume.dims, &self.volume.samples)?;
        let options =
            FileOptions { index_to_world: self.volume.index_to_world, coarse, ..FileOptions::default() };
        build_with(&mut source, &options, |_| {}).context("cannot build the octree")
    }

    fn detail(&self, levels: &Levels, eye: &Eye) -> Detail {
        let measure = match levels.by_slices {
            true => DistanceMeasure::Slices(eye.camera.forward()),
            false => DistanceMeasure::True,
        };
        let Levels { ratio, blend, .. } = *levels;
        let request = DetailRequest { pixel: eye.camera.pixel_width(), ratio, measure, blend };
        Detail::new(self.volume.dims, &self.volume.index_to_world, &request)
    }

    /// Levels of detail: the oracle has the field that they make together, sample by sample of the finest lattice, on which each coarser cell's interpolant is the same.
    fn levels(&self, look: &Surfaces, levels: Levels) -> Result<Outcome> {
        let Dense { dims, index_to_world, .. } = self.volume;
        let octree = self.coarse(levels.coarse)?;
        let view = DetailView::new(&octree.view(), levels.coarse, self.detail(&levels, self.eye));
        let own = DetailField::new(dims.axes(), self.lattice.samples(), &levels, index_to_world, self.eye)?;
        let lattice = own.lattice().context("the samples do not fill the lattice")?;
        let largest = lattice.samples().iter().fold(0f64, |m, v| m.max(v.abs()));
        let rounding = ROUNDINGS * f64::from(f32::EPSILON) / 2.0 * largest;
        let cells = DetailCells { field: &own, lattice: &lattice };
        let fine = Precision { rounding, cells: Some(&cells), far_shadows: levels.far_shadows, ..EXACT };
        let colors = ByPlace(dims.axes());
        let drawn = self.drawn(look, &colors);
        let title = self.scene.long_title();
        let subject = self.subject(self.eye);
        let mut outcome = match levels.far_shadows {
            true => {
                let source = FarShadowed { picture: &view, far: &view };
                subject.compared(&source, &lattice, fine, &drawn, &title)?
            }
            false => subject.compared(&view, &lattice, fine, &drawn, &title)?,
        };
        outcome.broken.extend(unlike_field(&view, &lattice, dims.axes(), rounding));
        Ok(outcome)
    }
}

/// Where the renderer's field is not the oracle's.
fn unlike_field<T: Scalar>(
    view: &DetailView<'_, T>,
    lattice: &DenseLattice<f64>,
    [nx, ny, nz]: [u32; 3],
    rounding: f64,
) -> Option<String> {
    let place = |n: u32| [n % nx, n / nx % ny, n / (nx * ny)];
    let off = |n: u32| apart(view.vertex(place(n)).into(), lattice.samples()[n as usize]);
    let all = (0..nx * ny * nz).into_par_iter().map(|n| (off(n), n));
    let (by, n) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let what =
        || format!("sample {:?} with levels of detail is off by {by:.2e}, expected {rounding:.2e}", place(n));
    breaks(by, rounding).then(what)
}

/// Compares a picture with the stored one, and prints its row; what is wrong, with the scene's name.
pub(crate) fn finished(
    scene: &PictureScene,
    outcome: Outcome,
    references: &mut References,
    index_to_world: &glam::DAffine3,
    eye: &Eye,
) -> Result<Vec<String>> {
    let Outcome { image, compared, mut broken, without } = outcome;
    let title = scene.long_title();
    ensure!(image.size() == [SIZE; 2], "{title}: a picture of another size");
    let picture = over_background(&image);
    broken.extend(eye.failures(index_to_world));
    let (least, unseen) = off::seen(&picture, &without)?;
    broken.extend(unseen);
    let (difference, unlike) =
        references.picture((&scene.title(), &title), &picture, |n| compared.is_doubtful(n))?;
    broken.extend(unlike);
    let [voxels, degrees, color] = compared.errors();
    let [_, unlit, lit] = compared.shares().map(|share| 100.0 * share);
    let (mean, max) = difference.map_or((0.0, 0.0), |d| (d.mean, d.max));
    let (pixels, steps) = difference.map_or((0, 0), |d| (d.pixels, d.steps));
    println!(
        "{title:<53} {:>8} {:>8} {:>6} {unlit:>8.1} {:>6} {lit:>7.1} | {voxels:>10.1e} {degrees:>12.1e} {color:>13.1e} | {mean:>10.1e} {max:>8.1e} {pixels:>7} {steps:>5} | {least}",
        compared.pixels - compared.doubtful,
        compared.doubtful,
        compared.wrong.len(),
        compared.unsteady,
    );
    Ok(broken.into_iter().map(|what| format!("{title}: {what}")).collect())
}
