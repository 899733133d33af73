//! Frames on one thread, two, and so on up to all cores.

use std::hint::black_box;

use anyhow::{Result, ensure};
use isoray_grid::Scalar;
use isoray_render::{Scene, render};
use serde::Serialize;

use super::fit::Fit;
use super::{ScalingSuite, groups};
use crate::bench::timer::interleave;
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
        let counts: Vec<usize> = (1..=cores).filter(|n| n.is_power_of_two() || *n == cores).collect();
        let pools: Vec<_> = counts
            .iter()
            .map(|&n| rayon::ThreadPoolBuilder::new().num_threads(n).build())
            .collect::<Result<_, _>>()?;
        let frame =
            |pool: &rayon::ThreadPool| pool.install(|| render(&view, volume.index_to_world, &camera, &scene));
        let alone = frame(&pools[0]);
        for (pool, threads) in pools.iter().zip(&counts) {
            ensure!(frame(pool) == alone, "{}: another picture on {threads} threads", self.entry.name);
        }
        let mut frames: Vec<_> = pools.iter().map(|pool| move || drop(black_box(frame(pool)))).collect();
        let mut variants: Vec<&mut dyn FnMut()> = frames.iter_mut().map(|frame| frame as _).collect();
        let times = interleave(self.repeat, &mut variants);
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

/// Frames a second by threads.
pub(super) fn fits(suite: &ScalingSuite) -> Vec<Fit> {
    let of = |rows: &[ThreadRow]| {
        let points = rows.iter().map(|row| [row.threads as f64, row.frames_per_s]);
        Fit::new(["frames a second by threads", "close"], &rows[0].volume, points)
    };
    let several = groups(&suite.threads, |row| row.volume.clone()).filter(|rows| rows.len() > 1);
    several.map(of).collect()
}
