//! VTK image data in XML: `.vti`.

use std::io::{ErrorKind, Read};
use std::path::Path;

use glam::{DMat3, DVec3};

use super::blocks::{Packing, Words};
use super::xml::{self, Document};
use super::{Array, Place, Span, choose, section};
use crate::coding::Coding;
use crate::dataset::Header;
use crate::error::ReadError;
use crate::layout::{Layout, Start};
use crate::sample::Endian;

/// Name of the format.
pub(crate) const FORMAT: &str = "VTK image data";

/// Whether `head` begins with a VTK file in XML.
pub(crate) fn is_header(head: &[u8]) -> bool {
    const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
    const ELEMENT: &[u8] = b"<VTKFile";
    let text = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head).trim_ascii_start();
    text.starts_with(b"<") && text.windows(ELEMENT.len()).any(|w| w == ELEMENT)
}

/// Reads the XML part of `path`; the volume is that of the array called `field`, if it is given.
pub(crate) fn header(path: &Path, field: Option<&str>) -> Result<Header, ReadError> {
    let document = xml::read(path)?;
    let array = choose(path, &document.arrays, field)?;
    let expected = "integers of 8 to 64 bits, Float32 or Float64";
    let unsupported = || ReadError::unsupported(path, "this type", expected, &array.type_name);
    let sample = array.sample.ok_or_else(unsupported)?;
    let (dims, index_to_world) = document.grid.lattice(path, array.place)?;
    let mut layout = Layout::new(dims, sample, document.words.endian, path.to_owned());
    layout.index_to_world = index_to_world;
    layout.components = super::components(path, array.components)?;
    place(path, &document, array, &mut layout)?;
    Ok(Header { format: FORMAT, layout, warnings: Vec::new() })
}

/// What a file says that is a piece of a larger mesh.
pub(crate) struct Piece {
    /// Cells along each axis.
    pub(crate) cells: [u64; 3],
    /// World position of the lowest corner.
    pub(crate) low: DVec3,
    /// World edges of a cell, as columns.
    pub(crate) edges: DMat3,
    pub(crate) arrays: Vec<Array>,
}

/// Reads the XML part of `path`.
pub(crate) fn piece(path: &Path) -> Result<Piece, ReadError> {
    let Document { grid, arrays, .. } = xml::read(path)?;
    let cells = grid.samples(path, Place::Points)?.map(|n| n - 1);
    let edges = grid.direction * DMat3::from_diagonal(grid.spacing);
    let first = DVec3::from_array(grid.extent.map(|[first, _]| first as f64));
    Ok(Piece { cells, low: grid.origin + edges * first, edges, arrays })
}

/// Where the numbers of `array` begin and end, and how they are coded.
fn place(path: &Path, document: &Document, array: &Array, layout: &mut Layout) -> Result<(), ReadError> {
    let words = document.words;
    let (start, end, base64) = match array.span {
        Span::Text([start, end]) => {
            layout.coding = Coding::Text;
            layout.endian = Endian::NATIVE;
            (layout.start, layout.end) = (Start::At(start), Some(end));
            return Ok(());
        }
        Span::Base64([start, end]) | Span::Binary([start, end]) => (start, Some(end), true),
        Span::Appended(offset) => {
            let missing = || ReadError::missing(path, "AppendedData");
            let (start, base64) = document.appended.ok_or_else(missing)?;
            (start.saturating_add(offset), None, base64)
        }
    };
    (layout.start, layout.end) = (Start::At(start), end);
    if let Some(codec) = document.codec {
        layout.coding = Coding::Blocks(Packing { codec, words, base64 });
        return Ok(());
    }
    let bytes = stated_bytes(path, words, &mut section(path, start, end, base64)?)?;
    let expected = layout.claimed_bytes();
    if u128::from(bytes) != expected {
        let found = format!("{bytes} bytes for {expected} in the extent");
        return Err(ReadError::field(path, "size of the array", "that of the extent", found));
    }
    if base64 {
        layout.coding = Coding::Base64;
        layout.stream_skip = words.size() as u64;
    } else {
        let start = start.saturating_add(words.size() as u64);
        (layout.start, layout.end) = (Start::At(start), Some(start.saturating_add(bytes)));
    }
    Ok(())
}

/// The word before an array that is not compressed: its bytes.
fn stated_bytes(path: &Path, words: Words, input: &mut dyn Read) -> Result<u64, ReadError> {
    words.read(input).map_err(|e| match e.kind() {
        ErrorKind::UnexpectedEof | ErrorKind::InvalidData => ReadError::missing(path, "size of the array"),
        _ => ReadError::io(path, "read", e),
    })
}
