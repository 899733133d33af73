//! Numbers of twice the precision of `f64`, for what `f64` cannot decide.

use std::cmp::Ordering;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// What the references are written for: `f64`, or [`DoubleDouble`].
pub trait Number:
    Copy
    + Debug
    + PartialOrd
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Relative error of an operation, at most.
    const ROUNDOFF: f64;
    /// The nearest `f64`.
    fn to_f64(self) -> f64;
    /// Square root of what is not negative.
    fn sqrt(self) -> Self;
}

impl Number for f64 {
    const ROUNDOFF: f64 = Self::EPSILON / 2.0;
    fn to_f64(self) -> f64 {
        self
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

/// The exact sum of two `f64`, the second at most half a unit in the last place of the first: 106 bits (Dekker 1971).
///
/// Results are within [`ROUNDOFF`](Number::ROUNDOFF), relative to the magnitudes that go into an operation, while no product of low parts
/// is denormal: for magnitudes of 10⁻¹²⁰ to 10¹⁵⁰, far beyond those of an `f32`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleDouble {
    high: f64,
    low: f64,
}

/// `a + b` and what rounding it lost, exactly (Knuth).
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    let b_part = high - a;
    DoubleDouble { high, low: (a - (high - b_part)) + (b - b_part) }
}

/// `a·b` and what rounding it lost, exactly: the factors are cut in halves of 26 bits, whose products are exact (Veltkamp).
fn two_product(a: f64, b: f64) -> DoubleDouble {
    const CUT: f64 = ((1_u64 << 27) + 1) as f64;
    let halves = |x: f64| {
        let high = CUT * x - (CUT * x - x);
        [high, x - high]
    };
    let high = a * b;
    let ([a1, a0], [b1, b0]) = (halves(a), halves(b));
    DoubleDouble { high, low: ((a1 * b1 - high) + a1 * b0 + a0 * b1) + a0 * b0 }
}

impl From<f64> for DoubleDouble {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let (high, low) = (two_sum(self.high, b.high), two_sum(self.low, b.low));
        let middle = two_sum(high.high, high.low + low.high);
        two_sum(middle.high, middle.low + low.low)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let product = two_product(self.high, b.high);
        two_sum(product.high, product.low + (self.high * b.low + self.low * b.high))
    }
}

impl DoubleDouble {
    /// Long division, a digit of 53 bits at a time.
    fn divided_by(self, b: Self) -> Self {
        let mut rest = self;
        let digits: [f64; 3] = std::array::from_fn(|_| {
            let digit = rest.high / b.high;
            rest = rest - b * Self::from(digit);
            digit
        });
        two_sum(digits[0], digits[1]) + Self::from(digits[2])
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        self.divided_by(b)
    }
}

impl PartialOrd for DoubleDouble {
    fn partial_cmp(&self, b: &Self) -> Option<Ordering> {
        let difference = *self - *b;
        (difference.high + difference.low).partial_cmp(&0.0)
    }
}

impl Number for DoubleDouble {
    const ROUNDOFF: f64 = 1.0 / (1_u128 << 102) as f64;
    fn to_f64(self) -> f64 {
        self.high + self.low
    }
    /// One step of Newton's iteration from the root in `f64`.
    fn sqrt(self) -> Self {
        let root = self.high.sqrt();
        if root == 0.0 {
            return Self::from(0.0);
        }
        let rest = self - two_product(root, root);
        two_sum(root, rest.high / (2.0 * root))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    /// Integers of up to 100 bits, whose sums and products a machine integer holds or bounds.
    #[test]
    fn operations_are_as_exact_as_is_said() {
        let mut rng = SplitMix64::new(1);
        let whole = |n: i128| {
            let high = n as f64;
            two_sum(high, (n - high as i128) as f64)
        };
        let back = |d: DoubleDouble| d.high as i128 + d.low as i128;
        for _ in 0..100_000 {
            let mut integer = |bits: u32| i128::from(rng.next_u64() as i64) >> (64 - bits);
            let (a, b) = (integer(60), integer(60) | 1);
            let (x, y) = (whole(a << 40 | 5), whole(b << 40 | 3));
            assert_eq!(back(x + y), (a << 40 | 5) + (b << 40 | 3));
            assert_eq!(back(x - y), (a << 40 | 5) - (b << 40 | 3));
            // 53 bits are rounded away nowhere: the product of two of them has 106.
            let (a, b) = (integer(52), integer(52) | 1);
            assert_eq!(back(whole(a) * whole(b)), a * b);
            let (product, a, b) = (whole(a * b), whole(a), whole(b));
            let close = |found: DoubleDouble, exact: DoubleDouble| {
                (found - exact).to_f64().abs() <= DoubleDouble::ROUNDOFF * exact.to_f64().abs()
            };
            assert!(close(product / b, a), "{product:?} / {b:?}");
            assert!(close((a * a).sqrt(), if a < 0.0.into() { -a } else { a }), "{a:?}");
            assert_eq!(x.partial_cmp(&(x + 1.0.into())), Some(Ordering::Less), "{x:?}");
            assert_eq!(x.partial_cmp(&x), Some(Ordering::Equal), "{x:?}");
        }
    }
}
