//! Headerless files.

use std::path::Path;

use crate::dataset::Header;
use crate::error::ReadError;
use crate::layout::{self, Layout, Start};
use crate::sample::{Endian, SampleType};

/// Layout of a headerless file of uncompressed samples, `i` (x) fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct RawLayout {
    /// Samples along x, y and z.
    pub dims: [u32; 3],
    /// Type of a sample.
    pub sample: SampleType,
    /// Byte order of a sample.
    pub endian: Endian,
    /// Bytes before the first sample.
    pub skip: u64,
    /// World units between neighbouring samples along x, y and z; 1 if not given.
    pub spacing: Option<[f64; 3]>,
    /// World position of sample (0, 0, 0); the origin if not given.
    pub origin: Option<[f64; 3]>,
}

/// Name of the format.
pub(crate) const FORMAT: &str = "raw";

/// Checks a layout given by the user.
pub(crate) fn header(path: &Path, raw: &RawLayout) -> Result<Header, ReadError> {
    let dims = layout::dims(path, raw.dims.map(u64::from))?;
    let spacing = raw.spacing.unwrap_or([1.0; 3]);
    let origin = raw.origin.unwrap_or([0.0; 3]);
    let index_to_world = layout::axis_aligned(spacing, origin).ok_or_else(|| {
        let found = format!("{spacing:?} and {origin:?}");
        ReadError::field(path, "spacing and origin", "finite numbers, no spacing of 0", found)
    })?;
    let start = Start::At(raw.skip);
    let layout =
        Layout { index_to_world, start, ..Layout::new(dims, raw.sample, raw.endian, path.to_owned()) };
    Ok(Header { format: FORMAT, layout, warnings: Vec::new() })
}
