//! Level of detail: time against error over the ratio.

use std::time::Instant;

use anyhow::{Context, Result, ensure};
use isoray_amr::{Mesh, MeshOptions};
use isoray_render::{Image, Scene as Surfaces, mesh_detail, render, render_volume};
use serde::Serialize;

use super::meshes::Source;
use super::tables::{EPSILON, Scene};
use crate::bench::timer::{interleave_kept, median};
use crate::shells::Errors;

/// Titles of the columns.
pub(super) const HEADER: &str = "\nLevel of detail. Frames of the far view on all threads, unlit volumes by bounded 1/510 and isosurfaces in the middle of the values, of meshes without cells where coarser ones are up to so many pixels wide; against the mesh with all of them.\nMade: cut, and the mesh of what is left, from patches in memory. Differences of linear RGBA; of depths, in edges of finest cells, where both hit; pixels that hit in one of both only, in % of those that hit in the whole.\nmesh                   what    size ratio |     leaves      MiB  made, ms  frame, ms |       rms   largest | depth, rms  changed";

/// The first is the whole.
const RATIOS: [f64; 5] = [0.0, 0.5, 1.0, 2.0, 4.0];

/// A frame against that of the whole mesh.
#[derive(Debug, Serialize)]
pub(crate) struct DetailRow {
    mesh: String,
    what: &'static str,
    size: u32,
    ratio: f64,
    leaves: u64,
    bytes: u64,
    /// Of cutting and of making the mesh.
    made_ms: f64,
    frame_ms: f64,
    rms_error: f64,
    largest_error: f64,
    /// Of surfaces: in edges of the finest cells.
    depth_rms_cells: Option<f64>,
    /// Of surfaces.
    changed_percent: Option<f64>,
}

/// A mesh for one view.
struct Cut {
    ratio: f64,
    mesh: Mesh,
    seconds: f64,
}

pub(super) fn rows(source: &Source, quick: bool, repeat: usize) -> Result<Vec<DetailRow>> {
    // Smaller pictures show of small meshes what larger ones do of large meshes.
    let sizes: &[u32] = if quick { &[128] } else { &[512, 128] };
    let whole = Mesh::new(&source.patches, MeshOptions::default())?;
    let name = &source.name;
    let mut rows = Vec::new();
    for &size in sizes {
        let scene = Scene::new(&whole, size)?;
        let cuts = cuts(source, &scene, repeat.min(3))?;
        fewer(name, &cuts)?;
        let to_world = whole.index_to_world();
        let scheme = scene.bounded(EPSILON, false);
        let seen = scene.scene(&scheme, &scene.visible, false);
        let volume = |mesh: &Mesh| render_volume(mesh, to_world, &scene.camera, &seen, |_, _| {});
        rows.extend(frames(source, "volume", size, &cuts, (&volume, volume(&whole)), repeat)?);
        let [least, most] = whole.range().context("the mesh has no values")?;
        let surfaces = Surfaces::of(0.5 * (least + most));
        let surface = |mesh: &Mesh| render(mesh, to_world, &scene.camera, &surfaces);
        rows.extend(frames(source, "surface", size, &cuts, (&surface, surface(&whole)), repeat)?);
    }
    rows.iter().for_each(print);
    Ok(rows)
}

/// The larger cells may be, the fewer there are.
fn fewer(name: &str, cuts: &[Cut]) -> Result<()> {
    for pair in cuts.windows(2) {
        let [before, after] = [0, 1].map(|n| leaves(&pair[n].mesh));
        let ratio = pair[1].ratio;
        ensure!(after <= before, "{name}: expected at most {before} leaves at ratio {ratio}, found {after}");
    }
    Ok(())
}

fn leaves(mesh: &Mesh) -> u64 {
    mesh.size().leaves.iter().sum()
}

/// In turn, so that all see the same machine.
fn cuts(source: &Source, scene: &Scene<'_>, repeat: usize) -> Result<Vec<Cut>> {
    let mut made = [const { Vec::new() }; RATIOS.len()];
    let mut meshes = Vec::new();
    for _ in 0..repeat {
        meshes.clear();
        for (ratio, seconds) in RATIOS.into_iter().zip(&mut made) {
            let patches = source.patches.clone();
            let begin = Instant::now();
            let left = mesh_detail(patches, scene.camera.pixel_width(), ratio)?;
            meshes.push(Mesh::new(&left, MeshOptions::default())?);
            seconds.push(begin.elapsed().as_secs_f64());
        }
    }
    let cuts = RATIOS.into_iter().zip(meshes).zip(made);
    Ok(cuts.map(|((ratio, mesh), seconds)| Cut { ratio, mesh, seconds: median(seconds) }).collect())
}

/// Of all cuts by one way to make a picture, which makes this one of the whole.
///
/// # Errors
/// A picture of nothing, or one that is not that of the whole although nothing is cut off: what is timed is then not what it is to be. How far the others may be off is said nowhere.
fn frames(
    source: &Source,
    what: &'static str,
    size: u32,
    cuts: &[Cut],
    (picture, exact): (&dyn Fn(&Mesh) -> Image, Image),
    repeat: usize,
) -> Result<Vec<DetailRow>> {
    let mut frames: Vec<_> = cuts.iter().map(|cut| || picture(&cut.mesh)).collect();
    let mut timed: Vec<&mut dyn FnMut() -> Image> = frames.iter_mut().map(|frame| frame as _).collect();
    let (seconds, images) = interleave_kept(repeat, &mut timed);
    let is_seen = exact.pixels().iter().any(|pixel| pixel.color.w > 0.0);
    ensure!(is_seen, "{}: {what}, {size}²: expected a picture, found nothing visible", source.name);
    let all = cuts.first().map_or(0, |cut| leaves(&cut.mesh));
    for (cut, image) in cuts.iter().zip(&images) {
        let is_right = leaves(&cut.mesh) != all || *image == exact;
        ensure!(
            is_right,
            "{}: {what}, {size}², ratio {}: no leaf is cut off, expected the whole's picture, found another",
            source.name,
            cut.ratio
        );
    }
    let colors: Vec<_> = exact.pixels().iter().map(|pixel| pixel.color.to_array().map(f64::from)).collect();
    let row = |((cut, image), seconds): ((&Cut, &Image), f64)| {
        let errors = Errors::of(image, &colors, None);
        let size_of = cut.mesh.size();
        let of_surface = (what == "surface").then(|| surface_errors(image, &exact, &cut.mesh));
        DetailRow {
            mesh: source.name.clone(),
            what,
            size,
            ratio: cut.ratio,
            leaves: size_of.leaves.iter().sum(),
            bytes: size_of.bytes,
            made_ms: cut.seconds * 1e3,
            frame_ms: seconds * 1e3,
            rms_error: errors.rms,
            largest_error: errors.max,
            depth_rms_cells: of_surface.map(|errors| errors[0]),
            changed_percent: of_surface.map(|errors| errors[1]),
        }
    };
    Ok(cuts.iter().zip(&images).zip(seconds).map(row).collect())
}

/// Root mean square difference of depths, in edges of the finest cells, and how many pixels changed from hit to miss or back, in % of the hits.
fn surface_errors(image: &Image, exact: &Image, mesh: &Mesh) -> [f64; 2] {
    let axes = mesh.index_to_world().matrix3;
    let edge = axes.x_axis.length().max(axes.y_axis.length()).max(axes.z_axis.length());
    let (mut square, mut both, mut changed, mut hits) = (0.0, 0u64, 0u64, 0u64);
    for (found, expected) in image.pixels().iter().zip(exact.pixels()) {
        let [is_hit, was_hit] = [found, expected].map(|pixel| pixel.depth.is_finite());
        hits += u64::from(was_hit);
        changed += u64::from(is_hit != was_hit);
        if is_hit && was_hit {
            both += 1;
            square += (f64::from(found.depth - expected.depth) / edge).powi(2);
        }
    }
    [(square / both.max(1) as f64).sqrt(), 100.0 * changed as f64 / hits.max(1) as f64]
}

fn print(row: &DetailRow) {
    let optional = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3}"));
    println!(
        "{:<22} {:<7} {:>4} {:>5} | {:>10} {:>8.1} {:>9.1} {:>10.1} | {:>9.2e} {:>9.2e} | {:>10} {:>8}",
        row.mesh,
        row.what,
        row.size,
        row.ratio,
        row.leaves,
        row.bytes as f64 / f64::from(1 << 20),
        row.made_ms,
        row.frame_ms,
        row.rms_error,
        row.largest_error,
        optional(row.depth_rms_cells),
        optional(row.changed_percent),
    );
}
