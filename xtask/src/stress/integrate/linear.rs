//! Pieces over which the value is linear, against the oracle.

use std::fmt;

use isoray_oracle::{OracleRadiance, OracleStretch, TransferPoints, integrate_stretch};
use isoray_preint::{ControlPoint, LinearPieces, Piece};
use serde::{Deserialize, Serialize};

use super::pixel::Pixel;
use super::{moved, moves};
use crate::stress::shard::Offending;

/// A piece.
#[derive(Clone, Copy)]
pub(super) struct Linear<'a> {
    points: &'a [ControlPoint],
    /// Values at both ends.
    ends: [f32; 2],
    length: f32,
}

/// As it pastes into a test.
impl fmt::Debug for Linear<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { points, ends, length } = self;
        write!(f, "Linear {{ points: &{points:?}, ends: {ends:?}, length: {length:?} }}")
    }
}

impl<'a> Linear<'a> {
    /// Between opposite corners of the first cell of a pixel.
    pub(super) fn of(pixel: &Pixel<'a>) -> Self {
        let first = &pixel.stretches[0];
        Self { points: pixel.points, ends: [first.corners[0], first.corners[7]], length: first.length }
    }

    /// What the oracle sees, with control points moved by `by` times the larger value.
    fn exact(&self, points: &TransferPoints, by: [f64; 2]) -> OracleRadiance {
        let ends = self.ends.map(f64::from);
        let stretch = OracleStretch {
            corners: std::array::from_fn(|c| ends[c & 1]),
            entry: [0.0, 0.5, 0.5],
            exit: [1.0, 0.5, 0.5],
            length: self.length.into(),
        };
        let points = moved(points, by, ends[0].abs().max(ends[1].abs()));
        integrate_stretch(&stretch, &points, None)
    }
}

/// What is counted of them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct LinearTally {
    tried: u64,
    compared: u64,
    undecided: u64,
    /// Not finite, negative, an alpha beyond 1, or one that is not that of the optical depth.
    invalid: u64,
    /// Off by more than is promised.
    off: u64,
    /// The largest error as a share of that.
    worst: f64,
}

impl fmt::Display for LinearTally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tried, compared, undecided, invalid, off, worst } = self;
        write!(
            f,
            "{tried} linear pieces, {compared} compared with the oracle: invalid {invalid}, off {off}; undecided {undecided}; largest error {worst:.3} of its bound"
        )
    }
}

/// Two roundings of single precision, and what the oracle may be off by.
const ROUNDING: f64 = f32::EPSILON as f64;
const EXACT: f64 = 3e-11;

impl LinearTally {
    pub(super) fn merge(&mut self, other: Self) {
        self.tried += other.tried;
        self.compared += other.compared;
        self.undecided += other.undecided;
        self.invalid += other.invalid;
        self.off += other.off;
        self.worst = self.worst.max(other.worst);
    }

    pub(super) fn violations(&self) -> u64 {
        self.invalid + self.off
    }

    /// Integrates a piece, and compares it with the oracle if there are its `points`.
    pub(super) fn take(
        &mut self,
        piece: &Linear,
        scheme: &LinearPieces,
        points: Option<&TransferPoints>,
        offending: &mut Offending,
    ) {
        self.tried += 1;
        let [s0, s1] = piece.ends;
        let found = scheme.integrate(s0, s1, piece.length);
        let depth = f64::from(scheme.optical_depth(s0, s1, piece.length));
        let [alpha, by_depth] = [f64::from(found.alpha), -(-depth).exp_m1()];
        let colors = found.front.into_iter().chain(found.back);
        let is_valid = colors.into_iter().all(|c| c.is_finite() && c >= 0.0)
            && (0.0..=1.0).contains(&alpha)
            && (alpha - by_depth).abs() <= 2.0 * ROUNDING * alpha.max(f32::MIN_POSITIVE.into());
        if !is_valid {
            self.invalid += 1;
            offending.keep(&format!("invalid: {found:?}, optical depth {depth:e}"), piece);
        }
        if let Some(points) = points {
            self.compare(piece, &found, points, offending);
        }
    }

    fn compare(&mut self, piece: &Linear, found: &Piece, points: &TransferPoints, offending: &mut Offending) {
        self.compared += 1;
        let exact = piece.exact(points, [0.0; 2]);
        let error = errors(piece, found, &exact);
        if error > 1.0 {
            let seen = |by| piece.exact(points, by);
            let change = |r: &OracleRadiance| {
                (0..3).fold((r.alpha() - exact.alpha()).abs(), |m, n| {
                    m.max((r.color[n] - exact.color[n]).abs())
                })
            };
            let off = (0..3).fold((f64::from(found.alpha) - exact.alpha()).abs(), |m, n| {
                m.max((f64::from(found.front[n]) + f64::from(found.back[n]) - exact.color[n]).abs())
            });
            if moves().map(seen).any(|seen| change(&seen) > 0.1 * off) {
                self.undecided += 1;
                return;
            }
            self.off += 1;
            offending.keep(&format!("off by {error} of the bound: {found:?} {exact:?}"), piece);
        }
        self.worst = self.worst.max(error);
    }
}

/// The largest error as a share of what is promised: of alpha, and of the color without shading.
fn errors(piece: &Linear, found: &Piece, exact: &OracleRadiance) -> f64 {
    let alpha = (f64::from(found.alpha) - exact.alpha()).abs();
    // The oracle tells no parts of a piece that are shorter than 10⁻³⁰ of it.
    let largest = piece.points.iter().fold(0.0, |m: f32, p| m.max(p.extinction));
    let faint = f64::from(f32::MIN_POSITIVE) + 1e-28 * f64::from(largest) * f64::from(piece.length);
    let allowed = ROUNDING * exact.alpha() + EXACT * exact.optical_depth.min(1.0) + faint;
    (0..3).fold(alpha / allowed, |worst, n| {
        let color = f64::from(found.front[n]) + f64::from(found.back[n]);
        let allowed = 2.0 * LinearPieces::ERROR + ROUNDING * exact.color[n];
        f64::max(worst, (color - exact.color[n]).abs() / allowed)
    })
}
