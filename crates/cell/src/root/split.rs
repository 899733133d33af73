//! Splitting at the extrema.

use super::{Piece, Polynomial};
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

/// The four ends of a cubic's monotone pieces by number, ascending, with the values there, each found when it is asked for. What pieces do
/// not exist have no length, at 1.
#[inline(always)]
pub(super) fn ends_of_pieces<R: Real>(cubic: &impl Polynomial<R>) -> impl Fn(usize) -> [R; 2] {
    let [zero, one] = [0.0, 1.0].map(R::splat);
    let [e0, e1] = cubic.extrema();
    let [f_begin, f_end] = cubic.ends();
    // The end's own value, where an extremum that does not exist stands for the end.
    let at = move |s: R| [s, R::select(s.ge(one), f_end, cubic.at(s))];
    move |n| match n {
        0 => [zero, f_begin],
        1 => at(e0),
        2 => at(e1),
        _ => [one, f_end],
    }
}

/// The first piece between extrema whose ends differ in side.
#[inline(always)]
pub(crate) fn first_piece<R: Real>(cubic: &impl Polynomial<R>) -> Piece<R> {
    let end = ends_of_pieces(cubic);
    let e0 = end(1);
    let first = Piece::between(end(0), e0);
    if first.found.all() {
        return first;
    }
    let e1 = end(2);
    let (second, third) = (Piece::between(e0, e1), Piece::between(e1, end(3)));
    first.or(first.found, second.or(second.found, third))
}
