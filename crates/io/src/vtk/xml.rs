//! The XML part of a `.vti` file, element by element, and where the numbers of its arrays are.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use glam::{DMat3, DVec3};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::blocks::{Codec, Words};
use super::{Array, Grid, Place, Span};
use crate::decode::{fill, open_at};
use crate::error::ReadError;
use crate::lines::numbers;
use crate::sample::{Endian, SampleType};

/// Most bytes of elements, without the numbers of arrays; it bounds what is held of them.
const MAX_XML: u64 = 4 << 20;

/// What the XML part of a file says.
#[derive(Debug)]
pub(super) struct Document {
    pub(super) words: Words,
    pub(super) codec: Option<Codec>,
    pub(super) grid: Grid,
    pub(super) arrays: Vec<Array>,
    /// The byte after the `_` that begins the appended section, and whether that is base64 text.
    pub(super) appended: Option<(u64, bool)>,
}

/// Reads the XML part of `path`.
pub(super) fn read(path: &Path) -> Result<Document, ReadError> {
    let mut parser = Parser {
        path: path.to_owned(),
        reader: Reader::from_reader(Source::open(path, MAX_XML)?),
        file: None,
        grid: None,
        pieces: 0,
        place: None,
        active: None,
        arrays: Vec::new(),
        appended: None,
        open: false,
    };
    parser.run()?;
    let missing = |field| ReadError::missing(path, field);
    let (words, codec) = parser.file.ok_or_else(|| missing("VTKFile"))?;
    let grid = parser.grid.ok_or_else(|| missing("ImageData"))?;
    if parser.pieces == 0 {
        return Err(missing("Piece"));
    }
    let (arrays, appended) = (parser.arrays, parser.appended);
    Ok(Document { words, codec, grid, arrays, appended })
}

/// A file that ends after a number of bytes, and knows where it is.
pub(super) struct Source {
    input: BufReader<File>,
    position: u64,
    left: u64,
}

impl Source {
    /// The first `most` bytes of `path`.
    pub(super) fn open(path: &Path, most: u64) -> Result<Self, ReadError> {
        Ok(Self { input: BufReader::new(open_at(path, 0)?), position: 0, left: most })
    }
}

impl Read for Source {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let bytes = self.fill_buf()?;
        let n = bytes.len().min(buffer.len());
        buffer[..n].copy_from_slice(&bytes[..n]);
        self.consume(n);
        Ok(n)
    }
}

impl BufRead for Source {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        let bytes = self.input.fill_buf()?;
        let most = usize::try_from(self.left).unwrap_or(usize::MAX).min(bytes.len());
        Ok(&bytes[..most])
    }

    fn consume(&mut self, count: usize) {
        self.input.consume(count);
        self.position += count as u64;
        self.left = self.left.saturating_sub(count as u64);
    }
}

struct Parser {
    path: PathBuf,
    reader: Reader<Source>,
    file: Option<(Words, Option<Codec>)>,
    grid: Option<Grid>,
    pieces: usize,
    /// Whose arrays the parser is at.
    place: Option<Place>,
    /// Name of their active array.
    active: Option<String>,
    arrays: Vec<Array>,
    appended: Option<(u64, bool)>,
    /// The last array is open, its numbers stand in it, and none have been met yet.
    open: bool,
}

impl Parser {
    fn run(&mut self) -> Result<(), ReadError> {
        let mut buffer = Vec::new();
        loop {
            buffer.clear();
            let event = self.reader.read_event_into(&mut buffer);
            match event.map_err(|e| malformed(&self.path, &e))? {
                Event::Start(element) => {
                    self.element(&element, true)?;
                    if self.appended.is_some() {
                        return Ok(());
                    }
                }
                Event::Empty(element) => self.element(&element, false)?,
                Event::End(element) => match element.name().as_ref() {
                    "PointData" | "CellData" => self.place = None,
                    "DataArray" | "Array" => self.open = false,
                    _ if self.open => self.inline()?,
                    _ => {}
                },
                Event::Eof => return Ok(()),
                _ => {}
            }
        }
    }

    /// Takes up an element, of which `content` says whether it has any.
    fn element(&mut self, element: &BytesStart, content: bool) -> Result<(), ReadError> {
        let element = Element { path: self.path.clone(), element };
        match element.element.name().as_ref() {
            "VTKFile" => {
                let kind = element.required("type", "VTKFile type")?;
                if kind != "ImageData" {
                    let expected = "VTKFile type=\"ImageData\"";
                    return Err(ReadError::unsupported(&self.path, "this VTK data set", expected, kind));
                }
                self.file = Some((element.words()?, element.codec()?));
            }
            "ImageData" => self.grid = Some(element.grid()?),
            "Piece" => self.piece(&element)?,
            "PointData" | "CellData" if content => {
                let points = element.element.name().as_ref() == "PointData";
                self.place = Some(if points { Place::Points } else { Place::Cells });
                self.active = element.get("Scalars")?;
            }
            "DataArray" | "Array" => self.array(&element, content)?,
            "AppendedData" if content => {
                let base64 = element.get("encoding")?.is_none_or(|e| e != "raw");
                self.appended = Some((self.underscore()?, base64));
            }
            _ => {}
        }
        Ok(())
    }

    fn piece(&mut self, element: &Element) -> Result<(), ReadError> {
        self.pieces += 1;
        if self.pieces > 1 {
            return Err(ReadError::unsupported(&self.path, "an image in pieces", "one Piece", "several"));
        }
        let grid = self.grid.ok_or_else(|| ReadError::missing(&self.path, "ImageData"))?;
        let extent = element.extent("Extent", "Piece Extent")?;
        if extent != grid.extent {
            let expected = "one Piece of the WholeExtent";
            return Err(ReadError::unsupported(
                &self.path,
                "a part of an image",
                expected,
                format!("{extent:?}"),
            ));
        }
        Ok(())
    }

    fn array(&mut self, element: &Element, content: bool) -> Result<(), ReadError> {
        let format = element.get("format")?.unwrap_or_default();
        let inline = content && format != "appended";
        let Some(place) = self.place else {
            // An array of the whole file; numbers in it must not be taken for one element of any length.
            return if inline { self.numbers().map(drop) } else { Ok(()) };
        };
        let type_name = element.required("type", "DataArray type")?;
        let name = element.get("Name")?.unwrap_or_default();
        let components = element.parsed("NumberOfComponents")?.unwrap_or(1);
        let span = match format.as_str() {
            "appended" => {
                let offset = element.parsed("offset")?;
                Span::Appended(offset.ok_or_else(|| ReadError::missing(&self.path, "DataArray offset"))?)
            }
            "ascii" => Span::Text([0; 2]),
            "binary" => Span::Base64([0; 2]),
            other => {
                let expected = "ascii, binary or appended";
                return Err(ReadError::field(&self.path, "DataArray format", expected, other));
            }
        };
        let (active, sample) = (self.active.as_ref() == Some(&name), sample_type(&type_name));
        let samples = 0;
        self.arrays.push(Array { name, place, active, type_name, sample, components, samples, span });
        self.open = inline;
        if inline { self.inline() } else { Ok(()) }
    }

    /// Looks for the numbers of the last array at the place the parser is at.
    fn inline(&mut self) -> Result<(), ReadError> {
        let range = self.numbers()?;
        if let Some(array) = self.arrays.last_mut().filter(|_| range[0] < range[1]) {
            self.open = false;
            match &mut array.span {
                Span::Text(span) | Span::Base64(span) => *span = range,
                Span::Appended(_) | Span::Binary(_) => {}
            }
        }
        Ok(())
    }

    /// Passes over white space and then all text up to the next element; the bytes of that text.
    fn numbers(&mut self) -> Result<[u64; 2], ReadError> {
        let mut stream = self.reader.stream();
        let before = std::mem::replace(&mut stream.get_mut().left, u64::MAX);
        let range = pass(&mut stream, |byte| byte.is_ascii_whitespace()).and_then(|()| {
            let start = stream.get_ref().position;
            pass(&mut stream, |byte| byte != b'<').map(|()| [start, stream.get_ref().position])
        });
        stream.get_mut().left = before;
        range.map_err(|e| ReadError::io(&self.path, "read", e))
    }

    /// The byte after the `_` that begins the appended section.
    fn underscore(&mut self) -> Result<u64, ReadError> {
        let mut stream = self.reader.stream();
        let mut found = [0];
        let passed = pass(&mut stream, |byte| byte.is_ascii_whitespace());
        let result = passed.and_then(|()| fill(&mut stream, &mut found).1);
        result.map_err(|e| ReadError::io(&self.path, "read", e))?;
        if found != *b"_" {
            let expected = "an underscore before the numbers";
            let found = format!("byte {:02x}", found[0]);
            return Err(ReadError::field(&self.path, "AppendedData", expected, found));
        }
        Ok(stream.get_ref().position)
    }
}

/// Passes over bytes as long as `go_on` holds for them.
fn pass(stream: &mut impl BufRead, go_on: impl Fn(u8) -> bool) -> io::Result<()> {
    loop {
        let bytes = stream.fill_buf()?;
        let n = bytes.iter().position(|&b| !go_on(b)).unwrap_or(bytes.len());
        let done = n < bytes.len() || bytes.is_empty();
        stream.consume(n);
        if done {
            return Ok(());
        }
    }
}

pub(super) fn malformed(path: &Path, error: &dyn std::error::Error) -> ReadError {
    ReadError::field(path, "XML header", "well-formed elements of at most 4 MiB", error)
}

fn sample_type(name: &str) -> Option<SampleType> {
    Some(match name {
        "UInt8" => SampleType::U8,
        "Int8" => SampleType::I8,
        "UInt16" => SampleType::U16,
        "Int16" => SampleType::I16,
        "UInt32" => SampleType::U32,
        "Int32" => SampleType::I32,
        "UInt64" => SampleType::U64,
        "Int64" => SampleType::I64,
        "Float32" => SampleType::F32,
        "Float64" => SampleType::F64,
        _ => return None,
    })
}

/// An element whose attributes are read.
pub(super) struct Element<'a> {
    pub(super) path: PathBuf,
    pub(super) element: &'a BytesStart<'a>,
}

impl Element<'_> {
    pub(super) fn get(&self, name: &str) -> Result<Option<String>, ReadError> {
        let attribute = self.element.try_get_attribute(name).map_err(|e| malformed(&self.path, &e))?;
        let value = attribute.map(|a| a.normalized_value(XmlVersion::Implicit1_0).map(|v| v.into_owned()));
        value.transpose().map_err(|e| malformed(&self.path, &e))
    }

    pub(super) fn required(&self, name: &str, shown: &'static str) -> Result<String, ReadError> {
        self.get(name)?.ok_or_else(|| ReadError::missing(&self.path, shown))
    }

    pub(super) fn parsed<T: FromStr>(&self, name: &'static str) -> Result<Option<T>, ReadError> {
        let Some(text) = self.get(name)? else { return Ok(None) };
        let parsed = text.trim().parse().map(Some);
        parsed.map_err(|_| ReadError::field(&self.path, name, "a whole number", text))
    }

    /// How the headers of arrays are written.
    fn words(&self) -> Result<Words, ReadError> {
        let wide = match self.get("header_type")?.as_deref() {
            None | Some("UInt32") => false,
            Some("UInt64") => true,
            Some(other) => {
                return Err(ReadError::field(&self.path, "header_type", "UInt32 or UInt64", other));
            }
        };
        let endian = match self.required("byte_order", "byte_order")?.as_str() {
            "LittleEndian" => Endian::Little,
            "BigEndian" => Endian::Big,
            other => {
                let expected = "LittleEndian or BigEndian";
                return Err(ReadError::field(&self.path, "byte_order", expected, other));
            }
        };
        Ok(Words { wide, endian })
    }

    fn codec(&self) -> Result<Option<Codec>, ReadError> {
        Ok(match self.get("compressor")?.as_deref() {
            None | Some("") => None,
            Some("vtkZLibDataCompressor") => Some(Codec::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Codec::Lz4),
            Some(other) => {
                let expected = "vtkZLibDataCompressor or vtkLZ4DataCompressor";
                return Err(ReadError::unsupported(&self.path, "this compressor", expected, other));
            }
        })
    }

    pub(super) fn extent(&self, name: &'static str, shown: &'static str) -> Result<[[i64; 2]; 3], ReadError> {
        let text = self.required(name, shown)?;
        let parsed: Option<Vec<i64>> = text.split_whitespace().map(|t| t.parse().ok()).collect();
        match parsed.as_deref() {
            Some(&[x0, x1, y0, y1, z0, z1]) => Ok([[x0, x1], [y0, y1], [z0, z1]]),
            _ => Err(ReadError::field(&self.path, shown, "six whole numbers", text)),
        }
    }

    /// Three numbers.
    pub(super) fn three(&self, name: &'static str) -> Result<Option<DVec3>, ReadError> {
        let Some(text) = self.get(name)? else { return Ok(None) };
        numbers::<3>(&self.path, name, "three numbers", &text).map(|n| Some(DVec3::from(n)))
    }

    fn grid(&self) -> Result<Grid, ReadError> {
        let three = |name, absent| self.three(name).map(|found| found.unwrap_or(absent));
        let direction = match self.get("Direction")? {
            None => DMat3::IDENTITY,
            // Row by row in the file.
            Some(text) => {
                let rows = numbers::<9>(&self.path, "Direction", "nine numbers", &text)?;
                DMat3::from_cols_array(&rows).transpose()
            }
        };
        Ok(Grid {
            extent: self.extent("WholeExtent", "WholeExtent")?,
            origin: three("Origin", DVec3::ZERO)?,
            spacing: three("Spacing", DVec3::ONE)?,
            direction,
        })
    }
}
