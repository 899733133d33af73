//! Segments in lanes.

use isoray_cell::{Cubic, Real};
use wide::f32x16;

use crate::Lighting;
use crate::bounded::Bounded;
use crate::fragments::Fragments;
use crate::leaf::VALUE_UNITS;
use crate::pieces::{Input, LEAST_ROUNDING, Pieces};
use crate::segments::{LANES, Segments};
use crate::shade::{LIT_UNITS, Lit};

/// Segments as they come, a lane each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whole {
    pub(crate) input: Input,
    /// The first and the last interval of the transfer function that each segment may meet.
    intervals: [[u32; LANES]; 2],
    /// What each emits and absorbs, if it meets one interval only.
    pub(crate) pieces: Pieces,
}

impl Whole {
    #[inline(always)]
    pub(crate) fn new(scheme: &Bounded, segments: &Segments, lighting: Option<&Lighting>) -> Self {
        let corners = segments.relative();
        let ends = segments.ends();
        let cubic = Cubic::along(&corners, &ends);
        let size = corners.into_iter().map(Real::abs).reduce(Real::max).unwrap_or(f32x16::ZERO);
        let intervals = intervals_met(scheme, segments, &cubic, size);
        let input = Input {
            value: cubic.0,
            lit: lighting.map(|lighting| Lit::along(&corners, &ends, segments.slopes(), lighting)),
            length: segments.lengths(),
            size,
            units: VALUE_UNITS as f32,
            lit_units: LIT_UNITS as f32,
            reference: segments.reference().to_array(),
            intervals: intervals[0],
        };
        Self { input, intervals, pieces: Pieces::new(scheme, &input, lighting) }
    }

    /// The first and the last interval of the transfer function that segment `n` may meet.
    #[inline(always)]
    pub(crate) fn intervals(&self, n: usize) -> [usize; 2] {
        [self.intervals[0][n] as usize, self.intervals[1][n] as usize]
    }

    /// Whether every segment meets one interval only.
    #[inline(always)]
    pub(crate) fn is_simple(&self) -> bool {
        self.intervals[0] == self.intervals[1]
    }

    /// Integrates segments that meet several intervals in fragments, and tells of which that cannot be done.
    #[inline(never)]
    pub(crate) fn take_apart(&mut self, scheme: &Bounded, count: usize, lighting: Option<&Lighting>) {
        let mut n = 0;
        while n < count {
            if self.intervals[0][n] == self.intervals[1][n] {
                n += 1;
                continue;
            }
            let fragments = Fragments::new(scheme, self, n, count);
            let pieces = fragments.integrate(scheme, lighting);
            for k in fragments.segments() {
                if self.intervals[0][k] < self.intervals[1][k] {
                    self.pieces.join(k, &pieces, fragments.of(k));
                }
            }
            n = fragments.segments().end;
        }
    }
}

/// The intervals that each segment may meet: by the exact range of its cell or, where that tells more than one, by its coefficients.
#[inline(always)]
fn intervals_met(
    scheme: &Bounded,
    segments: &Segments,
    cubic: &Cubic<f32x16>,
    size: f32x16,
) -> [[u32; LANES]; 2] {
    let [low, high] = segments.ranges();
    let [b0, b1, b2, b3] = cubic.0;
    let unit = f32x16::splat(0.5 * f32::EPSILON);
    let reference = segments.reference();
    // What coefficients may be off by, and their sum with the reference.
    let slack = unit * (f32x16::splat(VALUE_UNITS as f32) * size + reference.abs());
    let slack = Real::max(slack, f32x16::splat(LEAST_ROUNDING));
    let tight_low = reference + Real::min(Real::min(b0, b1), Real::min(b2, b3)) - slack;
    let tight_high = reference + Real::max(Real::max(b0, b1), Real::max(b2, b3)) + slack;
    let count = segments.count();
    let mut intervals = scheme.intervals().of_ranges(low, high, count);
    if intervals[0] != intervals[1] {
        let tight = scheme.intervals().of_ranges(tight_low, tight_high, count);
        let ([first, last], [tight_first, tight_last]) = (&mut intervals, &tight);
        for n in 0..LANES {
            let is_narrowed = first[n] < last[n];
            let narrowed = first[n].max(tight_first[n]);
            last[n] = if is_narrowed { last[n].min(tight_last[n]).max(narrowed) } else { last[n] };
            first[n] = if is_narrowed { narrowed } else { first[n] };
        }
    }
    // Lanes that are not in use, like the first.
    for of in &mut intervals {
        let first = of[0];
        of[count..].fill(first);
    }
    intervals
}
