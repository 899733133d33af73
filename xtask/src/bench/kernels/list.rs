//! The kernels, and what they work on.

use anyhow::{Context, Result};
use glam::{DAffine3, DVec3, Vec3};
use isoray_amr::{Mesh, MeshOptions, Patches};
use isoray_benches::cells::{packed, random};
use isoray_benches::knoll2006::PaperOctree;
use isoray_benches::views::View;
use isoray_cell::root::{BernsteinSeries, FirstRoot};
use isoray_cell::{Mask, Real, Segment};
use isoray_grid::{DenseVolume, GridVolume, Scalar};
use isoray_octree::OctreeVolume;
use isoray_packet::Slicing;
use isoray_render::{
    Camera, Clip, ColorField, Image, Light, Normals, Plane, SURFACE_COLOR, Scene, Surface, Traversal, render,
    render_volume,
};
use wide::f32x16;

use super::REFERENCE;
use crate::bench::amr::tables::Scene as MeshScene;
use crate::bench::amr::{few_patches, short_patches};
use crate::bench::picture::{LAMP, Pictures};
use crate::bench::volume::schemes::{self, Scheme};
use crate::catalog::{Dense, Entry, Place};
use crate::shells::Subject;

/// How much was found, and a sum over it.
pub(crate) type Answer = [f64; 2];

pub(crate) struct Kernel<'a> {
    pub(crate) name: &'static str,
    pub(crate) run: Box<dyn FnMut() -> Answer + 'a>,
}

/// Pixels along each side of a picture.
const SIZE: u32 = 128;
/// Of one that takes longer.
const SMALL: u32 = 64;
/// Cells in which a root is looked for, and how often.
const CELLS: usize = 1 << 14;
const TIMES: usize = 16;
/// Half a step of eight bits.
const EPSILON: f64 = 1.0 / 510.0;
/// Rays from each point to the sky: each takes about as long as one to a lamp.
const SKY_SAMPLES: u32 = 4;

/// What the kernels work on.
pub(crate) struct Data<'v, T: Scalar> {
    dense: &'v Dense<T>,
    octree: OctreeVolume<T>,
    paper: PaperOctree<T>,
    isovalue: f32,
    /// Of a surface behind that.
    inner: f32,
    cells: Vec<([f32x16; 8], Segment<f32x16>)>,
    /// Without and with light.
    subjects: [Subject<T>; 2],
    patches: Patches,
    mesh: Mesh,
}

impl<'v, T: Scalar + Into<f64>> Data<'v, T> {
    pub(crate) fn new(dense: &'v Dense<T>) -> Result<Self> {
        let entry = Entry::fixture();
        let subject = |is_shaded| Subject::new(&entry, dense, is_shaded, Place::Far, SMALL);
        Ok(Self {
            dense,
            octree: dense.octree()?,
            paper: PaperOctree::build(dense.dims, &dense.samples),
            isovalue: entry.isovalues[0],
            inner: entry.isovalues[1],
            cells: packed(&random(CELLS, 1)),
            subjects: [subject(false)?, subject(true)?],
            mesh: Mesh::new(short_patches(), MeshOptions::default())?,
            patches: few_patches(),
        })
    }

    /// All of them, [`REFERENCE`] first.
    pub(crate) fn kernels(&self) -> Result<Vec<Kernel<'_>>> {
        let mut all = vec![self.reference(), self.roots()];
        all.extend(self.surfaces()?);
        all.extend(self.volumes());
        all.extend(self.meshes()?);
        all.extend(self.makers());
        Ok(all)
    }

    fn reference(&self) -> Kernel<'_> {
        let view = View::far(self.dense.dims, 2 * SIZE, 2 * SIZE);
        let run = move || {
            let hits = view.directions.iter().filter_map(|&direction| {
                self.paper.first_hit(view.origin, direction, self.isovalue).map(|hit| f64::from(hit.t))
            });
            sum(hits)
        };
        Kernel { name: REFERENCE, run: Box::new(run) }
    }

    fn roots(&self) -> Kernel<'_> {
        let run = || {
            let roots =
                self.cells.iter().cycle().take(TIMES * self.cells.len()).flat_map(|(corners, segment)| {
                    let root = BernsteinSeries::first_root(corners, segment);
                    let found = root.found.bits();
                    (0..f32x16::LANES)
                        .filter(move |n| found >> n & 1 == 1)
                        .map(move |n| f64::from(root.s.lane(n)))
                });
            sum(roots)
        };
        Kernel { name: "first roots", run: Box::new(run) }
    }

    fn surfaces(&self) -> Result<Vec<Kernel<'_>>> {
        let exact = Scene::of(self.isovalue);
        let lit = |traversal| Scene {
            lights: vec![Light::Direction(LAMP)],
            shadows: true,
            traversal,
            ..exact.clone()
        };
        let scenes = [
            ("single rays", Scene { traversal: Traversal::Single, ..exact.clone() }),
            ("packets", Scene { traversal: Traversal::Masked, ..exact.clone() }),
            ("slabs", Scene { traversal: Traversal::Coherent(Slicing::default()), ..exact.clone() }),
            ("central normals", Scene { normals: Normals::Central, ..exact.clone() }),
            ("shadows", lit(Traversal::Single)),
            ("shadows, packets", lit(Traversal::Masked)),
            ("sky", Scene { sky_samples: SKY_SAMPLES, ..exact.clone() }),
            ("translucent surfaces", Scene { surfaces: self.layers(), ..exact.clone() }),
            ("cut and capped", Scene { clip: Clip(vec![self.cut()]), cap: true, ..exact.clone() }),
            ("coloured by a field", Scene { colors: Some(&ByPlace), ..exact.clone() }),
        ];
        let cameras = [Place::Far, Place::Close].map(|place| self.dense.camera(place, SIZE));
        let [far, close] = cameras;
        let cameras = [far?, close?];
        let mut kernels = Vec::new();
        for (name, scene) in scenes {
            let run = move || {
                let view = self.octree.view();
                let images = cameras.each_ref().map(|camera| render(&view, self.to_world(), camera, &scene));
                add(images.each_ref().map(depths))
            };
            kernels.push(Kernel { name, run: Box::new(run) });
        }
        let camera = cameras[0];
        for (name, traversal) in
            [("levels of detail", Traversal::Auto), ("levels of detail, single rays", Traversal::Single)]
        {
            let pictures = Pictures::new(&self.octree);
            let scene = Scene { traversal, ..exact.clone() };
            let run = move || depths(&pictures.frame(&camera, &scene, 4.0).0);
            kernels.push(Kernel { name, run: Box::new(run) });
        }
        let grid = GridVolume::new(DenseVolume::new(self.dense.dims, &self.dense.samples)?);
        let run = move || depths(&render(&grid, self.to_world(), &camera, &exact));
        kernels.push(Kernel { name: "grid", run: Box::new(run) });
        Ok(kernels)
    }

    /// Surfaces behind one another, each of which lets light through: all crossings of a ray are gathered, of all of them.
    fn layers(&self) -> Vec<Surface> {
        let surface = |isovalue, opacity| Surface { isovalue, color: SURFACE_COLOR, opacity };
        let between = 0.5 * (self.isovalue + self.inner);
        vec![surface(self.isovalue, 0.3), surface(between, 0.5), surface(self.inner, 0.8)]
    }

    /// A plane through the middle, aslant.
    fn cut(&self) -> Plane {
        let last = DVec3::from_array(self.dense.dims.axes().map(|n| f64::from(n - 1)));
        let normal = DVec3::new(0.3, 0.1, -1.0);
        Plane { normal, offset: normal.dot(self.to_world().transform_point3(0.5 * last)) }
    }

    fn to_world(&self) -> DAffine3 {
        self.dense.index_to_world
    }

    fn volumes<'d>(&'d self) -> Vec<Kernel<'d>> {
        let [unlit, lit] = &self.subjects;
        let bounded = |subject: &Subject<T>| schemes::bounded(&subject.transfer, EPSILON, subject.brightest);
        let all = [
            ("volume, unlit", unlit, bounded(unlit)),
            ("volume, lit", lit, bounded(lit)),
            ("volume, fixed 2", unlit, schemes::fixed(&unlit.transfer, 2)),
        ];
        let kernel = |(name, subject, scheme): (&'static str, &'d Subject<T>, Scheme)| -> Kernel<'d> {
            let run = move || {
                let scene = subject.scene(&scheme);
                colors(&render_volume(&subject.view(), self.to_world(), &subject.camera, &scene, |_, _| {}))
            };
            Kernel { name, run: Box::new(run) }
        };
        all.map(kernel).into()
    }

    fn meshes(&self) -> Result<Vec<Kernel<'_>>> {
        let [low, high] = self.mesh.range().context("the mesh has no values")?;
        let surface = Scene::of(0.5 * (low + high));
        let to_world = self.mesh.index_to_world();
        let camera = Camera::new(&Place::Far.view(self.mesh.dims(), &to_world), [2 * SIZE; 2])?;
        let mut kernels = Vec::new();
        for (name, is_lit) in [("mesh, volume", false), ("mesh, volume, lit", true)] {
            let of = MeshScene::new(&self.mesh, SMALL)?;
            let scheme = of.bounded(EPSILON, is_lit);
            let run = move || {
                let scene = of.scene(&scheme, &of.visible, is_lit);
                colors(&render_volume(&self.mesh, to_world, &of.camera, &scene, |_, _| {}))
            };
            kernels.push(Kernel { name, run: Box::new(run) });
        }
        let surface = move || depths(&render(&self.mesh, to_world, &camera, &surface));
        kernels.push(Kernel { name: "mesh, surface", run: Box::new(surface) });
        Ok(kernels)
    }

    fn makers(&self) -> Vec<Kernel<'_>> {
        let octree = || match self.dense.octree() {
            Ok(octree) => [octree.file_bytes() as f64, octree.raw_bytes() as f64],
            Err(_) => [0.0; 2],
        };
        let mesh = || match Mesh::new(&self.patches, MeshOptions::default()) {
            Ok(mesh) => [mesh.size().leaves.iter().sum::<u64>() as f64, mesh.size().bytes as f64],
            Err(_) => [0.0; 2],
        };
        vec![
            Kernel { name: "octree, making", run: Box::new(octree) },
            Kernel { name: "mesh, making", run: Box::new(mesh) },
        ]
    }
}

/// A colour for every place, that changes in a voxel.
struct ByPlace;

impl ColorField for ByPlace {
    fn color(&self, cell: [u32; 3], local: [f32; 3]) -> Vec3 {
        let at = |a: usize| ((cell[a] % 8) as f32 + local[a]) / 8.0;
        Vec3::new(at(0), at(1), at(2))
    }
}

fn sum(values: impl Iterator<Item = f64>) -> Answer {
    values.fold([0.0; 2], |[count, sum], value| [count + 1.0, sum + value])
}

fn add(answers: [Answer; 2]) -> Answer {
    [answers[0][0] + answers[1][0], answers[0][1] + answers[1][1]]
}

/// Hits, with their depth and their brightness.
fn depths(image: &Image) -> Answer {
    let hits = image.pixels().iter().filter(|pixel| pixel.depth.is_finite());
    sum(hits.map(|pixel| f64::from(pixel.depth) + f64::from(pixel.color.element_sum())))
}

/// Pixels that show anything, with their colour.
fn colors(image: &Image) -> Answer {
    let shown = image.pixels().iter().filter(|pixel| pixel.color.w > 0.0);
    sum(shown.map(|pixel| f64::from(pixel.color.element_sum())))
}
