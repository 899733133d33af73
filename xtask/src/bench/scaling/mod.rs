//! How time grows with threads, with the picture, with the volume and with the surface in it, as exponents of power laws.

mod complexity;
mod fit;
mod pixels;
mod sizes;
mod threads;

use anyhow::{Result, ensure};
use isoray_benches::views::View;
use isoray_trace::Trace;
use serde::Serialize;

use self::fit::Fit;
pub(super) use self::threads::on_threads;
use super::recorded::lambert;
use crate::catalog::Entry;

/// What the suite measured.
#[derive(Debug, Default, Serialize)]
pub(crate) struct ScalingSuite {
    pub(crate) threads: Vec<threads::ThreadRow>,
    pub(crate) pixels: Vec<pixels::PixelRow>,
    pub(crate) sizes: Vec<sizes::SizeRow>,
    pub(crate) complexity: Vec<complexity::ComplexityRow>,
    /// Power laws through these.
    pub(crate) fits: Vec<Fit>,
}

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) quick: bool,
    /// A volume of 2048³ too.
    pub(crate) is_large: bool,
    pub(crate) repeat: usize,
}

/// Volumes of which pictures of all sizes are made, and their surfaces looked at at many isovalues, unless others are asked for.
const CHOSEN: [&str; 3] = ["tooth (fixture)", "turbulence 512", "heptane"];

/// # Errors
/// Anything that is timed and finds another picture, or other hits, than it must.
pub(crate) fn run(extent: Extent, entries: &[Entry], only: Option<&str>) -> Result<ScalingSuite> {
    let Extent { quick, is_large, repeat } = extent;
    let mut suite = ScalingSuite::default();
    let chosen = |entry: &&Entry| quick || only.is_some() || CHOSEN.contains(&entry.name.as_str());
    let is_generated = |name: &str| only.is_none_or(|only| name.contains(only));
    ensure!(
        !entries.is_empty() || [sizes::VOLUME, complexity::GYROID].into_iter().any(is_generated),
        "no volume is named like {:?}",
        only.unwrap_or_default()
    );

    println!("\n{:<20} {:>7} {:>9} {:>11}", "volume", "threads", "frames/s", "efficiency");
    for entry in entries.iter().take(if quick { 1 } else { 3 }) {
        suite.threads.extend(entry.visit(threads::Threads { entry, quick, repeat })??);
    }
    suite.fit(threads::fits);

    println!(
        "\nPictures of all sizes, one thread.\n{:<20} {:>6} {:>6} {:>9} {:>8} {:>10} {:>8}",
        "volume", "view", "size", "ms", "ns/ray", "nodes/ray", "hits %"
    );
    for entry in entries.iter().filter(chosen).take(if quick { 1 } else { usize::MAX }) {
        suite.pixels.extend(entry.visit(pixels::Pixels { entry, quick, repeat })??);
    }
    suite.fit(pixels::fits);

    println!(
        "\n{:<20} {:>6} {:>6} {:>8} {:>10} {:>8}",
        "the same field", "edge", "view", "ns/ray", "nodes/ray", "hits %"
    );
    let edges: &[u32] = match (quick, is_large) {
        (true, _) => &[32, 64, 128],
        (false, false) => &[64, 128, 256, 512, 1024],
        (false, true) => &[64, 128, 256, 512, 1024, 2048],
    };
    if is_generated(sizes::VOLUME) {
        suite.sizes = sizes::run(edges, quick, repeat)?;
    }
    suite.fit(sizes::fits);

    println!(
        "\nSurfaces in one volume, one thread.\n{:<20} {:>6} {:>9} {:>6} {:>12} {:>8} {:>10} {:>10} {:>8}",
        "volume", "waves", "isovalue", "view", "mixed cells", "ns/ray", "nodes/ray", "cells/ray", "hits %"
    );
    if is_generated(complexity::GYROID) {
        suite.complexity = complexity::waves(quick, repeat)?;
    }
    for entry in entries.iter().filter(chosen) {
        suite.complexity.extend(entry.visit(complexity::Isovalues { entry, quick, repeat })??);
    }
    suite.fit(complexity::fits);
    Ok(suite)
}

impl ScalingSuite {
    fn fit(&mut self, of: impl Fn(&Self) -> Vec<Fit>) {
        let fits = of(self);
        fits.iter().for_each(Fit::print);
        self.fits.extend(fits);
    }
}

/// Rows of one kind, in runs of those that belong together.
fn groups<R, K: PartialEq>(rows: &[R], key: impl Fn(&R) -> K) -> impl Iterator<Item = &[R]> {
    rows.chunk_by(move |a, b| key(a) == key(b))
}

/// What a frame comes to: by this a timed run is known to have found what it should.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Sums {
    hits: u64,
    /// Of the bits of depths, and of shares of light.
    depths: u64,
    light: u64,
}

/// A frame of single rays: first hits, with forward normals and Lambert's law. As the overview's, with sums.
#[inline(never)]
fn frame(tracer: &mut impl Trace, view: &View, isovalue: f32) -> Sums {
    let mut sums = Sums::default();
    for &direction in &view.directions {
        if let Some(hit) = tracer.first_hit(&view.ray(direction), isovalue) {
            sums.hits += 1;
            sums.depths = sums.depths.wrapping_add(hit.t.to_bits().into());
            sums.light = sums.light.wrapping_add(lambert(hit.gradient(), direction).to_bits().into());
        }
    }
    sums
}
