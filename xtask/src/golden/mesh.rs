//! Adaptive meshes against the oracle on the finest lattice and against stored references: a surface and a volume.

use anyhow::{Context, Result};
use glam::{DAffine3, DVec3};
use isoray_amr::{Centering, Mesh, MeshOptions, OctreeLeaf, Patches};
use isoray_oracle::{AmrKind, AmrLeaf, Field as _, Gyroid};
use isoray_preint::{Bounded, Visibility};
use isoray_render::{
    Camera, Image, Scene, VolumeScene, VolumeShading, gradient_scale, render, render_volume,
};
use rayon::prelude::*;

use super::reference::References;
use crate::catalog::Place;
use crate::finest::{Field, Finest, Seen};
use crate::for_oracle;
use crate::shells::shells;

/// Titles of the columns.
pub(crate) const HEADER: &str = "adaptive meshes                                     compared doubtful | hits: right   wrong  cells max  degrees max | colours: max error  rms error";

/// A mesh to be made.
pub(crate) struct Source {
    pub(crate) name: &'static str,
    kind: AmrKind,
    centering: Centering,
    seed: u64,
}

/// Pixels along each side.
const SIZE: u32 = 64;

/// Isovalue of the surfaces, and of the shells that make up the volume.
const ISOVALUE: f32 = 0.1;

/// Bound of the volume.
const EPSILON: f64 = 1.0 / 510.0;

/// Share of a bound that the rounding of values may move the truth by, of a pixel that is held against that bound.
const DOUBTFUL: f64 = 1.0 / 16.0;

/// Errors of a hit, at most: along the ray in edges of finest cells, and of its normal in degrees.
const CELLS: f64 = 1e-2;
const DEGREES: f64 = 0.5;

impl Source {
    pub(crate) fn all() -> [Self; 3] {
        [
            Self {
                name: "mesh, unbalanced, vertices",
                kind: AmrKind::Unbalanced,
                centering: Centering::Vertices,
                seed: 1,
            },
            Self {
                name: "mesh, mixed ratios, cells",
                kind: AmrKind::MixedRatios,
                centering: Centering::Cells,
                seed: 1,
            },
            Self { name: "mesh, gaps, cells", kind: AmrKind::Gaps, centering: Centering::Cells, seed: 1 },
        ]
    }

    /// A gyroid in the mesh's cells, whatever their size.
    pub(crate) fn patches(&self) -> Patches {
        let shape = self.kind.generate(self.seed);
        let gyroid = Gyroid { period: 20.0 };
        let leaf = |of: &AmrLeaf<()>| OctreeLeaf {
            low: of.low,
            edge: of.edge,
            values: match self.centering {
                Centering::Cells => vec![gyroid.value(of.centre()) as f32],
                Centering::Vertices => {
                    (0..8).map(|c| gyroid.value(of.corner(c).map(f64::from)) as f32).collect()
                }
            },
        };
        // What is missing has no values, in cells of the smallest size.
        let least = shape.edges().last().copied().unwrap_or(1);
        let [nx, ny, nz] = shape.dims().map(|n| n / least);
        let places = (0..nx * ny * nz).map(|n| [n % nx, n / nx % ny, n / (nx * ny)].map(|c| c * least));
        let count = if self.centering == Centering::Cells { 1 } else { 8 };
        let missing = places.filter(|&low| shape.find(low).is_none()).map(|low| OctreeLeaf {
            low,
            edge: least,
            values: vec![f32::NAN; count],
        });
        let leaves = shape.leaves().iter().map(leaf).chain(missing);
        Patches::of_leaves(self.centering, DAffine3::IDENTITY, shape.dims(), leaves)
    }
}

/// The bounds that are broken.
pub(crate) fn check(source: &Source, references: &mut References) -> Result<Vec<String>> {
    let patches = source.patches();
    let mesh = Mesh::new(&patches, MeshOptions::default())?;
    let finest = Finest::new(&patches)?;
    let field = finest.field();
    let mut failures = Vec::new();
    for place in Place::ALL {
        let camera = Camera::new(&place.view(mesh.dims(), &mesh.index_to_world()), [SIZE; 2])?;
        let name = format!("{}, {}", source.name, place.name());
        let mut fail = |what: String| failures.push(format!("{name}: {what}"));
        let image = render(&mesh, mesh.index_to_world(), &camera, &Scene::of(ISOVALUE));
        let doubtful = surface(&name, (&mesh, &finest, &field), &camera, &image, &mut fail);
        // Of each kind one is stored.
        if place == Place::Far {
            let outcome = references.surface(&format!("{name} surface"), &image, doubtful)?;
            outcome.into_iter().for_each(&mut fail);
        }
        let image = volume(&name, (&mesh, &finest, &field), &camera, &mut fail)?;
        if place == Place::Far {
            let outcome = references.volume(&format!("{name} volume"), &image, EPSILON)?;
            outcome.into_iter().for_each(&mut fail);
        }
    }
    Ok(failures)
}

/// How a pixel compares: `None` where it is doubtful.
type Compared = Option<Result<[f64; 2], ()>>;

/// Compares the hits; how many are doubtful.
fn surface(
    name: &str,
    (mesh, finest, field): (&Mesh, &Finest, &Field<'_>),
    camera: &Camera,
    image: &Image,
    fail: &mut impl FnMut(String),
) -> u64 {
    let to_index = mesh.index_to_world().inverse();
    let one = |n: u32| -> Compared {
        let [x, y] = [n % SIZE, n / SIZE];
        let ray = camera.index_ray(&to_index, x, y);
        let expected = finest.hit(field, &ray, ISOVALUE)?;
        let found = image.pixel(x, y);
        Some(match expected {
            None if found.depth.is_finite() => Err(()),
            Some(_) if !found.depth.is_finite() => Err(()),
            None => Ok([0.0; 2]),
            Some(hit) => {
                let speed = DVec3::from_array(ray.direction.map(f64::from)).length();
                let exact = to_index.matrix3.transpose() * DVec3::from_array(hit.gradient);
                let degrees = for_oracle::degrees(found.normal.as_dvec3(), exact.normalize_or_zero());
                Ok([(f64::from(found.depth) - hit.t).abs() * speed, degrees])
            }
        })
    };
    let compared: Vec<Compared> = (0..SIZE * SIZE).into_par_iter().map(one).collect();
    let doubtful = compared.iter().filter(|of| of.is_none()).count();
    let is_wrong = |of: &Compared| matches!(of, Some(Err(())));
    let wrong = compared.iter().filter(|of| is_wrong(of)).count();
    let right = image.pixels().iter().filter(|pixel| pixel.depth.is_finite()).count();
    let errors = compared.iter().flatten().flatten();
    let [cells, degrees] = errors.fold([0.0; 2], |m, of| [f64::max(m[0], of[0]), f64::max(m[1], of[1])]);
    println!(
        "{:<51} {:>8} {doubtful:>8} | {right:>11} {wrong:>7} {cells:>10.1e} {degrees:>12.1e} |",
        format!("{name}, surface"),
        compared.len() - doubtful
    );
    if wrong > 0 {
        let first = compared.iter().position(is_wrong).unwrap_or(0) as u32;
        let at = [first % SIZE, first / SIZE];
        fail(format!("{wrong} hits that are not the oracle's, the first at {at:?}"));
    }
    if cells > CELLS || degrees > DEGREES {
        fail(format!("a hit off by {cells} cells, a normal by {degrees} degrees"));
    }
    if doubtful * 100 > compared.len() {
        fail(format!("{doubtful} rays graze"));
    }
    doubtful as u64
}

/// Compares the colours of a volume in which shells are lit; its picture.
fn volume(
    name: &str,
    (mesh, finest, field): (&Mesh, &Finest, &Field<'_>),
    camera: &Camera,
    fail: &mut impl FnMut(String),
) -> Result<Image> {
    let to_world = mesh.index_to_world();
    let range = mesh.range().context("the mesh has no values")?;
    let scale = gradient_scale(mesh, to_world);
    let transfer = shells(&[ISOVALUE], range, scale)?;
    let shading = VolumeShading {
        ambient: 0.3,
        diffuse: 0.7,
        specular: 0.2,
        exponent: 20.0,
        gradient_scale: scale,
        light: Some(DVec3::new(0.3, -0.5, 0.8)),
    };
    let brightest = shading.brightest(&to_world, f64::from(range[1]) - f64::from(range[0]));
    let scheme = Bounded::new(&transfer, EPSILON, brightest);
    let visible = Visibility::new(&transfer);
    let scene = VolumeScene { visible: &visible, scheme: &scheme, shading: Some(shading), clip: None };
    let image = render_volume(mesh, to_world, camera, &scene, |_, _| {});
    let seen = Seen { camera, index_to_world: to_world, points: transfer.points(), shading: Some(shading) };
    let apart = |a: [f64; 4], b: [f64; 4]| (0..4).fold(0.0, |m, n| f64::max(m, (a[n] - b[n]).abs()));
    let one = |n: u32| {
        let pixel = [n % SIZE, n / SIZE];
        let at = |by| finest.pixel(field, &seen, pixel, by);
        let [truth, above, below] = [0.0, finest.rounding(), -finest.rounding()].map(at);
        let found = image.pixel(pixel[0], pixel[1]).color.to_array().map(f64::from);
        let is_doubtful = apart(truth, above).max(apart(truth, below)) > DOUBTFUL * EPSILON;
        (!is_doubtful).then(|| apart(found, truth))
    };
    let compared: Vec<Option<f64>> = (0..SIZE * SIZE).into_par_iter().map(one).collect();
    let doubtful = compared.iter().filter(|of| of.is_none()).count();
    let errors = || compared.iter().flatten();
    let largest = errors().copied().fold(0.0, f64::max);
    let rms = (errors().map(|e| e * e).sum::<f64>() / errors().count().max(1) as f64).sqrt();
    println!(
        "{:<51} {:>8} {doubtful:>8} | {:>43} | {largest:>18.2e} {rms:>10.2e}",
        format!("{name}, volume"),
        compared.len() - doubtful,
        ""
    );
    if largest > EPSILON {
        let worst = compared.iter().position(|of| *of == Some(largest)).unwrap_or(0) as u32;
        let at = [worst % SIZE, worst / SIZE];
        fail(format!("a colour off by {largest:e} at {at:?}, more than {EPSILON:e}"));
    }
    if doubtful * 100 > compared.len() {
        fail(format!("{doubtful} pixels are doubtful"));
    }
    Ok(image)
}
