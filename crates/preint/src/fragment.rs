//! Parts of a segment, cut where the value passes a control point or in the middle.

use isoray_cell::{Cubic, Real};

use crate::intervals::Intervals;
use crate::opacity::is_single;
use crate::shade::Lit;

/// A part of a segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fragment<R: Real> {
    /// Coefficients of the value, relative to the segment's reference.
    pub(crate) value: [R; 4],
    /// And of `g·L` and `g·H`, if that matters.
    pub(crate) lit: Option<Lit<R>>,
    /// Share of the segment's length.
    pub(crate) share: R,
    /// The first and the last interval of the transfer function that the value may meet.
    pub(crate) intervals: [usize; 2],
    /// Number of cuts that it took to make it.
    pub(crate) cuts: u32,
}

/// How near to an end that has a control point's value another crossing of it is not told from it, but found by halving.
const BESIDE: f64 = 1e-3;

/// What [`Fragment::separate`] did.
pub(crate) enum Separated<R: Real> {
    /// The fragment meets fewer intervals than it might have.
    Narrowed(Fragment<R>),
    /// Front and back.
    Into([Fragment<R>; 2]),
}

impl<R: Real<Mask = bool>> Fragment<R> {
    /// Cuts a fragment where its value passes the middle one of the control points that it may meet, or finds that it does not. Never cuts what
    /// `is_last`, but decides by the value in the middle.
    pub(crate) fn separate(&self, intervals: &Intervals, reference: f64, is_last: bool) -> Separated<R> {
        let [first, last] = self.intervals;
        let middle = (first + last) / 2;
        let at = R::splat(intervals.break_after(middle) - reference);
        let zero = R::splat(0.0);
        let above = Separated::Narrowed(Self { intervals: [middle + 1, last], ..*self });
        let below = Separated::Narrowed(Self { intervals: [first, middle], ..*self });
        let off = self.value.map(|b| b - at);
        if off.iter().all(|b| b.ge(zero)) {
            return above;
        }
        if off.iter().all(|b| b.le(zero)) {
            return below;
        }
        if is_last {
            return if Cubic(off).at(R::splat(0.5)).ge(zero) { above } else { below };
        }
        // To 1, so that denormal numbers have roots too. The scale of single precision is no concern: see `fragments.rs`.
        let largest = off.iter().fold(zero, |m, b| m.max(b.abs()));
        let scaled = if is_single::<R>() { off } else { off.map(|b| b / largest) };
        let root = Cubic(scaled).first_root();
        // A root at an end separates nothing: the polygon crosses where the curve does not, or the curve touches. Where an end has been cut to
        // have the value, a root beside it is the same again, displaced by rounding: cut there, the rest would stay as long as it is.
        let [least, most] = [off[0], off[3]].map(|end| R::splat(if end == zero { BESIDE } else { 0.0 }));
        let is_inside = root.found && root.s.gt(least) && root.s.lt(R::splat(1.0) - most);
        let mut parts = self.cut(if is_inside { root.s } else { R::splat(0.5) });
        if is_inside {
            (parts[0].value[3], parts[1].value[0]) = (at, at);
        }
        Separated::Into(parts)
    }

    /// The parts before and after parameter `x` (de Casteljau).
    pub(crate) fn cut(&self, x: R) -> [Self; 2] {
        let value = split(self.value, x);
        let lit = self.lit.map(|lit| (split(lit.light, x), split(lit.half, x)));
        let share = [self.share * x, self.share * (R::splat(1.0) - x)];
        std::array::from_fn(|n| Self {
            value: value[n],
            lit: lit.map(|(light, half)| Lit { light: light[n], half: half[n] }),
            share: share[n],
            cuts: self.cuts + 1,
            ..*self
        })
    }
}

/// Bernstein coefficients of a polynomial on `[0, x]` and on `[x, 1]`.
pub(crate) fn split<R: Real, const N: usize>(mut b: [R; N], x: R) -> [[R; N]; 2] {
    let (mut near, mut far) = (b, b);
    for level in 1..N {
        for n in (level..N).rev() {
            b[n] = isoray_cell::lerp(b[n - 1], b[n], x);
        }
        near[level] = b[level];
        far[N - 1 - level] = b[N - 1];
    }
    [near, far]
}
