//! LDR-ꟻLIP: how different two pictures look that are shown in turn (P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild:
//! "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), article 15, 2020, doi:10.1145/3406183).
//!
//! Both pictures are filtered by what the eye resolves, in a space of opponent colours; what is left of their difference is a distance in L*a*b* (the *colour
//! pipeline*). Where edges or points are in one picture alone it counts for more (the *feature pipeline*).
//!
//! Written from the paper's formulas, in double precision.

use std::array;

use glam::{DMat3, DVec3};

/// Pixels per degree of the field of view: the paper's observer, 0.7 m before a display 0.7 m and 3840 pixels wide, rounded as in the paper.
const PER_DEGREE: f64 = 67.0;

/// Contrast sensitivity as sums of Gaussians `a·√(π/b)·exp(−π²x²/b)`, x in degrees: achromatic, red and green, blue and yellow; `[a, b]`.
const SENSITIVITY: [&[[f64; 2]]; 3] = [&[[1.0, 0.0047]], &[[1.0, 0.0053]], &[[34.1, 0.04], [13.5, 0.025]]];
/// The widest of them.
const WIDEST: f64 = 0.04;
/// Width of an edge or a point that is seen, in degrees.
const FEATURE: f64 = 0.082;

/// Exponents that compress differences of colours and of features.
const COLOR_EXPONENT: f64 = 0.7;
const FEATURE_EXPONENT: f64 = 0.5;
/// Where the map of compressed differences to 0…1 has its bend: a share of the largest, and what that becomes.
const BEND: [f64; 2] = [0.4, 0.95];

/// Rows of the map from linear sRGB to XYZ (IEC 61966-2-1).
const TO_XYZ: [[f64; 3]; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];

/// The difference at every pixel, from 0 to 1, of two pictures of 8-bit sRGB.
pub(crate) fn flip(size: [u32; 2], reference: &[u8], test: &[u8]) -> Vec<f64> {
    let spaces = Spaces::new();
    let [reference, test] = [reference, test].map(|rgb| Seen::new(size, rgb, &spaces));
    let largest = spaces.largest();
    let pairs = reference.pixels.iter().zip(&test.pixels);
    let one = |(a, b): (&SeenPixel, &SeenPixel)| {
        let color = redistributed(distance(a.lab, b.lab).powf(COLOR_EXPONENT), largest);
        let most = (a.edge - b.edge).abs().max((a.point - b.point).abs());
        let feature = (most / 2f64.sqrt()).powf(FEATURE_EXPONENT);
        color.powf(1.0 - feature)
    };
    pairs.map(one).collect()
}

/// The spaces of colours that are gone through.
struct Spaces {
    to_xyz: DMat3,
    to_rgb: DMat3,
    white: DVec3,
    decoded: [f64; 256],
}

impl Spaces {
    fn new() -> Self {
        let to_xyz = DMat3::from_cols_array_2d(&TO_XYZ).transpose();
        let decode = |n: usize| {
            let c = n as f64 / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        Self { to_xyz, to_rgb: to_xyz.inverse(), white: to_xyz * DVec3::ONE, decoded: array::from_fn(decode) }
    }

    /// Linearised opponent colours, Y, Cx and Cz, of linear sRGB.
    fn opponent(&self, rgb: DVec3) -> DVec3 {
        let v = self.to_xyz * rgb / self.white;
        DVec3::new(116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z))
    }

    /// The reverse.
    fn of_opponent(&self, ycc: DVec3) -> DVec3 {
        let y = (ycc.x + 16.0) / 116.0;
        self.to_rgb * (DVec3::new(y + ycc.y / 500.0, y, y - ycc.z / 200.0) * self.white)
    }

    /// L*a*b* of linear sRGB, colours the weaker the darker they are (Hunt's effect).
    fn lab(&self, rgb: DVec3) -> DVec3 {
        const BEND: f64 = 6.0 / 29.0;
        let f = |c: f64| if c > BEND.powi(3) { c.cbrt() } else { c / (3.0 * BEND * BEND) + 4.0 / 29.0 };
        let v = (self.to_xyz * rgb / self.white).to_array().map(f);
        let lightness = 116.0 * v[1] - 16.0;
        let hunt = 0.01 * lightness;
        DVec3::new(lightness, hunt * 500.0 * (v[0] - v[1]), hunt * 200.0 * (v[1] - v[2]))
    }

    /// The largest compressed difference: of green and blue.
    fn largest(&self) -> f64 {
        distance(self.lab(DVec3::Y), self.lab(DVec3::Z)).powf(COLOR_EXPONENT)
    }
}

/// HyAB: by lightness, and by what is left, each as one sees it alone.
fn distance(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// To 0…1, most of it for differences that are small.
fn redistributed(difference: f64, largest: f64) -> f64 {
    let bend = BEND[0] * largest;
    match difference < bend {
        true => BEND[1] * difference / bend,
        false => BEND[1] + (1.0 - BEND[1]) * (difference - bend) / (largest - bend),
    }
}

/// What is seen of a picture.
struct Seen {
    pixels: Vec<SeenPixel>,
}

struct SeenPixel {
    lab: DVec3,
    edge: f64,
    point: f64,
}

impl Seen {
    fn new(size: [u32; 2], rgb: &[u8], spaces: &Spaces) -> Self {
        let opponent = |p: &[u8]| {
            let linear: [f64; 3] = array::from_fn(|n| spaces.decoded[usize::from(p[n])]);
            spaces.opponent(linear.into())
        };
        let opponent: Vec<DVec3> = rgb.chunks_exact(3).map(opponent).collect();
        let plane = |f: &dyn Fn(&DVec3) -> f64| -> Vec<f64> { opponent.iter().map(f).collect() };
        let filters = SENSITIVITY.map(sensitivity);
        let [y, cx, cz] =
            array::from_fn(|n| filters[n].over(size, &plane(&|color: &DVec3| color.to_array()[n])));
        let lightness = plane(&|color| (color.x + 16.0) / 116.0);
        let [edges, points] = [1, 2].map(feature).map(|filter| {
            let [x, y] = [filter.over(size, &lightness), filter.transposed().over(size, &lightness)];
            x.into_iter().zip(y).map(|(x, y)| x.hypot(y)).collect::<Vec<f64>>()
        });
        let pixel = |n: usize| SeenPixel {
            lab: spaces
                .lab(spaces.of_opponent(DVec3::new(y[n], cx[n], cz[n])).clamp(DVec3::ZERO, DVec3::ONE)),
            edge: edges[n],
            point: points[n],
        };
        Self { pixels: (0..opponent.len()).map(pixel).collect() }
    }
}

/// A square of weights around a pixel.
struct Filter {
    radius: i64,
    weights: Vec<f64>,
}

impl Filter {
    fn of(radius: i64, weight: impl Fn(f64, f64) -> f64) -> Self {
        let along = -radius..=radius;
        let weights = along.clone().flat_map(|y| along.clone().map(move |x| [x as f64, y as f64]));
        Self { radius, weights: weights.map(|[x, y]| weight(x, y)).collect() }
    }

    /// With positive weights that make 1 together, and negative ones that make −1.
    fn normalised(mut self) -> Self {
        let sum = |sign: f64| self.weights.iter().map(|w| (sign * w).max(0.0)).sum::<f64>();
        let [positive, negative] = [sum(1.0), sum(-1.0)];
        self.weights
            .iter_mut()
            .for_each(|w| *w /= if *w > 0.0 { positive } else { negative.max(f64::MIN_POSITIVE) });
        self
    }

    fn transposed(&self) -> Self {
        let edge = 2 * self.radius as usize + 1;
        let weights = (0..edge * edge).map(|n| self.weights[n % edge * edge + n / edge]).collect();
        Self { radius: self.radius, weights }
    }

    /// The picture filtered; what is beyond its border is as at the border.
    fn over(&self, [width, height]: [u32; 2], of: &[f64]) -> Vec<f64> {
        let [width, height] = [i64::from(width), i64::from(height)];
        let edge = 2 * self.radius + 1;
        // With the border, so that rows of weights meet rows of pixels.
        let padded: Vec<f64> = (-self.radius..height + self.radius)
            .flat_map(|y| {
                let row = y.clamp(0, height - 1) * width;
                (-self.radius..width + self.radius).map(move |x| of[(row + x.clamp(0, width - 1)) as usize])
            })
            .collect();
        let pixel = |n: i64| {
            let rows = (0..edge).map(|dy| {
                let begin = ((n / width + dy) * (width + edge - 1) + n % width) as usize;
                let weights = &self.weights[(dy * edge) as usize..];
                let row = padded[begin..begin + edge as usize].iter();
                row.zip(weights).map(|(value, weight)| value * weight).sum::<f64>()
            });
            rows.sum()
        };
        (0..width * height).map(pixel).collect()
    }
}

/// A filter of contrast sensitivity; all have the radius of the widest.
fn sensitivity(gaussians: &[[f64; 2]]) -> Filter {
    use std::f64::consts::PI;
    let deviation = (WIDEST / (2.0 * PI * PI)).sqrt();
    let radius = (3.0 * deviation * PER_DEGREE).ceil() as i64;
    let weight = |x: f64, y: f64| {
        let square = (x * x + y * y) / (PER_DEGREE * PER_DEGREE);
        gaussians.iter().map(|[a, b]| a * (PI / b).sqrt() * (-PI * PI * square / b).exp()).sum()
    };
    Filter::of(radius, weight).normalised()
}

/// A filter that finds edges (the first derivative of a Gaussian along x) or points (the second).
fn feature(derivative: u32) -> Filter {
    let deviation = 0.5 * FEATURE * PER_DEGREE;
    let square = deviation * deviation;
    let weight = |x: f64, y: f64| {
        let gaussian = (-(x * x + y * y) / (2.0 * square)).exp();
        gaussian * if derivative == 1 { -x } else { x * x / square - 1.0 }
    };
    Filter::of((3.0 * deviation).ceil() as i64, weight).normalised()
}

#[cfg(test)]
mod tests;
