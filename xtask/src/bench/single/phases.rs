//! Where the time of a frame goes.

use std::cell::RefCell;

use anyhow::{Result, ensure};
use isoray_benches::views::View;
use isoray_grid::{DenseVolume, GridVolume, Scalar};
use isoray_trace::{GridTracer, Hit, Trace, Tracer};
use serde::Serialize;

use super::{frame, shaded_frame, views};
use crate::bench::recorded::{Found, Recorded};
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry};

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

/// Traversal, intersection and shading of a frame.
pub(super) struct Phases<'a> {
    pub(super) entry: &'a Entry,
    /// Pixels along each side.
    pub(super) size: u32,
    pub(super) repeat: usize,
}

impl DenseVisitor for Phases<'_> {
    type Output = Result<Vec<PhaseRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let octree = octree.view();
        let grid = GridVolume::new(DenseVolume::new(volume.dims, &volume.samples)?);
        let mut rows = Vec::new();
        for (name, view) in &views(volume.dims, self.size) {
            let octree = self.row(&mut Tracer::new(&octree), view, ["octree, octree data", name])?;
            let grid = self.row(&mut GridTracer::new(&grid), view, ["grid 4,4,4, array", name])?;
            let [in_octree, in_grid] = [octree.1, grid.1];
            ensure!(
                in_octree.hits > 0 && in_octree == in_grid,
                "{}, {name}: {in_octree:?} in the octree, {in_grid:?} in the grid",
                self.entry.name
            );
            rows.extend([octree.0, grid.0]);
        }
        Ok(rows)
    }
}

impl Phases<'_> {
    fn row(
        &self,
        tracer: &mut impl Trace,
        view: &View,
        [structure, name]: [&'static str; 2],
    ) -> Result<(PhaseRow, Found)> {
        let ([traversal, intersection, shading, _], found) =
            phases(tracer, view, self.entry.isovalues[0], self.repeat)?;
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
        Ok((row, found))
    }
}

/// Shares of traversal, intersection and shading in the time of a frame, and this itself, in seconds; and what it found.
///
/// # Errors
/// A part that was timed and came to something else than the frame.
pub(in crate::bench) fn phases(
    tracer: &mut impl Trace,
    view: &View,
    isovalue: f32,
    repeat: usize,
) -> Result<([f64; 4], Found)> {
    let recorded = Recorded::new(tracer, view, isovalue);
    let hits: Vec<Option<Hit>> =
        view.directions.iter().map(|&d| tracer.first_hit(&view.ray(d), isovalue)).collect();
    let mut expected = Found::default();
    hits.iter().flatten().for_each(|hit| expected.add(hit.t));
    let tracer = RefCell::new(tracer);
    let (times, found) = interleave_kept(
        repeat,
        &mut [
            &mut || recorded.traverse(*tracer.borrow_mut(), view, isovalue, &hits),
            &mut || shaded_frame(*tracer.borrow_mut(), view, isovalue, |hit, _| hit.t),
            &mut || frame(*tracer.borrow_mut(), view, isovalue),
        ],
    );
    for (part, found) in ["traversal alone", "a frame without shading", "a frame"].into_iter().zip(found) {
        ensure!(found == expected, "{part}, timed: {found:?}, expected {expected:?}");
    }
    let [traversal, up_to_hits, all] = [times[0], times[1], times[2]];
    Ok(([traversal / all, (up_to_hits - traversal) / all, (all - up_to_hits) / all, all], expected))
}
