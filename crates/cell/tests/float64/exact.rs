//! The same formulas in `f64`, from their definitions; its own errors are 10⁻⁹ of those under test.

use isoray_cell::Segment;

pub(crate) fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

/// The trilinear interpolant.
pub(crate) fn trilinear(c: &[f64; 8], [x, y, z]: [f64; 3]) -> f64 {
    let along_x = |n: usize| lerp(c[n], c[n + 1], x);
    let along_y = |n: usize| lerp(along_x(n), along_x(n + 2), y);
    lerp(along_y(0), along_y(4), z)
}

/// Its gradient: along each axis, the difference of its values on the two faces across it.
pub(crate) fn gradient(c: &[f64; 8], p: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let on_face = |side: f64| {
            let mut q = p;
            q[axis] = side;
            trilinear(c, q)
        };
        on_face(1.0) - on_face(0.0)
    })
}

/// A cubic by its Bernstein coefficients.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cubic(pub(crate) [f64; 4]);

impl Cubic {
    /// The interpolant along a segment: coefficient `n` is the mean of its values at those corners of the box which the end points
    /// span that take `n` coordinates from the exit.
    pub(crate) fn along(c: &[f64; 8], segment: &Segment) -> Self {
        let mut sums = [0.0; 4];
        for mask in 0..8_usize {
            let from = |axis: usize| if mask >> axis & 1 == 1 { segment.exit } else { segment.entry };
            sums[mask.count_ones() as usize] +=
                trilinear(c, std::array::from_fn(|axis| f64::from(from(axis)[axis])));
        }
        Self([sums[0], sums[1] / 3.0, sums[2] / 3.0, sums[3]])
    }

    /// De Casteljau's algorithm.
    pub(crate) fn at(self, s: f64) -> f64 {
        let [a, b, c, d] = self.0;
        let (ab, bc, cd) = (lerp(a, b, s), lerp(b, c, s), lerp(c, d, s));
        lerp(lerp(ab, bc, s), lerp(bc, cd, s), s)
    }

    /// The least `s` in `[0, 1]` at which the value is at most `level`; `s` is exact to 10⁻¹².
    pub(crate) fn first_at_most(self, level: f64) -> Option<f64> {
        let [a, b, c, d] = self.0;
        // The derivative is 3·(p·s² + 2q·s + r).
        let (p, q, r) = (d - 3.0 * c + 3.0 * b - a, c - 2.0 * b + a, b - a);
        let root = (q * q - p * r).max(0.0).sqrt();
        let stable = -(q + root.copysign(q));
        let mut ends = [0.0, stable / p, r / stable, 1.0]
            .map(|s: f64| if s.is_finite() { s.clamp(0.0, 1.0) } else { 0.0 });
        ends.sort_by(f64::total_cmp);
        if a <= level {
            return Some(0.0);
        }
        let piece = ends.windows(2).find(|w| self.at(w[1]) <= level)?;
        let (mut above, mut below) = (piece[0], piece[1]);
        for _ in 0..50 {
            let middle = 0.5 * (above + below);
            if self.at(middle) <= level { below = middle } else { above = middle }
        }
        Some(below)
    }
}
