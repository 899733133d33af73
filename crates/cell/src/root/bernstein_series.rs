//! Bernstein sign count, then the root by a series.

use super::newton::bisect;
use super::sign_count::{are_several, bracket, is_number, sign_changes};
use super::{FirstRoot, Piece, Root, is_inside, middle, root_step};
use crate::{Cubic, Mask, Real, Segment, lerp};

/// The default. The signs of the Bernstein coefficients tell most cells off at once (all alike: the convex hull lies on one side) and most
/// others as having exactly one crossing (one change: Descartes' rule); only what is left is split at the extrema. From where the control
/// polygon crosses zero, or a parabola through the piece's extremum does, the root is found by reversion of the cubic's Taylor series,
/// with a bound on what the series leaves out; where that does not do, from there again, in a bracket.
///
/// On real data one step does for 98 of 100 cells. It has two divisions and no decision, so that lanes need not wait for each other.
#[derive(Clone, Copy, Debug, Default)]
pub struct BernsteinSeries;

impl FirstRoot for BernsteinSeries {
    const NAME: &'static str = "Bernstein, sign count, series";

    #[inline(always)]
    fn first_root<R: Real>(corners: &[R; 8], segment: &Segment<R>) -> Root<R> {
        first_root_series(&Cubic::along(corners, segment))
    }
}

#[inline(always)]
pub(crate) fn first_root_series<R: Real>(cubic: &Cubic<R>) -> Root<R> {
    let changes = sign_changes(cubic);
    let found = changes[0] | changes[1] | changes[2];
    if !found.any() {
        return Root { s: R::splat(0.0), found };
    }
    let piece = bracket(cubic, changes);
    let mut start = start_of_whole(cubic, changes);
    let several = are_several(changes);
    if several.any() {
        start = R::select(several, start_in_part(&piece), start);
    }
    root_by_series(cubic, piece, start)
}

/// Where the control polygon, whose vertices are the coefficients at 0, ⅓, ⅔ and 1, first crosses zero. From a quadratic it deviates at most
/// half as much as the secant.
#[inline(always)]
pub(super) fn start_of_whole<R: Real>(cubic: &Cubic<R>, changes: [R::Mask; 3]) -> R {
    let [b0, b1, b2, b3] = cubic.0;
    let [zero, third, two_thirds] = [0.0, 1.0 / 3.0, 2.0 / 3.0].map(R::splat);
    let pick = |a, b, c| R::select(changes[0], a, R::select(changes[1], b, c));
    let (from, to) = (pick(b0, b1, b2), pick(b1, b2, b3));
    third.fma(from / (from - to), pick(zero, third, two_thirds))
}

/// Near the root in a monotone piece between extrema: where the parabola crosses zero that has its vertex at the extremum and passes through
/// the other end.
#[inline(always)]
pub(super) fn start_in_part<R: Real>(piece: &Piece<R>) -> R {
    let [zero, one] = [0.0, 1.0].map(R::splat);
    let Piece { lo, hi, f_lo, f_hi, .. } = *piece;
    // Between two extrema, the one at which the cubic is nearer to zero.
    let is_from_hi = hi.lt(one) & (f_hi.abs().le(f_lo.abs()) | lo.le(zero));
    let pick = |low, high| R::select(is_from_hi, low, high);
    let (extremum, f) = (pick(hi, lo), pick(f_hi, f_lo));
    let length = pick(lo, hi) - extremum;
    let s = (f / (f - pick(f_lo, f_hi))).sqrt().fma(length, extremum);
    R::select(s.ge(lo) & s.le(hi), s, middle(lo, hi))
}

/// Steps before every step halves the bracket. Of 28 000 random cells with one change of sign 59 % need one, 41 % two, 116 more, one
/// of them four; it is nearly triple roots at which the series has nothing to say.
const STEPS: u32 = 8;
/// Greatest `ε²`, and greatest `|h|`, for which the series is trusted.
const MOST_EPSILON_SQUARED: f64 = 1.0 / 64.0;
const MOST_STEP: f64 = 1.0 / 20.0;
/// What the series leaves out, at most, in units of `ε⁴·|h|`.
const REMAINDER: f64 = 84.0;

/// The terms up to the third order of the `σ` near 1 that solves `σ − p·σ² + q·σ³ = 1`, where `q` counts as of the second order.
///
/// Let `|p| ≤ ε` and `|q| ≤ ε²` with `ε ≤ ⅛`. The left side less the right is negative at `σ = ¾` and positive at 1¼, and its derivative at
/// least 0.614 from 0 up to there, so that there is one solution in between. The terms lie in the same interval, and leave a
/// residual: a polynomial in `p` and `q` whose sum of magnitudes is at most `51·ε⁴`. So they are within [`REMAINDER`]`·ε⁴` of it.
#[inline(always)]
fn sigma<R: Real>(p: R, q: R) -> R {
    let [one, two, five] = [1.0, 2.0, 5.0].map(R::splat);
    // 1 + p + 2p² − q + 5p³ − 5pq.
    p.fma(five.fma(p, two), q.neg_fma(five, one)).fma(p, one - q)
}

/// The root in a piece, beginning at `start`.
///
/// At `s` the cubic is `f(s + x) = f0 + f1·x + f2·x² + f3·x³`. With `h = f0/f1`, `p = f2·h/f1` and `q = f3·h²/f1`, its root `x` is `−h·σ`, with
/// the [`sigma`] of `p` and `q`; and from `s` to there the cubic is monotone. The root is taken where what the series leaves out, times
/// `|h|`, is at most [`root_step`].
///
/// The coefficients `f1` to `f3` are off by `48`, `96` and `24·u·M` at most, counted like those at
/// [`EXCURSION_UNITS`](crate::EXCURSION_UNITS), which adds `3.4·u·M` to the error of `f0` for the `|x| ≤ 1/16` that is let pass.
/// Rounding the terms of `x` adds an eighth of an ulp of 1, rounding `s + x` a quarter.
#[inline(always)]
pub(super) fn root_by_series<R: Real>(cubic: &Cubic<R>, piece: Piece<R>, start: R) -> Root<R> {
    let [zero, one, three] = [0.0, 1.0, 3.0].map(R::splat);
    let step = root_step::<R>();
    let starts_inside = is_inside(piece.f_lo);
    let [b0, b1, b2, b3] = cubic.0;
    let [e0, e1] = cubic.second_differences();
    let f3 = e1 - e0;
    let (mut lo, mut hi, mut s) = (piece.lo, piece.hi, start);
    let (mut open, mut root) = (piece.found, start);
    for _ in 0..STEPS {
        let [c0, c1, c2] = [lerp(b0, b1, s), lerp(b1, b2, s), lerp(b2, b3, s)];
        let [d0, d1] = [lerp(c0, c1, s), lerp(c1, c2, s)];
        let f0 = lerp(d0, d1, s);
        let f1_inverse = one / (three * (d1 - d0));
        let h = f0 * f1_inverse;
        let h_over_f1 = h * f1_inverse;
        let p = three * f3.fma(s, e0) * h_over_f1;
        let q = f3 * h * h_over_f1;
        let next = h.neg_fma(sigma(p, q), s);
        // The least that is told from zero: products of smaller numbers would be denormal, and slow.
        let epsilon_squared = (p * p).max(q.abs()).max(R::splat(R::EPSILON));
        let is_exact = (epsilon_squared * epsilon_squared * h.abs()).le(step * R::splat(1.0 / REMAINDER));
        let is_valid = epsilon_squared.le(R::splat(MOST_EPSILON_SQUARED)) & h.abs().le(R::splat(MOST_STEP));
        let is_here = next.ge(lo - step) & next.le(hi + step);
        // Where the field passes the other way, it is another root.
        let is_passing = f1_inverse.gt(zero) ^ starts_inside;
        let done = open & is_exact & is_valid & is_here & is_passing;
        root = R::select(done, next.max(lo).min(hi), root);
        open = open & !done;
        if !open.any() {
            return Root { s: root, found: piece.found };
        }
        let crosses = is_inside(f0) ^ starts_inside;
        // A start that is not a number, from infinite coefficients, leaves the bracket as it is; the middle is taken after such a step.
        lo = R::select(crosses, lo, s.max(lo));
        hi = R::select(crosses, s.min(hi), hi);
        s = R::select(next.gt(lo) & next.lt(hi), next, middle(lo, hi));
    }
    // A coefficient that is NaN, on neither side, has got this far.
    let is_number = is_number(cubic);
    let s = bisect(cubic, lo, hi, starts_inside, open & is_number, root);
    Root { s, found: piece.found & is_number }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isoray_oracle::SplitMix64;

    #[test]
    fn the_series_leaves_out_no_more_than_is_said() {
        let mut rng = SplitMix64::new(1);
        let mut most = 0.0_f64;
        for n in 0..100_000 {
            let epsilon = 0.125 * if n % 2 == 0 { 1.0 } else { rng.unit() };
            let mut within = |most: f64| if rng.coin() { rng.sign() * most } else { rng.range(-most, most) };
            let (p, q) = (within(epsilon), within(epsilon * epsilon));
            let (mut low, mut high) = (0.75, 1.25);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let is_below = middle * (1.0 - middle * (p - q * middle)) < 1.0;
                if is_below { low = middle } else { high = middle }
            }
            let error = (sigma(p, q) - low).abs();
            most = most.max((error - 1e-15) / epsilon.powi(4));
            assert!(error <= REMAINDER * epsilon.powi(4) + 1e-15, "{error:e} for {p} and {q}");
        }
        assert!(most > 30.0, "the bound is hardly tried: {most} of {REMAINDER}");
    }
}
