//! A stretch cut into pieces on which its extinction is a cubic.

use super::cubic::Cubic;
use super::transfer::{Interval, TransferPoint, TransferPoints};
use crate::Number;

/// A part of a stretch within one interval of the transfer function.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// The fraction of the interval along the piece, by Bernstein coefficients.
    pub(super) fraction: [f64; 4],
    /// Colour and extinction at fraction 0.
    pub(super) from: TransferPoint,
    /// At fraction 1.
    pub(super) to: TransferPoint,
    /// Parameter of the stretch at which it begins.
    pub(super) start: f64,
    /// Length as a fraction of the stretch.
    pub(super) extent: f64,
    /// Length in world units.
    pub(super) length: f64,
}

impl Piece {
    /// Extinction at a fraction of the interval. A fraction beyond it is a rounding error.
    pub(super) fn extinction(&self, fraction: f64) -> f64 {
        let x = fraction.clamp(0.0, 1.0);
        self.from.extinction * (1.0 - x) + self.to.extinction * x
    }

    /// Optical depth: the extinction is linear in the fraction, and the mean of a cubic is that of its coefficients.
    fn depth(&self) -> f64 {
        self.length * self.extinction(0.25 * self.fraction.iter().sum::<f64>())
    }
}

/// Error of an optical depth or of a colour beyond which pieces are found anew in twice the precision, relative to the depth where that is
/// less than 1: a hundredth of what a ray is promised.
const TOLERANCE: f64 = 1e-11;

/// How far beyond an interval, in widths of it, the ends of a piece in it may come to lie by rounding errors that do no harm.
const STRAY: f64 = 1e-3;

/// Cuts a stretch into pieces.
#[derive(Debug)]
pub(super) struct Pieces<'a> {
    transfer: &'a TransferPoints,
    /// Length of the stretch in world units.
    length: f64,
    /// The least and the largest corner.
    range: [f64; 2],
    /// The pieces in order.
    pub(super) list: Vec<Piece>,
    /// Their optical depth.
    depth: f64,
    /// What the errors of the cubic add to the optical depth and the colour, at most.
    error: f64,
}

impl<'a> Pieces<'a> {
    pub(super) fn new(transfer: &'a TransferPoints, length: f64, range: [f64; 2]) -> Self {
        Self { transfer, length, range, list: Vec::with_capacity(4), depth: 0.0, error: 0.0 }
    }

    /// Whether rounding errors of the cubic could matter.
    pub(super) fn is_doubtful(&self) -> bool {
        self.error > TOLERANCE * self.depth.min(1.0)
    }

    /// Whether no control point lies among the values of the cell, so that it need not be cut at extrema.
    pub(super) fn is_within_one(&self) -> bool {
        self.count(self.range[0]) == self.count(self.range[1])
    }

    /// The number of control points at or below a value.
    fn count(&self, value: f64) -> usize {
        self.transfer.0.partition_point(|p| p.value <= value)
    }

    /// Finds the pieces. `cuts` are parameters in ascending order, the last of them 1, that contain the extrema unless all is
    /// [within one](Self::is_within_one) interval.
    pub(super) fn cut<N: Number>(&mut self, cubic: &Cubic<N>, cuts: &[f64]) {
        self.list.clear();
        (self.depth, self.error) = (0.0, 0.0);
        let index = self.count(self.range[0]);
        let is_within_one = self.is_within_one();
        let mut start = N::from(0.0);
        for end in cuts.iter().map(|&u| N::from(u)) {
            if end <= start {
                continue;
            }
            if is_within_one {
                self.push(cubic, start, end, index);
            } else {
                self.cut_monotone(cubic, start, end);
            }
            start = end;
        }
    }

    /// Finds the pieces of a monotone section: from one control point to the next.
    ///
    /// Which interval follows from the order in which points are passed, not from values that are rounded. At a step's value exactly
    /// the interval above it holds, unless the section comes from there or goes below it at once.
    fn cut_monotone<N: Number>(&mut self, cubic: &Cubic<N>, start: N, end: N) {
        let points = &self.transfer.0;
        let level = |index: usize| cubic.level(points[index].value);
        let [first, last] = [start, end].map(|u| cubic.at(u));
        self.add_error_of_ends(cubic, [start, end], [first, last]);
        let mut u = start;
        let mut pass = |pieces: &mut Self, point: usize, index: usize| {
            let at = cubic.crossing(level(point), u, end);
            pieces.push(cubic, u, at, index);
            pieces.add_error_of_step(cubic, at.to_f64(), point);
            u = at;
        };
        let is_at_most = |limit: N| points.partition_point(|p| cubic.level(p.value) <= limit);
        let index = if last >= first {
            let mut index = is_at_most(first);
            while index < points.len() && level(index) < last {
                pass(self, index, index);
                index = is_at_most(level(index));
            }
            index
        } else {
            let is_below = |limit: N| points.partition_point(|p| cubic.level(p.value) < limit);
            let mut index = is_below(first);
            while index > 0 && level(index - 1) > last {
                pass(self, index - 1, index);
                index = is_below(level(index - 1));
            }
            index
        };
        self.push(cubic, u, end, index);
    }

    /// A piece in interval `index`, unless it has no length.
    fn push<N: Number>(&mut self, cubic: &Cubic<N>, start: N, end: N, index: usize) {
        let extent = (end - start).to_f64();
        let Some(interval) = self.transfer.interval(index).filter(|_| extent > 0.0) else { return };
        let Interval { mut from, mut to } = interval;
        let width = interval.width();
        let (mut fraction, mut error) = ([0.0; 4], 0.0);
        if width > 0.0 && (from.extinction, from.color) != (to.extinction, to.color) {
            fraction = cubic.between(start, end, from.value).map(|s| s / width);
            // Measured from the nearer end: extinction that falls to zero there must keep its digits.
            if fraction.iter().sum::<f64>() > 2.0 {
                fraction = cubic.between(start, end, to.value).map(|s| -s / width);
                (from, to) = (to, from);
            }
            // An interval too thin to be told from its neighbours: the whole piece is within it, at one end or the other.
            let is_within = |x: f64| (-STRAY..=1.0 + STRAY).contains(&x);
            if !(is_within(fraction[0]) && is_within(fraction[3])) {
                fraction = fraction.map(|x| x.clamp(0.0, 1.0));
            }
            error = difference(from, to) * (cubic.error() / width).min(1.0);
        }
        let length = extent * self.length;
        self.error += error * length;
        let piece = Piece { fraction, from: *from, to: *to, start: start.to_f64(), extent, length };
        self.depth += piece.depth();
        self.list.push(piece);
    }

    /// Where the ends of a section have values so near to a step that rounding errors could misplace them.
    fn add_error_of_ends<N: Number>(&mut self, cubic: &Cubic<N>, ends: [N; 2], values: [N; 2]) {
        let error = N::from(cubic.error());
        for (u, value) in ends.into_iter().zip(values) {
            let near = self.transfer.0.partition_point(|p| cubic.level(p.value) < value - error);
            for point in near..self.transfer.0.len() {
                if cubic.level(self.transfer.0[point].value) > value + error {
                    break;
                }
                self.add_error_of_step(cubic, u.to_f64(), point);
            }
        }
    }

    /// What an error in the value does to where a step is passed at `u`; points nearer to each other than errors are a step, too.
    fn add_error_of_step<N: Number>(&mut self, cubic: &Cubic<N>, u: f64, point: usize) {
        const NEAR: f64 = 4.0;
        let error = cubic.error();
        if error == 0.0 {
            return;
        }
        let points = &self.transfer.0;
        let value = points[point].value;
        let first = points.partition_point(|p| p.value < value - NEAR * error);
        let is_near = |pair: &&[TransferPoint]| pair[1].value <= value + NEAR * error;
        let near = points[first..].windows(2).take_while(is_near);
        let jump: f64 = near.map(|pair| difference(&pair[0], &pair[1])).sum();
        if jump > 0.0 {
            let slope = cubic.slope(u).abs();
            let moved = if slope > error { error / slope } else { 1.0 };
            self.error += jump * self.length * moved;
        }
    }
}

/// By how much two points differ, in extinction and in emission.
fn difference(a: &TransferPoint, b: &TransferPoint) -> f64 {
    let color = (0..3).fold(0.0, |m: f64, n| m.max((a.color[n] - b.color[n]).abs()));
    (a.extinction - b.extinction).abs() + a.extinction.max(b.extinction) * color
}
