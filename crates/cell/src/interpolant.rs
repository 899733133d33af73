//! Values inside a cell.

use crate::fma;

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

/// A ray's stretch inside a cell, by its end points in cell-local coordinates, each in `[0, 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Where the ray enters: exactly 0 or 1 on each axis whose face it crosses there.
    pub entry: [f32; 3],
    /// Where it leaves, likewise.
    pub exit: [f32; 3],
}

impl Segment {
    /// The cell-local point at parameter `s`, `0` at the entry and `1` at the exit.
    #[inline]
    pub fn at(&self, s: f32) -> [f32; 3] {
        std::array::from_fn(|a| lerp(self.entry[a], self.exit[a], s))
    }
}

/// `(1 − t)·a + t·b`, exactly `a` at `t = 0` and exactly `b` at `t = 1`; of one sign if `a` and `b` are
/// (unless they are so small, below `2⁻¹²⁵`, that the result underflows to a zero).
///
/// `a + t·(b − a)` would be cheaper by nothing and miss `b` at the end by a rounding, and with it the
/// neighbouring cell's value on a shared face.
#[inline(always)]
pub fn lerp(a: f32, b: f32, t: f32) -> f32 {
    fma(t, b, fma(-t, a, a))
}

/// Corner values minus the isovalue: zero exactly where a corner equals it, and of exact sign.
#[inline(always)]
pub fn relative(corners: &[f32; 8], isovalue: f32) -> [f32; 8] {
    corners.map(|c| c - isovalue)
}

/// The trilinear interpolant at cell-local `p`, along x first, then y, then z.
///
/// On a face the corners beyond it drop out exactly; both cells at the face get the same bits. The
/// error is at most [`VALUE_ERROR_UNITS`]`·2⁻²⁴·max|corner|`.
#[inline]
pub fn trilinear(corners: &[f32; 8], p: [f32; 3]) -> f32 {
    let c = corners;
    let x = |n: usize| lerp(c[n], c[n + 1], p[0]);
    let front = lerp(x(0), x(2), p[1]);
    let back = lerp(x(4), x(6), p[1]);
    lerp(front, back, p[2])
}
