//! The factor on the colour that the gradient makes.

use super::OracleStretch;
use super::cubic::quadratic_roots;
use crate::cell::gradient;

/// Shading by the gradient: the colour is multiplied with `ambient + diffuse·|g·L| + specular·min(1, |g·H|)^exponent`.
///
/// `g = ∇s / G` is the world-space gradient of the cell's interpolant over a fixed scale; both sides are lit alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OracleShading {
    /// What is there without light, at least 0.
    pub ambient: f64,
    /// Factor of `|g·L|`, at least 0.
    pub diffuse: f64,
    /// Factor of the highlight, at least 0.
    pub specular: f64,
    /// How narrow the highlight is, at least 0.
    pub exponent: f64,
    /// What the index-space gradient is multiplied with to give `g·L`: the transposed inverse of index-to-world is its adjoint, so this is
    /// world-to-index times `L`, over `G`.
    pub light: [f64; 3],
    /// The same for `g·H`, with `H` the direction half-way between those to the light and to the viewer.
    pub half: [f64; 3],
}

/// Whole exponents up to this are powers by multiplication, which is faster; its error is at most as many roundings.
const LARGEST_PRODUCT: f64 = 256.0;

/// The factor along a stretch: both products are quadratics, by Bernstein coefficients on `[0, 1]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct FactorAlong {
    shading: OracleShading,
    light: [f64; 3],
    half: [f64; 3],
}

impl FactorAlong {
    pub(super) fn new(shading: &OracleShading, stretch: &OracleStretch) -> Self {
        let base = stretch.corners[0];
        let corners = stretch.corners.map(|s| s - base);
        let at = |which: [[f64; 3]; 3]| gradient(&corners, std::array::from_fn(|axis| which[axis][axis]));
        let (a, b) = (stretch.entry, stretch.exit);
        // A component is bilinear in the two other coordinates: its polar form is the mean of both ways to take one from either end.
        let mixed = [[b, a, a], [a, b, a], [a, a, b]].map(at);
        let middle: [f64; 3] = std::array::from_fn(|n| 0.5 * (mixed[(n + 1) % 3][n] + mixed[(n + 2) % 3][n]));
        let along = [at([a; 3]), middle, at([b; 3])];
        let product = |v: [f64; 3]| along.map(|g| g[0] * v[0] + g[1] * v[1] + g[2] * v[2]);
        Self { shading: *shading, light: product(shading.light), half: product(shading.half) }
    }

    /// At parameter `u` of the stretch.
    pub(super) fn at(&self, u: f64) -> f64 {
        let OracleShading { ambient, diffuse, specular, exponent, .. } = self.shading;
        let mut factor = ambient + diffuse * quadratic(&self.light, u).abs();
        if specular != 0.0 {
            let highlight = quadratic(&self.half, u).abs().min(1.0);
            let is_small_integer = exponent.fract() == 0.0 && exponent <= LARGEST_PRODUCT;
            factor += specular
                * if is_small_integer { highlight.powi(exponent as i32) } else { highlight.powf(exponent) };
        }
        factor
    }

    /// An upper bound of the factor.
    pub(super) fn largest(&self) -> f64 {
        let light = self.light.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        self.shading.ambient + self.shading.diffuse * light + self.shading.specular
    }

    /// Where the factor is not smooth, or nearly not: zeros and extrema of both products, and where the highlight saturates.
    pub(super) fn cuts(&self) -> impl Iterator<Item = f64> + use<> {
        let shifted = |q: [f64; 3], by: f64| quadratic_roots(q.map(|c| c - by));
        let vertex = |[a, b, c]: [f64; 3]| (a - b) / ((a - b) + (c - b));
        let has_light = self.shading.diffuse != 0.0;
        let has_half = self.shading.specular != 0.0;
        let light = [shifted(self.light, 0.0), [vertex(self.light), f64::NAN]];
        let half = [-1.0, 0.0, 1.0].map(|level| shifted(self.half, level));
        let half_vertex = [[vertex(self.half), f64::NAN]];
        let light = light.into_iter().filter(move |_| has_light);
        let half = half.into_iter().chain(half_vertex).filter(move |_| has_half);
        light.chain(half).flatten()
    }
}

fn quadratic([a, b, c]: &[f64; 3], u: f64) -> f64 {
    let v = 1.0 - u;
    (a * v + b * u) * v + (b * v + c * u) * u
}
