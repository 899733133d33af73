//! Integration with a bounded error.

use isoray_cell::{Cubic, Real};
use wide::f32x16;

use crate::intervals::Intervals;
use crate::leaf::{Leaf, Medium};
use crate::refine::Refinement;
use crate::segments::{LANES, Radiance, Segments};
use crate::shade::{Lit, Shade};
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
/// - two thirds on segments. Of them, the share `1 − T` may be spent once the transmittance is down to `T`: a segment of opacity α may
///   always be off by that share of its own contribution `T·α`, and also use what those before it have left;
/// - what is left on ending the ray: when all that may come behind, `T` times the brightest colour, is no more than what has not been spent.
///
/// An error `δ` of an optical depth moves the pixel by at most `δ·T·max(1, brightest colour)`, and is counted as such; rounding errors of
/// single precision are among the bounds. Those of double precision, some `10⁻¹³`, are not.
#[derive(Clone, Debug)]
pub struct Bounded {
    intervals: Intervals,
    epsilon: f64,
    /// Of a pixel, without what is spent on the transfer function; and the part that segments may spend.
    total: f64,
    for_segments: f64,
    /// The brightest colour that there can be, or 1, the largest alpha.
    brightest: f64,
}

/// Parts of ε.
const FOR_TRANSFER: f64 = 1.0 / 8.0;
const FOR_SEGMENTS: f64 = 2.0 / 3.0;

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
        Self { intervals, epsilon, total, for_segments: epsilon * FOR_SEGMENTS, brightest }
    }

    /// The bound.
    pub fn epsilon(&self) -> f64 {
        self.epsilon
    }

    /// Whether a piece whose contribution may be off by `error` can be added.
    #[inline(always)]
    pub(crate) fn allows(&self, into: &Radiance, alpha: f64, error: f64) -> bool {
        let behind = into.transmittance * (1.0 - alpha);
        into.error + into.transmittance * error <= self.for_segments * (1.0 - behind)
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
        into.add(alpha, color);
        let behind = into.transmittance * self.brightest;
        if behind <= self.total - into.error {
            into.error += behind;
            into.is_done = true;
        }
    }
}

impl Integrate for Bounded {
    fn integrate(&self, segments: &Segments, lighting: Option<&Lighting>, into: &mut Radiance) {
        let lanes = Lanes::new(self, segments, lighting);
        for n in 0..segments.count() {
            if into.is_done {
                return;
            }
            match lanes.piece(self, segments, n) {
                Some((alpha, color, error)) if self.allows(into, alpha, error) => {
                    self.add(into, alpha, color, error)
                }
                _ => Refinement::new(self, segments, n, lanes.intervals[n], lighting).add_to(into),
            }
        }
    }
}

/// All segments at once, as if colour and extinction were linear along each.
struct Lanes {
    /// The first and last interval of the transfer function that each may meet.
    intervals: [[usize; 2]; LANES],
    alpha: [f32; LANES],
    value: [f32; LANES],
    value_error: [f32; LANES],
    depth_error: [f32; LANES],
    shade: Option<ShadeLanes>,
}

struct ShadeLanes {
    factor: [f32; LANES],
    factor_error: [f32; LANES],
    covariance: [f32; LANES],
    covariance_error: [f32; LANES],
}

impl Lanes {
    #[inline(always)]
    fn new(scheme: &Bounded, segments: &Segments, lighting: Option<&Lighting>) -> Self {
        let corners = segments.relative();
        let ends = segments.ends();
        let cubic = Cubic::along(&corners, &ends);
        let size = corners.into_iter().map(Real::abs).reduce(Real::max).unwrap_or(f32x16::ZERO);
        let intervals = intervals_met(scheme, segments, &cubic, size);
        let (mut extinction, mut slope) = ([0.0; LANES], [0.0; LANES]);
        for n in 0..segments.count() {
            let interval = scheme.intervals.get(intervals[n][0]);
            extinction[n] = interval.extinction(segments.reference_of(n)) as f32;
            slope[n] = interval.slope as f32;
        }
        let medium = Medium {
            extinction: f32x16::new(extinction),
            slope: f32x16::new(slope),
            length: segments.lengths(),
            size,
        };
        let leaf = Leaf::new(cubic.0, &medium);
        let shade = lighting.map(|lighting| {
            let shade = Shade::new(&leaf, &Lit::along(&corners, &ends, lighting), lighting, size);
            ShadeLanes {
                factor: shade.factor.to_array(),
                factor_error: shade.factor_error.to_array(),
                covariance: shade.covariance.to_array(),
                covariance_error: shade.covariance_error.to_array(),
            }
        });
        Self {
            intervals,
            alpha: leaf.alpha.to_array(),
            value: leaf.value.to_array(),
            value_error: leaf.value_error.to_array(),
            depth_error: leaf.depth_error.to_array(),
            shade,
        }
    }

    /// Opacity, colour and error of segment `n`; `None` if it meets several intervals.
    #[inline(always)]
    fn piece(&self, scheme: &Bounded, segments: &Segments, n: usize) -> Option<(f64, [f64; 3], f64)> {
        let [first, last] = self.intervals[n];
        if first != last {
            return None;
        }
        let interval = scheme.intervals.get(first);
        let mut color = interval.color(segments.reference_of(n) + f64::from(self.value[n]));
        let mut color_error = interval.steepest * self.value_error[n];
        if let Some(shade) = &self.shade {
            let factor = f64::from(shade.factor[n]);
            let covariance = f64::from(shade.covariance[n]);
            let slope = interval.color_slope();
            color = std::array::from_fn(|k| color[k] * factor + slope[k] * covariance);
            color_error = interval.brightest * shade.factor_error[n]
                + shade.factor[n] * color_error
                + interval.steepest * shade.covariance_error[n];
        }
        let alpha = f64::from(self.alpha[n]);
        // Four roundings of the opacity itself.
        let depth_error = f64::from(self.depth_error[n]) + alpha * 2.0 * f64::from(f32::EPSILON);
        Some((alpha, color, alpha * f64::from(color_error) + scheme.brightest * depth_error))
    }
}

/// The intervals that each segment may meet: by the exact range of its cell or, where that tells more than one, by its coefficients.
#[inline(always)]
fn intervals_met(
    scheme: &Bounded,
    segments: &Segments,
    cubic: &Cubic<f32x16>,
    size: f32x16,
) -> [[usize; 2]; LANES] {
    let [low, high] = segments.ranges();
    let [b0, b1, b2, b3] = cubic.0;
    let unit = f32x16::splat(0.5 * f32::EPSILON);
    let reference = segments.reference();
    // What coefficients may be off by, and their sum with the reference.
    let slack = unit * (f32x16::splat(isoray_cell::VALUE_ERROR_UNITS + 2.0) * size + reference.abs());
    let tight_low = (reference + Real::min(Real::min(b0, b1), Real::min(b2, b3)) - slack).to_array();
    let tight_high = (reference + Real::max(Real::max(b0, b1), Real::max(b2, b3)) + slack).to_array();
    let mut intervals = [[0; 2]; LANES];
    for n in 0..segments.count() {
        let [first, last] = scheme.intervals.of_range(low[n], high[n]);
        intervals[n] = if first == last {
            [first, last]
        } else {
            let [tight_first, tight_last] = scheme.intervals.of_range(tight_low[n], tight_high[n]);
            [first.max(tight_first), last.min(tight_last).max(first.max(tight_first))]
        };
    }
    intervals
}
