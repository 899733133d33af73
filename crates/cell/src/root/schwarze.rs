//! The closed form.

use super::{FirstRoot, Root};
use crate::{Power, Real, Segment};

/// Cardano's formula with the trigonometric form for three real roots, as Schwarze (1990) arranges it and Parker et al. (1998) use it.
///
/// Its weaknesses are those of the formula: dividing by the leading coefficient makes nearly quadratic cubics inexact, and where the
/// discriminant cancels, roots appear and vanish. Nothing brackets the result, so that cells whose ends differ in side may be found
/// without a root. Lanes are computed one by one, for want of cube roots and arc cosines in lanes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Schwarze;

impl FirstRoot for Schwarze {
    const NAME: &'static str = "power basis, closed form (Schwarze)";

    #[inline(always)]
    fn first_root<R: Real>(corners: &[R; 8], segment: &Segment<R>) -> Root<R> {
        let cubic = Power::along(corners, segment);
        let none = R::splat(f64::INFINITY);
        let s = solve(&cubic).into_iter().fold(none, |first, root| {
            let is_inside = root.ge(R::splat(0.0)) & root.le(R::splat(1.0));
            R::select(is_inside & root.lt(first), root, first)
        });
        Root { s, found: s.le(R::splat(1.0)) }
    }
}

/// Magnitude below which a leading coefficient, or a discriminant, counts as zero, as a share of the largest coefficient: Schwarze's
/// 10⁻⁹, which is meant for double precision, in units of the precision at hand.
const ZERO: f64 = 4.0;

/// Up to three real roots; what does not exist is infinite.
fn solve<R: Real>(cubic: &Power<R>) -> [R; 3] {
    let none = R::splat(f64::INFINITY);
    let Power { a, b, c, d } = *cubic;
    let largest = a.abs().max(b.abs()).max(c.abs()).max(d.abs());
    let zero = largest * R::splat(ZERO * R::EPSILON);
    let is_cubic = a.abs().gt(zero);
    let is_quadratic = b.abs().gt(zero);
    let cubics = cubic_roots(b / a, c / a, d / a);
    let quadratics = quadratic_roots(c / b, d / b);
    let quadratics = [quadratics[0], quadratics[1], none];
    let linear = [-d / c, none, none];
    std::array::from_fn(|n| R::select(is_cubic, cubics[n], R::select(is_quadratic, quadratics[n], linear[n])))
}

/// The real roots of `s³ + a·s² + b·s + c`.
fn cubic_roots<R: Real>(a: R, b: R, c: R) -> [R; 3] {
    let none = R::splat(f64::INFINITY);
    let third = R::splat(1.0 / 3.0);
    let a_third = a * third;
    // s = x − a/3 gives x³ + 3p·x + 2q.
    let p = third * b - a_third * a_third;
    let q = a_third * a_third * a_third - R::splat(0.5) * (a_third * b - c);
    let p3 = p * p * p;
    let discriminant = q * q + p3;
    let has_three = discriminant.lt(R::splat(0.0));
    // One real root: Cardano.
    let root = R::select(has_three, R::splat(0.0), discriminant).sqrt();
    let one = (root - q).cbrt() - (root + q).cbrt();
    // Three: cosines of angles a third of a turn apart.
    let cosine = -q / (-p3).sqrt();
    let angle = cosine.max(R::splat(-1.0)).min(R::splat(1.0)).acos() * third;
    let radius = R::splat(2.0) * (-p).sqrt();
    let turn = std::f64::consts::FRAC_PI_3;
    let three = [
        radius * angle.cos(),
        -radius * (angle + R::splat(turn)).cos(),
        -radius * (angle - R::splat(turn)).cos(),
    ];
    [
        R::select(has_three, three[0], one) - a_third,
        R::select(has_three, three[1] - a_third, none),
        R::select(has_three, three[2] - a_third, none),
    ]
}

/// The real roots of `s² + p·s + q`.
fn quadratic_roots<R: Real>(p: R, q: R) -> [R; 2] {
    let none = R::splat(f64::INFINITY);
    let half = R::splat(0.5) * p;
    let discriminant = half * half - q;
    let exists = discriminant.ge(R::splat(0.0));
    let root = discriminant.sqrt();
    [-half - root, -half + root].map(|s| R::select(exists, s, none))
}
