//! Frame times on the way round a volume: what a viewer feels, who minds the slowest frames and not only the mean.

use std::time::Instant;

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_render::{Camera, Image, Scene};
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use super::picture::Pictures;
use super::timer::{median, quantile};
use crate::catalog::{Dense, DenseVisitor, Entry};

/// Titles of the columns.
pub(crate) const HEADER: &str = "\nRound the volume in equal steps from the far view, all variants at each step; ms a frame, median and 99th percentile. Ratio 0: exact. Times exact: median over the frames.\nCoarsest level that a frame may show; what most differs in a frame: hits, in %, and by how many pixels that moves outlines in the mean.\nvolume                 iso   size frames threads ratio | coarsest | median ms  99 % ms × exact | hits %  outlines px";

/// Pixels a voxel may be wide where it is drawn in place of finer ones; zero: the exact picture.
const RATIOS: [f64; 4] = [0.0, 1.0, 2.0, 4.0];
/// Part of a circle after which it is made sure again that levels of detail at ratio 0 are the exact picture.
const CHECKS: usize = 6;

/// One way round.
#[derive(Debug, Serialize)]
pub(crate) struct OrbitRow {
    volume: String,
    isovalue: f32,
    /// Pixels along each side.
    size: u32,
    frames: usize,
    threads: usize,
    ratio: f64,
    /// That any frame may show.
    coarsest_level: u32,
    median_ms: f64,
    p99_ms: f64,
    times_exact: f64,
    /// More or fewer than exactly, in % of the exact ones, in the frame where that is most.
    hits_differ_percent: f64,
    /// The same in exact pixels of an outline: by how many pixels outlines would have to move for it.
    outlines_move_pixels: f64,
}

pub(crate) struct Orbit<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) size: u32,
    pub(crate) frames: usize,
}

/// What is timed at each step.
struct Variant<'p> {
    pool: &'p ThreadPool,
    ratio: f64,
    coarsest: u32,
    seconds: Vec<f64>,
    hits: u64,
    /// What a row tells of hits and outlines.
    differ: [f64; 2],
}

impl DenseVisitor for Orbit<'_> {
    type Output = Result<Vec<OrbitRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let pictures = Pictures::new(&octree);
        let scene = Scene::of(self.entry.isovalues[0]);
        let pools = pools()?;
        let pairs = pools.iter().flat_map(|pool| RATIOS.map(|ratio| (pool, ratio)));
        let mut variants: Vec<_> = pairs
            .map(|(pool, ratio)| Variant {
                pool,
                ratio,
                coarsest: 0,
                seconds: Vec::new(),
                hits: 0,
                differ: [0.0; 2],
            })
            .collect();
        let camera = |n: usize| volume.orbiting_camera(360.0 * n as f64 / self.frames as f64, self.size);
        // One step that does not count.
        step(&pictures, &camera(0)?, &scene, &mut variants, 0).context("the first frame")?;
        variants.iter_mut().for_each(|variant| variant.seconds.clear());
        for n in 0..self.frames {
            let camera = camera(n)?;
            let of_what = || format!("{}: frame {n} of {}", self.entry.name, self.frames);
            step(&pictures, &camera, &scene, &mut variants, n).with_context(of_what)?;
            if n % self.frames.div_ceil(CHECKS) == 0 {
                ensure_exact(&pictures, &camera, &scene).with_context(of_what)?;
            }
        }
        Ok(self.rows(&variants))
    }
}

/// One thread, and as many as there are.
fn pools() -> Result<Vec<ThreadPool>> {
    let all = rayon::current_num_threads();
    let counts = if all == 1 { vec![1] } else { vec![1, all] };
    let pool = |n| ThreadPoolBuilder::new().num_threads(n).build().context("no threads");
    counts.into_iter().map(pool).collect()
}

/// Renders a frame by every variant, each the first of them in its turn, and compares hits.
///
/// A coarse cell is at most as many pixels wide as the ratio says, so outlines move by no more than that; what is thinner can vanish as a whole, but has no pixel that
/// is farther from an outline. So in the mean hits come and go in a strip of no greater width along the exact outlines: a few percent of a solid body, more of wires.
fn step<T: Scalar>(
    pictures: &Pictures<'_, T>,
    camera: &Camera,
    scene: &Scene<'_>,
    variants: &mut [Variant<'_>],
    turn: usize,
) -> Result<()> {
    let count = variants.len();
    let mut outline = 0;
    for n in (0..count).map(|n| (n + turn) % count) {
        let variant = &mut variants[n];
        let begin = Instant::now();
        let (image, coarsest) = variant.pool.install(|| pictures.frame(camera, scene, variant.ratio));
        variant.seconds.push(begin.elapsed().as_secs_f64());
        variant.coarsest = variant.coarsest.max(coarsest);
        variant.hits = count_hits(&image);
        if n == 0 {
            outline = count_outline(&image);
        }
    }
    let exact = variants[0].hits;
    ensure!(exact > 0, "no ray hits");
    for variant in variants {
        let differ = exact.abs_diff(variant.hits) as f64;
        let moved = differ / outline.max(1) as f64;
        let limit = if variant.coarsest == 0 { 0.0 } else { variant.ratio };
        ensure!(
            variant.hits > 0 && moved <= limit,
            "ratio {}: {} hits, exactly {exact}, and {outline} on outlines",
            variant.ratio,
            variant.hits
        );
        let [percent, most] = variant.differ;
        variant.differ = [percent.max(100.0 * differ / exact as f64), most.max(moved)];
    }
    Ok(())
}

fn count_hits(image: &Image) -> u64 {
    image.pixels().iter().filter(|pixel| pixel.depth.is_finite()).count() as u64
}

/// Pixels that hit beside one that does not.
fn count_outline(image: &Image) -> u64 {
    let hits = |x: u32, y: u32| image.pixel(x, y).depth.is_finite();
    let is_outline = |x: u32, y: u32| {
        let beside = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        hits(x, y) && !beside.iter().all(|&(x, y)| hits(x, y))
    };
    let [width, height] = image.size();
    (0..height).map(|y| (0..width).filter(|&x| is_outline(x, y)).count() as u64).sum()
}

/// Makes sure that levels of detail of which only the finest is wanted show the exact picture.
fn ensure_exact<T: Scalar>(pictures: &Pictures<'_, T>, camera: &Camera, scene: &Scene<'_>) -> Result<()> {
    let found = pictures.at_levels(camera, scene, pictures.detail(camera, 0.0));
    ensure!(found == pictures.exact(camera, scene), "ratio 0 does not show the exact picture");
    Ok(())
}

impl Orbit<'_> {
    fn rows(&self, variants: &[Variant<'_>]) -> Vec<OrbitRow> {
        let of_pools = variants.chunks_exact(RATIOS.len());
        let pairs = of_pools.flat_map(|of_pool| of_pool.iter().map(|variant| (&of_pool[0], variant)));
        let rows = pairs.map(|(exact, variant)| {
            let times_exact = exact.seconds.iter().zip(&variant.seconds).map(|(exact, t)| exact / t);
            let row = OrbitRow {
                volume: self.entry.name.clone(),
                isovalue: self.entry.isovalues[0],
                size: self.size,
                frames: self.frames,
                threads: variant.pool.current_num_threads(),
                ratio: variant.ratio,
                coarsest_level: variant.coarsest,
                median_ms: 1e3 * median(variant.seconds.clone()),
                p99_ms: 1e3 * quantile(variant.seconds.clone(), 0.99),
                times_exact: median(times_exact.collect()),
                hits_differ_percent: variant.differ[0],
                outlines_move_pixels: variant.differ[1],
            };
            println!("{}", line(&row));
            row
        });
        rows.collect()
    }
}

fn line(row: &OrbitRow) -> String {
    format!(
        "{:<20} {:>6} {:>6} {:>6} {:>7} {:>5} | {:>8} | {:>9.2} {:>8.2} {:>7.2} | {:>6.3} {:>12.3}",
        row.volume,
        row.isovalue,
        row.size,
        row.frames,
        row.threads,
        row.ratio,
        row.coarsest_level,
        row.median_ms,
        row.p99_ms,
        row.times_exact,
        row.hits_differ_percent,
        row.outlines_move_pixels,
    )
}
