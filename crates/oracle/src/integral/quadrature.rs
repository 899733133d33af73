//! Light gathered piece by piece, front to back.

use std::sync::LazyLock;

use super::OracleRadiance;
use super::pieces::Piece;
use super::shading::FactorAlong;

/// Nodes of a panel: with a depth of at most 1, its error is below 10⁻¹⁴ of its light.
const NODES: usize = 16;

/// Optical depth of a panel, at most.
const PANEL_DEPTH: f64 = 1.0;

/// Behind this optical depth, where the transmittance is 10⁻¹⁷, nothing is gathered.
const DARK: f64 = 39.2;

/// Difference between a panel and its halves that is tolerated, relative to what the piece can emit, where the shading is not a polynomial.
const TOLERANCE: f64 = 1e-13;

/// Relative rounding errors of a panel's light.
const ROUNDING: f64 = 1e-14;

/// Halvings of a panel, at most.
const MAX_HALVINGS: u32 = 50;

/// Nodes and weights of Gauss-Legendre quadrature on `[0, 1]`.
static RULE: LazyLock<[(f64, f64); NODES]> = LazyLock::new(|| std::array::from_fn(gauss_legendre));

/// Node `k` and its weight: Newton's method on the Legendre polynomial from its asymptotic root.
fn gauss_legendre(k: usize) -> (f64, f64) {
    const NEWTON_STEPS: u32 = 8;
    let n = NODES as f64;
    let mut x = (std::f64::consts::PI * (k as f64 + 0.75) / (n + 0.5)).cos();
    let mut slope = 1.0;
    for _ in 0..NEWTON_STEPS {
        let (mut before, mut value) = (1.0, x);
        for m in 2..=NODES {
            let m = m as f64;
            (before, value) = (value, ((2.0 * m - 1.0) * x * value - (m - 1.0) * before) / m);
        }
        slope = n * (before - x * value) / (1.0 - x * x);
        x -= value / slope;
    }
    (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
}

/// Light that has been gathered, and what lies before what is to come.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Light {
    pub(super) radiance: OracleRadiance,
}

impl Light {
    /// Adds the pieces of a stretch behind all that is there.
    pub(super) fn add(&mut self, pieces: &[Piece], factor: Option<&FactorAlong>) {
        for piece in pieces {
            self.add_piece(piece, factor);
        }
    }

    /// Adds a piece, panel by panel while it can be seen: where it is dense, what can be seen is a thin layer at its start.
    fn add_piece(&mut self, piece: &Piece, factor: Option<&FactorAlong>) {
        let whole = Panel::new(piece);
        let depth = whole.depth();
        if depth == 0.0 {
            return;
        }
        let (mut start, mut step, mut before) = (0.0, 1.0_f64, self.radiance.optical_depth);
        let tolerance = TOLERANCE * -(-depth).exp_m1() * factor.map_or(0.0, FactorAlong::largest);
        while start < 1.0 && before < DARK {
            let mut end = if step >= 1.0 - start { 1.0 } else { start + step };
            let mut panel = whole.between(start, end);
            while panel.depth() > PANEL_DEPTH && step > f64::MIN_POSITIVE {
                step = 0.5 * (end - start);
                end = start + step;
                panel = whole.between(start, end);
            }
            let transmittance = (-before).exp();
            let light = panel.light(factor, tolerance / transmittance);
            for (sum, light) in self.radiance.color.iter_mut().zip(light) {
                *sum += transmittance * light;
            }
            before += panel.depth();
            if end <= start {
                break;
            }
            start = end;
            step *= 2.0;
        }
        self.radiance.optical_depth += depth;
    }
}

/// A part of a piece.
#[derive(Clone, Copy, Debug)]
struct Panel<'a> {
    piece: &'a Piece,
    /// The fraction of the interval of the transfer function, by Bernstein coefficients.
    fraction: [f64; 4],
    /// Where it begins in the piece.
    start: f64,
    /// Length as a fraction of the piece.
    extent: f64,
    /// Length in world units.
    length: f64,
}

fn mix(a: f64, b: f64, x: f64) -> f64 {
    a * (1.0 - x) + b * x
}

impl<'a> Panel<'a> {
    /// All of a piece.
    fn new(piece: &'a Piece) -> Self {
        // Products of length and extinction must not overflow.
        const LARGEST_DEPTH: f64 = 1e300;
        let largest = piece.from.extinction.max(piece.to.extinction).max(1.0);
        let length = piece.length.min(LARGEST_DEPTH / largest);
        Self { piece, fraction: piece.fraction, start: 0.0, extent: 1.0, length }
    }

    /// The part between two parameters of this.
    fn between(&self, start: f64, end: f64) -> Self {
        if (start, end) == (0.0, 1.0) {
            return *self;
        }
        let [a, b, c, d] = self.fraction;
        let blossom = |u, v, w| {
            let (ab, bc, cd) = (mix(a, b, u), mix(b, c, u), mix(c, d, u));
            mix(mix(ab, bc, v), mix(bc, cd, v), w)
        };
        Self {
            piece: self.piece,
            fraction: [
                blossom(start, start, start),
                blossom(start, start, end),
                blossom(start, end, end),
                blossom(end, end, end),
            ],
            start: self.start + start * self.extent,
            extent: (end - start) * self.extent,
            length: (end - start) * self.length,
        }
    }

    /// Optical depth, exact but for rounding.
    fn depth(&self) -> f64 {
        self.length * self.piece.extinction(0.25 * self.fraction.iter().sum::<f64>())
    }

    /// Light emitted through the front, to about `tolerance`.
    fn light(&self, factor: Option<&FactorAlong>, tolerance: f64) -> [f64; 3] {
        let whole = self.quadrature(factor);
        if factor.is_none() { whole } else { self.refined(whole, factor, tolerance, MAX_HALVINGS) }
    }

    /// By halves until they agree with the whole.
    fn refined(
        &self,
        whole: [f64; 3],
        factor: Option<&FactorAlong>,
        tolerance: f64,
        halvings: u32,
    ) -> [f64; 3] {
        let [front, back] = [self.between(0.0, 0.5), self.between(0.5, 1.0)];
        let transmittance = (-front.depth()).exp();
        let [front_light, back_light] = [front.quadrature(factor), back.quadrature(factor)];
        let over = |front: [f64; 3], back: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|n| front[n] + transmittance * back[n])
        };
        let halves = over(front_light, back_light);
        let largest = self.piece.from.color.iter().chain(&self.piece.to.color).copied().fold(0.0, f64::max);
        // Beyond their own rounding errors, relative or of denormal numbers, halves need not agree.
        let allowed = |n: usize| (tolerance * largest).max(ROUNDING * halves[n]).max(f64::MIN_POSITIVE);
        let differ = (0..3).any(|n| (halves[n] - whole[n]).abs() > allowed(n));
        if !differ || halvings == 0 {
            return halves;
        }
        over(
            front.refined(front_light, factor, tolerance, halvings - 1),
            back.refined(back_light, factor, tolerance, halvings - 1),
        )
    }

    /// By quadrature, with the optical depth in front of each node exact.
    fn quadrature(&self, factor: Option<&FactorAlong>) -> [f64; 3] {
        let [a, b, c, d] = self.fraction;
        let (from, to) = (&self.piece.from.color, &self.piece.to.color);
        let mut light = [0.0; 3];
        for &(w, weight) in RULE.iter() {
            // The left of de Casteljau's triangle holds the coefficients from the start to here, whose mean gives the depth.
            let (ab, bc, cd) = (mix(a, b, w), mix(b, c, w), mix(c, d, w));
            let (abc, bcd) = (mix(ab, bc, w), mix(bc, cd, w));
            let fraction = mix(abc, bcd, w).clamp(0.0, 1.0);
            let depth = w * self.length * self.piece.extinction(0.25 * (a + ab + abc + fraction));
            let mut density = weight * self.length * self.piece.extinction(fraction) * (-depth).exp();
            if let Some(factor) = factor {
                density *= factor.at(self.piece.start + self.piece.extent * (self.start + w * self.extent));
            }
            for n in 0..3 {
                light[n] += density * mix(from[n], to[n], fraction);
            }
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_for_polynomials() {
        for power in 0..2 * NODES as i32 {
            let sum: f64 = RULE.iter().map(|&(x, weight)| weight * x.powi(power)).sum();
            let exact = 1.0 / f64::from(power + 1);
            assert!((sum - exact).abs() < 1e-15, "{power}: {sum}");
        }
    }
}
