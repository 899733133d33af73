//! Adaptive meshes against the oracle on the finest lattice and against stored references: a surface and a volume.

use anyhow::{Context, Result};
use glam::{DAffine3, DVec3};
use isoray_amr::{Centering, Mesh, MeshOptions, OctreeLeaf, Patches};
use isoray_oracle::{AmrKind, AmrLeaf, Field as _, Gyroid, OracleHit};
use isoray_preint::{Bounded, Visibility};
use isoray_render::{Clip, Image, Scene, VolumeScene, gradient_scale, render, render_volume};
use rayon::prelude::*;

use super::compared::{colors_picture, over_background};
use super::eye::Eye;
use super::mesh_volume::MeshVolume;
use super::reference::{References, normals_picture, show};
use super::scenes::EPSILON;
use super::selection::Selection;
use crate::catalog::Place;
use crate::finest::{Field, Finest};
use crate::for_oracle::{self, apart, breaks, colors_apart, is_hit};
use crate::shells::{LIGHT, lit, shells};

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

/// Errors of a hit, at most: along the ray in edges of finest cells, and of its normal in degrees. In these views 2.8·10⁻⁶ and 5.7·10⁻⁵ are the most.
const CELLS: f64 = 1e-4;
const DEGREES: f64 = 1e-3;

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
pub(crate) fn check(
    source: &Source,
    selection: &Selection,
    references: &mut References,
) -> Result<Vec<String>> {
    let patches = source.patches();
    let mesh = Mesh::new(&patches, MeshOptions::default())?;
    let finest = Finest::new(&patches)?;
    let field = finest.field();
    let mut failures = Vec::new();
    for place in Place::ALL {
        let to_world = mesh.index_to_world();
        let eye = Eye::new(place.view(mesh.dims(), &to_world), SIZE)?;
        let name = format!("{}, {}", source.name, place.name());
        let mut fail = |what: String| failures.push(format!("{name}: {what}"));
        // Of each kind one is stored.
        let is_stored = place == Place::Far;
        if selection.wants(&format!("{name}, surface")) {
            eye.failures(&to_world).into_iter().for_each(&mut fail);
            let image = render(&mesh, to_world, &eye.camera, &Scene::of(ISOVALUE));
            let doubtful = surface(&name, (&mesh, &finest, &field), &eye, &image, &mut fail)?;
            if is_stored {
                let outcome = references.surface(&format!("{name} surface"), &image, |n| doubtful[n])?;
                outcome.into_iter().for_each(&mut fail);
            }
        }
        if selection.wants(&format!("{name}, volume")) {
            let image = volume(&name, (&mesh, &finest, &field), &eye, &mut fail)?;
            if is_stored {
                let outcome = references.volume(&format!("{name} volume"), &image, EPSILON)?;
                outcome.into_iter().for_each(&mut fail);
            }
        }
    }
    Ok(failures)
}

/// Compares the hits; by pixel, whether it is doubtful what is hit.
fn surface(
    name: &str,
    (mesh, finest, field): (&Mesh, &Finest, &Field<'_>),
    eye: &Eye,
    image: &Image,
    fail: &mut impl FnMut(String),
) -> Result<Vec<bool>> {
    let to_index = mesh.index_to_world().inverse();
    let expected = |n: u32| {
        let ray = eye.camera.index_ray(&to_index, n % SIZE, n / SIZE);
        finest.hit(field, &ray, ISOVALUE)
    };
    let truths: Vec<Option<Option<OracleHit>>> = (0..SIZE * SIZE).into_par_iter().map(expected).collect();
    let normal = |hit: &OracleHit| {
        (to_index.matrix3.transpose() * DVec3::from_array(hit.gradient)).normalize_or_zero()
    };
    let (mut right, mut wrong) = (0, Vec::new());
    let [mut cells, mut degrees] = [(0.0, 0); 2];
    let larger = |a: &mut (f64, usize), by: f64, n: usize| {
        if breaks(by, a.0) {
            *a = (by, n);
        }
    };
    for (n, truth) in truths.iter().enumerate() {
        let Some(truth) = truth else { continue };
        let found = image.pixels()[n];
        match truth {
            Some(hit) if is_hit(&found) => {
                right += 1;
                let ray = eye.camera.index_ray(&to_index, n as u32 % SIZE, n as u32 / SIZE);
                let speed = DVec3::from_array(ray.direction.map(f64::from)).length();
                larger(&mut cells, apart(found.depth.into(), hit.t) * speed, n);
                larger(&mut degrees, for_oracle::degrees(found.normal.as_dvec3(), normal(hit)), n);
            }
            None if !is_hit(&found) => {}
            _ => wrong.push(n),
        }
    }
    let is_doubtful: Vec<bool> = truths.iter().map(Option::is_none).collect();
    let doubtful = is_doubtful.iter().filter(|is| **is).count();
    println!(
        "{:<51} {:>8} {doubtful:>8} | {right:>11} {:>7} {:>10.1e} {:>12.1e} |",
        format!("{name}, surface"),
        truths.len() - doubtful,
        wrong.len(),
        cells.0,
        degrees.0
    );
    let at = |n: usize| [n as u32 % SIZE, n as u32 / SIZE];
    let mut broken = Vec::new();
    if let Some(&first) = wrong.first() {
        broken.push(format!("{} hits that are not the oracle's, the first at {:?}", wrong.len(), at(first)));
    }
    for (what, (by, n), bound) in
        [("a hit, in cells,", cells, CELLS), ("a normal, in degrees,", degrees, DEGREES)]
    {
        if breaks(by, bound) {
            broken.push(format!("{what} off by {by:.2e} at {:?}, expected at most {bound}", at(n)));
        }
    }
    if !broken.is_empty() {
        let found = |n: usize| is_hit(&image.pixels()[n]).then_some(image.pixels()[n].normal);
        let expected = normals_picture([SIZE; 2], |n| match &truths[n] {
            Some(truth) => truth.as_ref().map(|hit| normal(hit).as_vec3()),
            None => found(n),
        });
        let shown = show(&format!("{name}, surface, oracle"), &expected, &normals_picture([SIZE; 2], found))?;
        broken.push(format!("normals shown in {}", shown.display()));
    }
    if doubtful * 100 > truths.len() {
        broken.push(format!("{doubtful} rays graze"));
    }
    broken.into_iter().for_each(fail);
    Ok(is_doubtful)
}

/// Compares the colours of a volume in which shells are lit; its picture.
fn volume(
    name: &str,
    (mesh, finest, field): (&Mesh, &Finest, &Field<'_>),
    eye: &Eye,
    fail: &mut impl FnMut(String),
) -> Result<Image> {
    let to_world = mesh.index_to_world();
    let range = mesh.range().context("the mesh has no values")?;
    let scale = gradient_scale(mesh, to_world);
    let transfer = shells(&[ISOVALUE], range, scale)?;
    let shading = Some(lit(scale, Some(LIGHT)));
    let brightest =
        shading.map_or(1.0, |s| s.brightest(&to_world, f64::from(range[1]) - f64::from(range[0])));
    let scheme = Bounded::new(&transfer, EPSILON, brightest);
    let visible = Visibility::new(&transfer);
    let scene = VolumeScene { visible: &visible, scheme: &scheme, shading, clip: None };
    let image = render_volume(mesh, to_world, &eye.camera, &scene, |_, _| {});
    let clip = Clip::default();
    let seen = MeshVolume { finest, field, eye, to_world, points: transfer.points(), shading, clip: &clip };
    let truths: Vec<Option<[f64; 4]>> =
        (0..SIZE * SIZE).into_par_iter().map(|n| seen.pixel([n % SIZE, n / SIZE], EPSILON)).collect();
    let found = |n: usize| image.pixels()[n].color.to_array();
    let errors: Vec<(f64, usize)> =
        (0..truths.len()).filter_map(|n| Some((colors_apart(found(n), truths[n]?), n))).collect();
    let doubtful = truths.len() - errors.len();
    let (largest, worst) = errors.iter().copied().fold((0.0, 0), |m, e| if breaks(e.0, m.0) { e } else { m });
    let rms = (errors.iter().map(|(e, _)| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt();
    println!(
        "{:<51} {:>8} {doubtful:>8} | {:>43} | {largest:>18.2e} {rms:>10.2e}",
        format!("{name}, volume"),
        errors.len(),
        ""
    );
    if breaks(largest, EPSILON) {
        let at = [worst as u32 % SIZE, worst as u32 / SIZE];
        let expected =
            colors_picture([SIZE; 2], |n| truths[n].map_or(found(n), |color| color.map(|c| c as f32)));
        let shown = show(&format!("{name}, volume, oracle"), &expected, &over_background(&image))?;
        fail(format!(
            "a colour off by {largest:e} at {at:?}, more than {EPSILON:e}; shown in {}",
            shown.display()
        ));
    }
    if doubtful * 100 > truths.len() {
        fail(format!("{doubtful} pixels are doubtful"));
    }
    Ok(image)
}
