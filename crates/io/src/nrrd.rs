//! NRRD, versions 1 to 5, with attached or detached samples.
//!
//! Definition of the format: <https://teem.sourceforge.net/nrrd/format.html>.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind};
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::coding::Coding;
use crate::dataset::Header;
use crate::decode::open_at;
use crate::error::ReadError;
use crate::layout::{Layout, Order, Start, affine, dims};
use crate::lines::{HeaderLines, counts};
use crate::sample::{Endian, SampleType};

/// First bytes of the file.
pub(crate) const MAGIC: &[u8] = b"NRRD";
/// Name of the format.
pub(crate) const FORMAT: &str = "NRRD";
/// Most axes of a file, as in the reference implementation.
const MAX_AXES: usize = 16;

/// Reads the header of `path`.
pub(crate) fn header(path: &Path) -> Result<Header, ReadError> {
    let mut lines = HeaderLines::open(path)?;
    let fields = Fields::read(path, &mut lines)?;
    let axes = axes(path, &fields)?;
    let chosen = spatial_axes(path, &axes)?;
    let (components, order) = components(path, &axes, chosen)?;
    let steps = chosen.map(|a| axes[a].size);
    let sample = sample_type(path, fields.required("type")?)?;

    let (data, from) = match fields.get("datafile") {
        None => (path.to_owned(), lines.taken()),
        Some(name) => (data_file(path, name)?, 0),
    };
    let coding = coding(path, fields.required("encoding")?)?;
    let endian = endian(path, &fields, sample, &coding)?;
    let mut layout = Layout::new(dims(path, steps)?, sample, endian, data);
    layout.components = components;
    layout.order = order;
    layout.coding = coding;
    layout.index_to_world = world(path, &fields, &axes, chosen)?;
    place_data(path, &fields, from, &mut layout)?;
    Ok(Header { format: FORMAT, layout, warnings: Vec::new() })
}

/// The fields of a header; names are in lower case and without blanks, since both spellings occur.
struct Fields<'a> {
    path: &'a Path,
    by_name: BTreeMap<String, String>,
}

impl<'a> Fields<'a> {
    /// Reads magic, fields, comments and key/value pairs up to the blank line or the end of the file.
    fn read(path: &'a Path, lines: &mut HeaderLines) -> Result<Self, ReadError> {
        let magic = lines.next_line()?.unwrap_or_default();
        if !matches!(magic.trim_end(), "NRRD0001" | "NRRD0002" | "NRRD0003" | "NRRD0004" | "NRRD0005") {
            return Err(ReadError::field(path, "first line", "NRRD0001 to NRRD0005", magic));
        }
        let mut by_name = BTreeMap::new();
        loop {
            let Some(line) = lines.next_line()? else {
                if by_name.contains_key("datafile") {
                    break;
                }
                let expected = "a blank line before the samples";
                return Err(ReadError::ShortHeader { path: path.to_owned(), expected, found: lines.taken() });
            };
            if line.is_empty() {
                break;
            }
            if line.starts_with('#') {
                continue;
            }
            match line.split_once(':') {
                Some((_, value)) if value.starts_with('=') => {}
                Some((name, value)) => {
                    let name = name.to_ascii_lowercase().replace(' ', "");
                    if by_name.insert(name, value.trim().to_owned()).is_some() {
                        return Err(ReadError::field(path, "header", "each field once", line));
                    }
                }
                None => {
                    return Err(ReadError::field(path, "header line", "'field: value' or a comment", line));
                }
            }
        }
        Ok(Self { path, by_name })
    }

    fn get(&self, name: &str) -> Option<&str> {
        self.by_name.get(name).map(String::as_str)
    }

    fn required(&self, name: &'static str) -> Result<&str, ReadError> {
        self.get(name).ok_or_else(|| ReadError::missing(self.path, name))
    }
}

/// What an axis is for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Use {
    /// Has a direction in space.
    Space,
    /// Said to be none: components of a vector or colour, a list, time.
    Range,
    /// Not said.
    Unknown,
}

/// One axis, fastest first.
struct Axis {
    size: u64,
    used: Use,
    /// World vector of one step, if there are `space directions`.
    direction: Option<DVec3>,
}

/// Sizes, kinds and directions of all axes.
fn axes(path: &Path, fields: &Fields) -> Result<Vec<Axis>, ReadError> {
    let dimension = fields.required("dimension")?;
    let count = dimension.parse().ok().filter(|n| (1..=MAX_AXES).contains(n));
    let count =
        count.ok_or_else(|| ReadError::field(path, "dimension", "a number of axes, 1 to 16", dimension))?;
    let text = fields.required("sizes")?;
    let expected = "a positive integer for each axis";
    let sizes = counts(path, "sizes", expected, text)?;
    if sizes.len() != count {
        return Err(ReadError::field(path, "sizes", expected, text));
    }
    let mut axes: Vec<Axis> =
        sizes.into_iter().map(|size| Axis { size, used: Use::Unknown, direction: None }).collect();
    if let Some(text) = fields.get("kinds") {
        let kinds: Vec<&str> = text.split_whitespace().collect();
        if kinds.len() != count {
            return Err(ReadError::field(path, "kinds", "one for each axis", text));
        }
        for (axis, kind) in axes.iter_mut().zip(kinds) {
            axis.used = match kind.to_ascii_lowercase().as_str() {
                "domain" | "space" => Use::Space,
                "none" | "???" => Use::Unknown,
                _ => Use::Range,
            };
        }
    }
    if let Some(text) = fields.get("spacedirections") {
        let expected = "a vector of three numbers, or none, for each axis";
        let vectors = vectors(text).filter(|v| v.len() == count);
        let vectors = vectors.ok_or_else(|| ReadError::field(path, "space directions", expected, text))?;
        for (axis, vector) in axes.iter_mut().zip(vectors) {
            axis.direction = vector;
            axis.used = if vector.is_some() { Use::Space } else { Use::Range };
        }
    }
    Ok(axes)
}

/// Parses `(x,y,z)` vectors and `none`s.
fn vectors(text: &str) -> Option<Vec<Option<DVec3>>> {
    let mut rest = text.trim_start();
    let mut found = Vec::new();
    while !rest.is_empty() {
        if let Some(inner) = rest.strip_prefix('(') {
            let (inner, after) = inner.split_once(')')?;
            let numbers: Option<Vec<f64>> = inner.split(',').map(|n| n.trim().parse().ok()).collect();
            found.push(Some(DVec3::from_array(numbers?.try_into().ok()?)));
            rest = after.trim_start();
        } else {
            let (word, after) = rest.split_at(rest.find([' ', '\t', '(']).unwrap_or(rest.len()));
            if !word.eq_ignore_ascii_case("none") {
                return None;
            }
            found.push(None);
            rest = after.trim_start();
        }
    }
    Some(found)
}

/// The three axes of the lattice, fastest first.
fn spatial_axes(path: &Path, axes: &[Axis]) -> Result<[usize; 3], ReadError> {
    let mut chosen: Vec<usize> = (0..axes.len()).filter(|&a| axes[a].used != Use::Range).collect();
    // Axes of one sample that nobody gave a direction carry nothing.
    while chosen.len() > 3 {
        let single = chosen.iter().rposition(|&a| axes[a].size == 1 && axes[a].direction.is_none());
        let Some(single) = single else { break };
        chosen.remove(single);
    }
    let found = format!("{} axes, {} of them spatial", axes.len(), chosen.len());
    <[usize; 3]>::try_from(chosen).map_err(|_| {
        let expected = "3 spatial axes; 'kinds' or 'space directions' tell components from space";
        ReadError::unsupported(path, "this number of axes", expected, found)
    })
}

/// Number of components, and whether they lie before or after the axes of space.
fn components(path: &Path, axes: &[Axis], spatial: [usize; 3]) -> Result<(u64, Order), ReadError> {
    let others = || (0..axes.len()).filter(|a| !spatial.contains(a) && axes[*a].size > 1);
    let count = others().try_fold(1u64, |n, a| n.checked_mul(axes[a].size));
    let count = count.ok_or_else(|| {
        ReadError::field(path, "sizes", "fewer than 2^64 components", "a product that overflows")
    })?;
    if others().all(|a| a < spatial[0]) {
        Ok((count, Order::Interleaved))
    } else if others().all(|a| a > spatial[2]) {
        Ok((count, Order::Planar))
    } else {
        let expected = "the axis of components first or last";
        Err(ReadError::unsupported(
            path,
            "an axis of components between those of space",
            expected,
            "such an axis",
        ))
    }
}

/// The map to the world from directions and origin, or from spacings.
fn world(
    path: &Path,
    fields: &Fields,
    axes: &[Axis],
    spatial: [usize; 3],
) -> Result<glam::DAffine3, ReadError> {
    let origin = match fields.get("spaceorigin") {
        None => DVec3::ZERO,
        Some(text) => match vectors(text).as_deref() {
            Some([Some(origin)]) => *origin,
            _ => {
                return Err(ReadError::field(path, "space origin", "one vector of three numbers", text));
            }
        },
    };
    let mut spacings = vec![1.0; axes.len()];
    if let Some(text) = fields.get("spacings") {
        let parsed: Option<Vec<f64>> = text.split_whitespace().map(|t| t.parse().ok()).collect();
        let parsed = parsed.filter(|v| v.len() == axes.len());
        spacings =
            parsed.ok_or_else(|| ReadError::field(path, "spacings", "a number for each axis", text))?;
    }
    let unit = [DVec3::X, DVec3::Y, DVec3::Z];
    let steps = std::array::from_fn(|i| {
        let spacing = spacings[spatial[i]];
        // NaN says that the spacing is not known.
        axes[spatial[i]].direction.unwrap_or(unit[i] * if spacing.is_nan() { 1.0 } else { spacing })
    });
    affine(steps, origin).ok_or_else(|| {
        let found = format!("steps {}, {}, {}, origin {origin}", steps[0], steps[1], steps[2]);
        ReadError::field(path, "space directions or spacings", "finite, independent steps", found)
    })
}

/// All spellings of the sample types.
fn sample_type(path: &Path, name: &str) -> Result<SampleType, ReadError> {
    Ok(match name.to_ascii_lowercase().as_str() {
        "signed char" | "char" | "int8" | "int8_t" => SampleType::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => SampleType::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => SampleType::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => SampleType::U16,
        "int" | "signed int" | "int32" | "int32_t" => SampleType::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => SampleType::U32,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => {
            SampleType::U64
        }
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => SampleType::I64,
        "float" => SampleType::F32,
        "double" => SampleType::F64,
        _ => {
            let expected = "integers of 8 to 64 bits, float or double";
            return Err(ReadError::unsupported(path, "this type", expected, name));
        }
    })
}

fn coding(path: &Path, name: &str) -> Result<Coding, ReadError> {
    match name.to_ascii_lowercase().as_str() {
        "raw" => Ok(Coding::Raw),
        "gz" | "gzip" => Ok(Coding::Deflate),
        "txt" | "text" | "ascii" => Ok(Coding::Text),
        _ => Err(ReadError::unsupported(path, "this encoding", "raw, gzip or ascii", name)),
    }
}

/// The byte order, which only samples of several bytes need.
fn endian(path: &Path, fields: &Fields, sample: SampleType, coding: &Coding) -> Result<Endian, ReadError> {
    if *coding == Coding::Text || (sample.size() == 1 && fields.get("endian").is_none()) {
        return Ok(Endian::NATIVE);
    }
    match fields.required("endian")?.to_ascii_lowercase().as_str() {
        "little" => Ok(Endian::Little),
        "big" => Ok(Endian::Big),
        other => Err(ReadError::field(path, "endian", "little or big", other)),
    }
}

/// The separate file of samples, which is relative to the header.
fn data_file(path: &Path, name: &str) -> Result<PathBuf, ReadError> {
    let words: Vec<&str> = name.split_whitespace().collect();
    let expected = "the name of one file";
    // A pattern is followed by the first number, the last one and the step.
    let numbered = words.iter().rev().take_while(|w| w.parse::<i64>().is_ok()).count() >= 3;
    if words.first() == Some(&"LIST") || (name.contains('%') && numbered) {
        return Err(ReadError::unsupported(path, "a list of data files", expected, name));
    }
    sibling(path, name)
}

/// The file that a header at `path` calls `name`; it must be there.
pub(crate) fn sibling(path: &Path, name: &str) -> Result<PathBuf, ReadError> {
    let data = path.parent().unwrap_or(Path::new("")).join(name);
    let opened = match std::fs::metadata(&data) {
        // A folder can be opened, and an empty name is one.
        Ok(found) if found.is_dir() => Err(ErrorKind::IsADirectory.into()),
        _ => File::open(&data),
    };
    match opened {
        Ok(_) => Ok(data),
        Err(source) => Err(ReadError::DataFile { path: path.to_owned(), data, source }),
    }
}

/// Applies `line skip`, in the file, and `byte skip`, in a compressed file after decompression.
fn place_data(path: &Path, fields: &Fields, from: u64, layout: &mut Layout) -> Result<(), ReadError> {
    let mut offset = from;
    if let Some(text) = fields.get("lineskip") {
        let lines = text.parse();
        let lines = lines.map_err(|_| ReadError::field(path, "line skip", "a number of lines", text))?;
        offset = skip_lines(&layout.data, offset, lines)?;
    }
    let text = fields.get("byteskip").unwrap_or("0");
    let skip: i64 = match text.parse() {
        Ok(n) if n >= -1 => n,
        _ => return Err(ReadError::field(path, "byte skip", "a number of bytes, or -1", text)),
    };
    layout.start = match (u64::try_from(skip), &layout.coding) {
        (Err(_), Coding::Raw) => Start::FromEnd,
        (Err(_), _) => {
            return Err(ReadError::field(path, "byte skip", "-1 only with encoding raw", text));
        }
        (Ok(skip), Coding::Deflate) => {
            layout.stream_skip = skip;
            Start::At(offset)
        }
        (Ok(skip), _) => Start::At(offset.saturating_add(skip)),
    };
    Ok(())
}

/// The byte after `count` lines from byte `offset` of `path` on.
fn skip_lines(path: &Path, mut offset: u64, count: u64) -> Result<u64, ReadError> {
    let mut input = BufReader::new(open_at(path, offset)?);
    for _ in 0..count {
        let n = input.skip_until(b'\n').map_err(|e| ReadError::io(path, "read", e))?;
        if n == 0 {
            let expected = "the lines to skip before the samples";
            return Err(ReadError::ShortHeader { path: path.to_owned(), expected, found: offset });
        }
        offset += n as u64;
    }
    Ok(offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_vectors() {
        let found = vectors("none (1,0,0) (0, 1.5,0)(0,0,-2e0)").unwrap();
        assert_eq!(found[0], None);
        assert_eq!(found[2], Some(DVec3::new(0.0, 1.5, 0.0)));
        assert_eq!(found[3], Some(DVec3::new(0.0, 0.0, -2.0)));
        for bad in ["(1,0)", "(1,0,0", "nothing", "(a,b,c)", "1 2 3"] {
            assert_eq!(vectors(bad), None, "{bad}");
        }
    }
}
