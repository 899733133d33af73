//! Cells and segments to try.

use isoray_cell::{Segment, relative};
use isoray_oracle::{CellCase, SegmentCubic, SplitMix64, adversarial_cell};

/// `2⁻²⁴`.
pub(crate) const U: f64 = 1.0 / (1 << 24) as f64;

/// A cell: what is given, in `f32`, and what it should be.
pub(crate) struct Cell {
    samples: [f32; 8],
    isovalue: f32,
    pub(crate) corners: [f32; 8],
    pub(crate) exact: [f64; 8],
    /// Greatest magnitude of a corner.
    pub(crate) magnitude: f64,
}

/// Adversarial and random cells in turn, less an isovalue for half of them.
pub(crate) fn cell(rng: &mut SplitMix64, seed: u64) -> Cell {
    let samples: [f32; 8] = if rng.coin() {
        adversarial_cell(seed).map(|c| c as f32)
    } else {
        let scale = 10_f64.powf(rng.range(-8.0, 8.0));
        std::array::from_fn(|_| (scale * rng.range(-1.0, 1.0)) as f32)
    };
    let isovalue = match rng.below(4) {
        0 => samples[rng.below(8) as usize],
        1 => (rng.range(-1.0, 1.0) * f64::from(samples[0])) as f32,
        _ => 0.0,
    };
    let exact = samples.map(|s| f64::from(s) - f64::from(isovalue));
    let magnitude = exact.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    Cell { samples, isovalue, corners: relative(&samples, isovalue), exact, magnitude }
}

impl Cell {
    /// The exact field on a segment.
    pub(crate) fn along(&self, segment: &Segment) -> SegmentCubic {
        let Self { samples, isovalue, .. } = *self;
        SegmentCubic::new(&CellCase { samples, isovalue, entry: segment.entry, exit: segment.exit })
    }
}

/// A cell-local coordinate: often on a face, or next to one.
pub(crate) fn coordinate(rng: &mut SplitMix64) -> f32 {
    match rng.below(8) {
        0 | 1 => 0.0,
        2 | 3 => 1.0,
        4 => 1.0 - f32::EPSILON / 2.0,
        5 => rng.range(0.0, 1e-6) as f32,
        _ => rng.unit() as f32,
    }
}

pub(crate) fn point(rng: &mut SplitMix64) -> [f32; 3] {
    std::array::from_fn(|_| coordinate(rng))
}

/// A segment between any two points of the cell.
pub(crate) fn segment(rng: &mut SplitMix64) -> Segment {
    Segment { entry: point(rng), exit: point(rng) }
}
