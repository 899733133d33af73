//! Values inside a cell.

use crate::Real;

/// Bound of the error of a trilinear value or a Bernstein coefficient, in units of `2⁻²⁴·max|corner|`.
///
/// With `u = 2⁻²⁴`, one [`lerp`] of values bounded by `M` rounds `fl(a − t·a)`, at most `(1 − t)·M` in magnitude, and the
/// sum, at most `M`; where the multiply-add is not fused also two products, at most `t·M`: together `2u·M`, or `3u·M`
/// unfused. Convex combination does not amplify the errors that it is given, so three levels of `lerp` make `9u·M` at
/// most. The mean of three values rounds a sum of two and one of three, `(2 + 3)/3` units; the factor ⅓ is off by half a
/// unit and its product by one: `3.2` together. The rounding of `corner − v` adds one. Second-order terms are covered by
/// rounding the sum of 13.2 up. (Measured with fused multiply-add: at most 4.)
///
/// It holds for magnitudes up to a third of `f32::MAX`, the sum of three being formed, and but for underflow, which
/// adds a few times the least denormal number.
pub const VALUE_ERROR_UNITS: f32 = 14.0;

/// Bound `B` of the excursions to the other side that [`Cubic::first_root`](crate::Cubic::first_root) may miss, or report where there
/// are none, in units of `2⁻²⁴·max|corner|`: [`VALUE_ERROR_UNITS`] of a coefficient, 9 of evaluating the cubic, and
/// 1 because an extremum is itself computed, or 4 because a root lies beside where the cubic was evaluated.
///
/// No coefficient passes through more than nine roundings on its way to the sum (the second: `3s`, its product, and thrice the one of
/// `1 − s`, of a product and of a sum, less one of the first), and the weights add up to one.
/// De Casteljau's algorithm has three levels of [`lerp`], 3 units each.
///
/// For the extremum, let `p` be the derivative's quadratic, scaled so that its largest Bernstein coefficient is 1, and `D ≤ 2M` that
/// scale: `f' = 3D·p`. The stable formula gives the root `ŝ` of a quadratic whose coefficients are off by a few roundings, so that
/// `|p(ŝ)| ≤ 16u`. Where the roots of `p` are close together, its leading coefficient is at least ⅓, and `|ŝ − s*| ≤ √(48u) < 2·10⁻³`;
/// elsewhere `ŝ` is nearer. Since `|p| ≤ 16u` in between, `f(ŝ)` differs from `f(s*)` by less than `3·2M·16u·2·10⁻³ < 0.2·u·M`.
/// If the discriminant `q` vanishes by rounding, `q < 4u`, and the two extrema differ in value by `D·4·q^{3/2}/a² < 0.2·u·M`.
pub const EXCURSION_UNITS: f32 = VALUE_ERROR_UNITS + 13.0;

/// A ray's stretch inside a cell, by its end points in cell-local coordinates, each in `[0, 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment<R = f32> {
    /// Where the ray enters: exactly 0 or 1 on each axis whose face it crosses there.
    pub entry: [R; 3],
    /// Where it leaves, likewise.
    pub exit: [R; 3],
}

impl<R: Real> Segment<R> {
    /// The cell-local point at parameter `s`, `0` at the entry and `1` at the exit.
    #[inline]
    pub fn at(&self, s: R) -> [R; 3] {
        std::array::from_fn(|a| lerp(self.entry[a], self.exit[a], s))
    }
}

/// `(1 − t)·a + t·b`, exactly `a` at `t = 0` and exactly `b` at `t = 1`; of one sign if `a` and `b` are
/// (unless they are so small, below `2⁻¹²⁵`, that the result underflows to a zero).
///
/// `a + t·(b − a)` would be cheaper by nothing and miss `b` at the end by a rounding, and with it the
/// neighbouring cell's value on a shared face.
#[inline(always)]
pub fn lerp<R: Real>(a: R, b: R, t: R) -> R {
    t.fma(b, t.neg_fma(a, a))
}

/// Corner values minus the isovalue: zero exactly where a corner equals it, and of exact sign.
#[inline(always)]
pub fn relative<R: Real>(corners: &[R; 8], isovalue: R) -> [R; 8] {
    corners.map(|c| c - isovalue)
}

/// The trilinear interpolant at cell-local `p`, along x first, then y, then z.
///
/// On a face the corners beyond it drop out exactly; both cells at the face get the same bits. The
/// error is at most [`VALUE_ERROR_UNITS`]`·2⁻²⁴·max|corner|`.
#[inline]
pub fn trilinear<R: Real>(corners: &[R; 8], p: [R; 3]) -> R {
    let c = corners;
    let x = |n: usize| lerp(c[n], c[n + 1], p[0]);
    let front = lerp(x(0), x(2), p[1]);
    let back = lerp(x(4), x(6), p[1]);
    lerp(front, back, p[2])
}
