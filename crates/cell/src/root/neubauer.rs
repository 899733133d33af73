//! Neubauer's method.

use super::split::first_piece;
use super::{FirstRoot, Polynomial, Root};
use crate::{Power, Real, Segment};

/// Split at the extrema, then a fixed number of linear interpolations (Neubauer et al. 2002, Marmitt et al. 2004): what Knoll et al. use in
/// 2006 and 2009. Finds what the other splitting methods find; the roots of curved cubics are off by up to a tenth of the cell.
#[derive(Clone, Copy, Debug, Default)]
pub struct Neubauer;

/// Linear interpolations, the last of which gives the root.
const INTERPOLATIONS: u32 = 3;

impl FirstRoot for Neubauer {
    const NAME: &'static str = "power basis, split, 3 linear interpolations (Neubauer)";

    #[inline(always)]
    fn first_root<R: Real>(corners: &[R; 8], segment: &Segment<R>) -> Root<R> {
        let cubic = Power::along(corners, segment);
        first_piece(&cubic).root(|mut piece| {
            for _ in 1..INTERPOLATIONS {
                let s = piece.secant();
                piece.cut(s, cubic.at(s));
            }
            piece.secant()
        })
    }
}
