//! Time against error of every scheme on a mesh: against the oracle's integral on the finest lattice, at some of the pixels.

use anyhow::{Context, Result, ensure};
use isoray_amr::{Mesh, Patches};
use isoray_oracle::SplitMix64;
use isoray_render::{Image, render_volume};
use rayon::prelude::*;
use serde::Serialize;

use super::tables::Scene;
use crate::bench::timer::interleave;
use crate::bench::volume::schemes::{self, Scheme};
use crate::finest::{Field, Finest, Seen};

/// One scheme on one mesh.
#[derive(Debug, Serialize)]
pub(crate) struct ErrorRow {
    mesh: String,
    is_shaded: bool,
    scheme: String,
    family: &'static str,
    epsilon: Option<f64>,
    /// Pixels along each side.
    size: u32,
    /// Of a frame, on all threads.
    ms: f64,
    /// Pixels that are compared, and those among them that are not, as rounding the values moves the truth by more than a share of the least bound.
    compared: usize,
    doubtful: usize,
    /// Of a premultiplied linear RGBA channel.
    largest_error: f64,
    rms_error: f64,
}

pub(super) const HEADER: &str = "\nTime against error, far view, all threads; errors of linear RGBA against the oracle's integral on the finest lattice, of a pixel in each square of the picture.\nmesh                   lit  scheme                                   size | ms a frame | compared doubtful | largest error       rms";

/// Schemes that others stand for.
const LEFT_OUT: [&str; 9] = [
    "fixed 3,",
    "fixed 5,",
    "fixed 6,",
    "fixed 7,",
    "fixed 100,",
    "bounded 1/4",
    "bounded 3e-4",
    "adaptive with inflection, cubic",
    "adaptive, cubic, ends",
];

/// Share of a bound that the rounding of values may move the truth by, of a pixel that is held against that bound.
const DOUBTFUL: f64 = 1.0 / 16.0;

pub(super) fn rows(
    name: &str,
    (patches, mesh): (&Patches, &Mesh),
    finest: &Finest,
    quick: bool,
    repeat: usize,
) -> Result<Vec<ErrorRow>> {
    let (size, square) = if quick { (64, 4) } else { (512, 16) };
    let scene = Scene::new(mesh, size)?;
    let field = finest.field();
    let pixels = pixels(size, square);
    let mut rows = Vec::new();
    for is_shaded in [false, true] {
        let truth = truth(&scene, mesh, (finest, &field), &pixels, is_shaded);
        let schemes = schemes_of(&scene, (patches, mesh), is_shaded, quick)?;
        let (images, times) = frames(&scene, mesh, &schemes, is_shaded, repeat)?;
        for ((scheme, image), seconds) in schemes.iter().zip(&images).zip(times) {
            let errors = Errors::of(image, &pixels, &truth, scheme.epsilon);
            let row = ErrorRow {
                mesh: name.to_owned(),
                is_shaded,
                scheme: scheme.name.clone(),
                family: scheme.family,
                epsilon: scheme.epsilon,
                size,
                ms: seconds * 1e3,
                compared: errors.compared,
                doubtful: errors.doubtful,
                largest_error: errors.largest,
                rms_error: errors.rms,
            };
            print(&row);
            let most = scheme.epsilon.unwrap_or(f64::INFINITY);
            ensure!(row.largest_error <= most, "{name}: off by {} by {}", row.largest_error, row.scheme);
            ensure!(row.doubtful < row.compared, "{name}: most pixels are doubtful");
            rows.push(row);
        }
    }
    Ok(rows)
}

/// One pixel, anywhere, in each square of so many.
pub(super) fn pixels(size: u32, square: u32) -> Vec<[u32; 2]> {
    let along = size / square;
    let one = |n: u32| {
        let mut random = SplitMix64::new(n.into());
        [n % along, n / along].map(|at| at * square + random.below(square))
    };
    (0..along * along).map(one).collect()
}

/// RGBA, and how far rounding the values can move it.
type Truth = ([f64; 4], f64);

fn truth(
    scene: &Scene<'_>,
    mesh: &Mesh,
    (finest, field): (&Finest, &Field<'_>),
    pixels: &[[u32; 2]],
    is_shaded: bool,
) -> Vec<Truth> {
    let seen = Seen {
        camera: &scene.camera,
        index_to_world: mesh.index_to_world(),
        points: scene.transfer.points(),
        shading: is_shaded.then_some(scene.shading),
    };
    let one = |&pixel: &[u32; 2]| {
        let at = |by| finest.pixel(field, &seen, pixel, by);
        let (truth, rounding) = (at(0.0), finest.rounding());
        (truth, apart(truth, at(rounding)).max(apart(truth, at(-rounding))))
    };
    pixels.par_iter().map(one).collect()
}

fn apart(a: [f64; 4], b: [f64; 4]) -> f64 {
    (0..4).fold(0.0, |m, n| f64::max(m, (a[n] - b[n]).abs()))
}

fn schemes_of(
    scene: &Scene<'_>,
    (patches, mesh): (&Patches, &Mesh),
    is_shaded: bool,
    quick: bool,
) -> Result<Vec<Scheme>> {
    let range = mesh.range().context("the mesh has no values")?;
    let to_world = mesh.index_to_world();
    let axes = to_world.matrix3;
    let coarsest: u32 = patches.ratios.iter().product();
    let longest = f64::from(coarsest) * (axes.x_axis.length() + axes.y_axis.length() + axes.z_axis.length());
    let brightest = match is_shaded {
        true => scene.shading.brightest(&to_world, f64::from(range[1]) - f64::from(range[0])),
        false => 1.0,
    };
    let mut all = schemes::all(&scene.transfer, brightest, range, longest as f32, quick)?;
    all.retain(|scheme| !LEFT_OUT.iter().any(|left_out| scheme.name.starts_with(left_out)));
    Ok(all)
}

/// By scheme: the picture, and the seconds that it takes.
fn frames(
    scene: &Scene<'_>,
    mesh: &Mesh,
    schemes: &[Scheme],
    is_shaded: bool,
    repeat: usize,
) -> Result<(Vec<Image>, Vec<f64>)> {
    let mut images: Vec<Option<Image>> = schemes.iter().map(|_| None).collect();
    let mut runs: Vec<Box<dyn FnMut() + '_>> = Vec::new();
    for (scheme, image) in schemes.iter().zip(&mut images) {
        let seen = scene.scene(scheme, &scene.visible, is_shaded);
        runs.push(Box::new(move || {
            *image = Some(render_volume(mesh, mesh.index_to_world(), &scene.camera, &seen, |_, _| {}));
        }));
    }
    let mut timed: Vec<&mut dyn FnMut()> =
        runs.iter_mut().map(|run| &mut **run as &mut dyn FnMut()).collect();
    let times = interleave(repeat, &mut timed);
    drop(runs);
    let images: Option<Vec<Image>> = images.into_iter().collect();
    Ok((images.context("each scheme makes a picture")?, times))
}

struct Errors {
    compared: usize,
    doubtful: usize,
    largest: f64,
    rms: f64,
}

impl Errors {
    fn of(image: &Image, pixels: &[[u32; 2]], truth: &[Truth], epsilon: Option<f64>) -> Self {
        let (mut compared, mut doubtful, mut largest, mut sum) = (0, 0, 0.0f64, 0.0);
        for (&[x, y], &(expected, rounding)) in pixels.iter().zip(truth) {
            if epsilon.is_some_and(|epsilon| rounding > DOUBTFUL * epsilon) {
                doubtful += 1;
                continue;
            }
            let found = image.pixel(x, y).color.to_array().map(f64::from);
            compared += 1;
            largest = largest.max(apart(found, expected));
            sum += (0..4).map(|n| (found[n] - expected[n]).powi(2)).sum::<f64>();
        }
        let rms = (sum / (4 * compared.max(1)) as f64).sqrt();
        Self { compared, doubtful, largest, rms }
    }
}

fn print(row: &ErrorRow) {
    println!(
        "{:<22} {:<4} {:<40} {:>4} | {:>10.1} | {:>8} {:>8} | {:>13.2e} {:>9.2e}",
        row.mesh,
        if row.is_shaded { "yes" } else { "no" },
        row.scheme,
        row.size,
        row.ms,
        row.compared,
        row.doubtful,
        row.largest_error,
        row.rms_error,
    );
}
