//! How many rays go together: sixteen in registers of 256 and 512 bits, eight in those of 128; and as many numbers in double precision.
//!
//! Two registers of the shorter ones are better filled than one: measured in `docs/experiments.md`, Packets. `--cfg isoray_lanes="4"`, `"8"` or `"16"` in `RUSTFLAGS` sets another
//! number, for measurements and tests: hits are the same, bit for bit.

use std::ops::{Add, Div, Mul, Sub};

use isoray_trace::Doubles;
use wide::{f32x4, f32x8, f32x16, f64x2, f64x4, f64x8};

/// Rays that are intersected at once, in this build.
pub const LANES: usize = if cfg!(isoray_lanes = "16") {
    16
} else if cfg!(isoray_lanes = "8") {
    8
} else if cfg!(isoray_lanes = "4") {
    4
} else if cfg!(target_feature = "avx2") {
    16
} else {
    8
};

/// What so many lanes are kept in.
pub(crate) trait Width {
    type F32s;
    type F64Half;
}

impl Width for [(); 4] {
    type F32s = f32x4;
    type F64Half = f64x2;
}

impl Width for [(); 8] {
    type F32s = f32x8;
    type F64Half = f64x4;
}

impl Width for [(); 16] {
    type F32s = f32x16;
    type F64Half = f64x8;
}

pub(crate) type F32s = <[(); LANES] as Width>::F32s;
type F64Half = <[(); LANES] as Width>::F64Half;

const HALF: usize = LANES / 2;

/// The least of all lanes.
#[inline(always)]
pub(crate) fn least(lanes: F32s) -> f32 {
    folded(&lanes.to_array(), f32x8::fast_min, f32x4::fast_min, f32::min)
}

/// The greatest of all lanes.
#[inline(always)]
pub(crate) fn greatest(lanes: F32s) -> f32 {
    folded(&lanes.to_array(), f32x8::fast_max, f32x4::fast_max, f32::max)
}

/// All lanes together, half with half.
#[inline(always)]
fn folded(
    lanes: &[f32],
    of_eight: impl Fn(f32x8, f32x8) -> f32x8,
    of_four: impl Fn(f32x4, f32x4) -> f32x4,
    of_one: impl Fn(f32, f32) -> f32,
) -> f32 {
    let eight = |first: usize| f32x8::new(std::array::from_fn(|n| lanes[first + n]));
    let four = |of: &[f32], first: usize| f32x4::new(std::array::from_fn(|n| of[first + n]));
    let four = match LANES {
        16 => {
            let eight = of_eight(eight(0), eight(8)).to_array();
            of_four(four(&eight, 0), four(&eight, 4))
        }
        8 => of_four(four(lanes, 0), four(lanes, 4)),
        _ => four(lanes, 0),
    };
    let [a, b, c, d] = four.to_array();
    let [e, f, ..] = of_four(f32x4::new([a, b, a, b]), f32x4::new([c, d, c, d])).to_array();
    of_one(e, f)
}

/// Eight numbers of each row, in lanes.
#[inline(always)]
pub(crate) fn columns(row: impl Fn(usize) -> [f32; 8]) -> [F32s; 8] {
    if LANES == 4 {
        let rows: [[f32; 8]; LANES] = std::array::from_fn(row);
        return std::array::from_fn(|k| F32s::new(rows.map(|row| row[k])));
    }
    let eight = |first: usize| f32x8::transpose(std::array::from_fn(|n| f32x8::new(row(first + n))));
    let (low, high) = (eight(0), eight(LANES - 8));
    let [low, high] = [low, high].map(|columns| columns.map(f32x8::to_array));
    std::array::from_fn(|k| {
        F32s::new(std::array::from_fn(|n| if n < 8 { low[k][n] } else { high[k][n - 8] }))
    })
}

/// As many numbers as there are lanes, in double precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F64s([F64Half; 2]);

impl F64s {
    #[inline(always)]
    pub(crate) fn splat(x: f64) -> Self {
        Self([F64Half::splat(x); 2])
    }

    #[inline(always)]
    pub(crate) fn from_fn(lane: impl Fn(usize) -> f64) -> Self {
        Self([0, HALF].map(|first| F64Half::new(std::array::from_fn(|n| lane(first + n)))))
    }

    #[inline(always)]
    pub(crate) fn from_f32s(x: F32s) -> Self {
        let x = x.to_array();
        Self::from_fn(|n| x[n].into())
    }

    #[inline(always)]
    pub(crate) fn lane(self, n: usize) -> f64 {
        self.0[n / HALF % 2].to_array()[n % HALF]
    }

    /// Rounded.
    #[inline(always)]
    pub(crate) fn to_f32s(self) -> F32s {
        let [low, high] = self.0.map(F64Half::to_array);
        F32s::new(std::array::from_fn(|n| if n < HALF { low[n] as f32 } else { high[n - HALF] as f32 }))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(F64Half, F64Half) -> F64Half) -> Self {
        Self([f(self.0[0], other.0[0]), f(self.0[1], other.0[1])])
    }

    /// The greater; of numbers.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.zip(other, F64Half::fast_max)
    }

    /// The lesser; of numbers.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.zip(other, F64Half::fast_min)
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

impl Doubles for F64s {
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self([0, 1].map(|n| self.0[n].mul_add(b.0[n], c.0[n])))
    }

    #[inline(always)]
    fn mul_neg_add(self, b: Self, c: Self) -> Self {
        Self([0, 1].map(|n| self.0[n].mul_neg_add(b.0[n], c.0[n])))
    }
}

impl Div for F64s {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
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
