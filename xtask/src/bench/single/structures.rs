//! Grid or octree, over array or octree data, and the recursion of 2006.

use std::hint::black_box;

use anyhow::{Context, Result, ensure};
use isoray_benches::knoll2006::{PaperHit, PaperOctree};
use isoray_benches::views::View;
use isoray_grid::{Branching, DenseVolume, GridVolume, Scalar};
use isoray_trace::{GridTracer, Tracer, Work};
use serde::Serialize;

use super::{count, frame, views};
use crate::bench::overview::compare_recursion;
use crate::bench::recorded::Found;
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry};

/// One traversal of one kind of data, on one thread.
#[derive(Debug, Serialize)]
pub(crate) struct StructureRow {
    volume: String,
    pub(in crate::bench) view: &'static str,
    pub(in crate::bench) structure: &'static str,
    pub(in crate::bench) ns_per_ray: f64,
    nodes_per_ray: f64,
    lookups_per_ray: f64,
    /// Samples alone, in an array.
    raw: usize,
    /// Samples with all that goes with them.
    bytes: usize,
}

impl StructureRow {
    pub(super) fn print(&self) {
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

/// How many of the structures are ours; behind them are those of 2006.
const OURS: usize = 4;

/// Grid or octree, over array or octree data.
pub(in crate::bench) struct Structures<'a> {
    pub(in crate::bench) entry: &'a Entry,
    /// Pixels along each side.
    pub(in crate::bench) size: u32,
    pub(in crate::bench) repeat: usize,
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
        let kinds = [
            ("octree, octree data", octree.structure_bytes()),
            ("grid 4,4,4, array", raw + of_array.macrocells().bytes()),
            ("grid of five levels, array", raw + ranges),
            ("grid of five levels, octree data", octree.structure_bytes() + ranges),
            ("2006 octree, its own data", paper.bytes()),
            ("2006 octree, array", raw + paper.bytes()),
        ];
        let isovalue = self.entry.isovalues[0];
        let mut rows = Vec::new();
        for (name, view) in &views(volume.dims, self.size) {
            let mut tracer = Tracer::new(&octree_view);
            let mut grid = GridTracer::new(&of_array);
            let mut grid_five = GridTracer::new(&five_levels);
            let mut over_octree = GridTracer::new(&of_octree);
            let (times, found) = interleave_kept(
                self.repeat,
                &mut [
                    &mut || frame(&mut tracer, view, isovalue),
                    &mut || frame(&mut grid, view, isovalue),
                    &mut || frame(&mut grid_five, view, isovalue),
                    &mut || frame(&mut over_octree, view, isovalue),
                    &mut || paper_frame(view, |d| paper.first_hit(view.origin, d, isovalue)),
                    &mut || {
                        let array = &volume.samples;
                        paper_frame(view, |d| paper.first_hit_in_array(array, view.origin, d, isovalue))
                    },
                ],
            );
            compare(&kinds.map(|(structure, _)| structure), &found)
                .with_context(|| format!("{}, {name}", self.entry.name))?;
            let works = [
                count(&mut tracer, view, isovalue),
                count(&mut grid, view, isovalue),
                count(&mut grid_five, view, isovalue),
                count(&mut over_octree, view, isovalue),
                Work::default(),
                Work::default(),
            ];
            let rays = view.directions.len() as f64;
            let measured = kinds.into_iter().zip(times).zip(works);
            rows.extend(measured.map(|(((structure, bytes), seconds), work)| StructureRow {
                volume: self.entry.name.clone(),
                view: name,
                structure,
                ns_per_ray: seconds / rays * 1e9,
                nodes_per_ray: work.nodes as f64 / rays,
                lookups_per_ray: work.lookups as f64 / rays,
                raw,
                bytes,
            }));
        }
        Ok(rows)
    }
}

/// Makes sure that what is ours found the same, and the recursion of 2006 about as much.
fn compare(structures: &[&str], found: &[Found]) -> Result<()> {
    let octree = found[0];
    ensure!(octree.hits > 0, "no ray hits");
    for (n, (structure, &found)) in structures.iter().zip(found).enumerate() {
        if n < OURS {
            ensure!(found == octree, "{structure}: {found:?}, in the octree {octree:?}");
        } else {
            compare_recursion(octree, found).with_context(|| (*structure).to_owned())?;
        }
    }
    Ok(())
}

#[inline(never)]
fn paper_frame(view: &View, first_hit: impl Fn([f32; 3]) -> Option<PaperHit>) -> Found {
    let mut found = Found::default();
    for &direction in &view.directions {
        if let Some(hit) = black_box(first_hit(direction)) {
            found.add(hit.t);
        }
    }
    found
}
