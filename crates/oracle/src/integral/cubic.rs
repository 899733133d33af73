//! The field along a straight stretch through a cell: a cubic.

use super::OracleStretch;
use crate::Number;

/// The field less its value at corner 0 along a stretch, by Bernstein coefficients on `[0, 1]`.
///
/// The corner is subtracted first, so that errors are a few roundings of the variation of the field in the cell, not of its magnitude;
/// a constant field is exactly zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic<N> {
    bernstein: [N; 4],
    /// The value at corner 0.
    base: f64,
    /// The largest magnitude of a corner's value less the base.
    variation: f64,
}

/// At most: 1 rounding of a difference, 9 of three interpolations, 3 of a mean, 12 of de Casteljau's algorithm.
const ERROR_ROUNDOFFS: f64 = 25.0;

fn lerp<N: Number>(a: N, b: N, u: N) -> N {
    a * (N::from(1.0) - u) + b * u
}

impl<N: Number> Cubic<N> {
    /// Coefficient `n` is the mean of the field at those corners of the box spanned by both ends that take `n` coordinates from the exit.
    pub(super) fn new(stretch: &OracleStretch) -> Self {
        let base = stretch.corners[0];
        let corners = stretch.corners.map(|s| N::from(s) - N::from(base));
        let ends = [stretch.entry, stretch.exit].map(|end| end.map(N::from));
        // Indexed by where each interpolated coordinate comes from: 0 the entry, 1 the exit.
        let x: [[N; 4]; 2] = ends
            .map(|end| std::array::from_fn(|edge| lerp(corners[2 * edge], corners[2 * edge + 1], end[0])));
        let y = x.map(|x| ends.map(|end| [lerp(x[0], x[1], end[1]), lerp(x[2], x[3], end[1])]));
        let xyz = |a: usize, b: usize, c: usize| lerp(y[a][b][0], y[a][b][1], ends[c][2]);
        let three = N::from(3.0);
        let bernstein = [
            xyz(0, 0, 0),
            (xyz(1, 0, 0) + xyz(0, 1, 0) + xyz(0, 0, 1)) / three,
            (xyz(0, 1, 1) + xyz(1, 0, 1) + xyz(1, 1, 0)) / three,
            xyz(1, 1, 1),
        ];
        let variation = stretch.corners.iter().fold(0.0, |v: f64, s| v.max((s - base).abs()));
        Self { bernstein, base, variation }
    }

    /// Bound of the error of a value.
    pub(super) fn error(&self) -> f64 {
        ERROR_ROUNDOFFS * N::ROUNDOFF * self.variation
    }

    /// A value of the field as a level of the cubic.
    pub(super) fn level(&self, value: f64) -> N {
        N::from(value) - N::from(self.base)
    }

    /// By de Casteljau's algorithm.
    pub(super) fn at(&self, u: N) -> N {
        self.blossom(u, u, u)
    }

    /// The polar form: symmetric, linear in each argument, the cubic itself where they are equal.
    fn blossom(&self, u: N, v: N, w: N) -> N {
        let [a, b, c, d] = self.bernstein;
        let (ab, bc, cd) = (lerp(a, b, u), lerp(b, c, u), lerp(c, d, u));
        lerp(lerp(ab, bc, v), lerp(bc, cd, v), w)
    }

    /// The coefficients on `[u0, u1]` of the field less `value`.
    pub(super) fn between(&self, u0: N, u1: N, value: f64) -> [f64; 4] {
        let level = self.level(value);
        let shifted = Self { bernstein: self.bernstein.map(|b| b - level), ..*self };
        [
            shifted.blossom(u0, u0, u0),
            shifted.blossom(u0, u0, u1),
            shifted.blossom(u0, u1, u1),
            shifted.blossom(u1, u1, u1),
        ]
        .map(N::to_f64)
    }

    /// The derivative, in `f64`.
    pub(super) fn slope(&self, u: f64) -> f64 {
        let [a, b, c, d] = self.bernstein;
        let [a, b, c] = [b - a, c - b, d - c].map(|step| 3.0 * step.to_f64());
        lerp(lerp(a, b, u), lerp(b, c, u), u)
    }

    /// Parameters that contain the cubic's extrema; infinite or NaN where there are fewer than two.
    ///
    /// An error in one of them changes the value there by its square only.
    pub(super) fn extrema(&self) -> [f64; 2] {
        let [a, b, c, d] = self.bernstein;
        quadratic_roots([b - a, c - b, d - c].map(N::to_f64))
    }

    /// Where a monotone piece of the cubic passes `level`, which lies between its values at `low` and `high`.
    ///
    /// Newton's method, by halves wherever a step leaves the bracket or steps do not shrink. It ends when the value and the step are
    /// within one roundoff, a step is below the roundoff of the parameter, or nothing lies between the ends of the bracket.
    pub(super) fn crossing(&self, level: N, mut low: N, mut high: N) -> N {
        const MAX_STEPS: u32 = 300;
        let half = N::from(0.5);
        let rising = self.at(high) > level;
        let mut u = half * (low + high);
        let mut steps = [(high - low).to_f64(); 2];
        for _ in 0..MAX_STEPS {
            let excess = self.at(u) - level;
            let step = excess.to_f64() / self.slope(u.to_f64());
            let is_level = excess.to_f64().abs() <= N::ROUNDOFF * self.variation;
            if excess == N::from(0.0) || is_level && step.abs() <= N::ROUNDOFF {
                break;
            }
            if (excess > N::from(0.0)) == rising {
                high = u
            } else {
                low = u
            }
            let newton = u - N::from(if step.is_finite() { step } else { 0.0 });
            let shrinks = step.abs() < 0.5 * steps[0];
            let is_last = step.abs() <= N::ROUNDOFF * u.to_f64().abs();
            let next = if shrinks && newton >= low && newton <= high { newton } else { half * (low + high) };
            steps = [steps[1], (next - u).to_f64().abs()];
            if is_last || next == u || next < low || next > high {
                break;
            }
            u = next;
        }
        u
    }
}

/// The real roots of a quadratic of Bernstein coefficients on `[0, 1]`, in the form that subtracts no nearly equal numbers; NaN or
/// infinite where there are fewer. A slightly negative discriminant counts as zero, so that double roots are not lost.
pub(super) fn quadratic_roots(bernstein: [f64; 3]) -> [f64; 2] {
    let scale = bernstein.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    if !(scale > 0.0 && scale.is_finite()) {
        return [f64::NAN; 2];
    }
    let [p, q, r] = bernstein.map(|c| c / scale);
    // a·u² + 2·b·u + p
    let (a, b) = ((r - q) - (q - p), q - p);
    let root = (b * b - a * p).max(0.0).sqrt();
    let stable = -(b + root.copysign(b));
    [stable / a, p / stable]
}
