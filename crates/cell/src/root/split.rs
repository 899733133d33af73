//! Splitting at the extrema.

use super::{Piece, Polynomial};
use crate::Real;

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

/// The ends of the monotone pieces of a cubic and the values there, ascending. What pieces do not exist have no length, at 1.
#[inline(always)]
pub(super) fn ends_of_pieces<R: Real>(cubic: &impl Polynomial<R>) -> [[R; 2]; 4] {
    let [e0, e1] = cubic.extrema();
    let [f_begin, f_end] = cubic.ends();
    let one = R::splat(1.0);
    // The end's own value, where an extremum that does not exist stands for the end.
    let value = |s: R| R::select(s.ge(one), f_end, cubic.at(s));
    [[R::splat(0.0), f_begin], [e0, value(e0)], [e1, value(e1)], [one, f_end]]
}

/// The first piece between extrema whose ends differ in side.
#[inline(always)]
pub(crate) fn first_piece<R: Real>(cubic: &impl Polynomial<R>) -> Piece<R> {
    let ends = ends_of_pieces(cubic);
    let [first, second, third] = std::array::from_fn(|n| Piece::between(ends[n], ends[n + 1]));
    first.or(first.found, second.or(second.found, third))
}
