//! Single rays: octree against grid, as their authors compared them. How time grows with size and threads is what [`scaling`](super::scaling) measures.

use std::hint::black_box;

use anyhow::Result;
use isoray_benches::knoll2006::PaperOctree;
use isoray_benches::views::View;
use isoray_grid::{Branching, BrickSizes, BrickedVolume, DenseVolume, Dims, GridVolume, Scalar};
use isoray_trace::{FirstHit, GridTracer, Hit, Trace, Tracer, Work};
use serde::Serialize;

use super::recorded::{Recorded, lambert};
use super::timer::interleave;
use crate::catalog::{Dense, DenseVisitor, Entry};

/// What the suite measured.
#[derive(Debug, Default, Serialize)]
pub(crate) struct SingleSuite {
    pub(crate) structures: Vec<StructureRow>,
    pub(crate) phases: Vec<PhaseRow>,
    pub(crate) sweeps: Vec<SweepRow>,
}

/// One traversal of one kind of data, on one thread.
#[derive(Debug, Serialize)]
pub(crate) struct StructureRow {
    volume: String,
    pub(super) view: &'static str,
    pub(super) structure: &'static str,
    pub(super) ns_per_ray: f64,
    nodes_per_ray: f64,
    lookups_per_ray: f64,
    /// Samples alone, in an array.
    raw: usize,
    /// Samples with all that goes with them.
    bytes: usize,
}

impl StructureRow {
    fn print(&self) {
        println!(
            "{:<20} {:>6} {:<34} {:>8.0} {:>10.2} {:>12.2} {:>14.1}",
            self.volume,
            self.view,
            self.structure,
            self.ns_per_ray,
            self.nodes_per_ray,
            self.lookups_per_ray,
            100.0 * self.bytes as f64 / self.raw as f64
        );
    }
}

/// How the time of a frame is shared out, as the columns of 1998 Table 1.
#[derive(Debug, Serialize)]
pub(crate) struct PhaseRow {
    volume: String,
    view: &'static str,
    structure: &'static str,
    /// Shares of the whole.
    traversal: f64,
    intersection: f64,
    shading: f64,
}

/// A choice of bricks or of macrocells.
#[derive(Debug, Serialize)]
pub(crate) struct SweepRow {
    volume: String,
    choice: String,
    far_ns_per_ray: f64,
    close_ns_per_ray: f64,
    bytes: usize,
}

/// Pixels along the side of a picture.
const SIZE: u32 = 512;

pub(crate) fn run(quick: bool, entries: &[Entry], repeat: usize) -> Result<SingleSuite> {
    let mut suite = SingleSuite::default();
    println!(
        "\n{:<20} {:>6} {:<34} {:>8} {:>10} {:>12} {:>14}",
        "volume", "view", "traversal, data", "ns/ray", "nodes/ray", "lookups/ray", "bytes, % of raw"
    );
    for entry in entries {
        let rows = entry.visit(Structures { entry, size: SIZE, repeat })??;
        rows.iter().for_each(StructureRow::print);
        suite.structures.extend(rows);
    }
    println!(
        "\n{:<20} {:>6} {:<22} {:>10} {:>13} {:>8}",
        "volume", "view", "traversal, data", "traversal", "intersection", "shading"
    );
    for entry in entries {
        suite.phases.extend(entry.visit(Phases { entry, repeat })??);
    }
    println!("\n{:<20} {:<28} {:>9} {:>9} {:>15}", "volume", "grid", "far ns", "close ns", "bytes, % of raw");
    for entry in entries.iter().filter(|entry| quick || SWEPT.contains(&entry.name.as_str())) {
        suite.sweeps.extend(entry.visit(Sweeps { entry, repeat: repeat.min(3), quick })??);
    }
    Ok(suite)
}

/// Volumes whose bricks and macrocells are swept.
const SWEPT: [&str; 3] = ["turbulence 512", "heptane", "chest CT"];

pub(super) fn frame(tracer: &mut impl Trace, view: &View, isovalue: f32) {
    shaded_frame(tracer, view, isovalue, |hit, direction| lambert(hit.gradient(), direction));
}

// See the overview's loops.
#[inline(never)]
fn shaded_frame(tracer: &mut impl Trace, view: &View, isovalue: f32, shade: impl Fn(&Hit, [f32; 3]) -> f32) {
    for &direction in &view.directions {
        if let Some(hit) = tracer.first_hit(&view.ray(direction), isovalue) {
            black_box(shade(&hit, direction));
        }
    }
}

/// The work of all rays of a view.
pub(super) fn count(tracer: &mut impl Trace, view: &View, isovalue: f32) -> Work {
    let mut work = Work::default();
    for &direction in &view.directions {
        tracer.trace(&view.ray(direction), isovalue, &mut FirstHit::default(), &mut work);
    }
    work
}

fn views(dims: Dims, size: u32) -> [(&'static str, View); 2] {
    [("far", View::far(dims, size, size)), ("close", View::close(dims, size, size))]
}

/// Grid or octree, over array or octree data.
pub(super) struct Structures<'a> {
    pub(super) entry: &'a Entry,
    /// Pixels along each side.
    pub(super) size: u32,
    pub(super) repeat: usize,
}

impl DenseVisitor for Structures<'_> {
    type Output = Result<Vec<StructureRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let dense = DenseVolume::new(volume.dims, &volume.samples)?;
        let octree = volume.octree()?;
        let octree_view = octree.view();
        let five = Branching::new(&[4, 2, 2, 2, 2])?;
        let of_array = GridVolume::new(dense);
        let five_levels = GridVolume::with_branching(dense, &five);
        let of_octree = GridVolume::with_branching(&octree_view, &five);
        let paper = PaperOctree::build(volume.dims, &volume.samples);
        let raw = size_of_val(&volume.samples[..]);
        let ranges = five_levels.macrocells().bytes();
        let isovalue = self.entry.isovalues[0];
        let mut rows = Vec::new();
        for (name, view) in &views(volume.dims, self.size) {
            let mut tracer = Tracer::new(&octree_view);
            let mut grid = GridTracer::new(&of_array);
            let mut grid_five = GridTracer::new(&five_levels);
            let mut over_octree = GridTracer::new(&of_octree);
            let times = interleave(
                self.repeat,
                &mut [
                    &mut || frame(&mut tracer, view, isovalue),
                    &mut || frame(&mut grid, view, isovalue),
                    &mut || frame(&mut grid_five, view, isovalue),
                    &mut || frame(&mut over_octree, view, isovalue),
                    &mut || paper_frame(view, |d| paper.first_hit(view.origin, d, isovalue)),
                    &mut || {
                        let array = &volume.samples;
                        paper_frame(view, |d| paper.first_hit_in_array(array, view.origin, d, isovalue));
                    },
                ],
            );
            let works = [
                count(&mut tracer, view, isovalue),
                count(&mut grid, view, isovalue),
                count(&mut grid_five, view, isovalue),
                count(&mut over_octree, view, isovalue),
                Work::default(),
                Work::default(),
            ];
            let kinds = [
                ("octree, octree data", octree.structure_bytes()),
                ("grid 4,4,4, array", raw + of_array.macrocells().bytes()),
                ("grid of five levels, array", raw + ranges),
                ("grid of five levels, octree data", octree.structure_bytes() + ranges),
                ("2006 octree, its own data", paper.bytes()),
                ("2006 octree, array", raw + paper.bytes()),
            ];
            let rays = view.directions.len() as f64;
            for (((structure, bytes), seconds), work) in kinds.into_iter().zip(times).zip(works) {
                let row = StructureRow {
                    volume: self.entry.name.clone(),
                    view: name,
                    structure,
                    ns_per_ray: seconds / rays * 1e9,
                    nodes_per_ray: work.nodes as f64 / rays,
                    lookups_per_ray: work.lookups as f64 / rays,
                    raw,
                    bytes,
                };
                rows.push(row);
            }
        }
        Ok(rows)
    }
}

#[inline(never)]
fn paper_frame<H>(view: &View, first_hit: impl Fn([f32; 3]) -> Option<H>) {
    for &direction in &view.directions {
        black_box(first_hit(direction));
    }
}

/// Traversal, intersection and shading of a frame.
struct Phases<'a> {
    entry: &'a Entry,
    repeat: usize,
}

impl DenseVisitor for Phases<'_> {
    type Output = Result<Vec<PhaseRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let octree = octree.view();
        let grid = GridVolume::new(DenseVolume::new(volume.dims, &volume.samples)?);
        let mut rows = Vec::new();
        for (name, view) in &views(volume.dims, SIZE) {
            rows.push(self.row(&mut Tracer::new(&octree), view, ["octree, octree data", name]));
            rows.push(self.row(&mut GridTracer::new(&grid), view, ["grid 4,4,4, array", name]));
        }
        Ok(rows)
    }
}

impl Phases<'_> {
    fn row(&self, tracer: &mut impl Trace, view: &View, [structure, name]: [&'static str; 2]) -> PhaseRow {
        let [traversal, intersection, shading, _] =
            phases(tracer, view, self.entry.isovalues[0], self.repeat);
        let row = PhaseRow {
            volume: self.entry.name.clone(),
            view: name,
            structure,
            traversal,
            intersection,
            shading,
        };
        let percent = |share: f64| 100.0 * share;
        println!(
            "{:<20} {name:>6} {structure:<22} {:>9.0}% {:>12.0}% {:>7.0}%",
            row.volume,
            percent(row.traversal),
            percent(row.intersection),
            percent(row.shading)
        );
        row
    }
}

/// Shares of traversal, intersection and shading in the time of a frame, and this itself, in seconds.
pub(super) fn phases(tracer: &mut impl Trace, view: &View, isovalue: f32, repeat: usize) -> [f64; 4] {
    let recorded = Recorded::new(tracer, view, isovalue);
    let hits: Vec<Option<Hit>> =
        view.directions.iter().map(|&d| tracer.first_hit(&view.ray(d), isovalue)).collect();
    let tracer = std::cell::RefCell::new(tracer);
    let times = interleave(
        repeat,
        &mut [
            &mut || recorded.traverse(*tracer.borrow_mut(), view, isovalue, &hits),
            &mut || shaded_frame(*tracer.borrow_mut(), view, isovalue, |hit, _| hit.t),
            &mut || frame(*tracer.borrow_mut(), view, isovalue),
        ],
    );
    let [traversal, up_to_hits, all] = [times[0], times[1], times[2]];
    [traversal / all, (up_to_hits - traversal) / all, (all - up_to_hits) / all, all]
}

/// Sizes of bricks, and branchings of macrocells.
struct Sweeps<'a> {
    entry: &'a Entry,
    repeat: usize,
    quick: bool,
}

impl DenseVisitor for Sweeps<'_> {
    type Output = Result<Vec<SweepRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let mut dense = DenseVolume::new(volume.dims, &volume.samples)?;
        let raw = size_of_val(&volume.samples[..]);
        let views = views(volume.dims, SIZE);
        let isovalue = self.entry.isovalues[0];
        let mut rows = Vec::new();
        let mut add = |choice: String, bytes: usize, tracer: &mut dyn FnMut(&View)| {
            let [far, close] = [0, 1].map(|n| {
                let seconds = interleave(self.repeat, &mut [&mut || tracer(&views[n].1)]);
                seconds[0] / views[n].1.directions.len() as f64 * 1e9
            });
            println!(
                "{:<20} {choice:<28} {far:>9.0} {close:>9.0} {:>15.1}",
                self.entry.name,
                100.0 * bytes as f64 / raw as f64
            );
            rows.push(SweepRow {
                volume: self.entry.name.clone(),
                choice,
                far_ns_per_ray: far,
                close_ns_per_ray: close,
                bytes,
            });
        };
        let branchings: &[&[u32]] = &[
            &[4, 4, 4],
            &[4],
            &[8],
            &[4, 4],
            &[4, 8],
            &[8, 8],
            &[2, 2, 2],
            &[3, 3, 3],
            &[5, 5, 5],
            &[4, 4, 4, 4],
            &[4, 2, 2, 2, 2],
            &[2, 2, 2, 2, 2, 2],
        ];
        for parts in &branchings[..if self.quick { 2 } else { branchings.len() }] {
            let grid = GridVolume::with_branching(dense, &Branching::new(parts)?);
            let mut tracer = GridTracer::new(&grid);
            let bytes = raw + grid.macrocells().bytes();
            add(format!("macrocells of {parts:?}"), bytes, &mut |view| frame(&mut tracer, view, isovalue));
        }
        let bricks =
            [(1, 1), (2, 1), (3, 1), (4, 1), (5, 1), (8, 1), (2, 4), (4, 4), (4, 5), (3, 6), (5, 2), (8, 8)];
        for (brick, macrobrick) in &bricks[..if self.quick { 2 } else { bricks.len() }] {
            let sizes = BrickSizes { brick: *brick, macrobrick: *macrobrick };
            let bricked = BrickedVolume::new(&mut dense, sizes)?;
            let grid = GridVolume::new(&bricked);
            let mut tracer = GridTracer::new(&grid);
            let bytes = bricked.bytes() + grid.macrocells().bytes();
            let choice = format!("bricks of {brick}³ in {macrobrick}³");
            add(choice, bytes, &mut |view| frame(&mut tracer, view, isovalue));
        }
        Ok(rows)
    }
}
