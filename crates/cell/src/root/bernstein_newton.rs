//! Bernstein sign count, then bracketed Newton.

use super::newton::newton;
use super::split::first_piece;
use super::{FirstRoot, Piece, Polynomial, Root, is_inside};
use crate::{Cubic, Mask, Real, Segment};

/// As [`BernsteinSeries`](super::BernsteinSeries), but with Newton's iteration from the secant's root. The signs of the Bernstein coefficients tell most cells off at once (all alike: the convex hull lies on one side) and most
/// others as having exactly one crossing (one change: Descartes' rule); only what is left is split at the extrema.
#[derive(Clone, Copy, Debug, Default)]
pub struct BernsteinNewton;

impl FirstRoot for BernsteinNewton {
    const NAME: &'static str = "Bernstein, sign count, bracketed Newton";

    #[inline(always)]
    fn first_root<R: Real>(corners: &[R; 8], segment: &Segment<R>) -> Root<R> {
        first_root_newton(&Cubic::along(corners, segment))
    }
}

#[inline(always)]
pub(super) fn first_root_newton<R: Real>(cubic: &Cubic<R>) -> Root<R> {
    let found = differ_in_side(cubic);
    if found.any() {
        bracket(cubic).root(|piece| newton(cubic, piece))
    } else {
        Root { s: R::splat(0.0), found }
    }
}

/// Where the coefficients lie on both sides.
#[inline(always)]
fn differ_in_side<R: Real>(cubic: &Cubic<R>) -> R::Mask {
    let [s0, s1, s2, s3] = cubic.0.map(is_inside);
    (s0 ^ s1) | (s1 ^ s2) | (s2 ^ s3)
}

/// Where no coefficient is NaN: those lie on neither side, but make no crossing.
#[inline(always)]
pub(super) fn is_number<R: Real>(cubic: &Cubic<R>) -> R::Mask {
    let [b0, b1, b2, b3] = cubic.0;
    let sum = (b0 + b3) + (b1 + b2);
    sum.ge(sum)
}

/// The first piece in which a cubic changes side: all of the segment where its coefficients change sign once.
#[inline(always)]
pub(super) fn bracket<R: Real>(cubic: &Cubic<R>) -> Piece<R> {
    let [s0, s1, s2, s3] = cubic.0.map(is_inside);
    let changes = [s0 ^ s1, s1 ^ s2, s2 ^ s3];
    let is_number = is_number(cubic);
    let is_odd = changes[0] ^ changes[1] ^ changes[2];
    let is_one = is_number & is_odd & !(changes[0] & changes[1] & changes[2]);
    let several = is_number & (changes[0] | changes[1] | changes[2]) & !is_one;
    let whole = Piece::whole(cubic.ends(), is_one);
    if several.any() { first_piece(cubic).or(several, whole) } else { whole }
}
