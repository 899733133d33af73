//! Samples read in any order, by several threads.

use std::fs::File;
use std::io;

use isoray_grid::{RowSource, Scalar};
use zerocopy::IntoBytes;

use crate::coding::Coding;
use crate::error::ReadError;
use crate::layout::Layout;
use crate::sample::{Endian, swap_in_place};

/// A file whose samples lie one after the other as they are handed out, but for their byte order.
#[derive(Debug)]
pub(crate) struct Rows {
    file: File,
    layout: Layout,
    /// Byte of the first sample.
    start: u64,
}

impl Rows {
    /// `None` if the samples do not lie so, or the file cannot be opened; `start` is the byte of the first one.
    pub(crate) fn open(layout: &Layout, start: u64) -> Option<Self> {
        let is_plain = layout.coding == Coding::Raw && layout.is_unconverted() && layout.is_contiguous();
        let file = if is_plain && cfg!(unix) { File::open(&layout.data).ok()? } else { return None };
        Some(Self { file, layout: layout.clone(), start })
    }
}

impl<T: Scalar> RowSource<T> for Rows {
    type Error = ReadError;

    fn read_rows(&self, layer: u32, first: u32, out: &mut [T]) -> Result<(), ReadError> {
        let size = self.layout.sample.size() as u64;
        let begin = self.layout.dims.linear([0, first, layer]) as u64 * size;
        let bytes = out.as_mut_bytes();
        read_at(&self.file, bytes, self.start + begin).map_err(|e| {
            let path = self.layout.data.clone();
            let end = self.file.metadata().map_or(0, |m| m.len().saturating_sub(self.start));
            match e.kind() {
                io::ErrorKind::UnexpectedEof => {
                    let expected = self.layout.stored_bytes();
                    ReadError::ShortData { path, what: "samples", expected, found: end, at_most: false }
                }
                _ => ReadError::io(&path, "read", e),
            }
        })?;
        if self.layout.endian != Endian::NATIVE {
            swap_in_place(bytes, size as usize);
        }
        Ok(())
    }
}

#[cfg(unix)]
fn read_at(file: &File, bytes: &mut [u8], at: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, at)
}

#[cfg(not(unix))]
fn read_at(_: &File, _: &mut [u8], _: u64) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
