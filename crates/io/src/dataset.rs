//! Opening a file, whatever its format.

use std::io::Read;
use std::marker::PhantomData;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use glam::DAffine3;
use isoray_grid::{Dims, MappedFile, Scalar, ScalarType, map_file};
use zerocopy::FromBytes;

use crate::decode::{DECODED, GZIP_MAGIC, INFLATED, MAX_EXPANSION, fill, inflate, open_at};
use crate::error::{ReadError, Warning};
use crate::layout::{Coding, Layout, Start};
use crate::raw::RawLayout;
use crate::sample::Endian;
use crate::slabs::{Slabs, probe};
use crate::{metaimage, nifti, nrrd, raw};

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
    /// # Errors
    /// A file that cannot be read, is of no known format, contradicts itself, or is shorter than it says.
    pub fn open(path: &Path, options: &OpenOptions) -> Result<Self, ReadError> {
        let Header { format, layout, mut warnings } = read_header(path, options)?;
        let layout = layout.choose(path, options.component)?;
        let offset = match layout.coding {
            Coding::Raw => check_length(&layout, &mut warnings)?,
            Coding::Deflate | Coding::Text => match layout.start {
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

    /// Type of the samples handed out: 32-bit integers, 64-bit floats and rescaled samples become `f32`.
    pub fn scalar(&self) -> ScalarType {
        self.layout.scalar()
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

/// Bytes that tell every format: a NIfTI-2 header is the longest.
const HEAD: usize = nifti::NIFTI2_BYTES;

/// The first bytes of `path`, those of the decompressed stream if it is a gzip file, and whether it is one.
fn head(path: &Path) -> Result<(Vec<u8>, bool), ReadError> {
    let mut buffer = vec![0; HEAD];
    let mut file = open_at(path, 0)?;
    let (n, result) = fill(&mut file, &mut buffer);
    result.map_err(|e| ReadError::io(path, "read", e))?;
    buffer.truncate(n);
    if !buffer.starts_with(&GZIP_MAGIC) {
        return Ok((buffer, false));
    }
    let mut buffer = vec![0; HEAD];
    let mut stream: Box<dyn Read + Send> = inflate(path, 0)?;
    // A stream that breaks off is no known header; the reader of its samples says where it breaks.
    let (n, _) = fill(&mut stream, &mut buffer);
    buffer.truncate(n);
    Ok((buffer, true))
}

/// Tells the format and reads the header.
fn read_header(path: &Path, options: &OpenOptions) -> Result<Header, ReadError> {
    let (head, gzip) = head(path)?;
    if head.is_empty() && !gzip {
        return Err(ReadError::Empty { path: path.to_owned() });
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let known = if head.starts_with(nrrd::MAGIC) && !gzip {
        Some(nrrd::FORMAT)
    } else if nifti::is_header(&head) {
        Some(nifti::FORMAT)
    } else if metaimage::is_header(&head) && !gzip {
        Some(metaimage::FORMAT)
    } else {
        None
    };
    if let Some(layout) = &options.raw {
        return match known {
            Some(format) if layout.skip == 0 => Err(ReadError::NotRaw { path: path.to_owned(), format }),
            _ => raw::header(path, layout),
        };
    }
    match (known, extension.as_str()) {
        (Some(nrrd::FORMAT), _) | (None, "nrrd" | "nhdr") => nrrd::header(path),
        (Some(metaimage::FORMAT), _) | (None, "mhd" | "mha") => metaimage::header(path),
        (Some(_), _) => nifti::header(path, &head, gzip),
        (None, "img") if path.with_extension("hdr").is_file() => {
            let header = path.with_extension("hdr");
            let (head, gzip) = self::head(&header)?;
            nifti::header(&header, &head, gzip)
        }
        (None, "nii" | "hdr") => nifti::header(path, &head, gzip),
        (None, _) if gzip && path.to_string_lossy().to_ascii_lowercase().ends_with(".nii.gz") => {
            nifti::header(path, &head, gzip)
        }
        (None, _) => Err(ReadError::UnknownFormat { path: path.to_owned() }),
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
    let found = length.saturating_sub(offset);
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
    let metadata = open_at(path, 0)?.metadata().map_err(|e| ReadError::io(path, "ask for the length", e))?;
    let length = metadata.len().saturating_sub(offset);
    let (what, most) = match layout.coding {
        Coding::Raw => return Ok(()),
        Coding::Deflate => (INFLATED, length.saturating_mul(MAX_EXPANSION)),
        // A digit and a separator, which the last sample does not need.
        Coding::Text => (DECODED, length.div_ceil(2).saturating_mul(layout.sample.size() as u64)),
    };
    let (expected, found) = (layout.stored_bytes(), most.saturating_sub(layout.stream_skip));
    if found < expected {
        return Err(ReadError::ShortData { path: path.clone(), what, expected, found, at_most: true });
    }
    Ok(())
}
