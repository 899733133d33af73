//! Integration of a stretch on which extinction and colour are linear.

use super::{
    LinearPieces,
    interval::{Stretch, mix},
};
use crate::Piece;

/// Nodes of Gauss's rule with six points on `[0, 1]` and their weights.
const GAUSS: [[f64; 2]; 6] = [
    [0.033_765_242_898_423_99, 0.085_662_246_189_585_17],
    [0.169_395_306_766_867_74, 0.180_380_786_524_069_3],
    [0.380_690_406_958_401_55, 0.233_956_967_286_345_52],
    [0.619_309_593_041_598_4, 0.233_956_967_286_345_52],
    [0.830_604_693_233_132_3, 0.180_380_786_524_069_3],
    [0.966_234_757_101_576, 0.085_662_246_189_585_17],
];

/// The part of a piece that has been integrated.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    /// Optical depth.
    pub(crate) depth: f64,
    pub(crate) front: [f64; 3],
    pub(crate) back: [f64; 3],
}

impl Sums {
    pub(crate) fn alpha(&self) -> f64 {
        -(-self.depth).exp_m1()
    }

    /// Alpha, front and back.
    pub(crate) fn numbers(&self) -> [f64; 7] {
        let [f, b] = [self.front, self.back];
        [self.alpha(), f[0], f[1], f[2], b[0], b[1], b[2]]
    }

    pub(crate) fn piece(&self) -> Piece {
        let round = |x: [f64; 3]| x.map(|x| x as f32);
        Piece { alpha: self.alpha() as f32, front: round(self.front), back: round(self.back) }
    }

    /// Adds what follows, `length` being that of the whole piece. Whether anything behind it can still be seen.
    pub(super) fn add(&mut self, mut stretch: Stretch, length: f64) -> bool {
        for cut in LinearPieces::DEPTHS {
            if cut <= self.depth {
                continue;
            }
            let [low, high] = stretch.optics.map(|o| o[3] * stretch.share * length);
            let depth = 0.5 * (low + high);
            let wanted = cut - self.depth;
            if depth <= wanted {
                self.add_part(&stretch, [low, high]);
                return true;
            }
            // Where low·u + (high − low)·u²/2 = wanted, in the form that does not cancel; the depth at 1 is more.
            let root = (low * low + 2.0 * (high - low) * wanted).max(0.0).sqrt();
            let u = (2.0 * wanted / (low + root)).min(1.0);
            let (before, after) = cut_at(&stretch, u);
            let ends = before.optics.map(|o| o[3] * before.share * length);
            self.add_part(&before, ends);
            self.depth = cut;
            stretch = after;
        }
        false
    }

    /// Adds a stretch whose extinction times its length runs from `low` to `high`.
    fn add_part(&mut self, stretch: &Stretch, [low, high]: [f64; 2]) {
        let depth = 0.5 * (low + high);
        let opacity = -(-depth).exp_m1();
        // Integrals of 1 − E and u·(1 − E).
        let [mut sum, mut weighted] = [0.0; 2];
        for [u, weight] in GAUSS {
            let term = weight * -(-u * (low * (1.0 - 0.5 * u) + high * (0.5 * u))).exp_m1();
            sum += term;
            weighted += u * term;
        }
        let transmittance = (-self.depth).exp();
        // Integrals of −dE with the weights (1 − u)², u·(1 − u) and u².
        let [front, middle, back] = [2.0 * (sum - weighted), 2.0 * weighted - sum, opacity - 2.0 * weighted]
            .map(|x| x * transmittance);
        let [from, to] = stretch.optics;
        let [[left, behind], [left_after, behind_after]] = stretch.way;
        for n in 0..3 {
            let before = from[n] * front + to[n] * middle;
            let after = from[n] * middle + to[n] * back;
            self.front[n] += left * before + left_after * after;
            self.back[n] += behind * before + behind_after * after;
        }
        self.depth += depth;
    }
}

/// The two parts of a stretch on either side of `u`.
fn cut_at(stretch: &Stretch, u: f64) -> (Stretch, Stretch) {
    let weights = [1.0 - u, u];
    let [from, to] = stretch.optics;
    let [way_from, way_to] = stretch.way;
    let (optics, way) = (mix(from, to, weights), mix(way_from, way_to, weights));
    let before = Stretch { share: stretch.share * u, way: [way_from, way], optics: [from, optics] };
    let after = Stretch { share: stretch.share * (1.0 - u), way: [way, way_to], optics: [optics, to] };
    (before, after)
}
