//! Integration with a bounded error.

use crate::intervals::Intervals;
use crate::refine::Refinement;
use crate::segments::{Radiance, Segments};
use crate::whole::Whole;
use crate::{Integrate, Lighting, TransferFunction};

/// Integrates so that no premultiplied linear RGBA channel of a pixel is off by more than ε.
///
/// # How the error is bounded
///
/// A segment on which colour and extinction are linear in the value has an exact optical depth, and its mean colour has a bound
/// (see the source of `leaf.rs` for the derivation). Segments that come together are tried together, cut at control points where need be; if their bounds are too large for
/// what may be spent by the last of them, one after the other; and a segment whose bound is too large then is cut, where its value meets a control point or else in the
/// middle, and its pieces are integrated in double precision.
///
/// The budget ε is spent in three parts:
///
/// - an eighth on the transfer function: control points whose omission moves no colour by more than that are left out, which moves the colour of
///   a pixel by no more, since opacities along a ray add up to at most 1;
/// - two thirds on segments. Of them a sixteenth may be spent from the start, for roundings where there is next to nothing to see, and the share
///   `1 − T` of the rest once the transmittance is down to `T`: a segment of opacity α may always be off by that share of its own
///   contribution `T·α`, and also use what those before it have left;
/// - what is left on ending the ray: when all that may come behind, `T` times the brightest colour, is no more than what has not been spent.
///
/// An error `δ` of an optical depth moves the pixel by at most `δ·T·max(1, brightest colour)`, and is counted as such; rounding errors of
/// single precision are among the bounds. Those of double precision are not: some `10⁻¹³`, and what a step, or an interval narrower than them,
/// makes of a value that is within a few of them of it, which may be all of the segment.
#[derive(Clone, Debug)]
pub struct Bounded {
    intervals: Intervals,
    epsilon: f64,
    /// Of a pixel, without what is spent on the transfer function; and the part that segments may spend.
    total: f64,
    at_first: f64,
    for_segments: f64,
    /// The brightest colour that there can be, or 1, the largest alpha.
    brightest: f64,
}

/// Parts of ε.
const FOR_TRANSFER: f64 = 1.0 / 8.0;
const AT_FIRST: f64 = 1.0 / 24.0;
const FOR_SEGMENTS: f64 = 2.0 / 3.0 - AT_FIRST;

/// The least ε there can be: twice the rounding of colours to `f32`.
pub const LEAST_EPSILON: f64 = 2e-7;

impl Bounded {
    /// With errors of at most `epsilon`, raised to [`LEAST_EPSILON`] if it is less or no number. `lit` bounds the shading factor
    /// ([`Lighting::brightest`]); without shading it is 1.
    pub fn new(transfer: &TransferFunction, epsilon: f64, lit: f32) -> Self {
        let epsilon = epsilon.max(LEAST_EPSILON);
        let lit = f64::from(lit);
        let intervals = Intervals::new(transfer, epsilon * FOR_TRANSFER / lit.max(1.0));
        let total = epsilon * (1.0 - FOR_TRANSFER);
        let brightest = (f64::from(transfer.largest_color()) * lit).max(1.0);
        Self {
            intervals,
            epsilon,
            total,
            at_first: epsilon * AT_FIRST,
            for_segments: epsilon * FOR_SEGMENTS,
            brightest,
        }
    }

    /// The same, but following every ray to its end: to measure what ending gains.
    pub fn without_ending(self) -> Self {
        // Nothing is left to spend on it.
        Self { total: f64::NEG_INFINITY, ..self }
    }

    /// The bound.
    pub fn epsilon(&self) -> f64 {
        self.epsilon
    }

    /// Whether a piece whose contribution may be off by `error` can be added.
    #[inline(always)]
    pub(crate) fn allows(&self, into: &Radiance, alpha: f64, error: f64) -> bool {
        let behind = into.transmittance * (1.0 - alpha);
        into.error + into.transmittance * error <= self.at_first + self.for_segments * (1.0 - behind)
    }

    #[inline(always)]
    pub(crate) fn brightest(&self) -> f64 {
        self.brightest
    }

    #[inline(always)]
    pub(crate) fn intervals(&self) -> &Intervals {
        &self.intervals
    }

    /// Whether the errors so far are what may be spent on segments.
    #[inline(always)]
    fn has_kept(&self, so_far: &Radiance) -> bool {
        so_far.error <= self.at_first + self.for_segments * (1.0 - so_far.transmittance)
    }

    /// Adds a piece and what it may be off by, and ends the ray if nothing behind matters.
    #[inline(always)]
    pub(crate) fn add(&self, into: &mut Radiance, alpha: f64, color: [f64; 3], error: f64) {
        into.error += into.transmittance * error;
        // An error may make it negative, which only adds to the error.
        into.add(alpha, color.map(|c| c.max(0.0)));
        self.end(into);
    }

    /// Ends the ray if nothing behind matters.
    #[inline(always)]
    fn end(&self, into: &mut Radiance) {
        let behind = into.transmittance * self.brightest;
        if behind <= self.total - into.error {
            into.error += behind;
            into.is_done = true;
        }
    }
}

impl Integrate for Bounded {
    fn integrate(&self, segments: &Segments, lighting: Option<&Lighting>, into: &mut Radiance) {
        let mut whole = Whole::new(self, segments, lighting);
        let count = segments.count();
        if !whole.is_simple() {
            whole.take_apart(self, count, lighting);
        }
        // All of them at once, if that is allowed; most often it is.
        let mut all = *into;
        whole.pieces.add(count, &mut all);
        if self.has_kept(&all) {
            *into = all;
            return self.end(into);
        }
        for n in 0..count {
            let mut one = *into;
            whole.pieces.add_one(n, &mut one);
            if self.has_kept(&one) {
                *into = one;
                self.end(into);
            } else {
                Refinement::new(self, segments, n, whole.intervals(n), lighting, into).add_to(into);
            }
            if into.is_done {
                return;
            }
        }
    }
}
