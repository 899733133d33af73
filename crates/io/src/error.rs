//! What a failed read says.

use std::io;
use std::path::{Path, PathBuf};

use isoray_grid::{DimsError, ScalarType};

/// Why a volume file could not be opened or read: the file, what was expected and what was found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system refused to open or read the file.
    #[error("{}: cannot {action}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the operating system says.
        source: io::Error,
    },
    /// The separate file that a header names for its samples cannot be opened.
    #[error("{}: expected the samples in {}, which cannot be opened", path.display(), data.display())]
    DataFile {
        /// The header.
        path: PathBuf,
        /// The file that it names.
        data: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file is empty.
    #[error("{}: expected a volume, found an empty file", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Neither content nor extension tells the format, and no layout was given.
    #[error(
        "{}: expected NRRD, MetaImage, NIfTI, VTK image data, NumPy or TIFF, found none of them; a headerless raw \
         file needs its layout \
         (--dims NX,NY,NZ and --type, for instance --type u8)",
        path.display()
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A raw layout was given for a file that states its own.
    #[error(
        "{}: expected headerless samples (--dims and --type were given), found a {format} header; leave the \
         layout away, or skip the header",
        path.display()
    )]
    NotRaw {
        /// The file.
        path: PathBuf,
        /// The format found.
        format: &'static str,
    },
    /// The header ends too early.
    #[error("{}: expected {expected}, found the end of the header after {found} bytes", path.display())]
    ShortHeader {
        /// The file.
        path: PathBuf,
        /// What was still to come.
        expected: &'static str,
        /// Bytes of the header that are there.
        found: u64,
    },
    /// A required field is missing.
    #[error("{}: expected the header field '{field}', found none", path.display())]
    MissingField {
        /// The file.
        path: PathBuf,
        /// Name of the field.
        field: &'static str,
    },
    /// A field of the header, or an argument, has a value that it cannot have.
    #[error("{}: {field}: expected {expected}, found '{found}'", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// Name of the field.
        field: &'static str,
        /// What would have been legal.
        expected: &'static str,
        /// What is there, shortened.
        found: String,
    },
    /// A legal file that uses a feature that is not supported.
    #[error("{}: {feature} is not supported; expected {expected}, found '{found}'", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The feature.
        feature: &'static str,
        /// What is supported.
        expected: &'static str,
        /// What is there, shortened.
        found: String,
    },
    /// A lattice size that no volume can have.
    #[error("{}: no volume can have the size stated", path.display())]
    Dims {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: DimsError,
    },
    /// Several components and no choice.
    #[error("{}: file has {count} components; choose one with --component 0..{}", path.display(), count - 1)]
    ChooseComponent {
        /// The file.
        path: PathBuf,
        /// Components in the file.
        count: u64,
    },
    /// A choice beyond the last component.
    #[error("{}: expected a component in 0..{}, found --component {chosen}", path.display(), count - 1)]
    NoSuchComponent {
        /// The file.
        path: PathBuf,
        /// Components in the file.
        count: u64,
        /// The one asked for.
        chosen: usize,
    },
    /// A file with several named arrays, none of which is the obvious one, and no choice; or with no array at all.
    #[error("{}: expected one array, found {names}; choose one with --field NAME", path.display())]
    ChooseField {
        /// The file.
        path: PathBuf,
        /// The names of its arrays.
        names: String,
    },
    /// A choice of an array that the file does not have.
    #[error("{}: expected one of the arrays {names}, found --field {chosen}", path.display())]
    NoSuchField {
        /// The file.
        path: PathBuf,
        /// The one asked for.
        chosen: String,
        /// The names of the arrays in the file.
        names: String,
    },
    /// A choice of an array in a format whose arrays have no names.
    #[error("{}: the {format} format has no named arrays; leave --field away", path.display())]
    NoFields {
        /// The file.
        path: PathBuf,
        /// Its format.
        format: &'static str,
    },
    /// A folder without slices, a stack without pages, or a list without files.
    #[error("{}: expected a file with samples, or a directory of TIFF slices (*.tif, *.tiff), found neither", path.display())]
    NoSlices {
        /// The folder or file.
        path: PathBuf,
    },
    /// A page of a stack that does not agree with the first.
    #[error("{}: page {page}: expected {expected} like the first page, found {found}", path.display())]
    Page {
        /// The file with the page.
        path: PathBuf,
        /// Number of the page in it, from 0.
        page: u64,
        /// Size and type of the first page.
        expected: String,
        /// Size and type of this page.
        found: String,
    },
    /// Fewer bytes of samples than the header states.
    #[error(
        "{}: expected {expected} bytes of {what}, found {}{found}",
        path.display(),
        if *at_most { "room for at most " } else { "" }
    )]
    ShortData {
        /// The file that holds the samples.
        path: PathBuf,
        /// What the bytes are: samples, or decompressed samples.
        what: &'static str,
        /// Bytes that the header states.
        expected: u64,
        /// Bytes that are there.
        found: u64,
        /// Whether `found` is what a coded stream of the file's length can hold at most; it has not been decoded.
        at_most: bool,
    },
    /// A compressed or text stream that cannot be decoded.
    #[error("{}: expected a {coding}, found bytes that are none after {decoded} decoded ones", path.display())]
    Corrupt {
        /// The file that holds the samples.
        path: PathBuf,
        /// What the stream should have been.
        coding: &'static str,
        /// Bytes decoded before the error.
        decoded: u64,
        /// What the decoder says.
        source: io::Error,
    },
    /// The reader was asked for another sample type than the file hands out.
    #[error("{}: expected to read {expected} samples, found {found} ones", path.display())]
    WrongType {
        /// The file.
        path: PathBuf,
        /// The type asked for.
        expected: ScalarType,
        /// The type that the file hands out.
        found: ScalarType,
    },
    /// Part of a mesh of several levels that contradicts the rest, or has a form that is not read.
    #[error("{}: {what}: expected {expected}, found {found}", path.display())]
    Mesh {
        /// The file that says so.
        path: PathBuf,
        /// The part: a level, a box, a cell, a point.
        what: String,
        /// What would have been consistent.
        expected: String,
        /// What is there.
        found: String,
    },
    /// Neither a file nor a folder with a mesh of several levels.
    #[error(
        "{}: expected an AMReX plotfile (a folder with a Header), a VTK overlapping AMR file (.vthb, .vtm) or \
         legacy VTK hexahedra, found none of them",
        path.display()
    )]
    NoMesh {
        /// The file or folder.
        path: PathBuf,
    },
    /// A mesh in a known format that no reader is there for yet.
    #[error(
        "{}: {format} is not supported yet; expected an AMReX plotfile, a VTK overlapping AMR file or legacy VTK \
         hexahedra",
        path.display()
    )]
    NotYet {
        /// The file or folder.
        path: PathBuf,
        /// What it is.
        format: &'static str,
    },
    /// Layers were asked for that the volume does not have.
    #[error(
        "{}: expected whole layers of {layer} samples within {layers} layers, found a request for {samples} \
         samples from layer {first}",
        path.display()
    )]
    Layers {
        /// The file.
        path: PathBuf,
        /// Samples in a layer.
        layer: usize,
        /// Layers in the volume.
        layers: u32,
        /// First layer asked for.
        first: u32,
        /// Samples asked for.
        samples: usize,
    },
}

/// Characters of a bad value that an error repeats.
const SHOWN: usize = 60;

/// `found`, shortened and without control characters, for an error.
pub(crate) fn shown(found: &str) -> String {
    let mut text: String = found.chars().take(SHOWN).map(|c| if c.is_control() { '?' } else { c }).collect();
    if found.chars().nth(SHOWN).is_some() {
        text.push('…');
    }
    text
}

/// Names that an error lists.
const LISTED: usize = 20;

/// `names` as an error lists them; `none` if there are none.
pub(crate) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names = names.into_iter();
    let mut first: Vec<_> = names.by_ref().take(LISTED).map(shown).collect();
    if first.is_empty() {
        return "none".to_owned();
    }
    if names.next().is_some() {
        first.push("…".to_owned());
    }
    first.join(", ")
}

impl ReadError {
    pub(crate) fn io(path: &Path, action: &'static str, source: io::Error) -> Self {
        Self::Io { path: path.to_owned(), action, source }
    }

    pub(crate) fn field(
        path: &Path,
        field: &'static str,
        expected: &'static str,
        found: impl ToString,
    ) -> Self {
        Self::Field { path: path.to_owned(), field, expected, found: shown(&found.to_string()) }
    }

    pub(crate) fn unsupported(
        path: &Path,
        feature: &'static str,
        expected: &'static str,
        found: impl ToString,
    ) -> Self {
        Self::Unsupported { path: path.to_owned(), feature, expected, found: shown(&found.to_string()) }
    }

    pub(crate) fn mesh(
        path: &Path,
        what: impl Into<String>,
        expected: impl Into<String>,
        found: impl ToString,
    ) -> Self {
        let (what, expected, found) = (what.into(), expected.into(), shown(&found.to_string()));
        Self::Mesh { path: path.to_owned(), what, expected, found }
    }

    pub(crate) fn missing(path: &Path, field: &'static str) -> Self {
        Self::MissingField { path: path.to_owned(), field }
    }
}

/// Something about a file that can be read all the same, but that its user should know.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// The file goes on after the last sample.
    #[error("{}: {extra} bytes after the last sample are ignored", path.display())]
    ExtraBytes {
        /// The file that holds the samples.
        path: PathBuf,
        /// Bytes after the last sample.
        extra: u64,
    },
    /// A compressed or text stream goes on after the last sample; how far is not known.
    #[error("{}: the stream goes on after the last sample; the rest is ignored", path.display())]
    ExtraStream {
        /// The file that holds the samples.
        path: PathBuf,
    },
    /// Samples that are not exact in 32-bit floating point were rounded.
    #[error("{}: {samples} samples lost digits in the conversion to f32", path.display())]
    Rounded {
        /// The file that holds the samples.
        path: PathBuf,
        /// How many samples.
        samples: u64,
    },
    /// Finite samples beyond the range of 32-bit floating point became infinite.
    #[error("{}: {samples} samples are beyond the range of f32 and became infinite", path.display())]
    Overflowed {
        /// The file that holds the samples.
        path: PathBuf,
        /// How many samples.
        samples: u64,
    },
    /// A transform of the header cannot be inverted, and the next best was taken.
    #[error("{}: the {transform} transform of the header cannot be inverted and is ignored", path.display())]
    BadTransform {
        /// The file.
        path: PathBuf,
        /// Name of the transform.
        transform: &'static str,
    },
}
