//! The sample types.

use std::fmt;

use wide::{f32x16, i8x16, i8x64, i16x16, i16x32, u8x16, u8x64, u16x16, u16x32};
use zerocopy::little_endian::{F32, I16, U16};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Which of the five sample types a volume holds; the number is the one stored in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ScalarType {
    /// Unsigned 8-bit integer.
    U8 = 1,
    /// Signed 8-bit integer.
    I8 = 2,
    /// Unsigned 16-bit integer.
    U16 = 3,
    /// Signed 16-bit integer.
    I16 = 4,
    /// IEEE binary32; NaN and infinities are legal and make the cells that touch them empty.
    F32 = 5,
}

impl ScalarType {
    /// Every type, in the order of their stored numbers.
    pub const ALL: [Self; 5] = [Self::U8, Self::I8, Self::U16, Self::I16, Self::F32];

    /// Bytes of one sample.
    pub fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::F32 => 4,
        }
    }

    /// The short name used by flags and reports: `u8`, `i8`, `u16`, `i16` or `f32`.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::F32 => "f32",
        }
    }

    /// The type with stored number `n`.
    pub fn from_number(n: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|&t| t as u8 == n)
    }
}

impl fmt::Display for ScalarType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A sample type: every value but an `f32`'s NaN and infinities is exact in `f32`.
pub trait Scalar:
    Copy
    + Default
    + PartialOrd
    + fmt::Debug
    + Send
    + Sync
    + FromBytes
    + IntoBytes
    + Immutable
    + KnownLayout
    + 'static
{
    /// This type's tag.
    const TYPE: ScalarType;
    /// Smallest finite value.
    const LOWEST: Self;
    /// Largest finite value.
    const HIGHEST: Self;

    /// The little-endian form of alignment 1 that lies in files.
    type Stored: Copy
        + fmt::Debug
        + Send
        + Sync
        + FromBytes
        + IntoBytes
        + Immutable
        + KnownLayout
        + Unaligned
        + From<Self>
        + Into<Self>
        + 'static;

    /// The value as `f32`, exactly.
    fn to_f32(self) -> f32;
    /// Neither NaN nor infinite; always true for integers.
    fn is_finite(self) -> bool;
    /// Bitwise equality: unlike `==` it merges NaNs and keeps `-0.0` from `0.0`.
    fn same_bits(self, other: Self) -> bool;
    /// The isovalue `v` in a form that compares with samples of this type; see [`Threshold`].
    fn threshold(v: f32) -> Threshold<Self>;

    /// Whether differences of values are whole numbers that tell one value from the other; true for integers.
    const IS_INTEGER: bool;
    /// The value's bits, zero-extended.
    fn to_bits(self) -> u32;
    /// The value of the lowest bits.
    fn from_bits(bits: u32) -> Self;
    /// How far an integer is above another one; of floating-point numbers only the sign means something.
    fn steps_above(self, other: Self) -> i32;

    /// Bit `n` of the answer says `samples[n] ≥ threshold`, false for NaN; one vector comparison.
    fn at_least_16(samples: &[Self::Stored; 16], threshold: Self) -> u32;
    /// As [`at_least_16`](Self::at_least_16), for a block of 4³ samples.
    fn at_least_64(samples: &[Self::Stored; 64], threshold: Self) -> u64;
}

/// An isovalue as the least sample value that is *inside*.
///
/// A sample `s` is inside where `s ≥ v`. For an integer type that is `s ≥ ceil(v)`, a comparison of
/// integers; where no sample can be inside, or none outside, that is said apart, since `ceil(v)` is then
/// no value of the type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold<T> {
    /// Inside exactly where `s ≥` this value.
    AtLeast(T),
    /// Every sample is inside, or none is: there is no surface.
    NoSurface,
}

macro_rules! integer_scalar {
    ($t:ty, $unsigned:ty, $stored:ty, $tag:expr, $lanes16:ty, $widest:ty) => {
        impl Scalar for $t {
            const TYPE: ScalarType = $tag;
            const LOWEST: Self = <$t>::MIN;
            const HIGHEST: Self = <$t>::MAX;
            type Stored = $stored;

            fn to_f32(self) -> f32 {
                f32::from(self)
            }
            fn is_finite(self) -> bool {
                true
            }
            fn same_bits(self, other: Self) -> bool {
                self == other
            }
            fn threshold(v: f32) -> Threshold<Self> {
                let least = v.ceil();
                // At the lowest value every sample is inside; a NaN has no surface either.
                if least > f32::from(<$t>::MIN) && least <= f32::from(<$t>::MAX) {
                    Threshold::AtLeast(least as $t)
                } else {
                    Threshold::NoSurface
                }
            }
            const IS_INTEGER: bool = true;
            #[inline(always)]
            fn to_bits(self) -> u32 {
                (self as $unsigned).into()
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                bits as $t
            }
            #[inline(always)]
            fn steps_above(self, other: Self) -> i32 {
                i32::from(self) - i32::from(other)
            }
            #[inline(always)]
            fn at_least_16(samples: &[$stored; 16], threshold: Self) -> u32 {
                <$lanes16>::new(samples.map(Into::into)).simd_ge(<$lanes16>::splat(threshold)).to_bitmask()
            }
            #[inline(always)]
            fn at_least_64(samples: &[$stored; 64], threshold: Self) -> u64 {
                const LANES: usize = size_of::<$widest>() / size_of::<$t>();
                let (chunks, _) = samples.as_chunks::<LANES>();
                let mut mask = 0;
                for (n, chunk) in chunks.iter().enumerate() {
                    let lanes = <$widest>::new(chunk.map(Into::into));
                    mask |= u64::from(lanes.simd_ge(<$widest>::splat(threshold)).to_bitmask()) << (n * LANES);
                }
                mask
            }
        }
    };
}

integer_scalar!(u8, u8, u8, ScalarType::U8, u8x16, u8x64);
integer_scalar!(i8, u8, i8, ScalarType::I8, i8x16, i8x64);
integer_scalar!(u16, u16, U16, ScalarType::U16, u16x16, u16x32);
integer_scalar!(i16, u16, I16, ScalarType::I16, i16x16, i16x32);

impl Scalar for f32 {
    const TYPE: ScalarType = ScalarType::F32;
    const LOWEST: Self = f32::MIN;
    const HIGHEST: Self = f32::MAX;
    type Stored = F32;

    fn to_f32(self) -> f32 {
        self
    }
    fn is_finite(self) -> bool {
        f32::is_finite(self)
    }
    fn same_bits(self, other: Self) -> bool {
        self.to_bits() == other.to_bits()
    }
    fn threshold(v: f32) -> Threshold<Self> {
        if v.is_finite() { Threshold::AtLeast(v) } else { Threshold::NoSurface }
    }
    const IS_INTEGER: bool = false;
    #[inline(always)]
    fn to_bits(self) -> u32 {
        self.to_bits()
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self::from_bits(bits)
    }
    #[inline(always)]
    fn steps_above(self, other: Self) -> i32 {
        i32::from(self > other) - i32::from(self < other)
    }
    #[inline(always)]
    fn at_least_16(samples: &[F32; 16], threshold: Self) -> u32 {
        f32x16::new(samples.map(Into::into)).simd_ge(f32x16::splat(threshold)).to_bitmask()
    }
    #[inline(always)]
    fn at_least_64(samples: &[F32; 64], threshold: Self) -> u64 {
        let (chunks, _) = samples.as_chunks::<16>();
        let mut mask = 0;
        for (n, chunk) in chunks.iter().enumerate() {
            mask |= u64::from(Self::at_least_16(chunk, threshold)) << (n * 16);
        }
        mask
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threshold_agrees_with_comparison_in_reals() {
        for v in [-300.5f32, -128.0, -0.5, 0.0, 0.25, 41.999, 42.0, 42.001, 127.0, 255.0, 255.5, 1e9] {
            for s in u8::MIN..=u8::MAX {
                let inside = match u8::threshold(v) {
                    Threshold::AtLeast(c) => s >= c,
                    Threshold::NoSurface => f32::from(u8::MIN) >= v,
                };
                assert_eq!(inside, f32::from(s) >= v, "{s} against {v}");
            }
        }
        assert_eq!(i16::threshold(f32::NAN), Threshold::NoSurface);
        assert_eq!(i8::threshold(-128.0), Threshold::NoSurface);
        assert_eq!(i16::threshold(-300.5), Threshold::AtLeast(-300));
    }

    fn lanes_agree<T: Scalar>(values: impl Fn(usize) -> T) {
        let samples: [T; 64] = std::array::from_fn(values);
        let stored = samples.map(T::Stored::from);
        for threshold in samples {
            let expected = (0..64).fold(0u64, |m, n| m | u64::from(samples[n] >= threshold) << n);
            assert_eq!(T::at_least_64(&stored, threshold), expected, "{threshold:?}");
            let first = stored.as_chunks::<16>().0[1];
            assert_eq!(
                u64::from(T::at_least_16(&first, threshold)),
                expected >> 16 & 0xffff,
                "{threshold:?}"
            );
        }
    }

    #[test]
    fn lanes_agree_with_scalar_comparison() {
        lanes_agree(|n| (n * 37 % 256) as u8);
        lanes_agree(|n| (n * 37 % 256) as u8 as i8);
        lanes_agree(|n| (n * 9973) as u16);
        lanes_agree(|n| (n * 9973) as u16 as i16);
        lanes_agree(|n| match n {
            7 => f32::NAN,
            9 => f32::INFINITY,
            11 => -0.0,
            13 => f32::NEG_INFINITY,
            _ => (n * 31 % 64) as f32 - 32.0,
        });
    }

    #[test]
    fn numbers_round_trip() {
        for t in ScalarType::ALL {
            assert_eq!(ScalarType::from_number(t as u8), Some(t));
        }
        assert_eq!(ScalarType::from_number(0), None);
    }
}
