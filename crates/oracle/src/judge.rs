//! Whether an answer may be held against a renderer.

use crate::Lattice;
use crate::isosurface::{OracleHit, OracleRay, all_hits, all_hits_counted, first_hit, first_hit_counted};
use crate::path::Path;

/// How far the isovalue is moved to find out whether a ray grazes: units of 2⁻²⁴ of the largest
/// `|corner - v|` over the cells tested, which is what f32 arithmetic on them may lose.
pub const GRAZING_ULPS: f64 = 8.0;

/// A ray grazes if its hit then moves by more than this, in voxels along the ray.
pub const GRAZING_VOXELS: f64 = 1e-3;

/// Half a unit in the last place of an f32 in `[1, 2)`.
const F32_ROUNDOFF: f64 = 1.0 / (1 << 24) as f64;

/// The answer to a ray, and how much it can be relied on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// The first hit.
    pub hit: Option<OracleHit>,
    /// Whether f32 arithmetic cannot be expected to find the same answer.
    pub grazing: bool,
    /// Cells that could hold surface (`min < v <= max`), up to and including that of the hit.
    pub tested: u32,
}

/// Finds the first hit, and finds it again with the isovalue moved up and down by
/// [`GRAZING_ULPS`]` · 2⁻²⁴ · max|corner - v|` over the cells tested.
///
/// The ray is *grazing* if it is then a miss instead of a hit, a hit instead of a miss, or a hit further
/// than [`GRAZING_VOXELS`] away. A ray that meets no cell that could hold surface never grazes.
pub fn judge(l: &impl Lattice, ray: &OracleRay, v: f32) -> Verdict {
    let v = f64::from(v);
    let (hit, tally) = first_hit_counted(l, ray, v);
    let shift = GRAZING_ULPS * F32_ROUNDOFF * tally.largest;
    let speed = Path::new(l.dims(), ray).map_or(0.0, |path| path.speed());
    let agrees = |other: Option<OracleHit>| match (hit, other) {
        (None, None) => true,
        (Some(a), Some(b)) => (a.t - b.t).abs() * speed <= GRAZING_VOXELS,
        _ => false,
    };
    let grazing =
        tally.tested > 0 && [-shift, shift].into_iter().any(|shift| !agrees(first_hit(l, ray, v + shift)));
    Verdict { hit, grazing, tested: tally.tested }
}

/// All hits of a ray, and how much they can be relied on.
#[derive(Clone, Debug, PartialEq)]
pub struct AllVerdict {
    /// In ascending `t`.
    pub hits: Vec<OracleHit>,
    /// Whether f32 arithmetic cannot be expected to find the same ones.
    pub grazing: bool,
}

/// As [`judge`], of all hits: the ray is grazing if moving the isovalue changes their number, or moves any by more than
/// [`GRAZING_VOXELS`].
pub fn judge_all(l: &impl Lattice, ray: &OracleRay, v: f32) -> AllVerdict {
    let v = f64::from(v);
    let (hits, tally) = all_hits_counted(l, ray, v);
    let shift = GRAZING_ULPS * F32_ROUNDOFF * tally.largest;
    let speed = Path::new(l.dims(), ray).map_or(0.0, |path| path.speed());
    let agree = |others: Vec<OracleHit>| {
        let close = |(a, b): (&OracleHit, &OracleHit)| (a.t - b.t).abs() * speed <= GRAZING_VOXELS;
        others.len() == hits.len() && hits.iter().zip(&others).all(close)
    };
    let grazing =
        tally.tested > 0 && [-shift, shift].into_iter().any(|shift| !agree(all_hits(l, ray, v + shift)));
    AllVerdict { hits, grazing }
}
