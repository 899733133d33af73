//! Sample types on disk, and their conversion to the types handed out.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use isoray_grid::ScalarType;

use crate::error::Warning;

/// Type of the samples in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleType {
    /// Unsigned 8-bit integer.
    U8,
    /// Signed 8-bit integer.
    I8,
    /// Unsigned 16-bit integer.
    U16,
    /// Signed 16-bit integer.
    I16,
    /// Unsigned 32-bit integer, handed out as `f32`.
    U32,
    /// Signed 32-bit integer, handed out as `f32`.
    I32,
    /// Unsigned 64-bit integer, handed out as `f32`.
    U64,
    /// Signed 64-bit integer, handed out as `f32`.
    I64,
    /// IEEE binary32.
    F32,
    /// IEEE binary64, handed out as `f32`.
    F64,
}

impl SampleType {
    /// Every type.
    pub const ALL: [Self; 10] = [
        Self::U8,
        Self::I8,
        Self::U16,
        Self::I16,
        Self::U32,
        Self::I32,
        Self::U64,
        Self::I64,
        Self::F32,
        Self::F64,
    ];

    /// Bytes of one sample in the file.
    pub fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The short name used by flags and reports, for instance `u16`.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::U64 => "u64",
            Self::I64 => "i64",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    /// The type in which such samples are handed out if they are not rescaled.
    pub fn scalar(self) -> ScalarType {
        match self {
            Self::U8 => ScalarType::U8,
            Self::I8 => ScalarType::I8,
            Self::U16 => ScalarType::U16,
            Self::I16 => ScalarType::I16,
            Self::U32 | Self::I32 | Self::U64 | Self::I64 | Self::F32 | Self::F64 => ScalarType::F32,
        }
    }

    /// Whether samples in memory have the very bits of those in a file of this machine's byte order.
    pub(crate) fn is_scalar(self) -> bool {
        !matches!(self, Self::U32 | Self::I32 | Self::U64 | Self::I64 | Self::F64)
    }
}

impl fmt::Display for SampleType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is no sample type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("sample type: expected u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64, found '{0}'")]
pub struct SampleTypeError(String);

impl FromStr for SampleType {
    type Err = SampleTypeError;

    fn from_str(name: &str) -> Result<Self, SampleTypeError> {
        Self::ALL.into_iter().find(|t| t.name() == name).ok_or_else(|| SampleTypeError(name.to_owned()))
    }
}

/// Byte order of the samples in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Endian {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

impl Endian {
    /// This machine's byte order.
    pub const NATIVE: Self = if cfg!(target_endian = "big") { Self::Big } else { Self::Little };
}

/// Rescaling of stored values: `value = slope · stored + intercept`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    pub(crate) slope: f64,
    pub(crate) intercept: f64,
}

/// Samples that a conversion changed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Losses {
    pub(crate) rounded: u64,
    pub(crate) overflowed: u64,
}

impl Losses {
    /// What the user of `path` should know of them.
    pub(crate) fn warnings(self, path: &Path) -> Vec<Warning> {
        let path = || path.to_owned();
        let Self { rounded, overflowed } = self;
        let rounded = (rounded > 0).then(|| Warning::Rounded { path: path(), samples: rounded });
        let overflowed = (overflowed > 0).then(|| Warning::Overflowed { path: path(), samples: overflowed });
        rounded.into_iter().chain(overflowed).collect()
    }
}

impl std::ops::AddAssign for Losses {
    fn add_assign(&mut self, other: Self) {
        self.rounded += other.rounded;
        self.overflowed += other.overflowed;
    }
}

/// Reverses the bytes of every sample of `size` bytes in place.
pub(crate) fn swap_in_place(bytes: &mut [u8], size: usize) {
    match size {
        2 => bytes
            .as_chunks_mut()
            .0
            .iter_mut()
            .for_each(|c| *c = u16::from_ne_bytes(*c).swap_bytes().to_ne_bytes()),
        4 => bytes
            .as_chunks_mut()
            .0
            .iter_mut()
            .for_each(|c| *c = u32::from_ne_bytes(*c).swap_bytes().to_ne_bytes()),
        8 => bytes
            .as_chunks_mut()
            .0
            .iter_mut()
            .for_each(|c| *c = u64::from_ne_bytes(*c).swap_bytes().to_ne_bytes()),
        _ => {}
    }
}

/// Copies sample `chosen` of every tuple of `count` samples of `size` bytes from `tuples` to `out`.
pub(crate) fn pick(tuples: &[u8], size: usize, count: usize, chosen: usize, out: &mut [u8]) {
    fn sized<const N: usize>(tuples: &[u8], count: usize, chosen: usize, out: &mut [u8]) {
        let samples = tuples.as_chunks::<N>().0;
        for (o, s) in out.as_chunks_mut::<N>().0.iter_mut().zip(samples[chosen..].iter().step_by(count)) {
            *o = *s;
        }
    }
    match size {
        1 => sized::<1>(tuples, count, chosen, out),
        2 => sized::<2>(tuples, count, chosen, out),
        4 => sized::<4>(tuples, count, chosen, out),
        _ => sized::<8>(tuples, count, chosen, out),
    }
}

/// Converts `bytes`, samples of this machine's byte order, to `f32` and counts what that changed.
///
/// A rescaled value is rounded once, from `f64`; that rounding is not counted.
pub(crate) fn to_f32(bytes: &[u8], sample: SampleType, scale: Option<Scale>, out: &mut [f32]) -> Losses {
    match sample {
        SampleType::U8 => integers(bytes, |b| u8::from_ne_bytes(b).into(), scale, out),
        SampleType::I8 => integers(bytes, |b| i8::from_ne_bytes(b).into(), scale, out),
        SampleType::U16 => integers(bytes, |b| u16::from_ne_bytes(b).into(), scale, out),
        SampleType::I16 => integers(bytes, |b| i16::from_ne_bytes(b).into(), scale, out),
        SampleType::U32 => integers(bytes, |b| u32::from_ne_bytes(b).into(), scale, out),
        SampleType::I32 => integers(bytes, |b| i32::from_ne_bytes(b).into(), scale, out),
        SampleType::U64 => long_integers(bytes, |b| u64::from_ne_bytes(b).into(), scale, out),
        SampleType::I64 => long_integers(bytes, |b| i64::from_ne_bytes(b).into(), scale, out),
        SampleType::F32 => floats(bytes, |b| f32::from_ne_bytes(b).into(), scale, out),
        SampleType::F64 => floats(bytes, f64::from_ne_bytes, scale, out),
    }
}

/// Rescales without counting.
fn rescale<const N: usize>(bytes: &[u8], decode: impl Fn([u8; N]) -> f64, scale: Scale, out: &mut [f32]) {
    for (o, b) in out.iter_mut().zip(bytes.as_chunks().0) {
        *o = (decode(*b) * scale.slope + scale.intercept) as f32;
    }
}

/// Integers of at most 32 bits: exact in `f64`.
fn integers<const N: usize>(
    bytes: &[u8],
    decode: impl Fn([u8; N]) -> f64,
    scale: Option<Scale>,
    out: &mut [f32],
) -> Losses {
    if let Some(scale) = scale {
        rescale(bytes, decode, scale, out);
        return Losses::default();
    }
    let mut rounded = 0u64;
    for (o, b) in out.iter_mut().zip(bytes.as_chunks().0) {
        let value = decode(*b);
        *o = value as f32;
        rounded += u64::from(f64::from(*o) != value);
    }
    Losses { rounded, overflowed: 0 }
}

/// 64-bit integers: rounded once, not through `f64`, in which they are not exact.
fn long_integers(
    bytes: &[u8],
    decode: impl Fn([u8; 8]) -> i128,
    scale: Option<Scale>,
    out: &mut [f32],
) -> Losses {
    if let Some(scale) = scale {
        rescale(bytes, |b| decode(b) as f64, scale, out);
        return Losses::default();
    }
    let mut rounded = 0u64;
    for (o, b) in out.iter_mut().zip(bytes.as_chunks().0) {
        let value = decode(*b);
        *o = value as f32;
        rounded += u64::from(*o as i128 != value);
    }
    Losses { rounded, overflowed: 0 }
}

/// Floating-point samples: NaN and infinities stay what they are and are not counted.
fn floats<const N: usize>(
    bytes: &[u8],
    decode: impl Fn([u8; N]) -> f64,
    scale: Option<Scale>,
    out: &mut [f32],
) -> Losses {
    if let Some(scale) = scale {
        rescale(bytes, decode, scale, out);
        return Losses::default();
    }
    let mut losses = Losses::default();
    for (o, b) in out.iter_mut().zip(bytes.as_chunks().0) {
        let value = decode(*b);
        *o = value as f32;
        let overflowed = value.is_finite() & !o.is_finite();
        losses.overflowed += u64::from(overflowed);
        losses.rounded += u64::from((f64::from(*o) != value) & !value.is_nan() & !overflowed);
    }
    losses
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for t in SampleType::ALL {
            assert_eq!(t.name().parse(), Ok(t));
        }
        assert!("float".parse::<SampleType>().unwrap_err().to_string().contains("found 'float'"));
    }

    #[test]
    fn counts_losses() {
        let bytes: Vec<u8> = [1, (1 << 24) + 1, -7i32].iter().flat_map(|v| v.to_ne_bytes()).collect();
        let mut out = [0f32; 3];
        let losses = to_f32(&bytes, SampleType::I32, None, &mut out);
        assert_eq!((losses.rounded, losses.overflowed), (1, 0));
        assert_eq!(out[2], -7.0);

        // Through f64, the first would be rounded twice, to 2^60.
        let values = [(1i64 << 60) + (1 << 36) + 1, i64::MIN, -7];
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
        let losses = to_f32(&bytes, SampleType::I64, None, &mut out);
        assert_eq!((losses.rounded, losses.overflowed), (1, 0));
        assert_eq!(out, [((1u64 << 60) + (1 << 37)) as f32, -(2f32.powi(63)), -7.0]);

        let values = [0.5, 0.1, 1e300, f64::NAN, f64::INFINITY];
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
        let mut out = [0f32; 5];
        let losses = to_f32(&bytes, SampleType::F64, None, &mut out);
        assert_eq!((losses.rounded, losses.overflowed), (1, 1));
        assert!(out[3].is_nan() && out[2] == f32::INFINITY);
    }

    #[test]
    fn picks_and_swaps() {
        let tuples = [1u8, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
        let mut out = [0u8; 4];
        pick(&tuples, 2, 3, 1, &mut out);
        assert_eq!(out, [3, 4, 9, 10]);
        swap_in_place(&mut out, 2);
        assert_eq!(out, [4, 3, 10, 9]);
    }
}
