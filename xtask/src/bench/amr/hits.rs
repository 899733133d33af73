//! Isosurfaces of a mesh against the oracle's on the finest lattice, along some rays of the far view.

use anyhow::{Context, Result, ensure};
use isoray_amr::{Mesh, MeshTracer};
use isoray_trace::{Ray, Trace};
use rayon::prelude::*;
use serde::Serialize;

use super::errors::pixels;
use super::tables::Scene;
use crate::finest::{Field, Finest};

/// One isovalue of one mesh.
#[derive(Debug, Serialize)]
pub(crate) struct HitRow {
    mesh: String,
    isovalue: f32,
    rays: usize,
    hits: usize,
    /// Rays that graze, and whose hit hangs on the rounding of values to 32 bits; they are not compared.
    doubtful: usize,
    false_hits: usize,
    missed: usize,
    /// Along the ray, in edges of the finest cells.
    largest_error: f64,
    rms_error: f64,
}

pub(super) const HEADER: &str = "\nIsosurfaces, far view: first hits against the oracle's on the finest lattice, of a pixel in each square of the picture; errors along the ray in edges of finest cells.\nmesh                     isovalue |     rays     hits doubtful    false   missed | largest error       rms";

/// Where between the least and the largest value.
const ISOVALUES: [f32; 2] = [0.23, 0.51];

/// Error of a hit, at most, in edges of finest cells: that of the tests of rays through meshes.
const LARGEST: f64 = 1e-2;

/// What is found of a ray.
enum Found {
    Doubtful,
    Miss,
    False,
    Missed,
    Hit(f64),
}

pub(super) fn rows(name: &str, mesh: &Mesh, finest: &Finest, quick: bool) -> Result<Vec<HitRow>> {
    let (size, square) = if quick { (64, 2) } else { (512, 16) };
    let scene = Scene::new(mesh, size)?;
    let field = finest.field();
    let [low, high] = mesh.range().context("the mesh has no values")?;
    let world_to_index = mesh.index_to_world().inverse();
    let rays: Vec<Ray> = pixels(size, square)
        .into_iter()
        .map(|[x, y]| scene.camera.index_ray(&world_to_index, x, y))
        .collect();
    let mut rows = Vec::new();
    for share in ISOVALUES {
        let isovalue = low + share * (high - low);
        let one = |tracer: &mut MeshTracer<'_>, ray: &Ray| look(tracer, ray, isovalue, (finest, &field));
        let found: Vec<Found> = rays.par_iter().map_init(|| MeshTracer::new(mesh), one).collect();
        let count = |of: fn(&Found) -> bool| found.iter().filter(|found| of(found)).count();
        let errors =
            || found.iter().filter_map(|f| if let Found::Hit(error) = f { Some(error) } else { None });
        let hits = errors().count();
        let row = HitRow {
            mesh: name.to_owned(),
            isovalue,
            rays: rays.len(),
            hits,
            doubtful: count(|f| matches!(f, Found::Doubtful)),
            false_hits: count(|f| matches!(f, Found::False)),
            missed: count(|f| matches!(f, Found::Missed)),
            largest_error: errors().copied().fold(0.0, f64::max),
            rms_error: (errors().map(|e| e * e).sum::<f64>() / hits.max(1) as f64).sqrt(),
        };
        print(&row);
        ensure!(row.false_hits + row.missed == 0, "{name}: hits that are not the oracle's");
        ensure!(row.largest_error <= LARGEST, "{name}: a hit off by {} cells", row.largest_error);
        ensure!(row.doubtful * 10 <= row.rays, "{name}: too many rays graze");
        rows.push(row);
    }
    Ok(rows)
}

fn look(
    tracer: &mut MeshTracer<'_>,
    ray: &Ray,
    isovalue: f32,
    (finest, field): (&Finest, &Field<'_>),
) -> Found {
    let Some(expected) = finest.hit(field, ray, isovalue) else { return Found::Doubtful };
    let speed = ray.direction.iter().map(|d| f64::from(*d).powi(2)).sum::<f64>().sqrt();
    match (tracer.first_hit(ray, isovalue), expected) {
        (None, None) => Found::Miss,
        (Some(_), None) => Found::False,
        (None, Some(_)) => Found::Missed,
        (Some(found), Some(expected)) => Found::Hit((f64::from(found.t) - expected.t).abs() * speed),
    }
}

fn print(row: &HitRow) {
    println!(
        "{:<22} {:>10.4} | {:>8} {:>8} {:>8} {:>8} {:>8} | {:>13.2e} {:>9.2e}",
        row.mesh,
        row.isovalue,
        row.rays,
        row.hits,
        row.doubtful,
        row.false_hits,
        row.missed,
        row.largest_error,
        row.rms_error,
    );
}
