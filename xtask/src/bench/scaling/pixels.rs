//! One scene in pictures of all sizes.

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_render::{Scene, Traversal, render, render_counted};
use serde::Serialize;

use super::fit::Fit;
use super::{ScalingSuite, groups, hits};
use crate::bench::timer::interleave;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};

/// A frame of one size, on one thread.
#[derive(Debug, Serialize)]
pub(crate) struct PixelRow {
    volume: String,
    isovalue: f32,
    view: &'static str,
    /// Pixels along each side.
    size: u32,
    ms: f64,
    ns_per_ray: f64,
    nodes_per_ray: f64,
    hits: u64,
}

pub(super) struct Pixels<'a> {
    pub(super) entry: &'a Entry,
    pub(super) quick: bool,
    pub(super) repeat: usize,
}

/// Pixels along each side, and in a short run.
const SIZES: [&[u32]; 2] = [&[256, 512, 1024, 2048, 4096], &[64, 128, 256]];
/// Frames of this size and more are timed this often at most.
const BIG: u32 = 2048;
const SELDOM: usize = 3;
/// By how much the share of rays that hit may change from size to size: outlines are a part of a picture that shrinks with its pixels.
const HITS_DIFFER: f64 = 0.02;

impl DenseVisitor for Pixels<'_> {
    type Output = Result<Vec<PixelRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let view = octree.view();
        let isovalue = self.entry.isovalues[0];
        let scene = Scene::of(isovalue);
        let singly = Scene { traversal: Traversal::Single, ..scene.clone() };
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
        let mut rows: Vec<PixelRow> = Vec::new();
        for place in [Place::Far, Place::Close] {
            let mut share_before = None;
            for &size in SIZES[usize::from(self.quick)] {
                let camera = volume.camera(place, size)?;
                let (image, statistics) = render_counted(&view, volume.index_to_world, &camera, &scene);
                ensure!(
                    image == render(&view, volume.index_to_world, &camera, &singly),
                    "{}, {size}²: not the picture of single rays",
                    self.entry.name
                );
                let rays = f64::from(size).powi(2);
                let found = hits(&image);
                drop(image);
                let share = found as f64 / rays;
                let before: f64 = share_before.replace(share).unwrap_or(share);
                ensure!(
                    found > 0 && (share - before).abs() <= HITS_DIFFER,
                    "{}, {size}²: {share} of the rays hit, in half the size {before}",
                    self.entry.name
                );
                let mut timed = None;
                let repeat = if size < BIG { self.repeat } else { self.repeat.min(SELDOM) };
                let frame = || timed = Some(render(&view, volume.index_to_world, &camera, &scene));
                let seconds = one.install(move || interleave(repeat, &mut [&mut { frame }]))[0];
                let timed = timed.as_ref().map_or(0, hits);
                ensure!(timed == found, "{}, {size}²: {timed} hits when timed, not {found}", self.entry.name);
                let row = PixelRow {
                    volume: self.entry.name.clone(),
                    isovalue,
                    view: place.name(),
                    size,
                    ms: 1e3 * seconds,
                    ns_per_ray: 1e9 * seconds / rays,
                    nodes_per_ray: statistics.work.nodes as f64 / rays,
                    hits: found,
                };
                println!(
                    "{:<20} {:>6} {size:>6} {:>9.2} {:>8.1} {:>10.2} {:>8.2}",
                    row.volume,
                    row.view,
                    row.ms,
                    row.ns_per_ray,
                    row.nodes_per_ray,
                    100.0 * share
                );
                rows.push(row);
            }
        }
        Ok(rows)
    }
}

/// Time by pixels.
pub(super) fn fits(suite: &ScalingSuite) -> Vec<Fit> {
    let of = |rows: &[PixelRow]| {
        let points = rows.iter().map(|row| [f64::from(row.size).powi(2), row.ms]);
        Fit::new(["time of a frame by pixels", rows[0].view], &rows[0].volume, points)
    };
    groups(&suite.pixels, |row| (row.volume.clone(), row.view)).map(of).collect()
}
