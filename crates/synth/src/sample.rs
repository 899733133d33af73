//! The types that volumes are made of.

use isoray_grid::Scalar;

/// A sample type that every field can be made in: `u8`, `u16` or `f32`.
///
/// Fields that are defined as grey values from 0 to 255 keep them in `u8` and `f32`; in `u16` they are 257 times as
/// large, so that 255 becomes 65535.
pub trait Sample: Scalar {
    /// What grey value 255 becomes.
    const FULL: f32;

    /// The sample nearest to `v`, of two the even one. Unspecified, but the same on every machine, unless
    /// `0 ≤ v ≤` [`FULL`](Self::FULL) or the type is `f32`.
    fn nearest(v: f32) -> Self;

    /// As [`nearest`](Self::nearest), from `f64`.
    fn nearest_f64(v: f64) -> Self;

    /// The upper bits as a sample: 32 random bits give one as random, in `f32` a multiple of 255/2²⁴ below 255.
    fn from_random(bits: u32) -> Self;
}

// Adding 2^23 (2^52) leaves no bits for fractions: the sum is rounded to the nearest integer, of two the even one,
// and its lowest bits are that integer. A compiler makes vector instructions of this, unlike of `round`.
const UNIT: f32 = (1u32 << 23) as f32;
const UNIT_F64: f64 = (1u64 << 52) as f64;

impl Sample for u8 {
    const FULL: f32 = 255.0;
    #[inline(always)]
    fn nearest(v: f32) -> Self {
        (v + UNIT).to_bits() as u8
    }
    #[inline(always)]
    fn nearest_f64(v: f64) -> Self {
        (v + UNIT_F64).to_bits() as u8
    }
    #[inline(always)]
    fn from_random(bits: u32) -> Self {
        (bits >> 24) as u8
    }
}

impl Sample for u16 {
    const FULL: f32 = 65535.0;
    #[inline(always)]
    fn nearest(v: f32) -> Self {
        (v + UNIT).to_bits() as u16
    }
    #[inline(always)]
    fn nearest_f64(v: f64) -> Self {
        (v + UNIT_F64).to_bits() as u16
    }
    #[inline(always)]
    fn from_random(bits: u32) -> Self {
        (bits >> 16) as u16
    }
}

impl Sample for f32 {
    const FULL: f32 = 255.0;
    #[inline(always)]
    fn nearest(v: f32) -> Self {
        v
    }
    #[inline(always)]
    fn nearest_f64(v: f64) -> Self {
        v as f32
    }
    #[inline(always)]
    fn from_random(bits: u32) -> Self {
        (bits >> 8) as f32 * (255.0 / (1u32 << 24) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_to_nearest_even() {
        for n in 0..=65535u16 {
            for offset in [-0.5, -0.25, 0.0, 0.25, 0.5] {
                let v = (f64::from(n) + offset).clamp(0.0, 65535.0);
                assert_eq!(u16::nearest(v as f32), v.round_ties_even() as u16);
                assert_eq!(u16::nearest_f64(v), v.round_ties_even() as u16);
                if v <= 255.0 {
                    assert_eq!(u8::nearest(v as f32), v.round_ties_even() as u8);
                    assert_eq!(u8::nearest_f64(v), v.round_ties_even() as u8);
                }
            }
        }
    }
}
