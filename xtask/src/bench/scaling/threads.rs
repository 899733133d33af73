//! Frames on one thread, two, and so on up to eight; then on every power of two, and on all cores.

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_render::{Image, Scene, render};
use rayon::ThreadPool;
use serde::Serialize;

use super::fit::Fit;
use super::{ScalingSuite, groups};
use crate::bench::picture::hits;
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};

/// Frames on some threads.
#[derive(Debug, Serialize)]
pub(crate) struct ThreadRow {
    volume: String,
    threads: usize,
    frames_per_s: f64,
    /// Of one thread's rate, for each.
    efficiency: f64,
}

pub(super) struct Threads<'a> {
    pub(super) entry: &'a Entry,
    pub(super) quick: bool,
    pub(super) repeat: usize,
}

impl DenseVisitor for Threads<'_> {
    type Output = Result<Vec<ThreadRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let view = octree.view();
        let camera = volume.camera(Place::Close, if self.quick { 512 } else { 1024 })?;
        let scene = Scene::of(self.entry.isovalues[0]);
        let frame = || render(&view, volume.index_to_world, &camera, &scene);
        let measured = on_threads(&counts(rayon::current_num_threads()), self.repeat, frame)
            .with_context(|| format!("{}, close", self.entry.name))?;
        let alone = measured[0].1;
        let rows = measured.into_iter().map(|(threads, seconds)| {
            let row = ThreadRow {
                volume: self.entry.name.clone(),
                threads,
                frames_per_s: 1.0 / seconds,
                efficiency: alone / seconds / threads as f64,
            };
            println!(
                "{:<20} {threads:>7} {:>9.2} {:>10.1}%",
                row.volume,
                row.frames_per_s,
                100.0 * row.efficiency
            );
            row
        });
        Ok(rows.collect())
    }
}

/// Up to eight threads all numbers, since groups of cores share caches; beyond, powers of two and all cores.
fn counts(cores: usize) -> Vec<usize> {
    (1..=cores).filter(|&n| n <= 8 || n.is_power_of_two() || n == cores).collect()
}

/// Seconds of a frame on each of these numbers of threads that there are cores for.
///
/// # Errors
/// A frame in which no ray hits, or that is another on some threads than on the first number of them.
pub(in crate::bench) fn on_threads(
    counts: &[usize],
    repeat: usize,
    frame: impl Fn() -> Image + Sync,
) -> Result<Vec<(usize, f64)>> {
    let cores = rayon::current_num_threads();
    let counts = counts.iter().copied().filter(|&n| n <= cores);
    let pool =
        |n| Ok((n, rayon::ThreadPoolBuilder::new().num_threads(n).build().context("cannot start threads")?));
    let pools: Vec<(usize, ThreadPool)> = counts.map(pool).collect::<Result<_>>()?;
    let mut frames: Vec<_> = pools.iter().map(|(_, pool)| || pool.install(&frame)).collect();
    let mut variants: Vec<&mut dyn FnMut() -> Image> = frames.iter_mut().map(|frame| frame as _).collect();
    let (times, timed) = interleave_kept(repeat, &mut variants);
    let alone = timed.first().context("there is no number of threads to try")?;
    ensure!(hits(alone) > 0, "no ray hits");
    for (image, (threads, _)) in timed.iter().zip(&pools) {
        ensure!(image == alone, "another picture on {threads} threads");
    }
    Ok(pools.iter().map(|(threads, _)| *threads).zip(times).collect())
}

/// Frames a second by threads.
pub(super) fn fits(suite: &ScalingSuite) -> Vec<Fit> {
    let of = |rows: &[ThreadRow]| {
        let points = rows.iter().map(|row| [row.threads as f64, row.frames_per_s]);
        Fit::new(["frames a second by threads", "close"], &rows[0].volume, points)
    };
    groups(&suite.threads, |row| row.volume.clone()).filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_threads_are_all_tried() {
        assert_eq!(counts(2), [1, 2]);
        assert_eq!(counts(6), [1, 2, 3, 4, 5, 6]);
        assert_eq!(counts(48), [1, 2, 3, 4, 5, 6, 7, 8, 16, 32, 48]);
    }
}
