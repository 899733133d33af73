//! Sixteen numbers in double precision.

use std::ops::{Add, Mul, Sub};

use wide::{f32x16, f64x8};

/// Rays in a packlet.
pub(crate) const LANES: usize = 16;
const HALF: usize = LANES / 2;

#[derive(Clone, Copy, Debug)]
pub(crate) struct F64s([f64x8; 2]);

impl F64s {
    #[inline(always)]
    pub(crate) fn splat(x: f64) -> Self {
        Self([f64x8::splat(x); 2])
    }

    #[inline(always)]
    pub(crate) fn from_fn(lane: impl Fn(usize) -> f64) -> Self {
        Self([0, HALF].map(|first| f64x8::new(std::array::from_fn(|n| lane(first + n)))))
    }

    #[inline(always)]
    pub(crate) fn from_f32s(x: f32x16) -> Self {
        let x = x.to_array();
        Self::from_fn(|n| x[n].into())
    }

    #[inline(always)]
    pub(crate) fn lane(self, n: usize) -> f64 {
        self.0[n / HALF % 2].to_array()[n % HALF]
    }

    /// Rounded.
    #[inline(always)]
    pub(crate) fn to_f32s(self) -> f32x16 {
        let [low, high] = self.0.map(f64x8::to_array);
        f32x16::new(std::array::from_fn(|n| if n < HALF { low[n] as f32 } else { high[n - HALF] as f32 }))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64x8, f64x8) -> f64x8) -> Self {
        Self([f(self.0[0], other.0[0]), f(self.0[1], other.0[1])])
    }

    /// `self·b + c`, in one rounding where the build has it.
    #[inline(always)]
    pub(crate) fn mul_add(self, b: Self, c: Self) -> Self {
        Self([0, 1].map(|n| self.0[n].mul_add(b.0[n], c.0[n])))
    }

    /// `c − self·b`, likewise.
    #[inline(always)]
    pub(crate) fn mul_neg_add(self, b: Self, c: Self) -> Self {
        Self([0, 1].map(|n| self.0[n].mul_neg_add(b.0[n], c.0[n])))
    }

    /// The greater; of numbers.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.zip(other, f64x8::fast_max)
    }

    /// The lesser; of numbers.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.zip(other, f64x8::fast_min)
    }

    #[inline(always)]
    pub(crate) fn over(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }

    #[inline(always)]
    pub(crate) fn lt(self, other: Self) -> Lanes {
        Lanes(self.zip(other, |a, b| a.simd_lt(b)))
    }

    #[inline(always)]
    pub(crate) fn eq(self, other: Self) -> Lanes {
        Lanes(self.zip(other, |a, b| a.simd_eq(b)))
    }
}

impl Add for F64s {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for F64s {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for F64s {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

/// Some lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lanes(F64s);

impl Lanes {
    /// Bit `n`: lane `n`.
    #[inline(always)]
    pub(crate) fn bits(self) -> u32 {
        self.0.0[0].to_bitmask() | self.0.0[1].to_bitmask() << HALF
    }

    #[inline(always)]
    pub(crate) fn select(self, a: F64s, b: F64s) -> F64s {
        F64s([0, 1].map(|n| self.0.0[n].select(a.0[n], b.0[n])))
    }
}
