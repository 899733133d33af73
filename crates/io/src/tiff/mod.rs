//! TIFF stacks: a file of many pages, or files of one page each.

mod pages;
mod slices;
mod spacing;

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use tiff::TiffError;
use tiff::decoder::{BufferLayoutPreference, Decoder};
use tiff::tags::{ByteOrder, CompressionMethod, PlanarConfiguration, SampleFormat, Tag};

use crate::coding::Coding;
use crate::dataset::Header;
use crate::decode::{MAX_EXPANSION, open_at};
use crate::error::ReadError;
use crate::layout::{Layout, Start, dims};
use crate::sample::{Endian, SampleType};
pub(crate) use pages::PageReader;
pub(crate) use slices::slices;

/// Name of the format.
pub(crate) const FORMAT: &str = "TIFF";

type Pages = Decoder<BufReader<File>>;

/// What all pages of a stack must agree in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Page {
    width: u32,
    height: u32,
    sample: SampleType,
    components: u16,
}

impl Page {
    /// Bytes of all samples.
    fn bytes(self) -> u128 {
        u128::from(self.width)
            * u128::from(self.height)
            * u128::from(self.components)
            * self.sample.size() as u128
    }
}

impl std::fmt::Display for Page {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { width, height, sample, components } = self;
        write!(f, "{width}x{height} {sample} with {components} components")
    }
}

/// Checks all pages of `slices`: those of one file, or the single pages of several; `path` is what the user named.
pub(crate) fn header(path: &Path, slices: Vec<PathBuf>) -> Result<Header, ReadError> {
    let mut first: Option<Page> = None;
    let mut spacing = [1.0; 3];
    let mut layers = 0u64;
    for slice in &slices {
        let before = layers;
        let mut decoder = open(slice)?;
        for number in 0u64.. {
            if let Some(page) = page(slice, number, &mut decoder)? {
                match first {
                    None => {
                        spacing = spacing::of(slice, &mut decoder)?;
                        first = Some(page);
                    }
                    Some(first) if first == page => {}
                    Some(expected) => {
                        let (path, expected) = (slice.clone(), expected.to_string());
                        return Err(ReadError::Page {
                            path,
                            page: number,
                            expected,
                            found: page.to_string(),
                        });
                    }
                }
                layers += 1;
            }
            if !decoder.more_images() {
                break;
            }
            decoder.next_image().map_err(|e| failed(slice, number + 1, e))?;
        }
        if slices.len() > 1 && layers != before + 1 {
            let found = format!("{} pages", layers - before);
            return Err(ReadError::field(slice, "slice", "one page", found));
        }
    }
    let first = first.ok_or_else(|| ReadError::NoSlices { path: path.to_owned() })?;
    let large = match slices.as_slice() {
        [file] => large_stack(file, layers)?,
        _ => None,
    };
    if let Some((images, ..)) = large {
        layers = images;
    }
    let sizes = [first.width.into(), first.height.into(), layers];
    let data = slices.first().filter(|_| slices.len() == 1).map_or(path, PathBuf::as_path);
    let mut layout = Layout::new(dims(path, sizes)?, first.sample, Endian::NATIVE, data.to_owned());
    layout.components = first.components.into();
    layout.index_to_world = crate::layout::axis_aligned(spacing, [0.0; 3])
        .ok_or_else(|| ReadError::field(path, "resolution", "finite, positive", format!("{spacing:?}")))?;
    match large {
        Some((_, start, endian)) => (layout.start, layout.endian) = (Start::At(start), endian),
        None => layout.coding = Coding::Pages(Arc::from(slices)),
    }
    Ok(Header { format: FORMAT, layout, warnings: Vec::new() })
}

/// Number, first byte and byte order of the layers of an ImageJ stack that has more images than pages.
///
/// Beyond the 4 GiB of a plain TIFF file ImageJ writes the first page only, and all layers after it.
fn large_stack(path: &Path, pages: u64) -> Result<Option<(u64, u64, Endian)>, ReadError> {
    let fail = |e| failed(path, 0, e);
    let mut decoder = open(path)?;
    let images = spacing::images(path, &mut decoder)?;
    if images <= pages {
        return Ok(None);
    }
    let method = decoder.find_tag_unsigned::<u16>(Tag::Compression).map_err(fail)?;
    let starts = decoder.find_tag_unsigned_vec::<u64>(Tag::StripOffsets).map_err(fail)?.unwrap_or_default();
    match (starts.first(), method.unwrap_or(1), pages) {
        (Some(&start), 1, 1) => {
            let big = decoder.byte_order() == ByteOrder::BigEndian;
            Ok(Some((images, start, if big { Endian::Big } else { Endian::Little })))
        }
        _ => {
            let expected = "a page for each image, or one page and no compression";
            let found = format!("{images} images, {pages} pages");
            Err(ReadError::unsupported(path, "this ImageJ stack", expected, found))
        }
    }
}

/// Opens the first page of a file.
fn open(path: &Path) -> Result<Pages, ReadError> {
    Decoder::new(BufReader::new(open_at(path, 0)?)).map_err(|e| failed(path, 0, e))
}

fn failed(path: &Path, page: u64, error: TiffError) -> ReadError {
    match error {
        TiffError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            ReadError::io(path, "read", source)
        }
        error => {
            ReadError::field(path, "page", "a TIFF page that can be read", format!("{error} (page {page})"))
        }
    }
}

/// What the page says that the decoder is at; none if it is a smaller copy or a mask of another.
fn page(path: &Path, number: u64, decoder: &mut Pages) -> Result<Option<Page>, ReadError> {
    /// Bits of NewSubfileType.
    const REDUCED_OR_MASK: u32 = 1 | 4;
    let fail = |e| failed(path, number, e);
    let kind = decoder.find_tag_unsigned::<u32>(Tag::NewSubfileType).map_err(fail)?;
    if kind.is_some_and(|kind| kind & REDUCED_OR_MASK != 0) {
        return Ok(None);
    }
    let (width, height) = decoder.dimensions().map_err(fail)?;
    let components = decoder.find_tag_unsigned(Tag::SamplesPerPixel).map_err(fail)?.unwrap_or(1);
    let planar = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).map_err(fail)?;
    if components > 1 && planar == Some(PlanarConfiguration::Planar.to_u16()) {
        let expected = "components side by side";
        return Err(ReadError::unsupported(path, "one plane for each component", expected, "planes"));
    }
    let layout = decoder.image_buffer_layout().map_err(fail)?;
    let bits = decoder.colortype().map_err(fail)?.bit_depth();
    let sample = sample_type(path, bits, &layout)?;
    let page = Page { width, height, sample, components };
    if page.bytes() != layout.len as u128 {
        let found = format!("{} bytes a page for {page}", layout.len);
        return Err(ReadError::unsupported(
            path,
            "this kind of colour",
            "grey, RGB or more components",
            found,
        ));
    }
    check_room(path, number, decoder, page)?;
    Ok(Some(page))
}

fn sample_type(path: &Path, bits: u8, layout: &BufferLayoutPreference) -> Result<SampleType, ReadError> {
    Ok(match (layout.sample_format, bits) {
        (SampleFormat::Uint, 8) => SampleType::U8,
        (SampleFormat::Int, 8) => SampleType::I8,
        (SampleFormat::Uint, 16) => SampleType::U16,
        (SampleFormat::Int, 16) => SampleType::I16,
        (SampleFormat::Uint, 32) => SampleType::U32,
        (SampleFormat::Int, 32) => SampleType::I32,
        (SampleFormat::Uint, 64) => SampleType::U64,
        (SampleFormat::Int, 64) => SampleType::I64,
        (SampleFormat::IEEEFP, 32) => SampleType::F32,
        (SampleFormat::IEEEFP, 64) => SampleType::F64,
        (format, _) => {
            let expected = "integers of 8 to 64 bits, or floats of 32 or 64";
            let found = format!("{bits} bits, {format:?}");
            return Err(ReadError::unsupported(path, "this sample type", expected, found));
        }
    })
}

/// Bytes that one of an LZW stream decodes to at most: its table has 4096 entries, of which 258 begin it, so
/// that no string is longer than 3839 bytes; such a long one has a code of at least 9 bits.
const LZW_EXPANSION: u64 = 3839 * 8 / 9 + 1;
/// As much for PackBits: two bytes stand for up to 128.
const PACK_BITS_EXPANSION: u64 = 64;

/// Refuses a page that is too short for what it claims, whatever is in it.
fn check_room(path: &Path, number: u64, decoder: &mut Pages, page: Page) -> Result<(), ReadError> {
    let fail = |e| failed(path, number, e);
    let tiles = decoder.find_tag_unsigned_vec::<u64>(Tag::TileByteCounts).map_err(fail)?;
    let counts = match tiles {
        Some(tiles) => Some(tiles),
        None => decoder.find_tag_unsigned_vec(Tag::StripByteCounts).map_err(fail)?,
    };
    let metadata = decoder.inner().get_ref().metadata();
    let length = metadata.map_err(|e| ReadError::io(path, "ask for the length", e))?.len();
    let stored = counts.unwrap_or_default().iter().fold(0u64, |sum, &n| sum.saturating_add(n)).min(length);
    let method = decoder.find_tag_unsigned::<u16>(Tag::Compression).map_err(fail)?;
    let expansion = match method.map_or(CompressionMethod::None, CompressionMethod::from_u16_exhaustive) {
        CompressionMethod::None => 1,
        CompressionMethod::PackBits => PACK_BITS_EXPANSION,
        CompressionMethod::Deflate | CompressionMethod::OldDeflate => MAX_EXPANSION,
        CompressionMethod::LZW => LZW_EXPANSION,
        other => {
            let expected = "none, LZW, deflate or PackBits";
            return Err(ReadError::unsupported(path, "this compression", expected, format!("{other:?}")));
        }
    };
    let found = stored.saturating_mul(expansion);
    if page.bytes() > u128::from(found) {
        let expected = u64::try_from(page.bytes()).unwrap_or(u64::MAX);
        let (path, what) = (path.to_owned(), "samples of a page");
        return Err(ReadError::ShortData { path, what, expected, found, at_most: true });
    }
    Ok(())
}
