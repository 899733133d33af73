//! Mean, variances and covariances along a segment, in closed form from Bernstein coefficients.
//!
//! With `z = x − ½` on `[−½, ½]` and expectations over the segment's parameter, `E[z²] = 1/12`, `E[z⁴] = 1/80`, `E[z⁶] = 1/448`.

use isoray_cell::Real;

/// A cubic along a segment: `mean + odd part + even part`, both of mean zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CubicMoments<R> {
    pub(crate) mean: R,
    /// Covariance with the parameter.
    pub(crate) along: R,
    /// Deviation of the even part: it is this times `3x(1 − x)`, less its mean.
    bulge: R,
    pub(crate) odd_variance: R,
    pub(crate) even_variance: R,
}

impl<R: Real> CubicMoments<R> {
    #[inline(always)]
    pub(crate) fn new([b0, b1, b2, b3]: [R; 4]) -> Self {
        let half = R::splat(0.5);
        let (ends, inner) = (b0 + b3, b1 + b2);
        let (o0, o1) = ((b3 - b0) * half, (b2 - b1) * half);
        // The odd part is a·z + c·z³.
        let a = R::splat(1.5) * (o0 + o1);
        let c = R::splat(2.0).fma(o0, R::splat(-6.0) * o1);
        let bulge = (inner - ends) * half;
        let [twelfth, fortieth, least] = [1.0 / 12.0, 1.0 / 40.0, 1.0 / 448.0].map(R::splat);
        Self {
            mean: (ends + inner) * R::splat(0.25),
            along: a.fma(twelfth, c * fortieth * half),
            bulge,
            odd_variance: a.fma(a.fma(twelfth, c * fortieth), c * c * least),
            even_variance: bulge * bulge * R::splat(0.05),
        }
    }

    /// Variance along the segment.
    #[inline(always)]
    pub(crate) fn variance(&self) -> R {
        self.odd_variance + self.even_variance
    }

    /// Covariance with a quadratic.
    #[inline(always)]
    pub(crate) fn covariance(&self, q: &QuadraticMoments<R>) -> R {
        q.slope.fma(self.along, self.bulge * q.bulge * R::splat(1.0 / 30.0))
    }
}

/// A quadratic along a segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadraticMoments<R> {
    pub(crate) mean: R,
    /// The odd part is this times `z`.
    slope: R,
    /// The even part is this times `2x(1 − x)`, less its mean.
    bulge: R,
}

impl<R: Real> QuadraticMoments<R> {
    #[inline(always)]
    pub(crate) fn new([q0, q1, q2]: [R; 3]) -> Self {
        let ends = q0 + q2;
        Self { mean: (ends + q1) * R::splat(1.0 / 3.0), slope: q2 - q0, bulge: R::splat(-0.5).fma(ends, q1) }
    }

    /// Covariance with the parameter.
    #[inline(always)]
    pub(crate) fn along(&self) -> R {
        self.slope * R::splat(1.0 / 12.0)
    }

    /// Variance along the segment.
    #[inline(always)]
    pub(crate) fn variance(&self) -> R {
        let even = self.bulge * self.bulge * R::splat(1.0 / 45.0);
        (self.slope * R::splat(1.0 / 12.0)).fma(self.slope, even)
    }
}

#[cfg(test)]
mod tests {
    use isoray_oracle::SplitMix64;

    use super::*;

    /// Simpson's rule is exact for cubics only; a fine one does for the rest.
    fn mean(f: impl Fn(f64) -> f64) -> f64 {
        const N: u32 = 600;
        let weight = |n: u32| if n == 0 || n == N { 1.0 } else { f64::from(2 + 2 * (n % 2)) };
        (0..=N).map(|n| weight(n) * f(f64::from(n) / f64::from(N))).sum::<f64>() / (3.0 * f64::from(N))
    }

    #[test]
    fn moments_are_those_of_the_polynomials() {
        let mut random = SplitMix64::new(1);
        for _ in 0..200 {
            let b: [f64; 4] = std::array::from_fn(|_| random.range(-1.0, 1.0));
            let q: [f64; 3] = std::array::from_fn(|_| random.range(-1.0, 1.0));
            let cubic = |x: f64| {
                let y = 1.0 - x;
                y * y * y * b[0] + 3.0 * x * y * y * b[1] + 3.0 * x * x * y * b[2] + x * x * x * b[3]
            };
            let quadratic = |x: f64| (1.0 - x) * (1.0 - x) * q[0] + 2.0 * x * (1.0 - x) * q[1] + x * x * q[2];
            let (s, p) = (CubicMoments::new(b), QuadraticMoments::new(q));
            let [ms, mp] = [mean(cubic), mean(quadratic)];
            let even = |x: f64| (cubic(x) + cubic(1.0 - x)) / 2.0 - ms;
            let found = [
                s.mean - ms,
                s.along - mean(|x| cubic(x) * (x - 0.5)),
                s.variance() - mean(|x| (cubic(x) - ms).powi(2)),
                s.even_variance - mean(|x| even(x).powi(2)),
                p.mean - mp,
                p.along() - mean(|x| quadratic(x) * (x - 0.5)),
                p.variance() - mean(|x| (quadratic(x) - mp).powi(2)),
                s.covariance(&p) - mean(|x| (cubic(x) - ms) * (quadratic(x) - mp)),
            ];
            assert!(found.iter().all(|e| e.abs() < 1e-9), "{found:?}");
        }
    }
}
