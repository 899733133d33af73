//! The antiderivative of the extinction.

use super::interval::Intervals;

/// Below this share of the antiderivative, a difference of two of its values is not used, but the integrals it is made of are added anew.
///
/// Each value is a compensated sum, within 2⁻⁵² of itself, and so the difference is within 2⁻⁵¹ of the larger one: where it is at least
/// 2⁻²⁵ of that, its relative error is at most 2⁻²⁶, a quarter of a rounding to `f32`.
const CANCELS: f64 = 1.0 / (1 << 25) as f64;

/// The integral of the extinction from the first control point to each interval between control points.
#[derive(Clone, Debug)]
pub(super) struct Antiderivative {
    /// Up to the low end of each interval; of the first, which has none, 0.
    sums: Vec<f64>,
}

impl Antiderivative {
    pub(super) fn new(intervals: &Intervals) -> Self {
        let [mut sum, mut lost] = [0.0; 2];
        let mut sums = vec![0.0];
        for n in 1..intervals.0.len() {
            sums.push(sum + lost);
            // Neumaier's summation; what is beyond the last control point is never asked for.
            let term = whole(intervals, n);
            let next: f64 = sum + term;
            lost += if sum >= term { (sum - next) + term } else { (term - next) + sum };
            sum = next;
        }
        Self { sums }
    }

    /// The mean extinction of the values between `s0` and `s1`.
    ///
    /// Within one interval that is the extinction in the middle: nothing cancels as `s1` tends to `s0`. Else it is the sum of what lies in
    /// the first interval, in the last, and between.
    pub(super) fn mean(&self, intervals: &Intervals, s0: f64, s1: f64) -> f64 {
        let [low, high] = if s0 < s1 { [s0, s1] } else { [s1, s0] };
        let [first, last] = [intervals.containing(low), intervals.containing(high)];
        if first == last {
            return extinction(intervals, first, low + 0.5 * (high - low));
        }
        let [above, below] = [intervals.0[first].high, intervals.0[last].low];
        let mut between = self.sums[last] - self.sums[first + 1];
        if between < CANCELS * self.sums[last] {
            between = (first + 1..last).map(|n| whole(intervals, n)).sum();
        }
        let part =
            |n: usize, from: f64, to: f64| (to - from) * extinction(intervals, n, from + 0.5 * (to - from));
        (part(first, low, above) + between + part(last, below, high)) / (high - low)
    }
}

fn extinction(intervals: &Intervals, interval: usize, value: f64) -> f64 {
    intervals.0[interval].at(value)[3]
}

/// The integral over an interval.
fn whole(intervals: &Intervals, interval: usize) -> f64 {
    let i = &intervals.0[interval];
    let width = i.high - i.low;
    width * extinction(intervals, interval, i.low + 0.5 * width)
}
