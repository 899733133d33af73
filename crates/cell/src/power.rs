//! The field along a segment as a cubic in power form.

use crate::root::{Polynomial, extrema};
use crate::{Real, Segment};

/// `((a·s + b)·s + c)·s + d` on `[0, 1]`: Parker et al. (1998), appendix A, in the segment's own parameter. (In the ray's, single
/// precision loses hits.)
///
/// Its coefficients are differences of corner values, as long as the cell's largest, and so are its errors near the exit, where
/// the [Bernstein form](crate::Cubic) has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power<R = f32> {
    /// Coefficient of `s³`.
    pub a: R,
    /// Of `s²`.
    pub b: R,
    /// Of `s`.
    pub c: R,
    /// The value at the entry.
    pub d: R,
}

impl<R: Real> Power<R> {
    /// The trilinear interpolant of `corners` along `segment`, by nested products of forms linear in `s`.
    #[inline(always)]
    pub fn along(corners: &[R; 8], segment: &Segment<R>) -> Self {
        let v = corners;
        let [px, py, pz] = segment.entry;
        let [dx, dy, dz] = std::array::from_fn(|a| segment.exit[a] - segment.entry[a]);
        // Along x the edges are linear in s, along y the faces quadratic, along z all is cubic.
        let edge = |n: usize| {
            let slope = v[n + 1] - v[n];
            [slope.fma(px, v[n]), slope * dx]
        };
        let face = |low: [R; 2], high: [R; 2]| {
            let e = [high[0] - low[0], high[1] - low[1]];
            [e[0].fma(py, low[0]), e[0].fma(dy, e[1].fma(py, low[1])), e[1] * dy]
        };
        let (low, high) = (face(edge(0), edge(2)), face(edge(4), edge(6)));
        let e: [R; 3] = std::array::from_fn(|n| high[n] - low[n]);
        Self {
            a: e[2] * dz,
            b: e[1].fma(dz, e[2].fma(pz, low[2])),
            c: e[0].fma(dz, e[1].fma(pz, low[1])),
            d: e[0].fma(pz, low[0]),
        }
    }
}

impl<R: Real> Polynomial<R> for Power<R> {
    #[inline]
    fn at(&self, s: R) -> R {
        self.a.fma(s, self.b).fma(s, self.c).fma(s, self.d)
    }

    #[inline]
    fn slope(&self, s: R) -> R {
        let a3 = R::splat(3.0) * self.a;
        a3.fma(s, self.b + self.b).fma(s, self.c)
    }

    #[inline]
    fn ends(&self) -> [R; 2] {
        [self.d, self.at(R::splat(1.0))]
    }

    /// Half the second derivative is linear: it is largest at an end.
    #[inline]
    fn half_bend(&self) -> R {
        self.b.abs().max(R::splat(3.0).fma(self.a, self.b).abs())
    }

    fn extrema(&self) -> [R; 2] {
        let largest = self.a.abs().max(self.b.abs()).max(self.c.abs());
        let scale = R::splat(1.0) / largest.max(R::splat(f32::MIN_POSITIVE.into()));
        let [a, b, c] = [R::splat(3.0) * self.a, self.b, self.c].map(|k| k * scale);
        extrema(a, b, c, b.fma(b, -(a * c)))
    }
}
