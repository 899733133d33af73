//! How the samples of a file are coded, and the stream that decodes them.

use std::io::Read;
#[cfg(feature = "tiff")]
use std::path::PathBuf;
#[cfg(feature = "tiff")]
use std::sync::Arc;

use crate::decode::{MAX_EXPANSION, TextReader, inflate};
use crate::error::ReadError;
use crate::layout::Layout;
#[cfg(feature = "tiff")]
use crate::tiff::PageReader;
use crate::vtk::blocks::{BlockReader, Codec, LZ4_EXPANSION, Packing};
use crate::vtk::section;

/// How the samples of a file are coded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Coding {
    /// As they are.
    Raw,
    /// A gzip or zlib stream; its first bytes tell which.
    Deflate,
    /// Decimal numbers, separated by white space or commas.
    Text,
    /// Base64 text.
    Base64,
    /// Blocks compressed one by one, with a table of their sizes before them.
    Blocks(Packing),
    /// The pages of TIFF files, one after the other; they have been checked to agree.
    #[cfg(feature = "tiff")]
    Pages(Arc<[PathBuf]>),
}

/// What errors call a compressed stream.
pub(crate) const DEFLATE_NAME: &str = "gzip or zlib stream";
/// What errors call the samples of a compressed stream.
const INFLATED: &str = "decompressed samples";
/// What errors call the samples of a file in text form.
const DECODED: &str = "decoded samples";

impl Coding {
    /// What errors call the stream and the samples in it.
    pub(crate) fn names(&self) -> (&'static str, &'static str) {
        match self {
            Self::Raw => ("sample", "samples"),
            Self::Deflate => (DEFLATE_NAME, INFLATED),
            Self::Text => ("number of the stated type", DECODED),
            Self::Base64 => ("base64 text", DECODED),
            Self::Blocks(Packing { codec: Codec::Zlib, .. }) => ("sequence of zlib blocks", INFLATED),
            Self::Blocks(Packing { codec: Codec::Lz4, .. }) => ("sequence of LZ4 blocks", INFLATED),
            #[cfg(feature = "tiff")]
            Self::Pages(_) => ("sequence of TIFF pages", DECODED),
        }
    }

    /// Bytes of samples that `length` bytes of a file hold at most; none if that has been checked already.
    pub(crate) fn room(&self, length: u64, sample_bytes: u64) -> Option<u64> {
        match self {
            Self::Raw => None,
            Self::Deflate | Self::Blocks(Packing { codec: Codec::Zlib, .. }) => {
                Some(length.saturating_mul(MAX_EXPANSION))
            }
            Self::Blocks(Packing { codec: Codec::Lz4, .. }) => Some(length.saturating_mul(LZ4_EXPANSION)),
            // A digit and a separator, which the last sample does not need.
            Self::Text => Some(length.div_ceil(2).saturating_mul(sample_bytes)),
            // Four characters for three bytes.
            Self::Base64 => Some(length.div_ceil(4).saturating_mul(3)),
            #[cfg(feature = "tiff")]
            Self::Pages(_) => None,
        }
    }
}

/// The stream of the decoded samples of `layout`, which is not [`Coding::Raw`]; it begins at byte `offset`.
pub(crate) fn open_stream(layout: &Layout, offset: u64) -> Result<Box<dyn Read + Send>, ReadError> {
    let (path, end) = (&layout.data, layout.end);
    Ok(match &layout.coding {
        Coding::Deflate => inflate(path, offset)?,
        Coding::Raw | Coding::Text => Box::new(TextReader::open(path, offset, end, layout.sample)?),
        Coding::Base64 => {
            // Another array may follow in the same text.
            let length = layout.stream_skip.saturating_add(layout.stored_bytes());
            Box::new(section(path, offset, end, true)?.take(length))
        }
        Coding::Blocks(packing) => {
            Box::new(BlockReader::open(path, offset, end, *packing, layout.stored_bytes())?)
        }
        #[cfg(feature = "tiff")]
        Coding::Pages(slices) => Box::new(PageReader::new(slices.clone())),
    })
}
