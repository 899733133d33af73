//! Split, then bracketed Newton.

use super::newton::newton;
use super::split::first_piece;
use super::{FirstRoot, Root};
use crate::{Power, Real, Segment};

/// The power form split at its extrema, then Newton's iteration kept in the bracket: as Yuksel (2022) solves cubics, but for the
/// starting point, which is the secant's root here.
#[derive(Clone, Copy, Debug, Default)]
pub struct SplitNewton;

impl FirstRoot for SplitNewton {
    const NAME: &'static str = "power basis, split, bracketed Newton";

    #[inline(always)]
    fn first_root<R: Real>(corners: &[R; 8], segment: &Segment<R>) -> Root<R> {
        let cubic = Power::along(corners, segment);
        first_piece(&cubic).root(|piece| newton(&cubic, piece))
    }
}
