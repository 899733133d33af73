//! The numbers that formulas are written for: one at a time, or several in lanes.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use wide::{f32x4, f32x8, f32x16};

/// The outcome of a comparison, lane by lane.
pub trait Mask:
    Copy
    + Debug
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Not<Output = Self>
    + sealed::Sealed
{
    /// What holds in no lane.
    fn never() -> Self;
    /// Whether it holds in any lane.
    fn any(self) -> bool;
    /// Whether it holds in all lanes.
    fn all(self) -> bool;
    /// Bit `n`: it holds in lane `n`.
    fn bits(self) -> u32;
}

/// `f32` or `f64`, or lanes of `f32` that are computed at once. Every operation gives in each lane what it gives on that lane's number
/// alone, bit for bit, so that formulas agree between scalar and lanes within one build.
pub trait Real:
    Copy
    + Debug
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + sealed::Sealed
{
    /// What comparisons give.
    type Mask: Mask;
    /// The number in one lane.
    type Scalar: Copy + Debug + PartialOrd + Into<f64>;
    /// Number of lanes.
    const LANES: usize;
    /// Distance from 1 to the next larger number.
    const EPSILON: f64;
    /// Added to a number of magnitude below `2²¹`, rounds it to a whole one, which is had back by subtracting.
    const ROUNDER: f64;

    /// The nearest number to `x`, in all lanes.
    fn splat(x: f64) -> Self;
    /// By lane.
    fn from_lanes(lane: impl FnMut(usize) -> Self::Scalar) -> Self;
    /// Numbers of several lanes, each of which `lane` gives whole.
    #[inline(always)]
    fn gather<const N: usize>(lane: impl Fn(usize) -> [Self::Scalar; N]) -> [Self; N] {
        std::array::from_fn(|k| Self::from_lanes(|n| lane(n)[k]))
    }
    /// The number in lane `n`, which is less than [`LANES`](Self::LANES).
    fn lane(self, n: usize) -> Self::Scalar;

    /// `self·b + c`: rounded once where the build has the instruction, else twice.
    fn fma(self, b: Self, c: Self) -> Self;
    /// `c − self·b`, likewise.
    fn neg_fma(self, b: Self, c: Self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// The magnitude of `self` with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;

    /// `2ⁿ`, of `self = ROUNDER + n` with `-126 ≤ n ≤ 127`.
    fn power_of_two(self) -> Self;

    /// `self ≥ b`.
    fn ge(self, b: Self) -> Self::Mask;
    /// `self > b`.
    fn gt(self, b: Self) -> Self::Mask;
    /// `a` where `mask` holds, `b` elsewhere.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;

    /// `self ≤ b`.
    #[inline(always)]
    fn le(self, b: Self) -> Self::Mask {
        b.ge(self)
    }
    /// `self < b`.
    #[inline(always)]
    fn lt(self, b: Self) -> Self::Mask {
        b.gt(self)
    }
    /// The lesser; `b` if either is not a number.
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        Self::select(b.gt(self), self, b)
    }
    /// The greater; `b` if either is not a number.
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        Self::select(self.gt(b), self, b)
    }
    /// Numbers whose lanes are each computed alone, by a function that has no form in lanes.
    #[inline(always)]
    fn map(self, f: impl Fn(Self::Scalar) -> Self::Scalar) -> Self {
        Self::from_lanes(|n| f(self.lane(n)))
    }
    /// Cube root, of every lane alone.
    fn cbrt(self) -> Self;
    /// Arc cosine, of every lane alone.
    fn acos(self) -> Self;
    /// Cosine, of every lane alone.
    fn cos(self) -> Self;
    /// `self` to the power of `exponent`, of every lane alone.
    fn powf(self, exponent: f32) -> Self;

    /// Trilinear interpolants at the eight corners of a box; `low` and `high` are its lower and upper corners. The order of results
    /// is that of the corners: x fastest.
    #[inline(always)]
    fn trilinear_at_box(corners: &[Self; 8], low: &[Self; 3], high: &[Self; 3]) -> [Self; 8] {
        let c = corners;
        let ends = |axis: usize, n: usize, bit: usize| if n >> bit & 1 == 1 { high[axis] } else { low[axis] };
        // By edge of the cell (bits y, z from bit 1) and by end along x (bit 0).
        let x: [Self; 8] = std::array::from_fn(|n| crate::lerp(c[n & 6], c[n & 6 | 1], ends(0, n, 0)));
        // Bits: end along x, end along y, upper face.
        let y: [Self; 8] = std::array::from_fn(|n| crate::lerp(x[n & 5], x[n & 5 | 2], ends(1, n, 1)));
        std::array::from_fn(|n| crate::lerp(y[n & 3], y[n & 3 | 4], ends(2, n, 2)))
    }
}

/// `a·b + c`: rounded once where the build has the instruction, else twice.
///
/// Scalar code and lanes call this and nothing else, so that they agree bit for bit in one build.
/// `f32::mul_add` itself becomes a library call without the instruction, ten times as slow.
#[inline(always)]
pub fn fma<R: Real>(a: R, b: R, c: R) -> R {
    a.fma(b, c)
}

mod sealed {
    pub trait Sealed {}
}

impl sealed::Sealed for bool {}

impl Mask for bool {
    #[inline(always)]
    fn never() -> Self {
        false
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self.into()
    }
}

/// Whether the build has fused multiply-add.
const FUSED: bool = cfg!(any(target_feature = "fma", target_arch = "aarch64"));

macro_rules! scalar {
    ($scalar:ident { $($special:item)* }) => {
        impl sealed::Sealed for $scalar {}

        impl Real for $scalar {
            type Mask = bool;
            type Scalar = $scalar;
            const LANES: usize = 1;
            const EPSILON: f64 = $scalar::EPSILON as f64;
            const ROUNDER: f64 = 1.5 / $scalar::EPSILON as f64;

            #[inline(always)]
            fn splat(x: f64) -> Self {
                x as $scalar
            }
            #[inline(always)]
            fn power_of_two(self) -> Self {
                // The lowest bits count units: moved to the exponent, and offset by that of 1.
                const MANTISSA: u32 = $scalar::MANTISSA_DIGITS - 1;
                $scalar::from_bits((self.to_bits() << MANTISSA).wrapping_add($scalar::to_bits(1.0)))
            }
            #[inline(always)]
            fn from_lanes(mut lane: impl FnMut(usize) -> $scalar) -> Self {
                lane(0)
            }
            #[inline(always)]
            fn lane(self, _: usize) -> $scalar {
                self
            }
            #[inline(always)]
            fn fma(self, b: Self, c: Self) -> Self {
                if FUSED {
                    #[expect(clippy::disallowed_methods, reason = "the one place that knows the instruction exists")]
                    self.mul_add(b, c)
                } else {
                    self * b + c
                }
            }
            #[inline(always)]
            fn neg_fma(self, b: Self, c: Self) -> Self {
                Real::fma(-self, b, c)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $scalar::abs(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $scalar::sqrt(self)
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                $scalar::copysign(self, sign)
            }
            #[inline(always)]
            fn ge(self, b: Self) -> bool {
                self >= b
            }
            #[inline(always)]
            fn gt(self, b: Self) -> bool {
                self > b
            }
            #[inline(always)]
            fn select(mask: bool, a: Self, b: Self) -> Self {
                if mask { a } else { b }
            }
            fn cbrt(self) -> Self {
                $scalar::cbrt(self)
            }
            fn acos(self) -> Self {
                $scalar::acos(self)
            }
            fn cos(self) -> Self {
                $scalar::cos(self)
            }
            fn powf(self, exponent: f32) -> Self {
                $scalar::powf(self, exponent.into())
            }
            $($special)*
        }
    };
}

scalar!(f64 {});
scalar!(f32 {
    // Eight interpolations at a time.
    #[inline(always)]
    fn trilinear_at_box(corners: &[f32; 8], low: &[f32; 3], high: &[f32; 3]) -> [f32; 8] {
        let lerps = |a: [f32; 8], b: [f32; 8], t: [f32; 8]| {
            let [a, b, t] = [a, b, t].map(f32x8::new);
            crate::lerp(a, b, t).to_array()
        };
        let ends = |a: usize, bit: usize| std::array::from_fn(|n| if n >> bit & 1 == 1 { high[a] } else { low[a] });
        let pick = |v: &[f32; 8], bit: usize, upper: usize| std::array::from_fn(|n| v[n & !(1 << bit) | upper << bit]);
        let x = lerps(pick(corners, 0, 0), pick(corners, 0, 1), ends(0, 0));
        let y = lerps(pick(&x, 1, 0), pick(&x, 1, 1), ends(1, 1));
        lerps(pick(&y, 2, 0), pick(&y, 2, 1), ends(2, 2))
    }
});

macro_rules! lanes {
    ($($lanes:ident: $n:literal),*) => { $(
        impl sealed::Sealed for $lanes {}

        impl Mask for $lanes {
            #[inline(always)]
            fn never() -> Self {
                $lanes::ZERO
            }
            #[inline(always)]
            fn any(self) -> bool {
                $lanes::any(self)
            }
            #[inline(always)]
            fn all(self) -> bool {
                $lanes::all(self)
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                self.to_bitmask()
            }
        }

        impl Real for $lanes {
            type Mask = Self;
            type Scalar = f32;
            const LANES: usize = $n;
            const EPSILON: f64 = f32::EPSILON as f64;
            const ROUNDER: f64 = <f32 as Real>::ROUNDER;

            #[inline(always)]
            fn splat(x: f64) -> Self {
                $lanes::splat(x as f32)
            }
            #[inline(always)]
            fn power_of_two(self) -> Self {
                $lanes::new(self.to_array().map(Real::power_of_two))
            }
            #[inline(always)]
            fn from_lanes(lane: impl FnMut(usize) -> f32) -> Self {
                $lanes::new(std::array::from_fn(lane))
            }
            #[inline(always)]
            fn lane(self, n: usize) -> f32 {
                self.to_array()[n]
            }
            #[inline(always)]
            fn fma(self, b: Self, c: Self) -> Self {
                self.mul_add(b, c)
            }
            #[inline(always)]
            fn neg_fma(self, b: Self, c: Self) -> Self {
                self.mul_neg_add(b, c)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $lanes::abs(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $lanes::sqrt(self)
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                $lanes::copysign(self, sign)
            }
            #[inline(always)]
            fn ge(self, b: Self) -> Self {
                self.simd_ge(b)
            }
            #[inline(always)]
            fn gt(self, b: Self) -> Self {
                self.simd_gt(b)
            }
            #[inline(always)]
            fn select(mask: Self, a: Self, b: Self) -> Self {
                mask.select(a, b)
            }
            fn cbrt(self) -> Self {
                self.map(f32::cbrt)
            }
            fn acos(self) -> Self {
                self.map(f32::acos)
            }
            fn cos(self) -> Self {
                self.map(f32::cos)
            }
            fn powf(self, exponent: f32) -> Self {
                self.map(|x| x.powf(exponent))
            }
        }
    )* };
}

lanes!(f32x4: 4, f32x8: 8, f32x16: 16);
