//! The field along a segment as a cubic in Bernstein form, and its first change of side.

use wide::f32x8;

use crate::{Segment, fma};

/// Step at which root refinement stops, in the segment's parameter: half a unit in the last place of 1,
/// below which the parameter of a point near the exit cannot be told from its neighbour.
pub const ROOT_STEP: f32 = f32::EPSILON / 2.0;

/// Newton steps allowed before every step halves the bracket. Simple roots need three to five; a cubic
/// with a nearly triple root converges linearly and is better served by bisection.
const NEWTON_STEPS: u32 = 8;

/// Halvings that take a bracket of length 1 to below [`ROOT_STEP`], with one to spare.
const BISECTION_STEPS: u32 = 25;

/// A cubic on `[0, 1]` by its four Bernstein coefficients, in ascending order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic(pub [f32; 4]);

impl Cubic {
    /// The trilinear interpolant of `corners` along `segment`: `f(s)` at the point `entry + s·(exit − entry)`.
    ///
    /// The blossom of a trilinear form is evaluated at the corners of the box spanned by entry and exit:
    /// with `w(i, j, k)` the value where x is taken from the exit if `i`, and so on, the coefficients are
    /// `w(000)`, `(w(100) + w(010) + w(001))/3`, `(w(110) + w(101) + w(011))/3`, `w(111)`.
    #[inline(always)]
    pub fn along(corners: &[f32; 8], segment: &Segment) -> Self {
        let c = corners;
        let [e, x] = [segment.entry, segment.exit];
        // Eight lerps at a time. Along x: the four edges at the entry's x, then at the exit's.
        let q = lerps(
            [c[0], c[2], c[4], c[6], c[0], c[2], c[4], c[6]],
            [c[1], c[3], c[5], c[7], c[1], c[3], c[5], c[7]],
            [e[0], e[0], e[0], e[0], x[0], x[0], x[0], x[0]],
        );
        // Along y: x and y from 00, 10, 01, 11 (entry 0, exit 1) on the lower face, then on the upper one.
        let q = lerps(
            [q[0], q[4], q[0], q[4], q[2], q[6], q[2], q[6]],
            [q[1], q[5], q[1], q[5], q[3], q[7], q[3], q[7]],
            [e[1], e[1], x[1], x[1], e[1], e[1], x[1], x[1]],
        );
        // Along z: the same four at the entry's z, then at the exit's.
        let w = lerps(
            [q[0], q[1], q[2], q[3], q[0], q[1], q[2], q[3]],
            [q[4], q[5], q[6], q[7], q[4], q[5], q[6], q[7]],
            [e[2], e[2], e[2], e[2], x[2], x[2], x[2], x[2]],
        );
        const THIRD: f32 = 1.0 / 3.0;
        Self([w[0], (w[1] + w[2] + w[4]) * THIRD, (w[3] + w[5] + w[6]) * THIRD, w[7]])
    }

    /// The value at `s` in `[0, 1]`; exactly the end coefficients at 0 and 1.
    #[inline]
    pub fn at(&self, s: f32) -> f32 {
        let [b0, b1, b2, b3] = self.0;
        let r = 1.0 - s;
        let s3 = 3.0 * s;
        // Nested so that all weights are non-negative: no cancellation beyond that of the coefficients.
        let inner = fma(r, b0, s3 * b1);
        let middle = fma(r, inner, s3 * s * b2);
        fma(r, middle, s * s * s * b3)
    }

    /// The derivative at `s`.
    #[inline]
    fn slope(&self, s: f32) -> f32 {
        let [b0, b1, b2, b3] = self.0;
        let r = 1.0 - s;
        let inner = fma(r, b1 - b0, 2.0 * s * (b2 - b1));
        3.0 * fma(r, inner, s * s * (b3 - b2))
    }

    /// The greatest second difference of the coefficients: a sixth of the second derivative is between those.
    #[inline]
    fn bend(&self) -> f32 {
        let [b0, b1, b2, b3] = self.0;
        let [d0, d1, d2] = [b1 - b0, b2 - b1, b3 - b2];
        (d1 - d0).abs().max((d2 - d1).abs())
    }

    /// Whether the cubic starts inside (`≥ 0`), as decided identically in both cells at a face.
    #[inline]
    pub fn starts_inside(&self) -> bool {
        self.0[0] >= 0.0
    }

    /// The first `s` in `[0, 1]` at which the cubic passes from inside (`≥ 0`) to outside or back.
    ///
    /// If the end values differ in side there always is one. If they agree, a pair of crossings whose
    /// excursion is below the rounding of the coefficients may go unseen. A coefficient that is not a
    /// number makes no crossing.
    #[inline(always)]
    pub fn first_root(&self) -> Option<f32> {
        let [s0, s1, s2, s3] = self.0.map(|b| b >= 0.0);
        // The convex hull lies on one side: most cells that a ray meets are told off here.
        if s0 == s1 && s1 == s2 && s2 == s3 { None } else { self.first_change() }
    }

    /// [`first_root`](Self::first_root) where the coefficients differ in side.
    fn first_change(&self) -> Option<f32> {
        let [s0, s1, s2, s3] = self.0.map(|b| b >= 0.0);
        let changes = u32::from(s0 != s1) + u32::from(s1 != s2) + u32::from(s2 != s3);
        if changes == 1 {
            // One variation of sign: exactly one crossing (Descartes' rule in Bernstein form).
            Some(self.refine(0.0, 1.0, self.0[0], self.0[3]))
        } else {
            self.first_root_between_extrema()
        }
    }

    /// Splits at the extrema and takes the first monotone piece whose ends differ in side.
    fn first_root_between_extrema(&self) -> Option<f32> {
        let mut from = (0.0, self.0[0]);
        for s in self.extrema().into_iter().flatten() {
            let to = (s, self.at(s));
            if (from.1 >= 0.0) != (to.1 >= 0.0) {
                return Some(self.refine(from.0, to.0, from.1, to.1));
            }
            from = to;
        }
        ((from.1 >= 0.0) != (self.0[3] >= 0.0)).then(|| self.refine(from.0, 1.0, from.1, self.0[3]))
    }

    /// The parameters in `(0, 1)` at which the derivative vanishes, ascending.
    fn extrema(&self) -> [Option<f32>; 2] {
        let [b0, b1, b2, b3] = self.0;
        // A third of the derivative is the quadratic with Bernstein coefficients d, whose power form
        // a·s² + 2h·s + d0 has the discriminant h² − a·d0 = d1² − d0·d2. Its roots do not change with scale, and with the
        // largest coefficient at 1 no square can overflow or vanish.
        let d = [b1 - b0, b2 - b1, b3 - b2];
        let largest = d[0].abs().max(d[1].abs()).max(d[2].abs());
        let scale = 1.0 / largest.max(f32::MIN_POSITIVE);
        let d = d.map(|d| d * scale);
        let product = d[0] * d[2];
        let discriminant = fma(d[1], d[1], -product);
        if discriminant.is_nan() || discriminant <= 0.0 {
            return [None, None];
        }
        let h = d[1] - d[0];
        let a = (d[0] - d[1]) - (d[1] - d[2]);
        // The stable form: the root that adds magnitudes, and the other from the product of the roots.
        let q = -(h + discriminant.sqrt().copysign(h));
        let keep = |s: f32| (s > 0.0 && s < 1.0).then_some(s);
        let (r0, r1) = (keep(q / a), keep(d[0] / q));
        match (r0, r1) {
            (Some(x), Some(y)) if x > y => [r1, r0],
            _ => [r0, r1],
        }
    }

    /// Newton's iteration kept in a bracket `[lo, hi]` whose ends differ in side; ends when the root is known to be within
    /// [`ROOT_STEP`] of the next iterate, when a step falls below that, or when the bracket cannot be halved.
    ///
    /// With `|f''|/2 ≤ c` on `[0, 1]` and a step `h = f/f'` from `s`, let `4·c·h² ≤ ROOT_STEP·|f'|` and `|h| > ROOT_STEP`, so that
    /// `4·c·|h| < |f'|`. Then `f` is monotone within `2|h|` of `s` and changes sign there, since at `s − 2h` its tangent is
    /// `−f` and it differs from that by at most `4·c·h² < |f|`; and the root is within `c·(2h)²/|f'| ≤ ROOT_STEP` of `s − h`.
    #[inline]
    fn refine(&self, mut lo: f32, mut hi: f32, f_lo: f32, f_hi: f32) -> f32 {
        let starts_inside = f_lo >= 0.0;
        // The secant's root; the ends differ in side, so the difference is zero only for 0 and −0.
        let secant = fma(hi - lo, f_lo / (f_lo - f_hi), lo);
        let mut s = if secant > lo && secant < hi { secant } else { 0.5 * (lo + hi) };
        let four_c = 12.0 * self.bend();
        for _ in 0..NEWTON_STEPS {
            let f = self.at(s);
            if (f >= 0.0) == starts_inside {
                lo = s;
            } else {
                hi = s;
            }
            let slope = self.slope(s);
            let step = f / slope;
            let next = s - step;
            // A small step ends the search only where the field passes in the right direction: a bracket whose
            // far end is itself a root, of the way back, would otherwise draw the iteration there.
            let is_close = step.abs() <= ROOT_STEP || four_c * step * step <= ROOT_STEP * slope.abs();
            if is_close && (slope > 0.0) != starts_inside {
                return next.clamp(lo, hi);
            }
            // Also false for a step that is not a number.
            s = if next > lo && next < hi { next } else { 0.5 * (lo + hi) };
        }
        for _ in 0..BISECTION_STEPS {
            s = 0.5 * (lo + hi);
            if hi - lo <= ROOT_STEP || s <= lo || s >= hi {
                break;
            }
            if (self.at(s) >= 0.0) == starts_inside {
                lo = s;
            } else {
                hi = s;
            }
        }
        s
    }
}

/// [`lerp`] in each lane.
#[inline(always)]
fn lerps(a: [f32; 8], b: [f32; 8], t: [f32; 8]) -> [f32; 8] {
    let [a, b, t] = [a, b, t].map(f32x8::new);
    t.mul_add(b, t.mul_neg_add(a, a)).to_array()
}
