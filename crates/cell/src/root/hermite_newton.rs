//! Values and derivatives at the ends, sign count, bracketed Newton.

use super::bernstein_newton::first_root_newton;
use super::{FirstRoot, Root};
use crate::{Cubic, Real, Segment, gradient, trilinear};

/// The method of [`BernsteinNewton`](super::BernsteinNewton) on a cubic made from its values and its derivatives at the two ends, a third of which is the distance between
/// Bernstein coefficients. The derivatives are differences of corner values, and so less exact than the means that
/// [`Cubic::along`] takes.
#[derive(Clone, Copy, Debug, Default)]
pub struct HermiteNewton;

impl FirstRoot for HermiteNewton {
    const NAME: &'static str = "values and derivatives at the ends, sign count, bracketed Newton";

    #[inline(always)]
    fn first_root<R: Real>(corners: &[R; 8], segment: &Segment<R>) -> Root<R> {
        let third = R::splat(1.0 / 3.0);
        let Segment { entry, exit } = *segment;
        let [dx, dy, dz] = std::array::from_fn(|a| (exit[a] - entry[a]) * third);
        let third_of_slope = |p| {
            let [gx, gy, gz] = gradient(corners, p);
            gx.fma(dx, gy.fma(dy, gz * dz))
        };
        let [begin, end] = [entry, exit].map(|p| trilinear(corners, p));
        let inner = [begin + third_of_slope(entry), end - third_of_slope(exit)];
        first_root_newton(&Cubic([begin, inner[0], inner[1], end]))
    }
}
