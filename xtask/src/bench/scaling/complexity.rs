//! Surfaces of more and more cells, in volumes of one size.

use anyhow::{Result, ensure};
use glam::DAffine3;
use isoray_benches::views::View;
use isoray_grid::{DenseVolume, Dims, GridVolume, Scalar};
use isoray_octree::{OctreeView, OctreeVolume};
use isoray_trace::{GridTracer, Tracer};
use rayon::prelude::*;
use serde::Serialize;

use super::fit::Fit;
use super::{ScalingSuite, Sums, frame, groups};
use crate::bench::single::count;
use crate::bench::timer::{interleave_kept, quantile};
use crate::catalog::{Dense, DenseVisitor, Entry};

/// One surface, on one thread.
#[derive(Debug, Serialize)]
pub(crate) struct ComplexityRow {
    volume: String,
    /// Periods along an edge of the volume; zero of one that was not made for this.
    waves: u32,
    isovalue: f32,
    view: &'static str,
    /// Cells with corners on both sides, in the whole volume.
    mixed_cells: u64,
    ns_per_ray: f64,
    nodes_per_ray: f64,
    cells_per_ray: f64,
    hits: u64,
}

/// What a volume made for this is called.
pub(super) const GYROID: &str = "gyroid";
/// Gyroids with this many periods along an edge, and in a short run.
const WAVES: [&[u32]; 2] = [&[1, 2, 4, 8, 16, 32], &[1, 2, 4, 8]];
const EDGES: [u32; 2] = [256, 64];
const ISOVALUE: f32 = 127.5;
/// Shares of the samples that lie below the isovalues of a volume: of those above its least value.
const SHARES: [f64; 8] = [0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95, 0.99];
/// Samples by which the isovalues are found.
const LOOKED_AT: usize = 1 << 16;
/// Pixels along the side of a picture, and in a short run.
const SIZE: [u32; 2] = [512, 96];

/// Gyroids of growing frequency.
pub(super) fn waves(quick: bool, repeat: usize) -> Result<Vec<ComplexityRow>> {
    let edge = EDGES[usize::from(quick)];
    let waves = WAVES[usize::from(quick)];
    let volumes: Vec<Dense<u8>> = waves.iter().map(|&waves| gyroid(edge, waves)).collect::<Result<_>>()?;
    let octrees: Vec<_> = volumes.iter().map(Dense::octree).collect::<Result<_>>()?;
    let views: Vec<_> = octrees.iter().map(OctreeVolume::view).collect();
    let grids: Vec<_> = volumes.iter().map(grid).collect::<Result<_>>()?;
    let surfaces = (0..waves.len()).map(|n| {
        let mixed_cells = mixed_cells(&volumes[n], ISOVALUE);
        Surface { octree: &views[n], grid: &grids[n], waves: waves[n], isovalue: ISOVALUE, mixed_cells }
    });
    let surfaces: Vec<_> = surfaces.collect();
    let rows = measure(&format!("{GYROID} {edge}"), &surfaces, SIZE[usize::from(quick)], repeat)?;
    // Others may have isovalues of which nothing is seen.
    ensure!(rows.iter().all(|row| row.hits > 0), "a gyroid that no ray hits");
    Ok(rows)
}

/// `sin x cos y + sin y cos z + sin z cos x`, which is at most 1.5, with so many periods along an edge of `n` samples.
fn gyroid(n: u32, waves: u32) -> Result<Dense<u8>> {
    let turn = std::f64::consts::TAU * f64::from(waves) / f64::from(n - 1);
    let along: Vec<[f64; 2]> = (0..n).map(|i| (turn * f64::from(i)).sin_cos().into()).collect();
    let dims = Dims::new([n; 3])?;
    let mut samples = vec![0; dims.samples()];
    samples.par_chunks_mut(dims.layer()).zip(&along).for_each(|(layer, [sz, cz])| {
        for (row, [sy, cy]) in layer.chunks_mut(n as usize).zip(&along) {
            for (sample, [sx, cx]) in row.iter_mut().zip(&along) {
                *sample = (f64::from(ISOVALUE) + 80.0 * (sx * cy + sy * cz + sz * cx)).round() as u8;
            }
        }
    });
    Ok(Dense { dims, samples, index_to_world: DAffine3::IDENTITY })
}

/// One volume at several isovalues.
pub(super) struct Isovalues<'a> {
    pub(super) entry: &'a Entry,
    pub(super) quick: bool,
    pub(super) repeat: usize,
}

impl DenseVisitor for Isovalues<'_> {
    type Output = Result<Vec<ComplexityRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let stride = volume.samples.len().div_ceil(LOOKED_AT);
        let looked_at = volume.samples.iter().step_by(stride).map(|&s| s.into());
        let values: Vec<f64> = looked_at.filter(|s: &f64| s.is_finite()).collect();
        let least = quantile(values.clone(), 0.0);
        let above: Vec<f64> = values.into_iter().filter(|&s| s > least).collect();
        let step = if self.quick { 3 } else { 1 };
        let mut isovalues: Vec<f32> =
            SHARES.iter().step_by(step).map(|&share| quantile(above.clone(), share) as f32).collect();
        isovalues.dedup();
        let octree = volume.octree()?;
        let octree = &octree.view();
        let grid = &grid(volume)?;
        let surface = |isovalue| {
            let mixed_cells = mixed_cells(volume, isovalue);
            Surface { octree, grid, waves: 0, isovalue, mixed_cells }
        };
        let surfaces: Vec<_> = isovalues.into_iter().map(surface).collect();
        measure(&self.entry.name, &surfaces, SIZE[usize::from(self.quick)], self.repeat)
    }
}

/// One of the surfaces that are compared.
struct Surface<'a, T: Scalar> {
    octree: &'a OctreeView<'a, T>,
    /// Of the same samples, in an array.
    grid: &'a Grid<'a, T>,
    waves: u32,
    isovalue: f32,
    mixed_cells: u64,
}

type Grid<'a, T> = GridVolume<DenseVolume<'a, T>>;

fn grid<T: Scalar>(volume: &Dense<T>) -> Result<Grid<'_, T>> {
    Ok(GridVolume::new(DenseVolume::new(volume.dims, &volume.samples)?))
}

fn measure<T: Scalar>(
    name: &str,
    surfaces: &[Surface<'_, T>],
    size: u32,
    repeat: usize,
) -> Result<Vec<ComplexityRow>> {
    // The volumes are of one size, and so their views are the same.
    let Some(dims) = surfaces.first().map(|surface| surface.octree.dims()) else { return Ok(Vec::new()) };
    let mut rows = Vec::new();
    for (place, view) in [("far", View::far(dims, size, size)), ("close", View::close(dims, size, size))] {
        rows.extend(in_view(name, surfaces, (place, &view), repeat)?);
    }
    Ok(rows)
}

/// All surfaces in turn: time by surface then tells of surfaces alone, if the machine's speed drifts.
fn in_view<T: Scalar>(
    name: &str,
    surfaces: &[Surface<'_, T>],
    (place, view): (&'static str, &View),
    repeat: usize,
) -> Result<Vec<ComplexityRow>> {
    let frames = surfaces.iter().map(|&Surface { octree, isovalue, .. }| {
        let mut tracer = Tracer::new(octree);
        move || frame(&mut tracer, view, isovalue)
    });
    let mut frames: Vec<_> = frames.collect();
    let mut variants: Vec<&mut dyn FnMut() -> Sums> = frames.iter_mut().map(|frame| frame as _).collect();
    let (times, timed) = interleave_kept(repeat, &mut variants);
    let rays = view.directions.len() as f64;
    let mut rows = Vec::new();
    for ((surface, seconds), found) in surfaces.iter().zip(times).zip(timed) {
        let &Surface { octree, grid, waves, isovalue, mixed_cells } = surface;
        let expected = frame(&mut GridTracer::new(grid), view, isovalue);
        ensure!(found == expected, "{name} at {isovalue}, {place}: {found:?}, in the grid {expected:?}");
        let work = count(&mut Tracer::new(octree), view, isovalue);
        let row = ComplexityRow {
            volume: name.to_owned(),
            waves,
            isovalue,
            view: place,
            mixed_cells,
            ns_per_ray: seconds / rays * 1e9,
            nodes_per_ray: work.nodes as f64 / rays,
            cells_per_ray: work.cells as f64 / rays,
            hits: found.hits,
        };
        println!(
            "{name:<20} {waves:>6} {isovalue:>9} {place:>6} {mixed_cells:>12} {:>8.0} {:>10.2} {:>10.2} {:>8.2}",
            row.ns_per_ray,
            row.nodes_per_ray,
            row.cells_per_ray,
            100.0 * row.hits as f64 / rays
        );
        rows.push(row);
    }
    Ok(rows)
}

/// Cells with finite corners on both sides.
fn mixed_cells<T: Scalar>(volume: &Dense<T>, isovalue: f32) -> u64 {
    let [nx, ny, nz] = volume.dims.axes().map(|n| n as usize);
    let row = |y: usize, z: usize| &volume.samples[(z * ny + y) * nx..][..nx];
    let in_row = |y: usize, z: usize| {
        let rows = [row(y, z), row(y + 1, z), row(y, z + 1), row(y + 1, z + 1)];
        let is_mixed = |x: usize| {
            let corners = rows.iter().flat_map(|row| [row[x].to_f32(), row[x + 1].to_f32()]);
            let (inside, finite) = corners.fold((0, 0), |(inside, finite), s| {
                (inside + u32::from(s >= isovalue), finite + u32::from(s.is_finite()))
            });
            finite == 8 && !matches!(inside, 0 | 8)
        };
        (0..nx - 1).filter(|&x| is_mixed(x)).count() as u64
    };
    (0..nz - 1).into_par_iter().map(|z| (0..ny - 1).map(|y| in_row(y, z)).sum::<u64>()).sum()
}

/// Surfaces whose cells differ by less than this tell nothing of how anything grows with them.
const APART: f64 = 4.0;

/// Time, and cells that are intersected, by cells with surface.
pub(super) fn fits(suite: &ScalingSuite) -> Vec<Fit> {
    let of = |rows: &[ComplexityRow], view: &'static str| {
        let is_met = |row: &&ComplexityRow| row.view == view && row.cells_per_ray > 0.0;
        let met: Vec<&ComplexityRow> = rows.iter().filter(is_met).collect();
        let cells = met.iter().map(|row| row.mixed_cells as f64);
        let [least, most] = [cells.clone().fold(f64::INFINITY, f64::min), cells.fold(0.0, f64::max)];
        let fit = |what, y: fn(&ComplexityRow) -> f64| {
            let points = met.iter().map(|row| [row.mixed_cells as f64, y(row)]);
            Fit::new([what, view], &rows[0].volume, points)
        };
        let fits = [
            fit("time of a ray by mixed cells", |row| row.ns_per_ray),
            fit("cells of a ray by mixed cells", |row| row.cells_per_ray),
        ];
        fits.into_iter().flatten().filter(|_| most >= APART * least).collect::<Vec<_>>()
    };
    let groups = groups(&suite.complexity, |row| row.volume.clone());
    groups.flat_map(|rows| ["far", "close"].into_iter().flat_map(move |view| of(rows, view))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_on_both_sides_are_counted() {
        let dims = Dims::new([3, 3, 2]).unwrap();
        let mut samples = vec![0u8; dims.samples()];
        samples[dims.linear([0, 0, 0])] = 9;
        let volume = |samples| Dense { dims, samples, index_to_world: DAffine3::IDENTITY };
        assert_eq!(mixed_cells(&volume(samples.clone()), 5.0), 1);
        samples[dims.linear([1, 1, 1])] = 9;
        assert_eq!(mixed_cells(&volume(samples), 5.0), 4);
    }

    #[test]
    fn waves_make_cells() {
        let [few, many] = [1, 4].map(|waves| mixed_cells(&gyroid(48, waves).unwrap(), ISOVALUE));
        assert!(many > 3 * few && many < 5 * few, "{few} and {many}");
    }
}
