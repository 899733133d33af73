//! Legacy VTK files of structured points: `.vtk`.

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};

use super::unstructured::{self, Mesh};
use super::words::WordReader;
use super::{Array, Grid, Place, Span, choose};
use crate::coding::Coding;
use crate::dataset::Header;
use crate::error::ReadError;
use crate::layout::{Layout, Start};
use crate::sample::{Endian, SampleType};

/// Name of the format.
pub(crate) const FORMAT: &str = "legacy VTK";
/// First bytes of the file.
pub(crate) const MAGIC: &[u8] = b"# vtk DataFile";

/// Reads `path` but for the numbers; the volume is that of the array called `field`, if it is given.
pub(crate) fn header(path: &Path, field: Option<&str>) -> Result<Header, ReadError> {
    let mut parser = Parser::open(path, STRUCTURED)?;
    parser.run()?;
    let grid = parser.grid()?;
    let array = choose(path, &parser.arrays, field)?;
    let expected = "integers of 8 to 64 bits, float or double";
    let unsupported = || ReadError::unsupported(path, "this type", expected, &array.type_name);
    let sample = array.sample.ok_or_else(unsupported)?;
    let (dims, index_to_world) = grid.lattice(path, array.place)?;
    let mut layout = Layout::new(dims, sample, Endian::Big, path.to_owned());
    layout.index_to_world = index_to_world;
    layout.components = array.components;
    match array.span {
        Span::Binary([start, end]) => (layout.start, layout.end) = (Start::At(start), Some(end)),
        Span::Text([start, end]) | Span::Base64([start, end]) => {
            (layout.start, layout.end) = (Start::At(start), Some(end));
            (layout.coding, layout.endian) = (Coding::Text, Endian::NATIVE);
        }
        Span::Appended(_) => {}
    }
    Ok(Header { format: FORMAT, layout, warnings: Vec::new() })
}

/// The data set of a volume.
const STRUCTURED: &str = "DATASET STRUCTURED_POINTS";

pub(super) struct Parser {
    pub(super) path: PathBuf,
    pub(super) words: WordReader,
    pub(super) ascii: bool,
    /// First number of the version.
    pub(super) version: u32,
    /// The only kind of data set that is taken.
    kind: &'static str,
    pub(super) mesh: Mesh,
    dimensions: Option<[u64; 3]>,
    origin: DVec3,
    spacing: DVec3,
    /// Whose arrays the parser is at, and how many samples each has.
    place: Option<(Place, u64)>,
    pub(super) arrays: Vec<Array>,
}

/// The shape of an array.
struct Shape {
    name: String,
    type_name: String,
    components: u64,
    samples: u64,
    active: bool,
}

impl Parser {
    /// Reads the first lines of a file that must hold a data set of this `kind`.
    pub(super) fn open(path: &Path, kind: &'static str) -> Result<Self, ReadError> {
        let mut words = WordReader::open(path)?;
        let first = words.line()?;
        if !first.as_bytes().starts_with(MAGIC) {
            let expected = "# vtk DataFile Version";
            return Err(ReadError::field(path, "first line", expected, first));
        }
        let version = first.split("Version").nth(1).and_then(|v| v.trim().split('.').next()?.parse().ok());
        words.line()?;
        let encoding = words.required("ASCII or BINARY")?;
        let ascii = match encoding.to_ascii_uppercase().as_str() {
            "ASCII" => true,
            "BINARY" => false,
            _ => return Err(ReadError::field(path, "encoding", "ASCII or BINARY", encoding)),
        };
        let (origin, spacing) = (DVec3::ZERO, DVec3::ONE);
        Ok(Self {
            path: path.to_owned(),
            words,
            ascii,
            version: version.unwrap_or(0),
            kind,
            mesh: Mesh::default(),
            dimensions: None,
            origin,
            spacing,
            place: None,
            arrays: Vec::new(),
        })
    }

    /// Takes up all sections.
    pub(super) fn run(&mut self) -> Result<(), ReadError> {
        while let Some(word) = self.words.word()? {
            self.section(&word.to_ascii_lowercase(), &word)?;
        }
        Ok(())
    }

    fn grid(&self) -> Result<Grid, ReadError> {
        let dimensions = self.dimensions.ok_or_else(|| ReadError::missing(&self.path, "DIMENSIONS"))?;
        // One too large for an i64 becomes an extent that has none.
        let extent = dimensions.map(|n| [0, i64::try_from(n).map_or(-1, |n| n - 1)]);
        Ok(Grid { extent, origin: self.origin, spacing: self.spacing, direction: DMat3::IDENTITY })
    }

    /// Takes up the section that begins with `keyword`.
    fn section(&mut self, keyword: &str, found: &str) -> Result<(), ReadError> {
        match keyword {
            "dataset" => {
                let kind = self.words.required("the kind of data set")?;
                if !format!("DATASET {kind}").eq_ignore_ascii_case(self.kind) {
                    return Err(ReadError::unsupported(&self.path, "this VTK data set", self.kind, kind));
                }
            }
            "points" | "cells" | "cell_types" if self.kind == unstructured::KIND => {
                self.mesh_section(keyword)?;
            }
            "dimensions" => self.dimensions = Some(self.words.numbers("DIMENSIONS")?),
            "origin" => self.origin = self.words.numbers::<f64, 3>("ORIGIN")?.into(),
            "spacing" | "aspect_ratio" => self.spacing = self.words.numbers::<f64, 3>("SPACING")?.into(),
            "point_data" => self.samples(Place::Points, "POINT_DATA")?,
            "cell_data" => self.samples(Place::Cells, "CELL_DATA")?,
            "field" => self.fields()?,
            "metadata" => {
                self.words.line()?;
                while !self.words.line()?.trim().is_empty() {}
            }
            "lookup_table" => {
                let _name = self.words.required("the name of a table")?;
                let size: u64 = self.words.number("size of a LOOKUP_TABLE")?;
                // Red, green, blue and opacity: bytes in a binary file.
                self.pass(u128::from(size) * 4, 8, "LOOKUP_TABLE")?;
            }
            _ => self.attribute(keyword, found)?,
        }
        Ok(())
    }

    /// `POINT_DATA` or `CELL_DATA` and the number of samples.
    fn samples(&mut self, place: Place, what: &'static str) -> Result<(), ReadError> {
        let stated: u64 = self.words.number(what)?;
        if self.kind == unstructured::KIND {
            self.check_samples(place, what, stated)?;
            self.place = Some((place, stated));
            return Ok(());
        }
        let sizes = self.grid()?.samples(&self.path, place)?;
        if sizes.iter().try_fold(1u64, |product, &n| product.checked_mul(n)) != Some(stated) {
            let [x, y, z] = sizes;
            let found = format!("{stated} for {x}x{y}x{z}");
            return Err(ReadError::field(&self.path, what, "as many as DIMENSIONS say", found));
        }
        self.place = Some((place, stated));
        Ok(())
    }

    /// An array with a section of its own.
    fn attribute(&mut self, keyword: &str, found: &str) -> Result<(), ReadError> {
        const KEYWORDS: [&str; 10] = [
            "scalars",
            "color_scalars",
            "vectors",
            "normals",
            "texture_coordinates",
            "tensors",
            "tensors6",
            "global_ids",
            "pedigree_ids",
            "edge_flags",
        ];
        let Some((_, samples)) = self.place.filter(|_| KEYWORDS.contains(&keyword)) else {
            let expected = if self.kind == STRUCTURED {
                "a keyword of structured points"
            } else {
                "a keyword of an unstructured grid"
            };
            return Err(ReadError::field(&self.path, "keyword", expected, found));
        };
        let line = self.words.line()?;
        let parts: Vec<&str> = line.split_whitespace().collect();
        let wrong = || ReadError::field(&self.path, "array", "a name, a size and a type", &line);
        let count = |text: &str| text.parse::<u64>().map_err(|_| wrong());
        let in_text = if self.ascii { "float" } else { "unsigned_char" };
        let (name, type_name, components) = match (keyword, parts.as_slice()) {
            ("scalars", [name, kind]) => (name, *kind, 1),
            ("scalars", [name, kind, n]) => (name, *kind, count(n)?),
            ("color_scalars", [name, n]) => (name, in_text, count(n)?),
            ("texture_coordinates", [name, n, kind]) => (name, *kind, count(n)?),
            ("vectors" | "normals", [name, kind]) => (name, *kind, 3),
            ("tensors", [name, kind]) => (name, *kind, 9),
            ("tensors6", [name, kind]) => (name, *kind, 6),
            ("global_ids" | "pedigree_ids" | "edge_flags", [name, kind]) => (name, *kind, 1),
            _ => return Err(wrong()),
        };
        let (name, type_name) = (decoded(name), type_name.to_ascii_lowercase());
        if keyword == "scalars" {
            let table = self.words.required("LOOKUP_TABLE")?;
            if !table.eq_ignore_ascii_case("LOOKUP_TABLE") {
                return Err(ReadError::field(&self.path, "line after SCALARS", "LOOKUP_TABLE", table));
            }
            self.words.line()?;
        }
        // VTK writes scalars of this type as colours.
        let active = keyword == "scalars" || (keyword == "color_scalars" && components == 1);
        self.array(Shape { name, type_name, components, samples, active })
    }

    /// `FIELD` and its arrays.
    fn fields(&mut self) -> Result<(), ReadError> {
        let _name = self.words.required("the name of a FIELD")?;
        let count: u64 = self.words.number("number of arrays of a FIELD")?;
        for _ in 0..count {
            let mut name = self.words.required("the name of an array")?;
            // Belongs to the array before, and ends with an empty line.
            while name.eq_ignore_ascii_case("metadata") {
                self.section("metadata", &name)?;
                name = self.words.required("the name of an array")?;
            }
            let name = decoded(&name);
            let components = self.words.number("components of an array")?;
            let samples = self.words.number("samples of an array")?;
            let type_name = self.words.required("the type of an array")?.to_ascii_lowercase();
            self.words.line()?;
            self.array(Shape { name, type_name, components, samples, active: false })?;
        }
        Ok(())
    }

    /// Passes over the numbers of an array, and notes it if it is one of the points or cells.
    fn array(&mut self, shape: Shape) -> Result<(), ReadError> {
        let Shape { name, type_name, components, samples, active } = shape;
        let components = super::components(&self.path, components)?;
        let (bits, sample) = stored(&type_name).ok_or_else(|| {
            let expected = "bit, integers of 8 to 64 bits, float or double";
            ReadError::unsupported(&self.path, "this type", expected, &type_name)
        })?;
        let start = self.words.position();
        self.pass(u128::from(components) * u128::from(samples), bits, "array")?;
        let range = [start, self.words.position()];
        let span = if self.ascii { Span::Text(range) } else { Span::Binary(range) };
        if let Some((place, _)) = self.place.filter(|&(_, expected)| expected == samples) {
            self.arrays.push(Array { name, place, active, type_name, sample, components, samples, span });
        }
        Ok(())
    }

    /// Passes over `count` numbers.
    pub(super) fn pass(&mut self, count: u128, bits: u128, what: &'static str) -> Result<(), ReadError> {
        let there = if self.ascii {
            self.words.skip_words(count)?
        } else {
            self.words.skip_bytes((count * bits).div_ceil(8))?
        };
        let short = || ReadError::field(&self.path, what, "all its numbers", "the end of the file");
        if there { Ok(()) } else { Err(short()) }
    }
}

/// Bits of a number in a binary file, and its type if it is read.
pub(super) fn stored(type_name: &str) -> Option<(u128, Option<SampleType>)> {
    let sample = match type_name {
        "bit" => return Some((1, None)),
        "unsigned_char" => SampleType::U8,
        "char" | "signed_char" => SampleType::I8,
        "unsigned_short" => SampleType::U16,
        "short" => SampleType::I16,
        "unsigned_int" => SampleType::U32,
        // VTK writes its identifiers with 32 bits here.
        "int" | "vtkidtype" => SampleType::I32,
        // What VTK wrote on machines with 32-bit longs cannot be told apart.
        "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => SampleType::U64,
        "long" | "long_long" | "vtktypeint64" => SampleType::I64,
        "float" => SampleType::F32,
        "double" => SampleType::F64,
        _ => return None,
    };
    Some((sample.size() as u128 * 8, Some(sample)))
}

/// A name in which some characters stand as `%` and two hexadecimal digits.
fn decoded(name: &str) -> String {
    let mut bytes = Vec::with_capacity(name.len());
    let mut rest = name.as_bytes();
    while let [first, after @ ..] = rest {
        let code = after.get(..2).and_then(|c| std::str::from_utf8(c).ok());
        let code = code.filter(|c| c.bytes().all(|b| b.is_ascii_hexdigit()));
        match code.and_then(|c| u8::from_str_radix(c, 16).ok()).filter(|_| *first == b'%') {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(*first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::decoded;

    #[test]
    fn decodes_names() {
        for (name, expected) in [("a", "a"), ("my%20field", "my field"), ("100%", "100%"), ("%zz%2", "%zz%2")]
        {
            assert_eq!(decoded(name), expected);
        }
    }
}
