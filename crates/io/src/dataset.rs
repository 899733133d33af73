//! Opening a file, whatever its format.

use std::marker::PhantomData;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use glam::DAffine3;
use isoray_grid::{Dims, MappedFile, Scalar, ScalarType, map_file};
use zerocopy::FromBytes;

use crate::coding::Coding;
use crate::decode::open_at;
use crate::detect::read_header;
use crate::error::{ReadError, Warning};
use crate::layout::{Layout, Start};
use crate::raw::RawLayout;
use crate::sample::Endian;
use crate::slabs::{Slabs, probe};

/// What the user of a file knows beyond the file.
#[derive(Clone, Debug, Default)]
pub struct OpenOptions {
    /// Layout of a headerless file.
    ///
    /// A file whose first bytes are a known header is refused if a layout is given for it whose `skip` is 0,
    /// since its header would be read as samples; with another `skip` it is read as headerless.
    pub raw: Option<RawLayout>,
    /// The component to read, from 0, of a file with several.
    pub component: Option<usize>,
    /// The name of the array to read, of a VTK file with several.
    pub field: Option<String>,
}

/// A volume file whose header has been read and checked, and whose samples have not been read.
#[derive(Clone, Debug)]
pub struct Dataset {
    path: PathBuf,
    format: &'static str,
    layout: Layout,
    /// Byte of the data file at which samples or their stream begin.
    offset: u64,
    warnings: Vec<Warning>,
}

/// A file's format with what its header says.
pub(crate) struct Header {
    pub(crate) format: &'static str,
    pub(crate) layout: Layout,
    pub(crate) warnings: Vec<Warning>,
}

impl Dataset {
    /// Reads and checks the header of the file at `path`; its first bytes tell the format, else its extension.
    ///
    /// A folder is a stack of the TIFF slices in it, in the order of the numbers in their names.
    ///
    /// # Errors
    /// A file that cannot be read, is of no known format, contradicts itself, or is shorter than it says.
    pub fn open(path: &Path, options: &OpenOptions) -> Result<Self, ReadError> {
        Self::new(path, read_header(path, options)?, options)
    }

    /// Reads and checks the headers of TIFF files with one slice each, the lowest layer first.
    ///
    /// # Errors
    /// As [`open`](Self::open); also an empty list, and slices that differ in size or type.
    #[cfg(feature = "tiff")]
    pub fn open_slices(paths: &[PathBuf], options: &OpenOptions) -> Result<Self, ReadError> {
        let path = paths.first().map_or(Path::new("no files"), PathBuf::as_path);
        let header = crate::detect::slices_header(path, paths.to_vec(), options)?;
        Self::new(path, header, options)
    }

    fn new(path: &Path, header: Header, options: &OpenOptions) -> Result<Self, ReadError> {
        let Header { format, layout, mut warnings } = header;
        let layout = layout.choose(path, options.component)?;
        let offset = match layout.coding {
            Coding::Raw => check_length(&layout, &mut warnings)?,
            _ => match layout.start {
                Start::At(offset) => offset,
                Start::FromEnd => {
                    return Err(ReadError::unsupported(
                        path,
                        "a coded stream at the end of a file",
                        "a number of bytes to skip",
                        "-1",
                    ));
                }
            },
        };
        if layout.coding != Coding::Raw {
            probe(&layout, offset)?;
            check_room(&layout, offset)?;
        }
        Ok(Self { path: path.to_owned(), format, layout, offset, warnings })
    }

    /// Size of the lattice.
    pub fn dims(&self) -> Dims {
        self.layout.dims
    }

    /// Type of the samples handed out: integers of 32 and 64 bits, 64-bit floats and rescaled samples become `f32`.
    pub fn scalar(&self) -> ScalarType {
        self.layout.scalar()
    }

    /// Number of values per sample in the file, one of which is handed out.
    pub fn components(&self) -> u64 {
        self.layout.components
    }

    /// The map from index coordinates to the world of the file, in the file's own units and axes.
    pub fn index_to_world(&self) -> DAffine3 {
        self.layout.index_to_world
    }

    /// Name of the format, for reports.
    pub fn format(&self) -> &str {
        self.format
    }

    /// Size of all samples in the type handed out, in bytes.
    pub fn raw_bytes(&self) -> u64 {
        (self.dims().samples() * self.scalar().size()) as u64
    }

    /// The file that was opened.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What its user should know about the file, as far as the header tells.
    pub fn warnings(&self) -> Vec<Warning> {
        self.warnings.clone()
    }

    /// A reader of the samples, which must be asked for in the type [`scalar`](Self::scalar).
    ///
    /// # Errors
    /// Another type than that.
    pub fn slabs<T: Scalar>(&self) -> Result<Slabs<T>, ReadError> {
        if T::TYPE == self.scalar() {
            Ok(Slabs::new(self.path.clone(), self.layout.clone(), self.offset))
        } else {
            let (expected, found) = (T::TYPE, self.scalar());
            Err(ReadError::WrongType { path: self.path.clone(), expected, found })
        }
    }

    /// The samples as they lie in the file, if they lie there as they are handed out: uncompressed, in this
    /// machine's byte order, aligned, one component after the other, and of type `T`.
    ///
    /// `None` also if the file cannot be mapped; [`slabs`](Self::slabs) then says why.
    pub fn mapped<T: Scalar>(&self) -> Option<MappedSamples<T>> {
        let layout = &self.layout;
        let native = layout.endian == Endian::NATIVE || layout.sample.size() == 1;
        let as_is = layout.coding == Coding::Raw && layout.is_unconverted() && layout.is_contiguous();
        if !(T::TYPE == self.scalar() && native && as_is) {
            return None;
        }
        let bytes = layout.dims.samples() * layout.sample.size();
        let start = usize::try_from(self.offset).ok()?.checked_add(bytes * layout.component as usize)?;
        let map = map_file(&layout.data).ok()?;
        <[T]>::ref_from_bytes(map.get(start..start.checked_add(bytes)?)?).ok()?;
        Some(MappedSamples { map, start, bytes, sample: PhantomData })
    }
}

/// The samples of a file, mapped into memory; it dereferences to a slice, `i` fastest.
///
/// The file must not be shortened meanwhile, see [`map_file`].
#[derive(Clone, Debug)]
pub struct MappedSamples<T> {
    map: MappedFile,
    start: usize,
    bytes: usize,
    sample: PhantomData<T>,
}

impl<T: Scalar> Deref for MappedSamples<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        // Length and alignment were checked when the file was mapped, and a mapping does not move.
        <[T]>::ref_from_bytes(&self.map[self.start..self.start + self.bytes]).unwrap_or_default()
    }
}

/// Checks an uncoded data file's length against its header; the byte at which the samples begin.
fn check_length(layout: &Layout, warnings: &mut Vec<Warning>) -> Result<u64, ReadError> {
    let path = &layout.data;
    let file = open_at(path, 0)?;
    let length = file.metadata().map_err(|e| ReadError::io(path, "ask for the length", e))?.len();
    let expected = layout.stored_bytes();
    let (offset, what) = match layout.start {
        Start::At(offset) => (offset, "samples"),
        Start::FromEnd => (length.saturating_sub(expected), "samples at the end"),
    };
    let found = layout.end.map_or(length, |end| end.min(length)).saturating_sub(offset);
    if found < expected {
        return Err(ReadError::ShortData { path: path.clone(), what, expected, found, at_most: false });
    }
    if found > expected {
        warnings.push(Warning::ExtraBytes { path: path.clone(), extra: found - expected });
    }
    Ok(offset)
}

/// Refuses a compressed or text file that is too short for the samples of its header, whatever is in it, so that a
/// claim costs nobody memory or time.
fn check_room(layout: &Layout, offset: u64) -> Result<(), ReadError> {
    let path = &layout.data;
    let ask = |e| ReadError::io(path, "ask for the length", e);
    let length = std::fs::metadata(path).map_err(ask)?.len();
    let length = layout.end.map_or(length, |end| end.min(length)).saturating_sub(offset);
    let Some(most) = layout.coding.room(length, layout.sample.size() as u64) else { return Ok(()) };
    let what = layout.coding.names().1;
    let (expected, found) = (layout.stored_bytes(), most.saturating_sub(layout.stream_skip));
    if found < expected {
        return Err(ReadError::ShortData { path: path.clone(), what, expected, found, at_most: true });
    }
    Ok(())
}
