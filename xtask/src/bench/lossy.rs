//! Lossy compression: size against what becomes of isosurfaces, which has to be what is guaranteed.

mod check;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use isoray_benches::views::View;
use isoray_build::{Changes, Isovalues, Loss, Lossy, SurfaceTolerance, build};
use isoray_grid::{DenseVolume, Scalar};
use isoray_octree::OctreeVolume;
use isoray_trace::{Ray, Tracer};
use plotters::prelude::*;
use rayon::prelude::*;
use serde::Serialize;

use super::chart;
use crate::catalog::{Dense, DenseVisitor, Entry};
use crate::root;

/// The volumes that are measured.
const VOLUMES: [&str; 3] = ["heptane", "CT head", "chest CT"];
/// Tolerances of samples, in 255ths of a volume's range.
const TOLERANCES: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];
/// Displacements of surfaces, in voxels.
const DISPLACEMENTS: [f64; 6] = [0.0, 0.01, 0.03, 0.1, 0.3, 1.0];
/// Ranges reach this part of an isovalue to both sides of it.
const RANGE: f32 = 0.2;
/// Pixels along each side of the view.
const SIZE: u32 = 512;

/// One volume with one loss.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LossyRow {
    volume: String,
    /// What is bounded.
    bound: &'static str,
    /// By how much, in the bound's units.
    amount: f64,
    /// The whole file, in % of the raw samples.
    percent: f64,
    /// Samples changed, in % of all.
    changed: f64,
    /// Building, the loss included.
    build_s: f64,
    /// Isosurfaces that the hits are those of.
    isovalues: Vec<f32>,
    /// Distances of hits along their rays to those without loss, in voxels.
    mean: f64,
    percentile_99: f64,
    max: f64,
    /// Hits that should not be there and those that should, in % of those without loss.
    false_hits: f64,
    missed: f64,
}

/// # Errors
/// A loss that does not keep what it has to, and `docs` without a volume of the chart's.
pub(crate) fn run(quick: bool, docs: bool, data: &Path, only: Option<&str>) -> Result<Vec<LossyRow>> {
    let entries = if quick { vec![Entry::fixture()] } else { Entry::all(&[], data) };
    if docs && !quick {
        let is_there = |name: &str| entries.iter().any(|entry| entry.name == name);
        let lacking: Vec<_> = VOLUMES.into_iter().filter(|name| !is_there(name)).collect();
        let is_whole = lacking.is_empty();
        ensure!(is_whole, "--docs: expected {VOLUMES:?} for the chart of losses, found no {lacking:?}");
    }
    println!(
        "\nLoss: depth of hits in a {SIZE}² view from outside against those without loss, in voxels\n{:<10} {:<34} {:>6} {:>7} {:>9} {:>6} | {:>8} {:>8} {:>8} {:>7} {:>7}  isovalues",
        "volume",
        "bound",
        "amount",
        "size %",
        "changed %",
        "build",
        "mean",
        "99 %",
        "max",
        "false %",
        "missed%"
    );
    let mut rows = Vec::new();
    for entry in Entry::chosen(entries, only, &VOLUMES) {
        rows.extend(entry.visit(Measure(&entry))??);
    }
    if docs && !quick {
        draw(&rows, &root().join("docs/pictures/lossy.svg"))?;
    }
    Ok(rows)
}

struct Measure<'a>(&'a Entry);

impl DenseVisitor for Measure<'_> {
    type Output = Result<Vec<LossyRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let Self(entry) = self;
        let view = View::far(volume.dims, SIZE, SIZE);
        let begin = Instant::now();
        let octree = volume.octree()?;
        let build_s = begin.elapsed().as_secs_f64();
        let exact: Vec<_> = entry.isovalues.iter().map(|&v| depths(&octree, &view, v)).collect();
        let range = octree.meta().range.map_or(0.0, |[min, max]| max - min);
        let row = LossyRow {
            volume: entry.name.clone(),
            bound: "(no loss)",
            amount: 0.0,
            percent: percent(&octree),
            changed: 0.0,
            build_s,
            isovalues: entry.isovalues.clone(),
            mean: 0.0,
            percentile_99: 0.0,
            max: 0.0,
            false_hits: 0.0,
            missed: 0.0,
        };
        print(&row);
        for (depths, isovalue) in exact.iter().zip(&entry.isovalues) {
            let is_hit = depths.iter().any(|t| t.is_finite());
            ensure!(is_hit, "{}: isovalue {isovalue}: expected hits without loss, found none", entry.name);
        }
        let nothing = Loss { tolerance: 0.0, ..Loss::default() };
        check::samples(&volume.samples, &check::decoded(&octree), &nothing, Changes::default())
            .with_context(|| format!("{}: without loss", entry.name))?;
        drop(octree);
        let lossless = Lossless { volume, view, exact, row };
        let mut rows = vec![lossless.row.clone()];
        for case in cases(&entry.isovalues, range) {
            rows.push(lossless.row(&case)?);
        }
        Ok(rows)
    }
}

/// A volume as it is, and what is seen of it.
struct Lossless<'a, T> {
    volume: &'a Dense<T>,
    view: View,
    /// Depths of each of its isovalues.
    exact: Vec<Vec<f64>>,
    row: LossyRow,
}

impl<T: Scalar + Into<f64>> Lossless<'_, T> {
    fn row(&self, case: &Case) -> Result<LossyRow> {
        let (volume, isovalues) = (self.volume, &self.row.isovalues[..case.isovalues]);
        let mut source = Lossy::new(DenseVolume::new(volume.dims, &volume.samples)?, &case.loss)?;
        let begin = Instant::now();
        let lossy = build(&mut source, volume.index_to_world, |_| {}).context("cannot build")?;
        let build_s = begin.elapsed().as_secs_f64();
        let changes = source.changes();
        let found: Vec<_> = isovalues.iter().map(|&v| depths(&lossy, &self.view, v)).collect();
        let pairs = self.exact.iter().flatten().copied().zip(found.iter().flatten().copied());
        let row = LossyRow {
            bound: case.bound,
            amount: case.amount,
            percent: percent(&lossy),
            changed: 100.0 * changes.samples as f64 / volume.dims.samples() as f64,
            build_s,
            isovalues: isovalues.to_vec(),
            ..errors(pairs, &self.row)
        };
        print(&row);
        self.check(&row, &case.loss, (&check::decoded(&lossy), changes), &found)
            .with_context(|| format!("{}: {} {}", row.volume, row.bound, row.amount))?;
        Ok(row)
    }

    /// Whether samples, and surfaces at these depths, are where the loss guarantees that they are. A tolerance of samples alone says nothing about surfaces.
    fn check(
        &self,
        row: &LossyRow,
        loss: &Loss,
        (decoded, changes): (&[T], Changes),
        found: &[Vec<f64>],
    ) -> Result<()> {
        check::samples(&self.volume.samples, decoded, loss, changes)?;
        let displacement = loss.surface.as_ref().map(|surface| surface.displacement);
        if displacement == Some(0.0) || loss.range.is_some() {
            // The cells with a surface are those that were, to the bit, and what is found in a cell depends on nothing else.
            ensure!(
                found.iter().zip(&self.exact).all(|(found, exact)| found == exact),
                "expected the hits without loss, found some {} voxels off, {} % false and {} % missed",
                row.max,
                row.false_hits,
                row.missed
            );
        } else if let Some(displacement) = displacement {
            for ((found, exact), &isovalue) in found.iter().zip(&self.exact).zip(&row.isovalues) {
                let surfaces = check::Surfaces {
                    dims: self.volume.dims,
                    view: &self.view,
                    isovalue,
                    samples: [&self.volume.samples, decoded],
                    depths: [exact, found],
                };
                surfaces.check(displacement)?;
            }
        }
        Ok(())
    }
}

/// A loss, and for how many of the volume's isovalues it is meant.
struct Case {
    bound: &'static str,
    amount: f64,
    loss: Loss,
    isovalues: usize,
}

fn cases(isovalues: &[f32], range: f64) -> Vec<Case> {
    let Some(&first) = isovalues.first() else { return Vec::new() };
    let around = [first - RANGE * first.abs(), first + RANGE * first.abs()];
    let surface = |displacement, isovalues| Loss {
        surface: Some(SurfaceTolerance { displacement, isovalues }),
        ..Loss::default()
    };
    let mut cases = Vec::new();
    for n in TOLERANCES {
        let loss = Loss { tolerance: f64::from(n) / 255.0 * range, ..Loss::default() };
        let bound = "samples, 255ths of the range";
        cases.push(Case { bound, amount: n.into(), loss, isovalues: isovalues.len() });
    }
    for amount in DISPLACEMENTS {
        let loss = surface(amount, Isovalues::List(isovalues.to_vec()));
        let bound = "surfaces of the isovalues, voxels";
        cases.push(Case { bound, amount, loss, isovalues: isovalues.len() });
    }
    for amount in DISPLACEMENTS {
        let loss = surface(amount, Isovalues::Range(around));
        cases.push(Case { bound: "surfaces of ±20 %, voxels", amount, loss, isovalues: 1 });
    }
    let loss = Loss { range: Some(around.map(f64::from)), ..Loss::default() };
    cases.push(Case { bound: "range of ±20 %, lossless", amount: 0.0, loss, isovalues: 1 });
    cases
}

fn percent<T: Scalar>(volume: &OctreeVolume<T>) -> f64 {
    100.0 * volume.file_bytes() as f64 / volume.raw_bytes() as f64
}

/// Depths of the view's rays, in voxels; infinite where nothing is hit.
fn depths<T: Scalar>(volume: &OctreeVolume<T>, view: &View, isovalue: f32) -> Vec<f64> {
    let structure = volume.view();
    let depth = |tracer: &mut Tracer<'_, T>, &direction: &[f32; 3]| {
        let ray = Ray { origin: view.origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        tracer.first_hit(&ray, isovalue).map_or(f64::INFINITY, |hit| hit.t.into())
    };
    view.directions.par_iter().map_init(|| Tracer::new(&structure), depth).collect()
}

/// The errors of a loss, in a copy of the row without it.
fn errors(pairs: impl Iterator<Item = (f64, f64)>, lossless: &LossyRow) -> LossyRow {
    let (mut hits, mut false_hits, mut missed) = (0u64, 0u64, 0u64);
    let mut distances = Vec::new();
    for (exact, lossy) in pairs {
        hits += u64::from(exact.is_finite());
        match (exact.is_finite(), lossy.is_finite()) {
            (true, true) => distances.push((exact - lossy).abs()),
            (true, false) => missed += 1,
            (false, true) => false_hits += 1,
            (false, false) => {}
        }
    }
    distances.sort_by(f64::total_cmp);
    let share = |n: u64| 100.0 * n as f64 / hits.max(1) as f64;
    LossyRow {
        mean: distances.iter().sum::<f64>() / distances.len().max(1) as f64,
        percentile_99: distances.get(distances.len() * 99 / 100).copied().unwrap_or(0.0),
        max: distances.last().copied().unwrap_or(0.0),
        false_hits: share(false_hits),
        missed: share(missed),
        ..lossless.clone()
    }
}

fn print(row: &LossyRow) {
    println!(
        "{:<10} {:<34} {:>6} {:>7.2} {:>9.1} {:>5.2}s | {:>8.4} {:>8.3} {:>8.2} {:>7.3} {:>7.3}  {:?}",
        row.volume,
        row.bound,
        row.amount,
        row.percent,
        row.changed,
        row.build_s,
        row.mean,
        row.percentile_99,
        row.max,
        row.false_hits,
        row.missed,
        row.isovalues
    );
}

/// Size against the mean distance, a line each volume and bound.
fn draw(rows: &[LossyRow], file: &Path) -> Result<()> {
    /// Smaller ones, and none, are drawn here: on logarithmic axes they have no place of their own.
    const LEAST: f64 = 1e-5;
    let mut lines: Vec<(&str, &str)> = Vec::new();
    for row in rows {
        if !lines.contains(&(&row.volume, row.bound)) {
            lines.push((&row.volume, row.bound));
        }
    }
    chart::save(file, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Size against the mean distance of hits from those without loss", ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(70)
            // Room for the legend above.
            .build_cartesian_2d((0.5..200.0).log_scale(), (0.5 * LEAST..1e7).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("size, % of the raw samples")
            .y_desc("mean distance in voxels; none at the bottom")
            .draw()?;
        for (n, (volume, bound)) in lines.iter().enumerate() {
            let colour = Palette99::pick(n).to_rgba();
            let points: Vec<(f64, f64)> = rows
                .iter()
                .filter(|r| r.volume == *volume && r.bound == *bound)
                .map(|r| (r.percent, r.mean.max(LEAST)))
                .collect();
            chart
                .draw_series(LineSeries::new(points.clone(), colour))?
                .label(format!("{volume}: {bound}"))
                .legend(move |(x, y)| Circle::new((x + 6, y), 4, colour.filled()));
            chart.draw_series(points.into_iter().map(|p| Circle::new(p, 4, colour.filled())))?;
        }
        chart::legend(&mut chart)
    })
}
