//! Pieces on which the value is a cubic.

use crate::fragment::{Fragment, Separated};
use crate::intervals::{Interval, Intervals};
use crate::leaf::{Leaf, Medium};
use crate::{Piece, TransferFunction};

/// Integrals of a transfer function over pieces of a ray on which the value is a cubic: cut where it passes a control point, so that the optical
/// depth is exact, with the colour at the mean value that is seen, to second order in the optical depth. No value is missed.
#[derive(Clone, Debug)]
pub struct CubicPieces {
    intervals: Intervals,
}

/// Cuts within cuts.
const MOST_CUTS: u32 = 40;

/// What has been put together, front to back.
#[derive(Default)]
struct Sum {
    transmittance: f64,
    front: [f64; 3],
    back: [f64; 3],
    /// How far on the piece it has come.
    done: f64,
}

impl CubicPieces {
    /// Prepares the integration of `transfer`.
    pub fn new(transfer: &TransferFunction) -> Self {
        Self { intervals: Intervals::new(transfer, 0.0) }
    }

    /// Opacity and colour of the piece of world length `length ≥ 0` on which the value has the Bernstein coefficients `value`.
    pub fn integrate(&self, value: [f64; 4], length: f64) -> Piece {
        let [low, high] = [f64::min, f64::max].map(|of| value.into_iter().reduce(of).unwrap_or(0.0) as f32);
        // Rounded to `f32`, the range may have lost a value.
        let intervals = match low < high {
            true => self.intervals.of_range(low.next_down(), high.next_up()),
            false => self.intervals.of_range(low, high),
        };
        let mut sum = Sum { transmittance: 1.0, ..Sum::default() };
        self.add(Fragment { value, lit: None, share: 1.0, intervals, cuts: 0 }, length, &mut sum);
        let single = |c: [f64; 3]| c.map(|c| c as f32);
        Piece { alpha: (1.0 - sum.transmittance) as f32, front: single(sum.front), back: single(sum.back) }
    }

    fn add(&self, mut fragment: Fragment<f64>, length: f64, sum: &mut Sum) {
        let is_last = fragment.cuts == MOST_CUTS;
        while fragment.intervals[0] < fragment.intervals[1] {
            match fragment.separate(&self.intervals, 0.0, is_last) {
                Separated::Narrowed(narrowed) => fragment = narrowed,
                Separated::Into(parts) => {
                    return parts.into_iter().for_each(|part| self.add(part, length, sum));
                }
            }
        }
        sum.add(&fragment, self.intervals.get(fragment.intervals[0]), length);
    }
}

impl Sum {
    fn add(&mut self, fragment: &Fragment<f64>, interval: &Interval, length: f64) {
        let medium = Medium {
            extinction: interval.extinction(0.0),
            extinction_error: 0.0,
            slope: interval.slope,
            steep: 0.0,
            length: length * fragment.share,
            rounding: 0.0,
        };
        let leaf = Leaf::new(fragment.value, &medium);
        // Where on the whole piece it is seen, on average.
        let place = self.done + fragment.share * leaf.place();
        let weight = self.transmittance * leaf.alpha;
        for (n, c) in interval.color(leaf.value).into_iter().enumerate() {
            self.front[n] += weight * c * (1.0 - place);
            self.back[n] += weight * c * place;
        }
        self.transmittance -= weight;
        self.done += fragment.share;
    }
}
