//! Intervals of values on which the transfer function is linear.

use crate::{ControlPoint, TransferFunction};

/// Linear RGB and, last, extinction.
pub(super) type Optics = [f64; 4];

/// `a` at 0 and `b` at 1, by positive weights.
pub(crate) fn mix<const N: usize>(a: [f64; N], b: [f64; N], [before, after]: [f64; 2]) -> [f64; N] {
    std::array::from_fn(|n| a[n] * before + b[n] * after)
}

/// Values from `low` to less than `high`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    pub(super) low: f64,
    pub(super) high: f64,
    /// At `low` and at `high`.
    ends: [Optics; 2],
}

impl Interval {
    /// At a value within the interval: relative error of a few roundings, since no difference of optics is taken.
    pub(super) fn at(&self, value: f64) -> Optics {
        let width = self.high - self.low;
        if width.is_infinite() {
            return self.ends[0];
        }
        mix(self.ends[0], self.ends[1], [(self.high - value) / width, (value - self.low) / width])
    }
}

/// The part of a piece within one interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// Share of the piece's length.
    pub(crate) share: f64,
    /// What is left of the way to the back and what is behind, from 0 to 1, at both ends.
    pub(crate) way: [[f64; 2]; 2],
    /// At both ends.
    pub(crate) optics: [Optics; 2],
}

/// All values, cut at the control points.
#[derive(Clone, Debug)]
pub(super) struct Intervals(pub(super) Vec<Interval>);

impl Intervals {
    pub(super) fn new(transfer: &TransferFunction) -> Self {
        let optics = |p: &ControlPoint| [p.color[0], p.color[1], p.color[2], p.extinction].map(f64::from);
        let points = transfer.points();
        let mut intervals = Vec::with_capacity(points.len() + 1);
        if let Some(first) = points.first() {
            let ends = [optics(first); 2];
            intervals.push(Interval { low: f64::NEG_INFINITY, high: first.value.into(), ends });
        }
        for pair in points.windows(2) {
            // A step has no values in between.
            if pair[0].value < pair[1].value {
                let [low, high] = [pair[0].value.into(), pair[1].value.into()];
                intervals.push(Interval { low, high, ends: [optics(&pair[0]), optics(&pair[1])] });
            }
        }
        if let Some(last) = points.last() {
            intervals.push(Interval { low: last.value.into(), high: f64::INFINITY, ends: [optics(last); 2] });
        }
        Self(intervals)
    }

    /// The index of the interval that `value` lies in.
    pub(super) fn containing(&self, value: f64) -> usize {
        self.0.partition_point(|i| i.low <= value).saturating_sub(1)
    }

    /// The parts of the piece from `s0` to `s1`, in order; the lengths of all are positive.
    pub(super) fn stretches(&self, s0: f64, s1: f64) -> impl Iterator<Item = Stretch> {
        let [first, last] = [self.containing(s0), self.containing(s1)];
        let rises = s0 < s1;
        let count = first.abs_diff(last) + 1;
        let span = s1 - s0;
        (0..count).filter_map(move |n| {
            let interval = &self.0[if rises { first + n } else { first - n }];
            if span == 0.0 {
                let optics = [interval.at(s0); 2];
                return Some(Stretch { share: 1.0, way: [[1.0, 0.0], [0.0, 1.0]], optics });
            }
            let [enter, leave] =
                if rises { [interval.low, interval.high] } else { [interval.high, interval.low] };
            let from = if n == 0 { s0 } else { enter };
            let to = if n + 1 == count { s1 } else { leave };
            let way = |value: f64| [(s1 - value) / span, (value - s0) / span];
            // A fall from the low end of an interval leaves it at once.
            (from != to).then(|| Stretch {
                share: (to - from) / span,
                way: [way(from), way(to)],
                optics: [interval.at(from), interval.at(to)],
            })
        })
    }
}
