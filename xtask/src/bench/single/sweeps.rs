//! Sizes of bricks, and branchings of macrocells.

use anyhow::{Result, ensure};
use isoray_benches::views::View;
use isoray_grid::{Branching, BrickSizes, BrickedVolume, DenseVolume, GridVolume, Samples, Scalar};
use isoray_trace::{GridTracer, Tracer};
use serde::Serialize;

use super::{frame, views};
use crate::bench::recorded::Found;
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry};

/// A choice of bricks or of macrocells.
#[derive(Debug, Serialize)]
pub(crate) struct SweepRow {
    volume: String,
    choice: String,
    far_ns_per_ray: f64,
    close_ns_per_ray: f64,
    bytes: usize,
}

/// Parts of macrocells by level, the lowest first; in a short run two of them.
const BRANCHINGS: [&[u32]; 12] = [
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
/// Samples along the edge of a brick, bricks along that of a macrobrick; in a short run two of them.
const BRICKS: [(u32, u32); 12] =
    [(1, 1), (2, 1), (3, 1), (4, 1), (5, 1), (8, 1), (2, 4), (4, 4), (4, 5), (3, 6), (5, 2), (8, 8)];
const QUICK: usize = 2;

pub(super) struct Sweeps<'a> {
    pub(super) entry: &'a Entry,
    /// Pixels along each side.
    pub(super) size: u32,
    pub(super) repeat: usize,
    pub(super) quick: bool,
}

/// Samples in an array or in bricks, and their macrocells.
struct Choice<S: Samples> {
    name: String,
    bytes: usize,
    grid: GridVolume<S>,
}

/// The views, and what is to be found in each.
type Expected = [(View, Found); 2];

impl DenseVisitor for Sweeps<'_> {
    type Output = Result<Vec<SweepRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let mut dense = DenseVolume::new(volume.dims, &volume.samples)?;
        let raw = size_of_val(&volume.samples[..]);
        let expected = self.expected(volume)?;
        let branchings = &BRANCHINGS[..if self.quick { QUICK } else { BRANCHINGS.len() }];
        let macrocells = branchings.iter().map(|parts| {
            let grid = GridVolume::with_branching(dense, &Branching::new(parts)?);
            let bytes = raw + grid.macrocells().bytes();
            Ok(Choice { name: format!("macrocells of {parts:?}"), bytes, grid })
        });
        let macrocells: Vec<_> = macrocells.collect::<Result<_>>()?;
        let mut rows = self.rows(&macrocells, &expected, raw)?;
        drop(macrocells);
        let sizes = &BRICKS[..if self.quick { QUICK } else { BRICKS.len() }];
        let mut bricks: Vec<BrickedVolume<T>> = Vec::new();
        for &(brick, macrobrick) in sizes {
            bricks.push(BrickedVolume::new(&mut dense, BrickSizes { brick, macrobrick })?);
        }
        let bricks = sizes.iter().zip(&bricks).map(|((brick, macrobrick), bricked)| {
            let grid = GridVolume::new(bricked);
            let bytes = bricked.bytes() + grid.macrocells().bytes();
            Choice { name: format!("bricks of {brick}³ in {macrobrick}³"), bytes, grid }
        });
        rows.extend(self.rows(&bricks.collect::<Vec<_>>(), &expected, raw)?);
        Ok(rows)
    }
}

impl Sweeps<'_> {
    /// By the octree.
    fn expected<T: Scalar>(&self, volume: &Dense<T>) -> Result<Expected> {
        let octree = volume.octree()?;
        let octree = octree.view();
        let mut tracer = Tracer::new(&octree);
        let expected = views(volume.dims, self.size).map(|(_, view)| {
            let found = frame(&mut tracer, &view, self.entry.isovalues[0]);
            (view, found)
        });
        ensure!(expected.iter().all(|(_, found)| found.hits > 0), "{}: no ray hits", self.entry.name);
        Ok(expected)
    }

    /// All choices in turn, which are in memory together: times by choice then tell of choices alone, if the machine's speed drifts.
    fn rows<S: Samples>(
        &self,
        choices: &[Choice<S>],
        expected: &Expected,
        raw: usize,
    ) -> Result<Vec<SweepRow>> {
        let isovalue = self.entry.isovalues[0];
        let mut times = Vec::new();
        for (view, expected) in expected {
            let frames = choices.iter().map(|choice| {
                let mut tracer = GridTracer::new(&choice.grid);
                move || frame(&mut tracer, view, isovalue)
            });
            let mut frames: Vec<_> = frames.collect();
            let mut variants: Vec<&mut dyn FnMut() -> Found> =
                frames.iter_mut().map(|frame| frame as _).collect();
            let (seconds, found) = interleave_kept(self.repeat, &mut variants);
            for (Choice { name, .. }, found) in choices.iter().zip(&found) {
                let volume = &self.entry.name;
                ensure!(found == expected, "{volume}, {name}: {found:?}, in the octree {expected:?}");
            }
            let rays = view.directions.len() as f64;
            times.push(seconds.into_iter().map(|seconds| seconds / rays * 1e9).collect::<Vec<_>>());
        }
        let rows = choices.iter().enumerate().map(|(n, Choice { name, bytes, .. })| {
            let [far, close] = [times[0][n], times[1][n]];
            println!(
                "{:<20} {name:<28} {far:>9.0} {close:>9.0} {:>15.1}",
                self.entry.name,
                100.0 * *bytes as f64 / raw as f64
            );
            SweepRow {
                volume: self.entry.name.clone(),
                choice: name.clone(),
                far_ns_per_ray: far,
                close_ns_per_ray: close,
                bytes: *bytes,
            }
        });
        Ok(rows.collect())
    }
}
