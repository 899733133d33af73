//! Emission and absorption along a piece of a segment on which colour and extinction are linear in the value.
//!
//! # Derivation
//!
//! Let `s(x)`, `x` in `[0, 1]`, be the cubic along the piece, `m` its mean, `r = s − m`, and `τ = τ̄·(1 + κr)` its extinction, `τ̄ = τ(m)`.
//! The mean of `r` being zero, the optical depth of the piece is exactly `D = l·τ̄`. (`m` is the mean of the four Bernstein coefficients.)
//! The colour `c` being linear in `s` as well, the piece emits `α·c(s̄)`, where `s̄ = m + r̄` is the mean of `s` weighted by what is seen
//! of it, `w = τ e^(−T)`, `T` the optical depth up to `x`. With `y = T − D/2`, which lies in `[−D/2, D/2]`,
//!
//! `r̄ = ∫ r(1 + κr) e^(−y) dx / Z`,  `Z = ∫ (1 + κr) e^(−y) dx = e^(D/2)·α/D`.
//!
//! Insert `e^(−y) = 1 − y + ρ` and `y = D·z + Dκ·R`, with `z = x − ½` and `R = ∫₀ˣ r`. Since `R` vanishes at both ends, `∫ rR = 0`, and
//! what remains of the numerator is
//!
//! `κ·Var(s) − D·Cov(s, x)` + errors.
//!
//! Let `σ² = Var(s) = σₒ² + σₑ²` be split into the odd and the even part about the middle. As `|R| ≤ ½E|r| ≤ σ/2`, the errors are
//!
//! - `κ∫ r²·Dz ≤ D|κ|·σₒσₑ`, only the product of both parts being odd, and `κ∫ r²·DκR ≤ Dκ²σ²·σ/2`;
//! - `∫ rρ`, where `ρ = y²/2` and a rest of at most `(D/2)³/6·e^(D/2)`. Of `y²/2 = D²z²/2 + D²zκR + D²κ²R²/2` the first meets only the
//!   even part: `D²/2·σₑ·√E[z⁴]`; the second gives `D²|κ|σ²/2·√E[z²]`, the third `D²κ²σ³/8`, the rest `D³/48·e^(D/2)·σ`;
//! - `κ∫ r²ρ ≤ |κ|σ²·D²/8·e^(D/2)`.
//!
//! Where they exceed what is known anyway, that `s̄` lies between the least and the greatest coefficient, that holds.

use isoray_cell::Real;

use crate::moments::{CubicMoments, QuadraticMoments};
use crate::opacity::{is_single, opacity};

/// Extinction along a piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Medium<R> {
    /// At value 0 (of a field that is relative to a reference).
    pub(crate) extinction: R,
    /// What that may be off by.
    pub(crate) extinction_error: R,
    /// Change per unit of value.
    pub(crate) slope: R,
    /// Magnitude of that change, in the neighbouring intervals too, to which a value may really belong.
    pub(crate) steep: R,
    /// World length of the piece.
    pub(crate) length: R,
    /// What a value may be off by.
    pub(crate) rounding: R,
}

/// What a piece emits and absorbs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf<R> {
    pub(crate) alpha: R,
    /// Mean value, weighted by what is seen of it.
    pub(crate) value: R,
    /// Bounds of the errors of that value, without the rounding of the coefficients, and of the optical depth.
    pub(crate) value_error: R,
    pub(crate) depth_error: R,
    depth: R,
    /// `κ`, and its square root that is bounded.
    kappa: R,
    moments: CubicMoments<R>,
    /// Least and greatest coefficient.
    hull: [R; 2],
}

/// Bound of the rounding errors of a coefficient, with one more unit for their mean and one for the value that is made of it.
pub(crate) const VALUE_UNITS: f64 = isoray_cell::VALUE_ERROR_UNITS as f64 + 2.0;

/// A variation whose square loses digits among denormal numbers of single precision. What follows from it is not known then,
/// unless there is none.
const FAINTEST: f64 = 1e-17;

#[inline(always)]
fn is_faint<R: Real>(width: R) -> R::Mask {
    width.gt(R::splat(0.0)) & width.lt(R::splat(if is_single::<R>() { FAINTEST } else { 0.0 }))
}

/// Up to this optical depth `e^(D/2)` is bounded by a chord.
const DEEPEST: f64 = 2.0;

/// `e^(depth/2)` or more, for depths from 0 to [`DEEPEST`]: the chord of a convex function.
#[inline(always)]
fn attenuation_bound<R: Real>(depth: R) -> R {
    R::splat((std::f64::consts::E - 1.0) / DEEPEST).fma(depth, R::splat(1.0))
}

impl<R: Real> Leaf<R> {
    /// Of the cubic with coefficients `b`.
    #[inline(always)]
    pub(crate) fn new(b: [R; 4], medium: &Medium<R>) -> Self {
        let zero = R::splat(0.0);
        let unit = R::splat(0.5 * R::EPSILON);
        let moments = CubicMoments::new(b);
        let extinction = medium.slope.fma(moments.mean, medium.extinction).max(zero);
        let depth = medium.length * extinction;
        let alpha = opacity(depth);
        let hull = [b[0].min(b[1]).min(b[2].min(b[3])), b[0].max(b[1]).max(b[2].max(b[3]))];
        // No division by zero where there is nothing to see.
        let kappa = medium.slope / extinction.max(R::splat(f32::MIN_POSITIVE.into()));
        let variance = moments.variance();
        // D over e^(D/2)·α, that is 1/Z, but for its sign of less than one: Z only divides what is a correction, so it may be bounded too.
        let shift = (kappa * variance - depth * moments.along) * inverse_norm(depth);
        let low = hull[0] - moments.mean;
        let high = hull[1] - moments.mean;
        let value = moments.mean + shift.max(low).min(high);
        let width = hull[1] - hull[0];
        let error = value_error(depth, kappa, &moments).min(width);
        let value_error = R::select(is_faint(width), width, error);
        let absolute = medium.steep.fma(medium.rounding, medium.extinction_error);
        let depth_error = medium.length.fma(absolute, R::splat(8.0) * unit * depth);
        Self { alpha, value, value_error, depth_error, depth, kappa, moments, hull }
    }

    /// The weighted mean of a quadratic, and a bound of its error: as for the value, with `∫ pR ≤ σₚσ/2` as one more error, since it does not
    /// vanish. The factor ⅛ of `ρ` is raised by what the approximation of `Z` may cost.
    #[inline(always)]
    pub(crate) fn mean_of(&self, q: &QuadraticMoments<R>, range: R) -> [R; 2] {
        let (kappa, depth) = (self.kappa.abs(), self.depth);
        let shift = (self.kappa * self.moments.covariance(q) - depth * q.along()) * inverse_norm(depth);
        let [sigma, deviation] = [self.moments.variance().sqrt(), q.variance().sqrt()];
        let product = kappa * sigma;
        let quadratic = depth * depth * R::splat(0.127) * attenuation_bound(depth);
        let error = deviation * quadratic.fma(R::splat(1.0) + product, depth * product);
        let is_known = depth.le(R::splat(DEEPEST)) & !is_faint(self.hull[1] - self.hull[0]);
        let bounded = R::select(is_known, error, range).min(range);
        [q.mean + shift.max(-range).min(range), bounded]
    }

    /// The weighted covariance of the value with a quadratic, and a bound of its error: the weights `ω = (1 + κr)e^(−y)/Z` differ from 1 by at
    /// most `(1 + |κ|·max|r|)·e^(D/2)·Z − 1`, and the means by what [`mean_of`](Self::mean_of) shifts them, to
    /// `mean` and no more than its error beyond.
    #[inline(always)]
    pub(crate) fn covariance_with(
        &self,
        q: &QuadraticMoments<R>,
        [mean, mean_error]: [R; 2],
        range: R,
    ) -> [R; 2] {
        let one = R::splat(1.0);
        let depth = self.depth;
        let width = self.hull[1] - self.hull[0];
        let norm = (depth * depth).fma(R::splat(0.05), one);
        let weights = (one + self.kappa.abs() * width) * attenuation_bound(depth) * norm - one;
        let deviations = self.moments.variance().sqrt() * q.variance().sqrt();
        let shift = (self.value - self.moments.mean).abs() + self.value_error;
        let shifts = shift * ((mean - q.mean).abs() + mean_error);
        // At most a quarter of the product of the ranges (Grüss 1935), and so is the error of 0.
        let largest = R::splat(0.25) * width * range;
        let error = weights.fma(deviations, shifts);
        let is_known = depth.le(R::splat(DEEPEST)) & error.lt(largest) & !is_faint(width);
        let zero = R::splat(0.0);
        [R::select(is_known, self.moments.covariance(q), zero), R::select(is_known, error, largest)]
    }

    /// The mean parameter, weighted by what is seen, to first order: that of a polynomial like any other.
    pub(crate) fn place(&self) -> R {
        let shift = self.kappa.fma(self.moments.along, self.depth * R::splat(-1.0 / 12.0));
        let half = R::splat(0.5);
        half + (shift * inverse_norm(self.depth)).max(-half).min(half)
    }

    /// Least and greatest coefficient.
    #[inline(always)]
    pub(crate) fn hull(&self) -> [R; 2] {
        self.hull
    }
}

/// `1/Z = (D/2)/sinh(D/2)`, to `2·10⁻³` of itself up to a depth of 2: the error is that of a correction of less than `D·σ`, and is counted with
/// the next order's.
#[inline(always)]
fn inverse_norm<R: Real>(depth: R) -> R {
    let one = R::splat(1.0);
    one / (depth * depth).fma(R::splat(1.0 / 24.0), one)
}

/// Bound of the error of the weighted mean value; see the derivation above.
#[inline(always)]
fn value_error<R: Real>(depth: R, kappa: R, moments: &CubicMoments<R>) -> R {
    let kappa = kappa.abs();
    let variance = moments.variance();
    let sigma = variance.sqrt();
    let even = moments.even_variance.sqrt();
    // Not the root of the product, which may be less than any number of single precision.
    let mixed = moments.odd_variance.sqrt() * even;
    let e = attenuation_bound(depth);
    let product = kappa * variance;
    let square = kappa * product * sigma;
    // Terms of D, D² and D³.
    let first = kappa.fma(mixed, R::splat(0.5) * square);
    let second = R::splat(0.056)
        .fma(even, product.fma(R::splat(0.125).fma(e, R::splat(0.145)), R::splat(0.125) * square));
    let third = R::splat(1.0 / 48.0) * e * sigma;
    // That of 1/Z: D⁴/1920 of a shift of at most |κ|σ² + D·σ/√12.
    let norm = R::splat(1.0 / 1920.0) * depth * (depth * R::splat(0.29)).fma(sigma, product);
    let error = depth * depth.fma(depth.fma(third + norm, second), first);
    R::select(depth.le(R::splat(DEEPEST)), error, R::splat(f32::MAX.into()))
}
