//! From what may be lost to the values that a sample may take.

use isoray_grid::Scalar;

use super::limits::HALO;
use super::loss::Loss;
use super::surfaces::Surfaces;
use super::values::{Interval, Values};

/// A [`Loss`] for one sample type.
#[derive(Clone, Debug)]
pub(super) struct Rules {
    values: Values,
    tolerance: f64,
    /// What bounds isosurfaces: the displacement, the range, both or neither.
    pub(super) surfaces: Vec<Surfaces>,
    clamp: Option<Clamp>,
}

/// The range that is kept, and the values that all others are clamped to.
#[derive(Clone, Copy, Debug)]
struct Clamp {
    low: f64,
    high: f64,
    below: f32,
    above: f32,
}

impl Rules {
    /// The rules of `loss`, which has been checked.
    pub(super) fn new<T: Scalar>(loss: &Loss) -> Self {
        let values = Values::of::<T>();
        let range = loss.range.map(outwards);
        let mut surfaces: Vec<_> = loss.surface.iter().map(|s| Surfaces::new(s, values)).collect();
        surfaces.extend(range.map(|range| Surfaces::exact(range, values)));
        let clamp = range.map(|[low, high]| Clamp {
            low,
            high,
            below: values.greatest_below(low),
            above: values.least_from(high),
        });
        Self { values, tolerance: loss.tolerance, surfaces, clamp }
    }

    /// Samples around a box that bear on those in it.
    pub(super) fn halo(&self) -> usize {
        if self.surfaces.is_empty() { 0 } else { HALO }
    }

    /// What sample `s` may become if isosurfaces let it change by `limit`; it always contains a finite `s`, and nothing if `s` is not finite.
    pub(super) fn allowed(&self, s: f32, limit: f64) -> Interval {
        let wide = f64::from(s);
        if !s.is_finite() {
            return Interval::NONE;
        }
        if self.clamp.is_some_and(|c| c.low <= wide && wide <= c.high) {
            return Interval::exactly(s);
        }
        let around = self.values.around(s, limit.min(self.tolerance));
        self.surfaces.iter().fold(around, |allowed, surfaces| allowed.and(surfaces.bracket(s)))
    }

    /// The one value for samples that may all become any of `allowed`, which is not empty.
    pub(super) fn value(&self, allowed: Interval) -> f32 {
        let preferred = self.clamp.iter().flat_map(|c| [c.below, c.above]).find(|&v| allowed.contains(v));
        // Where surfaces alone bound it, nothing is gained by keeping near the samples, and the interval may be endless.
        let candidates = if self.tolerance.is_finite() { self.values.central(allowed) } else { allowed };
        // Never -0.0.
        preferred.unwrap_or_else(|| self.values.roundest(candidates)) + 0.0
    }

    /// What becomes of a sample that is not made equal to its neighbours: clamped as far as it may, so that the ranges around it are tight.
    pub(super) fn alone(&self, s: f32, allowed: Interval) -> f32 {
        match self.clamp {
            Some(clamp) if f64::from(s) < clamp.low => clamp.below.min(allowed.high),
            Some(clamp) if f64::from(s) > clamp.high => clamp.above.max(allowed.low),
            _ => s,
        }
    }
}

/// The range whose ends are taken in although rounding to `f32`, as is done with isovalues, would move them out of it.
fn outwards([low, high]: [f64; 2]) -> [f64; 2] {
    [low.min(f64::from(low as f32)), high.max(f64::from(high as f32))]
}
