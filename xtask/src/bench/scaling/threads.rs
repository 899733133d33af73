//! Frames on one thread, two, and so on up to eight; then on every power of two, and on all cores.

use anyhow::{Result, ensure};
use isoray_grid::Scalar;
use isoray_render::{Image, Scene, render};
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
        let cores = rayon::current_num_threads();
        let counts = counts(cores);
        let pools: Vec<_> = counts
            .iter()
            .map(|&n| rayon::ThreadPoolBuilder::new().num_threads(n).build())
            .collect::<Result<_, _>>()?;
        let frame =
            |pool: &rayon::ThreadPool| pool.install(|| render(&view, volume.index_to_world, &camera, &scene));
        let alone = frame(&pools[0]);
        ensure!(hits(&alone) > 0, "{}, close: no ray hits", self.entry.name);
        let mut frames: Vec<_> = pools.iter().map(|pool| move || frame(pool)).collect();
        let mut variants: Vec<&mut dyn FnMut() -> Image> =
            frames.iter_mut().map(|frame| frame as _).collect();
        let (times, timed) = interleave_kept(self.repeat, &mut variants);
        for (image, threads) in timed.iter().zip(&counts) {
            ensure!(*image == alone, "{}: another picture on {threads} threads", self.entry.name);
        }
        let rows = counts.iter().zip(&times).map(|(&threads, seconds)| {
            let row = ThreadRow {
                volume: self.entry.name.clone(),
                threads,
                frames_per_s: 1.0 / seconds,
                efficiency: times[0] / seconds / threads as f64,
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
