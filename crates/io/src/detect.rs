//! Telling the format of a file, and reading its header.

use std::io::Read;
use std::path::Path;
#[cfg(feature = "tiff")]
use std::path::PathBuf;

use crate::dataset::{Header, OpenOptions};
use crate::decode::{GZIP_MAGIC, fill, inflate, open_at};
use crate::error::ReadError;
#[cfg(feature = "tiff")]
use crate::tiff;
use crate::vtk::{image_data, legacy};
use crate::{metaimage, nifti, npy, nrrd, raw};

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

/// The formats with a header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Nrrd,
    MetaImage,
    Nifti,
    ImageData,
    LegacyVtk,
    Numpy,
    Tiff,
}

impl Format {
    fn name(self) -> &'static str {
        match self {
            Self::Nrrd => nrrd::FORMAT,
            Self::MetaImage => metaimage::FORMAT,
            Self::Nifti => nifti::FORMAT,
            Self::ImageData => image_data::FORMAT,
            Self::LegacyVtk => legacy::FORMAT,
            Self::Numpy => npy::FORMAT,
            Self::Tiff => "TIFF",
        }
    }

    /// Whether the file is a collection of named arrays.
    fn has_fields(self) -> bool {
        matches!(self, Self::ImageData | Self::LegacyVtk)
    }

    /// The format of a file that begins with `head`, after decompression if it is a gzip file.
    fn by_content(head: &[u8], gzip: bool) -> Option<Self> {
        /// Byte order and version, 42 or for large files 43.
        const TIFF: [&[u8]; 4] = [b"II\x2a\0", b"MM\0\x2a", b"II\x2b\0", b"MM\0\x2b"];
        if nifti::is_header(head) {
            return Some(Self::Nifti);
        }
        let plain = [
            (Self::Nrrd, head.starts_with(nrrd::MAGIC)),
            (Self::ImageData, image_data::is_header(head)),
            (Self::LegacyVtk, head.starts_with(legacy::MAGIC)),
            (Self::Numpy, head.starts_with(npy::MAGIC)),
            (Self::Tiff, TIFF.iter().any(|magic| head.starts_with(magic))),
            (Self::MetaImage, metaimage::is_header(head)),
        ];
        plain.into_iter().find(|&(_, found)| found && !gzip).map(|(format, _)| format)
    }

    /// The format that the name of a file promises.
    fn by_name(path: &Path, gzip: bool) -> Option<Self> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref()? {
            "nrrd" | "nhdr" => Some(Self::Nrrd),
            "mhd" | "mha" => Some(Self::MetaImage),
            "nii" | "hdr" => Some(Self::Nifti),
            "vti" => Some(Self::ImageData),
            "vtk" => Some(Self::LegacyVtk),
            "npy" => Some(Self::Numpy),
            "tif" | "tiff" => Some(Self::Tiff),
            "gz" if gzip && path.to_string_lossy().to_ascii_lowercase().ends_with(".nii.gz") => {
                Some(Self::Nifti)
            }
            _ => None,
        }
    }
}

/// Tells the format and reads the header.
pub(crate) fn read_header(path: &Path, options: &OpenOptions) -> Result<Header, ReadError> {
    #[cfg(feature = "tiff")]
    if path.is_dir() {
        return slices_header(path, tiff::slices(path)?, options);
    }
    let (head, gzip) = head(path)?;
    if head.is_empty() && !gzip {
        return Err(ReadError::Empty { path: path.to_owned() });
    }
    let known = Format::by_content(&head, gzip);
    if let Some(layout) = &options.raw {
        return match known {
            Some(format) if layout.skip == 0 => {
                Err(ReadError::NotRaw { path: path.to_owned(), format: format.name() })
            }
            _ if options.field.is_some() => Err(no_fields(path, raw::FORMAT)),
            _ => raw::header(path, layout),
        };
    }
    // The header of such an image is in another file.
    let header = path.with_extension("hdr");
    if known.is_none() && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("img")) && header.is_file()
    {
        let (head, gzip) = self::head(&header)?;
        return nifti::header(&header, &head, gzip);
    }
    let Some(format) = known.or_else(|| Format::by_name(path, gzip)) else {
        return Err(ReadError::UnknownFormat { path: path.to_owned() });
    };
    if options.field.is_some() && !format.has_fields() {
        return Err(no_fields(path, format.name()));
    }
    match format {
        Format::Nrrd => nrrd::header(path),
        Format::MetaImage => metaimage::header(path),
        Format::Nifti => nifti::header(path, &head, gzip),
        Format::ImageData => image_data::header(path, options.field.as_deref()),
        Format::LegacyVtk => legacy::header(path, options.field.as_deref()),
        Format::Numpy => npy::header(path),
        #[cfg(feature = "tiff")]
        Format::Tiff => tiff::header(path, vec![path.to_owned()]),
        #[cfg(not(feature = "tiff"))]
        Format::Tiff => {
            Err(ReadError::unsupported(path, "this build", "one with the feature 'tiff'", "TIFF"))
        }
    }
}

fn no_fields(path: &Path, format: &'static str) -> ReadError {
    ReadError::NoFields { path: path.to_owned(), format }
}

/// Reads the headers of TIFF slices; `path` is what the user named.
#[cfg(feature = "tiff")]
pub(crate) fn slices_header(
    path: &Path,
    slices: Vec<PathBuf>,
    options: &OpenOptions,
) -> Result<Header, ReadError> {
    if options.field.is_some() {
        return Err(no_fields(path, tiff::FORMAT));
    }
    if options.raw.is_some() {
        return Err(ReadError::NotRaw { path: path.to_owned(), format: tiff::FORMAT });
    }
    tiff::header(path, slices)
}
