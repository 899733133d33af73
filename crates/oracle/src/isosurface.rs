//! Hits of a ray with an isosurface.

use std::ops::ControlFlow;

use crate::Lattice;
use crate::cell::{Corners, corners, gradient};
use crate::path::{Path, Segment};
use crate::stretch::Profile;

/// A ray in index space, `origin + t · direction`, its f32 numbers taken as exact.
///
/// The direction need not be unit. `t_min` may be `-inf` and `t_max` `+inf`; a NaN anywhere, an
/// infinite origin or direction, or a zero direction makes a ray that hits nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OracleRay {
    /// Origin, in lattice coordinates; it may lie inside the domain.
    pub origin: [f32; 3],
    /// Lattice coordinates per unit of `t`; `-0.0` is parallel, as `0.0` is.
    pub direction: [f32; 3],
    /// Start of the ray; the state begins here, so that a change exactly here is no hit.
    pub t_min: f32,
    /// End of the ray; a change exactly here is no hit.
    pub t_max: f32,
}

/// A point at which a ray passes through the isosurface, in index space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OracleHit {
    /// Ray parameter.
    pub t: f64,
    /// Lattice coordinates of the point, inside the closed cell.
    pub position: [f64; 3],
    /// The cell. A hit on a face between two cells belongs to the one in which the ray is outside.
    pub cell: [u32; 3],
    /// Gradient of the cell's trilinear interpolant at the point, per voxel; not normalised.
    pub gradient: [f64; 3],
    /// Whether the ray passes from outside (`s < v`) to inside (`s >= v`).
    pub entering: bool,
}

/// The first hit of a ray with the isosurface of value `v`.
pub fn first_hit(l: &impl Lattice, ray: &OracleRay, v: f64) -> Option<OracleHit> {
    first_hit_counted(l, ray, v).0
}

/// All hits of a ray in ascending `t`; between two of the same kind lies an empty cell.
pub fn all_hits(l: &impl Lattice, ray: &OracleRay, v: f64) -> Vec<OracleHit> {
    all_hits_counted(l, ray, v).0
}

/// All hits, and what was looked at to find them.
pub(crate) fn all_hits_counted(l: &impl Lattice, ray: &OracleRay, v: f64) -> (Vec<OracleHit>, Tally) {
    let mut hits = Vec::new();
    let tally = trace(l, ray, v, |hit| {
        hits.push(hit);
        ControlFlow::Continue(())
    });
    (hits, tally)
}

/// The first hit, and what was looked at to find it.
pub(crate) fn first_hit_counted(l: &impl Lattice, ray: &OracleRay, v: f64) -> (Option<OracleHit>, Tally) {
    let mut first = None;
    let tally = trace(l, ray, v, |hit| {
        first = Some(hit);
        ControlFlow::Break(())
    });
    (first, tally)
}

/// The cells that could hold surface and so were solved.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) tested: u32,
    /// The largest `|corner - v|` of these cells.
    pub(crate) largest: f64,
}

/// What the corners of a cell say about it.
enum Content {
    /// A corner is not finite.
    Empty,
    /// All corners are on one side, and so is everything between them.
    Uniform { inside: bool },
    /// The corners minus the isovalue.
    Mixed(Corners),
}

#[inline]
fn classify(corners: Corners, v: f64) -> Content {
    if corners.iter().any(|s| !s.is_finite()) {
        return Content::Empty;
    }
    let inside = corners.iter().filter(|&&s| s >= v).count();
    match inside {
        0 => Content::Uniform { inside: false },
        n if n == corners.len() => Content::Uniform { inside: true },
        _ => Content::Mixed(corners.map(|s| s - v)),
    }
}

/// The last stretch of positive length behind the ray.
#[derive(Clone, Copy)]
struct Behind {
    inside: bool,
    cell: [u32; 3],
}

/// Walks the ray through the cells and reports each change of state, until told to stop.
fn trace(
    l: &impl Lattice,
    ray: &OracleRay,
    v: f64,
    mut on_hit: impl FnMut(OracleHit) -> ControlFlow<()>,
) -> Tally {
    let mut tally = Tally::default();
    let Some(path) = Path::new(l.dims(), ray).filter(|_| v.is_finite()) else {
        return tally;
    };
    let mut behind: Option<Behind> = None;
    // Enters a stretch of the segment at a fraction of it; a hit if the state changes there.
    let mut enter = |segment: &Segment, start: f64, inside: bool, behind: &mut Option<Behind>| {
        let before = behind.replace(Behind { inside, cell: segment.cell });
        match before {
            Some(before) if before.inside != inside => {
                let cell = if inside { before.cell } else { segment.cell };
                let t = segment.t0 + start * (segment.t1 - segment.t0);
                on_hit(hit_at(l, &path, cell, t, inside))
            }
            _ => ControlFlow::Continue(()),
        }
    };
    for segment in path.segments() {
        let flow = match classify(corners(l, segment.cell), v) {
            Content::Empty => {
                behind = None;
                ControlFlow::Continue(())
            }
            Content::Uniform { inside } => enter(&segment, 0.0, inside, &mut behind),
            Content::Mixed(corners) => {
                tally.tested += 1;
                tally.largest = corners.iter().fold(tally.largest, |m, c| m.max(c.abs()));
                let entry = path.local(segment.cell, segment.t0);
                let exit = path.local(segment.cell, segment.t1);
                let stretches = Profile { corners, entry, exit }.stretches();
                stretches.as_slice().iter().try_for_each(|s| enter(&segment, s.start, s.inside, &mut behind))
            }
        };
        if flow.is_break() {
            break;
        }
    }
    tally
}

fn hit_at(l: &impl Lattice, path: &Path, cell: [u32; 3], t: f64, entering: bool) -> OracleHit {
    let local = path.local(cell, t);
    OracleHit {
        t,
        position: std::array::from_fn(|axis| f64::from(cell[axis]) + local[axis]),
        cell,
        gradient: gradient(&corners(l, cell), local),
        entering,
    }
}
