//! MetaImage: `.mha`, and `.mhd` with a separate file of samples.
//!
//! Definition of the format: <https://itk.org/Wiki/ITK/MetaIO/Documentation>.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;

use crate::coding::Coding;
use crate::dataset::Header;
use crate::error::ReadError;
use crate::layout::{Layout, Start, affine, dims};
use crate::lines::{HeaderLines, counts, numbers};
use crate::nrrd::sibling;
use crate::sample::{Endian, SampleType};

/// Name of the format.
pub(crate) const FORMAT: &str = "MetaImage";
/// Keys that stand in the first line of the files met.
const FIRST_KEYS: [&str; 5] = ["ObjectType", "NDims", "Comment", "ObjectSubType", "TransformType"];

/// Whether the first line of `head` is that of a MetaImage.
pub(crate) fn is_header(head: &[u8]) -> bool {
    let line = head.split(|&b| b == b'\n').next().unwrap_or_default();
    std::str::from_utf8(line)
        .ok()
        .and_then(|line| line.split_once('='))
        .is_some_and(|(key, _)| FIRST_KEYS.iter().any(|k| key.trim().eq_ignore_ascii_case(k)))
}

/// Reads the header of `path`.
pub(crate) fn header(path: &Path) -> Result<Header, ReadError> {
    let mut lines = HeaderLines::open(path)?;
    let fields = Fields::read(path, &mut lines)?;
    if let Some(kind) = fields.get("objecttype").filter(|k| !k.eq_ignore_ascii_case("image")) {
        return Err(ReadError::unsupported(path, "this ObjectType", "Image", kind));
    }
    let axes = fields.required("ndims", "NDims")?;
    if axes != "3" {
        return Err(ReadError::unsupported(path, "this number of axes", "NDims = 3", axes));
    }
    let expected = "three positive integers";
    let text = fields.required("dimsize", "DimSize")?;
    let sizes = <[u64; 3]>::try_from(counts(path, "DimSize", expected, text)?)
        .map_err(|_| ReadError::field(path, "DimSize", expected, text))?;
    let sample = sample_type(path, fields.required("elementtype", "ElementType")?)?;

    let name = fields.required("elementdatafile", "ElementDataFile")?;
    let (data, from) = if name.eq_ignore_ascii_case("local") {
        (path.to_owned(), lines.taken())
    } else if name.split_whitespace().next() == Some("LIST") || name.contains('%') {
        let expected = "LOCAL or the name of one file";
        return Err(ReadError::unsupported(path, "a list of data files", expected, name));
    } else {
        (sibling(path, name)?, 0)
    };
    let coding = coding(&fields)?;
    let endian = if coding == Coding::Text { Endian::NATIVE } else { endian(&fields)? };
    let mut layout = Layout::new(dims(path, sizes)?, sample, endian, data);
    layout.coding = coding;
    layout.start = start(&fields, from)?;
    if let Some(text) = fields.get("elementnumberofchannels") {
        let count = text.parse().ok().filter(|&n| n > 0);
        let error = || ReadError::field(path, "ElementNumberOfChannels", "a positive integer", text);
        layout.components = count.ok_or_else(error)?;
    }
    layout.index_to_world = world(&fields)?;
    Ok(Header { format: FORMAT, layout, warnings: Vec::new() })
}

/// The fields of a header; keys are in lower case.
struct Fields<'a> {
    path: &'a Path,
    by_key: BTreeMap<String, String>,
}

impl<'a> Fields<'a> {
    /// Reads up to `ElementDataFile`, which is the last field.
    fn read(path: &'a Path, lines: &mut HeaderLines) -> Result<Self, ReadError> {
        let mut by_key = BTreeMap::new();
        loop {
            let Some(line) = lines.next_line()? else {
                let expected = "the field ElementDataFile";
                return Err(ReadError::ShortHeader { path: path.to_owned(), expected, found: lines.taken() });
            };
            if line.trim().is_empty() {
                continue;
            }
            let Some((key, value)) = line.split_once('=') else {
                return Err(ReadError::field(path, "header line", "'Key = value'", line));
            };
            let key = key.trim().to_ascii_lowercase();
            let last = key == "elementdatafile";
            by_key.insert(key, value.trim().to_owned());
            if last {
                return Ok(Self { path, by_key });
            }
        }
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.by_key.get(key).map(String::as_str)
    }

    /// The first of several spellings.
    fn any(&self, keys: &[&str]) -> Option<&str> {
        keys.iter().find_map(|key| self.get(key))
    }

    fn required(&self, key: &str, shown: &'static str) -> Result<&str, ReadError> {
        self.get(key).ok_or_else(|| ReadError::missing(self.path, shown))
    }

    /// A truth value, `absent` if it is not there.
    fn flag(&self, keys: &[&str], shown: &'static str, absent: bool) -> Result<bool, ReadError> {
        let Some(text) = self.any(keys) else { return Ok(absent) };
        match text.to_ascii_lowercase().as_str() {
            "true" | "t" | "1" => Ok(true),
            "false" | "f" | "0" => Ok(false),
            _ => Err(ReadError::field(self.path, shown, "True or False", text)),
        }
    }
}

fn sample_type(path: &Path, name: &str) -> Result<SampleType, ReadError> {
    // Files with several channels may call their type an array.
    Ok(match name.strip_suffix("_ARRAY").unwrap_or(name) {
        "MET_CHAR" | "MET_ASCII_CHAR" => SampleType::I8,
        "MET_UCHAR" => SampleType::U8,
        "MET_SHORT" => SampleType::I16,
        "MET_USHORT" => SampleType::U16,
        // A 'long' of this format has 32 bits on every machine.
        "MET_INT" | "MET_LONG" => SampleType::I32,
        "MET_UINT" | "MET_ULONG" => SampleType::U32,
        "MET_ULONG_LONG" => SampleType::U64,
        "MET_LONG_LONG" => SampleType::I64,
        "MET_FLOAT" => SampleType::F32,
        "MET_DOUBLE" => SampleType::F64,
        _ => {
            let expected =
                "MET_[U]CHAR, MET_[U]SHORT, MET_[U]INT, MET_[U]LONG[_LONG], MET_FLOAT or MET_DOUBLE";
            return Err(ReadError::unsupported(path, "this ElementType", expected, name));
        }
    })
}

fn coding(fields: &Fields) -> Result<Coding, ReadError> {
    let binary = fields.flag(&["binarydata"], "BinaryData", true)?;
    let compressed = fields.flag(&["compresseddata"], "CompressedData", false)?;
    Ok(match (binary, compressed) {
        (_, true) => Coding::Deflate,
        (true, false) => Coding::Raw,
        (false, false) => Coding::Text,
    })
}

fn endian(fields: &Fields) -> Result<Endian, ReadError> {
    let keys = ["elementbyteordermsb", "binarydatabyteordermsb"];
    let big = fields.flag(&keys, "BinaryDataByteOrderMSB", false)?;
    Ok(if big { Endian::Big } else { Endian::Little })
}

/// `HeaderSize` bytes into the data file, or after the header if samples are local.
fn start(fields: &Fields, from: u64) -> Result<Start, ReadError> {
    let Some(text) = fields.get("headersize") else { return Ok(Start::At(from)) };
    match text.parse::<i64>() {
        Ok(-1) => Ok(Start::FromEnd),
        // A header that counts itself is the same as none.
        Ok(n) if n >= 0 => Ok(Start::At(from.max(n.unsigned_abs()))),
        _ => Err(ReadError::field(fields.path, "HeaderSize", "a number of bytes, or -1", text)),
    }
}

/// The map to the world from spacing, direction cosines and offset.
fn world(fields: &Fields) -> Result<glam::DAffine3, ReadError> {
    let path = fields.path;
    let three = |keys: &[&str], shown, absent: [f64; 3]| match fields.any(keys) {
        Some(text) => numbers::<3>(path, shown, "three numbers", text),
        None => Ok(absent),
    };
    let spacing = three(&["elementspacing", "elementsize"], "ElementSpacing", [1.0; 3])?;
    let offset = three(&["offset", "origin", "position"], "Offset", [0.0; 3])?;
    let directions = match fields.any(&["transformmatrix", "rotation", "orientation"]) {
        Some(text) => numbers::<9>(path, "TransformMatrix", "nine numbers", text)?,
        None => [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    };
    // Each triple of the matrix is the direction of one index axis.
    let steps = std::array::from_fn(|i| DVec3::from_slice(&directions[3 * i..]) * spacing[i]);
    affine(steps, offset.into()).ok_or_else(|| {
        let found = format!("steps {}, {}, {}, offset {offset:?}", steps[0], steps[1], steps[2]);
        ReadError::field(path, "ElementSpacing and TransformMatrix", "finite, independent steps", found)
    })
}
