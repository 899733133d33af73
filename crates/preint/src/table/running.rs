//! Running compositions of units.

use crate::LinearPieces;

use super::TableAxes;
use crate::linear::Stretch;

/// Composable: linear RGB and alpha; then the first moments of both, in units of length from the front.
type Composite = [f64; 8];

/// Terms of the power series of a unit.
const TERMS: usize = 8;

/// The greatest depth for which the first `n + 1` terms leave out at most 10⁻⁸ of the depth. The series alternates: with `K` terms, what
/// is left out is at most the next, `D^(K + 1)/(K + 1)!` times the largest colour; so `D^K = 10⁻⁸·(K + 1)!`, rounded down.
const DEEPEST: [f64; TERMS] = [2e-8, 2.4e-4, 6.2e-3, 0.033, 0.093, 0.19, 0.32, 0.49];

/// Nodes of Gauss's rule with ten points on `[0, 1]` and their weights; exact to degree 19.
const GAUSS: [[f64; 2]; 10] = gauss([
    [0.148_874_338_981_631_22, 0.295_524_224_714_752_87],
    [0.433_395_394_129_247_2, 0.269_266_719_309_996_35],
    [0.679_409_568_299_024_4, 0.219_086_362_515_982_04],
    [0.865_063_366_688_984_5, 0.149_451_349_150_580_6],
    [0.973_906_528_517_171_7, 0.066_671_344_308_688_14],
]);

/// From the positive half of `[−1, 1]`.
const fn gauss(half: [[f64; 2]; 5]) -> [[f64; 2]; 10] {
    let mut all = [[0.0; 2]; 10];
    let mut n = 0;
    while n < 5 {
        let [node, weight] = half[n];
        all[2 * n] = [0.5 - 0.5 * node, 0.5 * weight];
        all[2 * n + 1] = [0.5 + 0.5 * node, 0.5 * weight];
        n += 1;
    }
    all
}

/// The part of a piece between two sampled values.
struct Unit {
    ends: [f64; 2],
    /// Mean extinction.
    extinction: f64,
    /// Coefficient `k` is `(−1)ᵏ/k!·∫₀¹ τ·w·tᵏ du`, where `t` is the integral of the extinction from the front and `w` the colour or 1, and
    /// `u` times that: times `λ^(k + 1)`, the terms of a unit of length `λ`.
    series: [Composite; TERMS],
}

impl Unit {
    fn new(pieces: &LinearPieces, ends: [f64; 2]) -> Self {
        let mut unit = Self { ends, extinction: 0.0, series: [[0.0; 8]; TERMS] };
        for stretch in pieces.stretches(ends[0], ends[1]) {
            unit.add(&stretch);
        }
        unit
    }

    /// The integrands are polynomials of degree at most 2 + 1 + 2·7 = 17, for which the rule is exact.
    fn add(&mut self, stretch: &Stretch) {
        let [from, to] = stretch.optics;
        for [u, weight] in GAUSS {
            let optics: [f64; 4] = std::array::from_fn(|n| from[n] * (1.0 - u) + to[n] * u);
            let place = stretch.way[0][1] * (1.0 - u) + stretch.way[1][1] * u;
            let before = u * (from[3] * (1.0 - 0.5 * u) + to[3] * (0.5 * u));
            let depth = self.extinction + stretch.share * before;
            let mut term = stretch.share * weight * optics[3];
            for (k, sums) in self.series.iter_mut().enumerate() {
                for (n, w) in [optics[0], optics[1], optics[2], 1.0].into_iter().enumerate() {
                    sums[n] += term * w;
                    sums[4 + n] += term * w * place;
                }
                term *= -depth / (k + 1) as f64;
            }
        }
        self.extinction += stretch.share * 0.5 * (from[3] + to[3]);
    }

    /// The unit at a length, by the first `terms` terms if they suffice.
    fn at(&self, pieces: &LinearPieces, length: f64, terms: usize) -> Composite {
        if self.extinction * length > DEEPEST[TERMS - 1] {
            let sums = pieces.sums(self.ends[0], self.ends[1], length);
            let [alpha, f0, f1, f2, b0, b1, b2] = sums.numbers();
            return [f0 + b0, f1 + b1, f2 + b2, alpha, b0, b1, b2, 0.0];
        }
        let mut sum = [0.0; 8];
        for coefficients in self.series[..terms].iter().rev() {
            for n in 0..8 {
                sum[n] = sum[n] * length + coefficients[n];
            }
        }
        sum.map(|x| x * length)
    }
}

/// `a` in front of `b`; `units` is the length of `a`.
#[inline(always)]
fn compose(a: &Composite, b: &Composite, units: f64) -> Composite {
    let left = 1.0 - a[3];
    let mut all = *a;
    for n in 0..4 {
        all[n] += left * b[n];
        all[4 + n] += left * (b[4 + n] + units * b[n]);
    }
    all
}

/// Compositions of all windows of consecutive units, in one direction.
pub(super) struct Running {
    units: Vec<Unit>,
    /// The greatest extinction of a unit for which the series may be used is found from those of all.
    extinctions: Vec<f64>,
    /// From a unit to the end of its block.
    ends: Vec<Composite>,
    /// From the beginning of its block to a unit.
    beginnings: Vec<Composite>,
}

impl Running {
    /// For values in the order of the axis, or from the last to the first.
    pub(super) fn new(pieces: &LinearPieces, axes: &TableAxes, falls: bool) -> Self {
        let value = |n: usize| axes.value(if falls { axes.values - 1 - n } else { n });
        let units: Vec<Unit> =
            (1..axes.values).map(|n| Unit::new(pieces, [value(n - 1), value(n)])).collect();
        let mut extinctions: Vec<f64> = units.iter().map(|u| u.extinction).collect();
        extinctions.sort_by(f64::total_cmp);
        let composites = vec![[0.0; 8]; units.len()];
        Self { units, extinctions, ends: composites.clone(), beginnings: composites }
    }

    /// Calls `entry` with the first unit of each window of `window` units and the window's alpha, front and back for a world length of
    /// `length`.
    pub(super) fn windows(
        &mut self,
        pieces: &LinearPieces,
        window: usize,
        length: f64,
        mut entry: impl FnMut(usize, [f64; 7]),
    ) {
        self.run(pieces, window, length / window as f64);
        let inverse = 1.0 / window as f64;
        for start in 0..=self.units.len() - window {
            let ahead = (window - start % window) % window;
            let all = if ahead == 0 {
                self.ends[start]
            } else {
                compose(&self.ends[start], &self.beginnings[start + window - 1], ahead as f64)
            };
            let [c0, c1, c2, alpha, x0, x1, x2, _] = all;
            let back = [x0, x1, x2].map(|x| x * inverse);
            entry(start, [alpha, c0 - back[0], c1 - back[1], c2 - back[2], back[0], back[1], back[2]]);
        }
    }

    /// Both running compositions within blocks of `window` units, each of length `length`.
    fn run(&mut self, pieces: &LinearPieces, window: usize, length: f64) {
        // The thickest of the units whose series is used.
        let thin = self.extinctions.partition_point(|e| e * length <= DEEPEST[TERMS - 1]);
        let depth = thin.checked_sub(1).map_or(0.0, |n| self.extinctions[n] * length);
        let terms = DEEPEST.iter().position(|&d| depth <= d).map_or(TERMS, |n| n + 1);
        for (n, unit) in self.units.iter().enumerate() {
            let composite = unit.at(pieces, length, terms);
            self.ends[n] = composite;
            self.beginnings[n] = match n % window {
                0 => composite,
                before => compose(&self.beginnings[n - 1], &composite, before as f64),
            };
        }
        for n in (0..self.units.len() - 1).rev() {
            if (n + 1) % window != 0 {
                self.ends[n] = compose(&self.ends[n], &self.ends[n + 1], 1.0);
            }
        }
    }
}
