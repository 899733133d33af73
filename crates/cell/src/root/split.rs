//! Splitting at the extrema.

use super::{Piece, Polynomial, is_inside};
use crate::{Mask, Real};

/// The roots in `(0, 1)` of `a·s² + 2h·s + c`, whose discriminant is `h² − a·c`, ascending; 1 in place of what does not exist.
#[inline(always)]
pub(crate) fn extrema<R: Real>(a: R, h: R, c: R, discriminant: R) -> [R; 2] {
    let [zero, one] = [0.0, 1.0].map(R::splat);
    let exists = discriminant.gt(zero);
    // The stable form: the root that adds magnitudes, and the other from the product of the roots.
    let q = -(h + discriminant.sqrt().copysign(h));
    let [r0, r1] = [q / a, c / q].map(|s| R::select(exists & s.gt(zero) & s.lt(one), s, one));
    [r0.min(r1), r0.max(r1)]
}

/// The first piece between extrema whose ends differ in side.
#[inline(always)]
pub(crate) fn first_piece<R: Real>(cubic: &impl Polynomial<R>) -> Piece<R> {
    let [e0, e1] = cubic.extrema();
    let [f_begin, f_end] = cubic.ends();
    let one = R::splat(1.0);
    // The end's own value, where an extremum that does not exist stands for the end.
    let value = |s: R| R::select(s.ge(one), f_end, cubic.at(s));
    let piece = |lo: R, hi: R, f_lo: R, f_hi: R| Piece {
        lo,
        hi,
        f_lo,
        f_hi,
        found: is_inside(f_lo) ^ is_inside(f_hi),
    };
    let f0 = value(e0);
    let first = piece(R::splat(0.0), e0, f_begin, f0);
    if first.found.all() {
        return first;
    }
    let f1 = value(e1);
    let second = piece(e0, e1, f0, f1);
    let third = piece(e1, one, f1, f_end);
    first.or(first.found, second.or(second.found, third))
}
