//! Newton's iteration in a bracket.

use super::{Piece, Polynomial, is_inside, middle, root_step};
use crate::{Mask, Real};

/// Newton steps allowed before every step halves the bracket. Simple roots need three to five; a cubic
/// with a nearly triple root converges linearly and is better served by bisection.
const NEWTON_STEPS: u32 = 8;

/// The root in a piece: Newton's iteration kept in the bracket; ends when the root is known to be within half an ulp of 1 (`δ`) of the
/// next iterate, when a step falls below that, or when the bracket cannot be halved.
///
/// With `|f''|/2 ≤ c` on `[0, 1]` and a step `h = f/f'` from `s`, let `4·c·h² ≤ δ·|f'|` and `|h| > δ`, so that
/// `4·c·|h| < |f'|`. Then `f` is monotone within `2|h|` of `s` and changes sign there, since at `s − 2h` its tangent is
/// `−f` and it differs from that by at most `4·c·h² < |f|`; and the root is within `c·(2h)²/|f'| ≤ δ` of `s − h`.
#[inline(always)]
pub(super) fn newton<R: Real>(cubic: &impl Polynomial<R>, piece: Piece<R>) -> R {
    let step_size = root_step::<R>();
    let starts_inside = is_inside(piece.f_lo);
    let (mut lo, mut hi) = (piece.lo, piece.hi);
    let mut s = piece.secant();
    let mut root = s;
    let mut open = piece.found;
    let four_c = R::splat(4.0) * cubic.half_bend();
    for _ in 0..NEWTON_STEPS {
        let f = cubic.at(s);
        let crosses = is_inside(f) ^ starts_inside;
        lo = R::select(crosses, lo, s);
        hi = R::select(crosses, s, hi);
        let slope = cubic.slope(s);
        let step = f / slope;
        let next = s - step;
        // A small step ends the search only where the field passes in the right direction: a bracket whose
        // far end is itself a root, of the way back, would otherwise draw the iteration there.
        let is_small = step.abs().le(step_size) | (four_c * step * step).le(step_size * slope.abs());
        let done = open & is_small & (slope.gt(R::splat(0.0)) ^ starts_inside);
        root = R::select(done, next.max(lo).min(hi), root);
        open = open & !done;
        if !open.any() {
            return root;
        }
        // Also false for a step that is not a number.
        s = R::select(next.gt(lo) & next.lt(hi), next, middle(lo, hi));
    }
    bisect(cubic, lo, hi, starts_inside, open, root)
}

/// Halves the brackets of the lanes `open` until they are as small as they get; `root` keeps what the others have.
#[cold]
pub(super) fn bisect<R: Real>(
    cubic: &impl Polynomial<R>,
    mut lo: R,
    mut hi: R,
    starts_inside: R::Mask,
    mut open: R::Mask,
    mut root: R,
) -> R {
    // Halvings that take a bracket of length 1 to below the least step, with one to spare.
    let steps = 2 - (0.5 * R::EPSILON).log2() as i32;
    for _ in 0..steps {
        let s = middle(lo, hi);
        root = R::select(open, s, root);
        open = open & (hi - lo).gt(root_step()) & s.gt(lo) & s.lt(hi);
        if !open.any() {
            break;
        }
        let crosses = is_inside(cubic.at(s)) ^ starts_inside;
        lo = R::select(crosses, lo, s);
        hi = R::select(crosses, s, hi);
    }
    root
}
