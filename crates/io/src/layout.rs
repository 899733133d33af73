//! What a header says, in one form for every format.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use isoray_grid::{Dims, ScalarType};

use crate::coding::Coding;
use crate::error::ReadError;
use crate::sample::{Endian, SampleType, Scale};

/// Where in a file the samples, or the stream that holds them, begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    /// Bytes from the beginning of the file.
    At(u64),
    /// The samples are the last bytes of the file.
    FromEnd,
}

/// How the components of a sample lie in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// All components of a sample side by side.
    Interleaved,
    /// One whole volume after the other.
    Planar,
}

/// Everything that is needed to read samples.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub(crate) dims: Dims,
    pub(crate) sample: SampleType,
    pub(crate) endian: Endian,
    /// Components in the file.
    pub(crate) components: u64,
    /// The component to read.
    pub(crate) component: u64,
    pub(crate) order: Order,
    pub(crate) scale: Option<Scale>,
    pub(crate) index_to_world: DAffine3,
    /// The file that holds the samples.
    pub(crate) data: PathBuf,
    pub(crate) start: Start,
    /// The byte of the file at which the samples or their stream end, where something else follows.
    pub(crate) end: Option<u64>,
    pub(crate) coding: Coding,
    /// Bytes of a decoded stream before the first sample.
    pub(crate) stream_skip: u64,
}

/// Most components side by side that are read; it bounds the buffer for one sample.
const MAX_INTERLEAVED: u64 = 1 << 16;

impl Layout {
    /// A one-component layout of uncoded samples at the start of `data`, one world unit apart.
    pub(crate) fn new(dims: Dims, sample: SampleType, endian: Endian, data: PathBuf) -> Self {
        Self {
            dims,
            sample,
            endian,
            components: 1,
            component: 0,
            order: Order::Interleaved,
            scale: None,
            index_to_world: DAffine3::IDENTITY,
            data,
            start: Start::At(0),
            end: None,
            coding: Coding::Raw,
            stream_skip: 0,
        }
    }

    /// Type of the samples handed out.
    pub(crate) fn scalar(&self) -> ScalarType {
        if self.scale.is_some() { ScalarType::F32 } else { self.sample.scalar() }
    }

    /// Whether stored samples are handed out with the same value and type.
    pub(crate) fn is_unconverted(&self) -> bool {
        self.scale.is_none() && self.sample.is_scalar()
    }

    /// Whether consecutive samples of a component are consecutive in the file.
    pub(crate) fn is_contiguous(&self) -> bool {
        self.components == 1 || self.order == Order::Planar
    }

    /// [`stored_bytes`](Self::stored_bytes) of a layout that has not been checked.
    pub(crate) fn claimed_bytes(&self) -> u128 {
        self.dims.samples() as u128 * self.sample.size() as u128 * u128::from(self.components)
    }

    /// Bytes of all samples and components, as stored and decoded.
    pub(crate) fn stored_bytes(&self) -> u64 {
        self.dims.samples() as u64 * self.sample.size() as u64 * self.components
    }

    /// Takes the user's choice of a component, and checks the numbers that later arithmetic relies on.
    pub(crate) fn choose(mut self, path: &Path, component: Option<usize>) -> Result<Self, ReadError> {
        let bytes = self.claimed_bytes();
        if bytes > i64::MAX as u128 {
            return Err(ReadError::field(
                path,
                "size of all components",
                "fewer than 2^63 bytes",
                format!("{bytes} bytes"),
            ));
        }
        if self.order == Order::Interleaved && self.components > MAX_INTERLEAVED {
            return Err(ReadError::unsupported(
                path,
                "so many components side by side",
                "at most 65536",
                self.components,
            ));
        }
        let count = self.components;
        self.component = match component {
            None if count > 1 => return Err(ReadError::ChooseComponent { path: path.to_owned(), count }),
            None => 0,
            Some(chosen) if (chosen as u64) < count => chosen as u64,
            Some(chosen) => return Err(ReadError::NoSuchComponent { path: path.to_owned(), count, chosen }),
        };
        Ok(self)
    }
}

/// Checks three sample counts of a header.
pub(crate) fn dims(path: &Path, n: [u64; 3]) -> Result<Dims, ReadError> {
    let [Ok(x), Ok(y), Ok(z)] = n.map(u32::try_from) else {
        let found = format!("{}x{}x{}", n[0], n[1], n[2]);
        return Err(ReadError::field(path, "dimensions", "fewer than 2^32 samples along each axis", found));
    };
    Dims::new([x, y, z]).map_err(|source| ReadError::Dims { path: path.to_owned(), source })
}

/// Least volume of a voxel relative to the box of its edge lengths; below, its axes count as dependent.
const LEAST_RELATIVE_VOLUME: f64 = 1e-9;

/// The affine map with the world steps of one index step along i, j and k as columns, if it can be inverted.
pub(crate) fn affine(steps: [DVec3; 3], origin: DVec3) -> Option<DAffine3> {
    let matrix = DMat3::from_cols(steps[0], steps[1], steps[2]);
    let directions = steps.map(|s| s / s.length());
    let relative = DMat3::from_cols(directions[0], directions[1], directions[2]).determinant().abs();
    let map = DAffine3 { matrix3: matrix, translation: origin };
    let usable = relative > LEAST_RELATIVE_VOLUME && map.is_finite() && map.inverse().is_finite();
    usable.then_some(map)
}

/// [`affine`] with the axes of the world: `spacing` apart, the first sample at `origin`.
pub(crate) fn axis_aligned(spacing: [f64; 3], origin: [f64; 3]) -> Option<DAffine3> {
    affine([DVec3::X * spacing[0], DVec3::Y * spacing[1], DVec3::Z * spacing[2]], origin.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_maps_without_inverse() {
        assert!(axis_aligned([1.0, 0.0, 1.0], [0.0; 3]).is_none());
        assert!(axis_aligned([1.0, f64::NAN, 1.0], [0.0; 3]).is_none());
        assert!(axis_aligned([1.0; 3], [f64::INFINITY, 0.0, 0.0]).is_none());
        assert!(affine([DVec3::X, DVec3::X, DVec3::Z], DVec3::ZERO).is_none());
        assert!(axis_aligned([1e-9, -1e-9, 1e-9], [0.0; 3]).is_some());
    }
}
