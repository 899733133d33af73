//! The field along a segment as a cubic in Bernstein form.

use crate::root::{Departing, Polynomial, Root, Roots, all_roots, extrema, first_root_series, is_inside};
use crate::{Real, Segment};

/// A cubic on `[0, 1]` by its four Bernstein coefficients, in ascending order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic<R = f32>(pub [R; 4]);

impl<R: Real> Cubic<R> {
    /// The trilinear interpolant of `corners` along `segment`: `f(s)` at the point `entry + s·(exit − entry)`.
    ///
    /// The blossom of a trilinear form is evaluated at the corners of the box spanned by entry and exit:
    /// with `w(i, j, k)` the value where x is taken from the exit if `i`, and so on, the coefficients are
    /// `w(000)`, `(w(100) + w(010) + w(001))/3`, `(w(110) + w(101) + w(011))/3`, `w(111)`.
    #[inline(always)]
    pub fn along(corners: &[R; 8], segment: &Segment<R>) -> Self {
        let w = R::trilinear_at_box(corners, &segment.entry, &segment.exit);
        let third = R::splat(1.0 / 3.0);
        Self([w[0], (w[1] + w[2] + w[4]) * third, (w[3] + w[5] + w[6]) * third, w[7]])
    }

    /// The value at `s` in `[0, 1]`; exactly the end coefficients at 0 and 1.
    #[inline]
    pub fn at(&self, s: R) -> R {
        let [b0, b1, b2, b3] = self.0;
        let r = R::splat(1.0) - s;
        let s3 = R::splat(3.0) * s;
        // Nested so that all weights are non-negative: no cancellation beyond that of the coefficients.
        let inner = r.fma(b0, s3 * b1);
        let middle = r.fma(inner, s3 * s * b2);
        r.fma(middle, s * s * s * b3)
    }

    /// Whether the cubic starts inside (`≥ 0`), as decided identically in both cells at a face.
    #[inline]
    pub fn starts_inside(&self) -> R::Mask {
        is_inside(self.0[0])
    }

    /// Whether it ends inside.
    #[inline]
    pub fn ends_inside(&self) -> R::Mask {
        is_inside(self.0[3])
    }

    /// A sixth of the second derivative at 0 and at 1, between which it is linear.
    #[inline(always)]
    pub(crate) fn second_differences(&self) -> [R; 2] {
        let [b0, b1, b2, b3] = self.0;
        let [d0, d1, d2] = [b1 - b0, b2 - b1, b3 - b2];
        [d1 - d0, d2 - d1]
    }

    /// The first `s` in `[0, 1]` at which the cubic passes from inside (`≥ 0`) to outside or back, by
    /// [`BernsteinSeries`](crate::root::BernsteinSeries).
    ///
    /// If the end values differ in side there always is one. If they agree, a pair of crossings whose excursion is below
    /// [`EXCURSION_UNITS`](crate::EXCURSION_UNITS)`·2⁻²⁴·max|corner|` may go unseen, or be seen where there is none by as little.
    #[inline(always)]
    pub fn first_root(&self) -> Root<R> {
        first_root_series(self)
    }
}

impl Cubic<f32> {
    /// All crossings, in order; the first is [`first_root`](Self::first_root).
    pub fn roots(&self) -> Roots {
        all_roots(self)
    }

    /// The same for a segment that starts on the surface, less that start.
    #[inline]
    pub fn departing(&self) -> Departing {
        Departing::new(self)
    }
}

impl<R: Real> Polynomial<R> for Cubic<R> {
    #[inline]
    fn at(&self, s: R) -> R {
        Cubic::at(self, s)
    }

    #[inline]
    fn slope(&self, s: R) -> R {
        let [b0, b1, b2, b3] = self.0;
        let r = R::splat(1.0) - s;
        let inner = r.fma(b1 - b0, R::splat(2.0) * s * (b2 - b1));
        R::splat(3.0) * r.fma(inner, s * s * (b3 - b2))
    }

    #[inline]
    fn ends(&self) -> [R; 2] {
        [self.0[0], self.0[3]]
    }

    #[inline]
    fn half_bend(&self) -> R {
        let [e0, e1] = self.second_differences();
        R::splat(3.0) * e0.abs().max(e1.abs())
    }

    fn extrema(&self) -> [R; 2] {
        let [b0, b1, b2, b3] = self.0;
        // A third of the derivative is the quadratic with Bernstein coefficients d, whose power form
        // a·s² + 2h·s + d0 has the discriminant h² − a·d0 = d1² − d0·d2. Its roots do not change with scale, and with the
        // largest coefficient at 1 no square can overflow or vanish.
        let d = [b1 - b0, b2 - b1, b3 - b2];
        let largest = d[0].abs().max(d[1].abs()).max(d[2].abs());
        let scale = R::splat(1.0) / largest.max(R::splat(f32::MIN_POSITIVE.into()));
        let d = d.map(|d| d * scale);
        let discriminant = d[1].fma(d[1], -(d[0] * d[2]));
        extrema((d[0] - d[1]) - (d[1] - d[2]), d[1] - d[0], d[0], discriminant)
    }
}
