//! Single rays: octree against grid, as their authors compared them. How time grows with size and threads is what [`scaling`](super::scaling) measures.

mod phases;
mod structures;
mod sweeps;

use std::hint::black_box;

use anyhow::Result;
use isoray_benches::views::View;
use isoray_grid::Dims;
use isoray_trace::{FirstHit, Hit, Trace, Work};
use serde::Serialize;

pub(super) use self::phases::phases;
pub(super) use self::structures::Structures;
use super::recorded::{Found, lambert};
use crate::catalog::Entry;

/// What the suite measured.
#[derive(Debug, Default, Serialize)]
pub(crate) struct SingleSuite {
    pub(crate) structures: Vec<structures::StructureRow>,
    pub(crate) phases: Vec<phases::PhaseRow>,
    pub(crate) sweeps: Vec<sweeps::SweepRow>,
}

/// Pixels along the side of a picture, in a full and in a short run.
const SIZES: [u32; 2] = [512, 256];

/// # Errors
/// Anything that is timed and finds other hits than it must.
pub(crate) fn run(quick: bool, entries: &[Entry], repeat: usize) -> Result<SingleSuite> {
    let size = SIZES[usize::from(quick)];
    let mut suite = SingleSuite::default();
    println!(
        "\n{:<20} {:>6} {:<34} {:>8} {:>10} {:>12} {:>14}",
        "volume", "view", "traversal, data", "ns/ray", "nodes/ray", "lookups/ray", "bytes, % of raw"
    );
    for entry in entries {
        let rows = entry.visit(Structures { entry, size, repeat })??;
        rows.iter().for_each(structures::StructureRow::print);
        suite.structures.extend(rows);
    }
    println!(
        "\n{:<20} {:>6} {:<22} {:>10} {:>13} {:>8}",
        "volume", "view", "traversal, data", "traversal", "intersection", "shading"
    );
    for entry in entries {
        suite.phases.extend(entry.visit(phases::Phases { entry, size, repeat })??);
    }
    println!("\n{:<20} {:<28} {:>9} {:>9} {:>15}", "volume", "grid", "far ns", "close ns", "bytes, % of raw");
    for entry in entries.iter().filter(|entry| quick || SWEPT.contains(&entry.name.as_str())) {
        let sweeps = sweeps::Sweeps { entry, size, repeat: repeat.min(3), quick };
        suite.sweeps.extend(entry.visit(sweeps)??);
    }
    Ok(suite)
}

/// Volumes whose bricks and macrocells are swept.
const SWEPT: [&str; 3] = ["turbulence 512", "heptane", "chest CT"];

/// A frame of first hits, with forward normals and Lambert's law.
fn frame(tracer: &mut impl Trace, view: &View, isovalue: f32) -> Found {
    shaded_frame(tracer, view, isovalue, |hit, direction| lambert(hit.gradient(), direction))
}

// See the overview's loops.
#[inline(never)]
fn shaded_frame(
    tracer: &mut impl Trace,
    view: &View,
    isovalue: f32,
    shade: impl Fn(&Hit, [f32; 3]) -> f32,
) -> Found {
    let mut found = Found::default();
    for &direction in &view.directions {
        if let Some(hit) = tracer.first_hit(&view.ray(direction), isovalue) {
            found.add(hit.t);
            black_box(shade(&hit, direction));
        }
    }
    found
}

/// The work of all rays of a view.
pub(super) fn count(tracer: &mut impl Trace, view: &View, isovalue: f32) -> Work {
    let mut work = Work::default();
    for &direction in &view.directions {
        tracer.trace(&view.ray(direction), isovalue, &mut FirstHit::default(), &mut work);
    }
    work
}

fn views(dims: Dims, size: u32) -> [(&'static str, View); 2] {
    [("far", View::far(dims, size, size)), ("close", View::close(dims, size, size))]
}
