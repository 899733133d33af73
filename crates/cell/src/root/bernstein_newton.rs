//! Bernstein sign count, then bracketed Newton.

use super::newton::newton;
use super::sign_count::{bracket, is_number, sign_changes};
use super::{FirstRoot, Root};
use crate::{Cubic, Mask, Real, Segment};

/// As [`BernsteinSeries`](super::BernsteinSeries), but with Newton's iteration from the secant's root.
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
    let changes = sign_changes(cubic);
    let found = changes[0] | changes[1] | changes[2];
    if !found.any() {
        return Root { s: R::splat(0.0), found };
    }
    bracket(cubic, changes).only(is_number(cubic)).root(|piece| newton(cubic, piece))
}
