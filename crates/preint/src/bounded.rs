//! Integration with a bounded error.

use crate::intervals::Intervals;
use crate::lanes::{Fragments, Lanes, Piece, Whole};
use crate::refine::Refinement;
use crate::segments::{Radiance, Segments};
use crate::{Integrate, Lighting, TransferFunction};

/// Integrates so that no premultiplied linear RGBA channel of a pixel is off by more than ε.
///
/// # How the error is bounded
///
/// A segment on which colour and extinction are linear in the value has an exact optical depth, and its mean colour has a bound
/// (see the source of `leaf.rs` for the derivation). A segment whose bound is too large is cut, where its value meets a control point or else in the
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

    /// Adds a piece and what it may be off by, and ends the ray if nothing behind matters.
    #[inline(always)]
    pub(crate) fn add(&self, into: &mut Radiance, alpha: f64, color: [f64; 3], error: f64) {
        into.error += into.transmittance * error;
        // An error may make it negative, which only adds to the error.
        into.add(alpha, color.map(|c| c.max(0.0)));
        let behind = into.transmittance * self.brightest;
        if behind <= self.total - into.error {
            into.error += behind;
            into.is_done = true;
        }
    }
}

impl Integrate for Bounded {
    fn integrate(&self, segments: &Segments, lighting: Option<&Lighting>, into: &mut Radiance) {
        let whole = Whole::new(self, segments, lighting);
        // Fragments of the segments from one to before another.
        let mut cut: Option<(Fragments, Lanes)> = None;
        for n in 0..segments.count() {
            let intervals = whole.intervals()[n];
            let is_added = if intervals[0] == intervals[1] {
                self.try_add(whole.lanes(), n, intervals[0], into)
            } else if self.intervals.has_step(intervals) {
                false
            } else {
                if !cut.as_ref().is_some_and(|(fragments, _)| fragments.has(n)) {
                    let fragments = Fragments::new(self, &whole, n, segments.count());
                    let lanes = fragments.integrate(self, lighting);
                    cut = Some((fragments, lanes));
                }
                cut.as_ref().is_some_and(|(fragments, lanes)| self.try_add_all(fragments, lanes, n, into))
            };
            if !is_added {
                Refinement::new(self, segments, n, intervals, lighting, into).add_to(into);
            }
            if into.is_done {
                return;
            }
        }
    }
}

impl Bounded {
    /// Adds the piece in lane `n`, in `interval`, if its error is allowed.
    #[inline(always)]
    fn try_add(&self, lanes: &Lanes, n: usize, interval: usize, into: &mut Radiance) -> bool {
        let Piece { alpha, color, error } = lanes.piece(self, n, interval);
        let is_allowed = self.allows(into, alpha, error);
        if is_allowed {
            self.add(into, alpha, color, error);
        }
        is_allowed
    }

    /// Adds all fragments of segment `n`, if there are any and the error of each is allowed.
    fn try_add_all(&self, fragments: &Fragments, lanes: &Lanes, n: usize, into: &mut Radiance) -> bool {
        let range = fragments.of(n);
        let mut tried = *into;
        let is_allowed = !range.is_empty()
            && range
                .into_iter()
                .all(|at| tried.is_done || self.try_add(lanes, at, fragments.interval(at), &mut tried));
        if is_allowed {
            *into = tried;
        }
        is_allowed
    }
}
