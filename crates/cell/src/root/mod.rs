//! First-root finders, all with one interface, for scalars and lanes.
//!
//! [`BernsteinSeries`] is the one that all else uses, through [`Cubic::first_root`](crate::Cubic::first_root); the others are here to be
//! measured against it.

mod bernstein_itp;
mod bernstein_newton;
mod bernstein_series;
mod departing;
mod hermite_newton;
mod neubauer;
mod newton;
mod schwarze;
mod several;
mod sign_count;
mod split;
mod split_newton;

pub use bernstein_itp::BernsteinItp;
pub use bernstein_newton::BernsteinNewton;
pub use bernstein_series::BernsteinSeries;
pub use departing::Departing;
pub use hermite_newton::HermiteNewton;
pub use neubauer::Neubauer;
pub use schwarze::Schwarze;
pub use several::{Crossing, Roots, crossings};
pub use split_newton::SplitNewton;

pub(crate) use bernstein_series::first_root_series;
pub(crate) use several::all_roots;
pub(crate) use split::extrema;

use crate::{Mask, Real, Segment};

/// The first crossing in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Root<R: Real> {
    /// Where, on the segment, in `[0, 1]`; without meaning where there is none.
    pub s: R,
    /// Whether there is one.
    pub found: R::Mask,
}

impl<R: Real<Mask = bool>> Root<R> {
    /// The crossing, if there is one.
    #[inline(always)]
    pub fn get(self) -> Option<R> {
        self.found.then_some(self.s)
    }
}

/// A method to find where a ray first passes from inside (`≥ 0`) to outside in a cell, or back.
pub trait FirstRoot {
    /// What tables call it.
    const NAME: &'static str;

    /// The first crossing on `segment` in the cell with these corner values, which are relative to the isovalue.
    fn first_root<R: Real>(corners: &[R; 8], segment: &Segment<R>) -> Root<R>;
}

/// What finders ask of a cubic on `[0, 1]`.
pub(crate) trait Polynomial<R: Real> {
    fn at(&self, s: R) -> R;
    fn slope(&self, s: R) -> R;
    /// The values at 0 and 1.
    fn ends(&self) -> [R; 2];
    /// A bound of half the magnitude of the second derivative.
    fn half_bend(&self) -> R;
    /// Where the derivative vanishes in `(0, 1)`, ascending; 1 in place of what does not exist.
    fn extrema(&self) -> [R; 2];
}

/// A part of `[0, 1]` on which the cubic is monotone and at whose ends it differs in side, in lanes where there is one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece<R: Real> {
    pub(crate) lo: R,
    pub(crate) hi: R,
    pub(crate) f_lo: R,
    pub(crate) f_hi: R,
    pub(crate) found: R::Mask,
}

impl<R: Real> Piece<R> {
    /// From `lo` to `hi`, where a monotone cubic is `f_lo` and `f_hi`.
    #[inline(always)]
    pub(crate) fn between([lo, f_lo]: [R; 2], [hi, f_hi]: [R; 2]) -> Self {
        Self { lo, hi, f_lo, f_hi, found: is_inside(f_lo) ^ is_inside(f_hi) }
    }

    /// All of `[0, 1]`, in the lanes of `found`.
    #[inline(always)]
    pub(crate) fn whole([f_lo, f_hi]: [R; 2], found: R::Mask) -> Self {
        Self { lo: R::splat(0.0), hi: R::splat(1.0), f_lo, f_hi, found }
    }

    /// The root that `refine` finds in the piece; it is not asked where there is none in any lane.
    #[inline(always)]
    pub(crate) fn root(self, refine: impl FnOnce(Self) -> R) -> Root<R> {
        let s = if self.found.any() { refine(self) } else { R::splat(0.0) };
        Root { s, found: self.found }
    }

    /// In the lanes of `mask` alone.
    #[inline(always)]
    pub(crate) fn only(self, mask: R::Mask) -> Self {
        Self { found: self.found & mask, ..self }
    }

    /// `self` in the lanes of `mask`, `other` elsewhere.
    #[inline(always)]
    pub(crate) fn or(self, mask: R::Mask, other: Self) -> Self {
        Self {
            lo: R::select(mask, self.lo, other.lo),
            hi: R::select(mask, self.hi, other.hi),
            f_lo: R::select(mask, self.f_lo, other.f_lo),
            f_hi: R::select(mask, self.f_hi, other.f_hi),
            found: mask & self.found | !mask & other.found,
        }
    }

    /// Where the secant through the ends is zero; the middle if that is at an end.
    #[inline(always)]
    pub(crate) fn secant(&self) -> R {
        // The ends differ in side, so the difference is zero only for 0 and −0.
        let s = (self.hi - self.lo).fma(self.f_lo / (self.f_lo - self.f_hi), self.lo);
        R::select(s.gt(self.lo) & s.lt(self.hi), s, middle(self.lo, self.hi))
    }

    /// What remains when the cubic is `f` at `s`: the part in which it changes side.
    #[inline(always)]
    pub(crate) fn cut(&mut self, s: R, f: R) {
        let stays = !(is_inside(f) ^ is_inside(self.f_lo));
        self.lo = R::select(stays, s, self.lo);
        self.f_lo = R::select(stays, f, self.f_lo);
        self.hi = R::select(stays, self.hi, s);
        self.f_hi = R::select(stays, self.f_hi, f);
    }
}

/// Step at which roots are as good as they get, in the segment's parameter: half a unit in the last place of 1, below which the
/// parameter of a point near the exit cannot be told from its neighbour.
#[inline(always)]
pub(crate) fn root_step<R: Real>() -> R {
    R::splat(0.5 * R::EPSILON)
}

#[inline(always)]
pub(crate) fn is_inside<R: Real>(f: R) -> R::Mask {
    f.ge(R::splat(0.0))
}

#[inline(always)]
pub(crate) fn middle<R: Real>(lo: R, hi: R) -> R {
    R::splat(0.5) * (lo + hi)
}
