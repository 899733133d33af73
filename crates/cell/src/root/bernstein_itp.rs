//! Bernstein sign count, then ITP.

use super::sign_count::{bracket, is_number, sign_changes};
use super::{FirstRoot, Piece, Root, middle, root_step};
use crate::{Cubic, Mask, Real, Segment};

/// Interpolate, truncate, project (Oliveira and Takahashi, 2020): never more evaluations than bisection and one, superlinear on the
/// average, without derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub struct BernsteinItp;

impl FirstRoot for BernsteinItp {
    const NAME: &'static str = "Bernstein, sign count, ITP";

    #[inline(always)]
    fn first_root<R: Real>(corners: &[R; 8], segment: &Segment<R>) -> Root<R> {
        let cubic = Cubic::along(corners, segment);
        let piece = bracket(&cubic, sign_changes(&cubic)).only(is_number(&cubic));
        piece.root(|piece| itp(&cubic, piece))
    }
}

/// Their parameters `κ₁·(b − a)`, `κ₂ = 2` and `n₀`.
const TRUNCATION: f64 = 0.2;
const SPARE_STEPS: i32 = 1;

fn itp<R: Real>(cubic: &Cubic<R>, mut piece: Piece<R>) -> R {
    let step = root_step::<R>();
    let truncation = R::splat(TRUNCATION) / (piece.hi - piece.lo);
    // The bracket is at most 1 long: after this many halvings it is within the least step of the root.
    let steps = -(R::EPSILON.log2() as i32) + SPARE_STEPS;
    let mut open = piece.found;
    for n in 0..=steps {
        let length = piece.hi - piece.lo;
        open = open & length.gt(step + step);
        if !open.any() {
            break;
        }
        let half = middle(piece.lo, piece.hi);
        let radius = step * R::splat(f64::from(steps - n).exp2()) - R::splat(0.5) * length;
        let secant = piece.secant();
        let to_half = half - secant;
        let shift = truncation * length * length;
        let truncated = R::select(shift.le(to_half.abs()), secant + shift.copysign(to_half), half);
        let is_near = (truncated - half).abs().le(radius);
        let s = R::select(is_near, truncated, half - radius.max(R::splat(0.0)).copysign(to_half));
        let before = piece;
        piece.cut(s, cubic.at(s));
        // Lanes that are done stay as they are.
        piece = piece.or(open, before);
    }
    middle(piece.lo, piece.hi)
}
