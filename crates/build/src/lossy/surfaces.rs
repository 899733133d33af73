//! Isosurfaces whose displacement is bounded: where they are, and what that allows a sample.

use super::loss::{Isovalues, SurfaceTolerance};
use super::values::{Interval, Values};

/// What one bound on isosurfaces says of cells and of samples.
#[derive(Clone, Debug)]
pub(super) struct Surfaces {
    isovalues: Levels,
    /// Times the least slope, this is how much the corners of a cell may change: D/(1 + 2D), not rounded up.
    pub(super) share: f64,
}

/// Isovalues, with the greatest sample value below and the least one at or above each.
#[derive(Clone, Debug)]
enum Levels {
    /// Ascending.
    List(Vec<Level>),
    Range([Level; 2]),
}

#[derive(Clone, Copy, Debug)]
struct Level {
    value: f64,
    below: f32,
    above: f32,
}

/// Where a cell is, to the isosurfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meeting {
    /// A corner is not finite: there is no surface, whatever the others are.
    Empty,
    /// No isosurface meets it, as long as its corners keep to their brackets.
    Apart,
    /// No isosurface meets it only because all its corners have the same value in the range.
    Flat,
    /// An isosurface meets it.
    Met,
}

/// A displacement of more than this is not used: the slope is known for one voxel to both sides.
const MOST: f64 = 1.0;
/// 1 − 2⁻⁵⁰, by which a bound is multiplied that came out of at most seven operations in `f64`, each off by 2⁻⁵³ of its
/// result at most: so it is not above the exact one.
const ROUNDED_DOWN: f64 = 1.0 - 4.0 * f64::EPSILON;

impl Surfaces {
    /// The isosurfaces of `tolerance`, which has been checked, among samples of `values`.
    pub(super) fn new(tolerance: &SurfaceTolerance, values: Values) -> Self {
        let displacement = tolerance.displacement.min(MOST);
        let isovalues = match &tolerance.isovalues {
            Isovalues::List(list) => {
                let mut levels: Vec<_> = list.iter().map(|&v| Level::new(v.into(), values)).collect();
                levels.sort_by(|a, b| a.value.total_cmp(&b.value));
                Levels::List(levels)
            }
            Isovalues::Range(range) => Levels::Range(range.map(|v| Level::new(v.into(), values))),
        };
        Self { isovalues, share: displacement / (1.0 + 2.0 * displacement) * ROUNDED_DOWN }
    }

    /// All isosurfaces in a range, exactly.
    pub(super) fn exact(range: [f64; 2], values: Values) -> Self {
        Self { isovalues: Levels::Range(range.map(|v| Level::new(v, values))), share: 0.0 }
    }

    /// Where a cell is whose corners have this least and greatest value, both finite.
    pub(super) fn meeting(&self, min: f32, max: f32) -> Meeting {
        let [least, most] = [min, max].map(f64::from);
        match &self.isovalues {
            // Met by v if min < v ≤ max.
            Levels::List(list) => match list.get(list.partition_point(|l| l.value <= least)) {
                Some(level) if level.value <= most => Meeting::Met,
                _ => Meeting::Apart,
            },
            Levels::Range([low, high]) if most < low.value || least >= high.value => Meeting::Apart,
            Levels::Range(_) if least == most => Meeting::Flat,
            Levels::Range(_) => Meeting::Met,
        }
    }

    /// The values that are on the same side of every isovalue as `s`; for a range, of its ends, and any if `s` is between them.
    pub(super) fn bracket(&self, s: f32) -> Interval {
        let wide = f64::from(s);
        match &self.isovalues {
            Levels::List(list) => {
                let n = list.partition_point(|l| l.value <= wide);
                let low = n.checked_sub(1).and_then(|n| list.get(n)).map_or(f32::NEG_INFINITY, |l| l.above);
                Interval { low, high: list.get(n).map_or(f32::INFINITY, |l| l.below) }
            }
            Levels::Range([low, _]) if wide < low.value => Interval { high: low.below, ..Interval::ALL },
            Levels::Range([_, high]) if wide >= high.value => Interval { low: high.above, ..Interval::ALL },
            Levels::Range(_) => Interval::ALL,
        }
    }
}

impl Level {
    fn new(value: f64, values: Values) -> Self {
        Self { value, below: values.greatest_below(value), above: values.least_from(value) }
    }
}
