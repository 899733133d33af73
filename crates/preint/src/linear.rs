//! Pieces over which the value is linear.

mod antiderivative;
mod interval;
mod quadrature;

use crate::{Piece, TransferFunction};
use antiderivative::Antiderivative;
use interval::Intervals;
pub(crate) use interval::Stretch;
pub(crate) use quadrature::Sums;

/// Integrals of a transfer function over pieces of a ray on which the value is linear: those that a preintegration table holds samples of
/// (Marchesin and Colin de Verdière 2009, section 3.1, equations 10 and 15), computed where they are needed.
///
/// # Method
///
/// A piece is cut where its value passes a control point, so that on each stretch extinction `τ` and colour `c` are linear in the
/// stretch's parameter `u`. Let `E(u) = e^(−T(u))`, `T` being the stretch's optical depth up to `u`, and `D = T(1)`. Since
/// `τ·l·E du = −dE`, integrating by parts gives
///
/// ```text
/// ∫ τ·c·l·E du = c₀·(1 − M) + c₁·(M − e^(−D)),    M = ∫₀¹ E du,
/// ```
///
/// and, weighted with `u` or `1 − u`, the same with `∫ u·E du` beside `M`. The opacity is exact, a constant colour `c` gives `c·alpha`, and
/// only the smooth integrals are left to a quadrature. That is Gauss's of 6 points, applied to `1 − E` by `expm1`, so that
/// all terms are positive and the result has the relative accuracy of the terms, however thin the piece.
///
/// # Error
///
/// `alpha` is within 2⁻²³ of itself, relatively. Components of `front` and `back` are within [`LinearPieces::ERROR`] of the exact ones,
/// relative to the largest component of any colour, plus one rounding to `f32`. This is so for any finite values, lengths from 0
/// to `f32::MAX`, and any optical depth that these give: 10⁻³⁰, or 10⁶.
#[derive(Clone, Debug)]
pub struct LinearPieces {
    intervals: Intervals,
    antiderivative: Antiderivative,
}

impl LinearPieces {
    /// Bound on the error of `front` and `back`, relative to the largest component of any colour, before they are rounded to `f32`.
    ///
    /// Gauss's rule with `n = 6` points on `[0, 1]` is off by `n!⁴ / ((2n + 1)·(2n)!³)·f⁽²ⁿ⁾(ξ) = 1.9·10⁻¹⁶·f⁽¹²⁾`. For
    /// `f = e^(−T)` with a quadratic `T` that rises from 0 to at most 1, the twelfth derivative is the largest if extinction falls to
    /// zero at the end, `T = 2u − u²`: at most 3.1·10⁷, the sum of the magnitudes of the twelfth Hermite polynomial's terms at 1; with the
    /// weight `u` another 12 times the eleventh, 8·10⁷. Together 2.1·10⁻⁸, times 2 for the factor before `∫ u·E du`. A
    /// thinner stretch has an error that falls with the sixth power of its depth at least (the rule is exact on `Tᵏ` up to `k = 5`),
    /// so the sum over stretches, each times the transmittance before it, is at most `e` times as much.
    ///
    /// Deeper stretches are cut at [`DEPTHS`](Self::DEPTHS); what the parts beyond the first add is not derived but measured: with ramps
    /// of any slope and depths up to 60, the largest error is 6.5·10⁻⁹.
    pub const ERROR: f64 = 2e-7;

    /// Optical depths, from the front of the piece, at which stretches are cut: each by `e^(d/6)` more than the one before, `d`. The error
    /// of the quadrature rises with the sixth power of the part's depth at most and counts `e^(−d)`, so no part adds more than the first. What
    /// lies beyond the last, e^(−18.7) = 7.6·10⁻⁹, is left out, which no `f32` beside 1 shows.
    pub const DEPTHS: [f64; 7] = [1.0, 2.2, 3.6, 5.4, 7.9, 11.7, 18.7];

    /// Prepares the integration of `transfer`.
    pub fn new(transfer: &TransferFunction) -> Self {
        let intervals = Intervals::new(transfer);
        let antiderivative = Antiderivative::new(&intervals);
        Self { intervals, antiderivative }
    }

    /// Opacity and colour of the piece of world length `length ≥ 0` on which the value runs linearly from `s0` to `s1`.
    pub fn integrate(&self, s0: f32, s1: f32, length: f32) -> Piece {
        self.sums(s0.into(), s1.into(), length.into()).piece()
    }

    /// The optical depth alone: `length` times the mean extinction of the values between `s0` and `s1`.
    ///
    /// It costs the same however many control points lie between, and has a relative error of at most 2⁻²³.
    pub fn optical_depth(&self, s0: f32, s1: f32, length: f32) -> f32 {
        let mean = self.antiderivative.mean(&self.intervals, s0.into(), s1.into());
        (f64::from(length) * mean) as f32
    }

    /// In double precision.
    pub(crate) fn sums(&self, s0: f64, s1: f64, length: f64) -> Sums {
        let mut sums = Sums::default();
        for stretch in self.stretches(s0, s1) {
            if !sums.add(stretch, length) {
                break;
            }
        }
        sums
    }

    /// The parts of the piece between control points, in order.
    pub(crate) fn stretches(&self, s0: f64, s1: f64) -> impl Iterator<Item = Stretch> {
        self.intervals.stretches(s0, s1)
    }
}

#[cfg(test)]
pub(crate) mod tests;
