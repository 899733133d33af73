//! What the signs of the Bernstein coefficients tell.

use super::split::first_piece;
use super::{Piece, Polynomial, is_inside};
use crate::{Cubic, Mask, Real};

/// Where consecutive coefficients lie on different sides. All alike: the convex hull lies on one side, and there is no crossing. One change:
/// there is exactly one (Descartes' rule).
#[inline(always)]
pub(super) fn sign_changes<R: Real>(cubic: &Cubic<R>) -> [R::Mask; 3] {
    let [s0, s1, s2, s3] = cubic.0.map(is_inside);
    [s0 ^ s1, s1 ^ s2, s2 ^ s3]
}

/// Where there are two or three.
#[inline(always)]
pub(super) fn are_several<M: Mask>([c0, c1, c2]: [M; 3]) -> M {
    (c0 & c1) | (c2 & (c0 | c1))
}

/// Where no coefficient is NaN: those lie on neither side, but make no crossing.
#[inline(always)]
pub(super) fn is_number<R: Real>(cubic: &Cubic<R>) -> R::Mask {
    let [b0, b1, b2, b3] = cubic.0;
    let sum = (b0 + b3) + (b1 + b2);
    sum.ge(sum)
}

/// The first piece in which a cubic with these sign changes changes side, numbers or not: all of the segment where there is one change.
#[inline(always)]
pub(super) fn bracket<R: Real>(cubic: &Cubic<R>, changes: [R::Mask; 3]) -> Piece<R> {
    let whole = Piece::whole(cubic.ends(), changes[0] | changes[1] | changes[2]);
    let several = are_several(changes);
    if several.any() { first_piece(cubic).or(several, whole) } else { whole }
}
