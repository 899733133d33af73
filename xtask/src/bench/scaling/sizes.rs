//! One field at several resolutions, in the same view: the signal of Marschner and Lobb, in which hardly anything is constant.

use anyhow::{Result, ensure};
use glam::DAffine3;
use isoray_benches::path;
use isoray_benches::views::View;
use isoray_grid::Dims;
use isoray_octree::{OctreeView, OctreeVolume};
use isoray_synth::MarschnerLobb;
use isoray_trace::{GridTracer, GridVolume, Tracer};
use serde::Serialize;

use super::fit::Fit;
use super::{ScalingSuite, Sums, frame};
use crate::bench::single::count;
use crate::bench::timer::interleave_kept;

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

/// One of so many rays is compared with a look at every cell on its way. Odd, so that they are not all of one column of the tiles.
const COMPARED: usize = 61;

pub(super) fn run(edges: &[u32], quick: bool, repeat: usize) -> Result<Vec<SizeRow>> {
    let size = if quick { 128 } else { 512 };
    // Streamed: the samples themselves are never all in memory. The octrees are, so that all are timed in turn: the largest is seven eighths of them.
    let build = |&edge: &u32| -> Result<OctreeVolume<u8>> {
        let mut field = MarschnerLobb::new(Dims::new([edge; 3])?);
        Ok(isoray_build::build(&mut field, DAffine3::IDENTITY, |_| {})?)
    };
    let volumes: Vec<_> = edges.iter().map(build).collect::<Result<_>>()?;
    let octrees: Vec<_> = volumes.iter().map(OctreeVolume::view).collect();
    let mut rows = Vec::new();
    for (name, view) in [("far", View::far as fn(Dims, u32, u32) -> View), ("close", View::close)] {
        let scenes = octrees.iter().map(|octree| {
            let view = view(octree.dims(), size, size);
            Scene { octree, view, name }
        });
        rows.extend(views(&scenes.collect::<Vec<_>>(), repeat)?);
    }
    Ok(rows)
}

/// The field at one resolution, as it is looked at.
struct Scene<'a> {
    octree: &'a OctreeView<'a, u8>,
    view: View,
    name: &'static str,
}

/// All resolutions, in the same view.
fn views(scenes: &[Scene<'_>], repeat: usize) -> Result<Vec<SizeRow>> {
    let expected: Vec<Sums> = scenes.iter().map(Scene::checked).collect::<Result<_>>()?;
    let frames = scenes.iter().map(|Scene { octree, view, .. }| {
        let mut tracer = Tracer::new(octree);
        move || frame(&mut tracer, view, ISOVALUE)
    });
    let mut frames: Vec<_> = frames.collect();
    let mut variants: Vec<&mut dyn FnMut() -> Sums> = frames.iter_mut().map(|frame| frame as _).collect();
    let (times, timed) = interleave_kept(repeat, &mut variants);
    let mut rows: Vec<SizeRow> = Vec::new();
    for (n, scene) in scenes.iter().enumerate() {
        let Scene { octree, view, name } = scene;
        let edge = octree.dims().axes()[0];
        let (found, expected) = (timed[n], expected[n]);
        ensure!(found == expected, "{edge}³, {name}: {found:?} when timed, not {expected:?}");
        let rays = view.directions.len() as f64;
        let row = SizeRow {
            edge,
            view: name,
            ns_per_ray: times[n] / rays * 1e9,
            nodes_per_ray: count(&mut Tracer::new(octree), view, ISOVALUE).nodes as f64 / rays,
            hits: found.hits,
        };
        let share = row.hits as f64 / rays;
        let share_before = rows.last().map_or(share, |before| before.hits as f64 / rays);
        ensure!(
            share > 0.0 && (edge <= RESOLVED || (share - share_before).abs() <= HITS_DIFFER),
            "{edge}³, {name}: {share} of the rays hit, in half the size {share_before}"
        );
        println!(
            "{VOLUME:<20} {edge:>6} {name:>6} {:>8.0} {:>10.2} {:>8.2}",
            row.ns_per_ray,
            row.nodes_per_ray,
            100.0 * share
        );
        rows.push(row);
    }
    Ok(rows)
}

impl Scene<'_> {
    /// What the frame must come to, once some of its rays have been compared with a look at every cell, and all with a grid of macrocells over the same samples if those are
    /// soon read.
    fn checked(&self) -> Result<Sums> {
        let Self { octree, view, name } = self;
        let edge = octree.dims().axes()[0];
        let mut tracer = Tracer::new(octree);
        for &direction in view.directions.iter().step_by(COMPARED) {
            let ray = view.ray(direction);
            let found = tracer.first_hit(&ray, ISOVALUE);
            let expected = path::first_hit(*octree, &ray, ISOVALUE, &mut ());
            ensure!(found == expected, "{edge}³, {name}: {found:?}, by every cell {expected:?}, on {ray:?}");
        }
        let sums = frame(&mut tracer, view, ISOVALUE);
        if edge <= RESOLVED {
            let expected = frame(&mut GridTracer::new(&GridVolume::new(*octree)), view, ISOVALUE);
            ensure!(sums == expected, "{edge}³, {name}: {sums:?}, in a grid {expected:?}");
        }
        Ok(sums)
    }
}

/// Time by samples along an edge.
pub(super) fn fits(suite: &ScalingSuite) -> Vec<Fit> {
    let of = |view| {
        let rows = suite.sizes.iter().filter(|row| row.view == view);
        let points = rows.map(|row| [f64::from(row.edge), row.ns_per_ray]);
        Fit::new(["time of a ray by samples along an edge", view], VOLUME, points)
    };
    ["far", "close"].into_iter().filter_map(of).collect()
}
