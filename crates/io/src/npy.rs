//! NumPy arrays: `.npy`, versions 1 to 3.
//!
//! Definition of the format: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

use std::io::Read;
use std::path::Path;

use crate::dataset::Header;
use crate::decode::open_at;
use crate::error::ReadError;
use crate::layout::{Layout, Order, Start, dims};
use crate::sample::{Endian, SampleType};

/// First bytes of the file.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";
/// Name of the format.
pub(crate) const FORMAT: &str = "NumPy";
/// Longest description that is read, in bytes; that of an array of plain numbers takes about a hundred.
const MAX_HEADER: u64 = 64 << 10;

/// Reads the header of `path`.
pub(crate) fn header(path: &Path) -> Result<Header, ReadError> {
    let (text, samples_at) = description(path)?;
    let wrong = || ReadError::field(path, "header", "descr, fortran_order and shape", &text);
    let descr = value(&text, "descr").ok_or_else(wrong)?;
    let (sample, endian) = sample_type(path, descr)?;
    let fortran = match value(&text, "fortran_order") {
        Some(rest) if rest.starts_with("True") => true,
        Some(rest) if rest.starts_with("False") => false,
        _ => return Err(wrong()),
    };
    let shape = value(&text, "shape").and_then(tuple).ok_or_else(wrong)?;
    let (sizes, components) = match (shape.as_slice(), fortran) {
        (&[y, x], false) => ([x, y, 1], 1),
        (&[z, y, x], false) => ([x, y, z], 1),
        (&[z, y, x, c], false) => ([x, y, z], c),
        (&[x, y], true) => ([x, y, 1], 1),
        (&[x, y, z], true) => ([x, y, z], 1),
        (&[x, y, z, c], true) => ([x, y, z], c),
        _ => {
            let expected = "2 or 3 axes, or 4 with the components last";
            return Err(ReadError::unsupported(path, "this shape", expected, format!("{shape:?}")));
        }
    };
    if components == 0 {
        return Err(ReadError::field(path, "shape", "positive sizes", format!("{shape:?}")));
    }
    let mut layout = Layout::new(dims(path, sizes)?, sample, endian, path.to_owned());
    layout.components = components;
    layout.order = if fortran { Order::Planar } else { Order::Interleaved };
    layout.start = Start::At(samples_at);
    Ok(Header { format: FORMAT, layout, warnings: Vec::new() })
}

/// The text that describes the array, and the byte after it.
fn description(path: &Path) -> Result<(String, u64), ReadError> {
    let mut file = open_at(path, 0)?;
    let mut read = |count: u64| {
        let mut bytes = Vec::new();
        let result = (&mut file).take(count).read_to_end(&mut bytes);
        result.map_err(|e| ReadError::io(path, "read", e))?;
        let (expected, found) = ("the description of a NumPy array", bytes.len() as u64);
        let short = ReadError::ShortHeader { path: path.to_owned(), expected, found };
        if found == count { Ok(bytes) } else { Err(short) }
    };
    let start = read(8)?;
    let version = start[MAGIC.len()];
    if !start.starts_with(MAGIC) || !(1..=3).contains(&version) {
        let expected = "\\x93NUMPY and a version from 1 to 3";
        return Err(ReadError::field(path, "first bytes", expected, format!("{start:02x?}")));
    }
    let mut length = [0; 4];
    let stored = if version == 1 { 2 } else { 4 };
    length[..stored].copy_from_slice(&read(stored as u64)?);
    let length = u64::from(u32::from_le_bytes(length));
    if length > MAX_HEADER {
        return Err(ReadError::field(path, "length of the header", "at most 65536 bytes", length));
    }
    let text = String::from_utf8_lossy(&read(length)?).into_owned();
    Ok((text, (start.len() + stored) as u64 + length))
}

/// What follows the key in the text of a dictionary.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let quoted = [format!("'{key}'"), format!("\"{key}\"")];
    let (_, rest) = quoted.iter().find_map(|quoted| text.split_once(quoted.as_str()))?;
    Some(rest.trim_start().strip_prefix(':')?.trim_start())
}

/// The numbers of `(1, 2, 3)`, with which `text` begins.
fn tuple(text: &str) -> Option<Vec<u64>> {
    let (inner, _) = text.strip_prefix('(')?.split_once(')')?;
    let parts = inner.split(',').map(str::trim).filter(|part| !part.is_empty());
    // Python 2 wrote long integers with a letter.
    parts.map(|part| part.trim_end_matches('L').parse().ok()).collect()
}

/// The type and byte order of `'<f4'`, with which `text` begins.
fn sample_type(path: &Path, text: &str) -> Result<(SampleType, Endian), ReadError> {
    let quoted = ['\'', '"'].iter().find_map(|&quote| text.strip_prefix(quote)?.split_once(quote));
    let shown = text.split('}').next().unwrap_or_default();
    let name = quoted.map_or(shown, |(name, _)| name);
    let (endian, kind) = match name.split_at_checked(1) {
        Some((">", kind)) => (Endian::Big, kind),
        Some(("<", kind)) => (Endian::Little, kind),
        Some(("|" | "=", kind)) => (Endian::NATIVE, kind),
        _ => (Endian::NATIVE, name),
    };
    let sample = match kind {
        "u1" | "b1" => SampleType::U8,
        "i1" => SampleType::I8,
        "u2" => SampleType::U16,
        "i2" => SampleType::I16,
        "u4" => SampleType::U32,
        "i4" => SampleType::I32,
        "u8" => SampleType::U64,
        "i8" => SampleType::I64,
        "f4" => SampleType::F32,
        "f8" => SampleType::F64,
        _ => {
            let expected = "one of u1, i1, u2, i2, u4, i4, u8, i8, f4, f8 and b1";
            return Err(ReadError::unsupported(path, "this dtype", expected, name));
        }
    };
    Ok((sample, endian))
}
