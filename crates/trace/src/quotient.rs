//! Correctly rounded quotients, in lanes.

use std::ops::{Div, Mul};

use wide::{f64x4, f64x8};

/// Numbers in double precision, in lanes.
pub trait Doubles: Copy + Mul<Output = Self> + Div<Output = Self> {
    /// `self·b + c`, in one rounding where the build has it.
    fn mul_add(self, b: Self, c: Self) -> Self;

    /// `c − self·b`, likewise.
    fn mul_neg_add(self, b: Self, c: Self) -> Self;
}

macro_rules! doubles {
    ($($lanes:ty),*) => { $(
        impl Doubles for $lanes {
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                <$lanes>::mul_add(self, b, c)
            }

            #[inline(always)]
            fn mul_neg_add(self, b: Self, c: Self) -> Self {
                <$lanes>::mul_neg_add(self, b, c)
            }
        }
    )* };
}

doubles!(f64x4, f64x8);

/// `a/d`, correctly rounded, of a `d` of 24 significant bits whose correctly rounded reciprocal is `inverse`: where a ray crosses a plane at distance `a`. The one
/// expression that decides every order.
///
/// With fused multiply-add it is had without dividing. Let `y` be the reciprocal; then `q = fl(a·y)` is within 2 ulp of `a/d`, the
/// residual `r = a − q·d` is exact, and `q + r·y` misses `a/d` by less than `2⁻⁵⁰` ulp before it is rounded. Since `d` has 24
/// significant bits and a midpoint between two doubles 54, `a/d` is further than `2⁻²⁶` ulp from any midpoint, so rounding
/// `q + r·y` gives what rounding `a/d` would.
#[inline(always)]
pub fn quotient<L: Doubles>(a: L, d: L, inverse: L) -> L {
    if cfg!(any(target_feature = "fma", target_arch = "aarch64")) {
        let q = a * inverse;
        let r = q.mul_neg_add(d, a);
        r.mul_add(inverse, q)
    } else {
        a / d
    }
}
