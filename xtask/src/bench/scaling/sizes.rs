//! One field at several resolutions, in the same view: the signal of Marschner and Lobb, in which hardly anything is constant.

use anyhow::{Result, ensure};
use glam::DAffine3;
use isoray_benches::views::View;
use isoray_grid::Dims;
use isoray_octree::OctreeVolume;
use isoray_synth::MarschnerLobb;
use isoray_trace::{GridTracer, GridVolume, Tracer};
use serde::Serialize;

use super::fit::Fit;
use super::{ScalingSuite, first_hits};
use crate::bench::single::count;
use crate::bench::timer::interleave;

/// One size of the field, on one thread.
#[derive(Debug, Serialize)]
pub(crate) struct SizeRow {
    /// Samples along each axis.
    edge: u32,
    view: &'static str,
    ns_per_ray: f64,
    nodes_per_ray: f64,
    hits: u64,
}

/// What it is called.
pub(super) const VOLUME: &str = "Marschner-Lobb";
const ISOVALUE: f32 = 127.5;
/// By how much the share of rays that hit may change from one resolution to the next; below 256³ rings are a few samples wide, and the surface another.
const HITS_DIFFER: f64 = 0.01;
const RESOLVED: u32 = 256;

pub(super) fn run(edges: &[u32], quick: bool, repeat: usize) -> Result<Vec<SizeRow>> {
    let size = if quick { 128 } else { 512 };
    let mut rows: Vec<SizeRow> = Vec::new();
    for &edge in edges {
        let dims = Dims::new([edge; 3])?;
        // Streamed: the samples themselves are never all in memory.
        let octree: OctreeVolume<u8> =
            isoray_build::build(&mut MarschnerLobb::new(dims), DAffine3::IDENTITY, |_| {})?;
        let octree = octree.view();
        let mut tracer = Tracer::new(&octree);
        for (name, view) in [("far", View::far(dims, size, size)), ("close", View::close(dims, size, size))] {
            let mut found = [0, 0];
            let seconds =
                interleave(repeat, &mut [&mut || found = first_hits(&mut tracer, &view, ISOVALUE)])[0];
            // In a grid of macrocells over the same samples, if those are soon read.
            let expected = match edge <= RESOLVED {
                true => first_hits(&mut GridTracer::new(&GridVolume::new(&octree)), &view, ISOVALUE),
                false => first_hits(&mut Tracer::new(&octree), &view, ISOVALUE),
            };
            ensure!(
                found == expected,
                "{edge}³, {name}: hits and depths {found:?} when timed, not {expected:?}"
            );
            let work = count(&mut tracer, &view, ISOVALUE);
            let rays = view.directions.len() as f64;
            let share = found[0] as f64 / rays;
            let before = rows.iter().rev().find(|row| row.view == name);
            let share_before = before.map_or(share, |row| row.hits as f64 / rays);
            ensure!(
                edge <= RESOLVED || (share - share_before).abs() <= HITS_DIFFER,
                "{edge}³, {name}: {share} of the rays hit, in half the size {share_before}"
            );
            let row = SizeRow {
                edge,
                view: name,
                ns_per_ray: seconds / rays * 1e9,
                nodes_per_ray: work.nodes as f64 / rays,
                hits: found[0],
            };
            println!(
                "{VOLUME:<20} {edge:>6} {name:>6} {:>8.0} {:>10.2} {:>8.2}",
                row.ns_per_ray,
                row.nodes_per_ray,
                100.0 * share
            );
            rows.push(row);
        }
    }
    Ok(rows)
}

/// Time by samples along an edge.
pub(super) fn fits(suite: &ScalingSuite) -> Vec<Fit> {
    let of = |view| {
        let rows = suite.sizes.iter().filter(|row| row.view == view);
        let points = rows.map(|row| [f64::from(row.edge), row.ns_per_ray]);
        Fit::new(["time of a ray by samples along an edge", view], VOLUME, points)
    };
    if suite.sizes.is_empty() { Vec::new() } else { ["far", "close"].map(of).into() }
}
