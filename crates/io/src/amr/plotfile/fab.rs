//! The values of one box: a FAB.
//!
//! A line of text, and after it the values of one component after the other, x fastest:
//! `FAB ((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))((0,0,0) (15,15,31) (0,0,0)) 7`

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::notation::{Notation, RealFormat, TypedBox};
use crate::decode::{fill, open_at};
use crate::error::ReadError;
use crate::sample::{Endian, Losses, swap_in_place, to_f32};

/// Longest line before the values, in bytes.
const MOST_LINE: usize = 512;

/// An open file with the values of several boxes.
#[derive(Debug)]
pub(super) struct FabFile {
    path: PathBuf,
    file: File,
    length: u64,
}

/// The values of a box in its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FabHeader {
    pub(super) format: RealFormat,
    /// The box with its ghost cells.
    pub(super) corners: TypedBox,
    pub(super) components: u64,
    /// Byte of the file at which the values begin.
    pub(super) start: u64,
}

/// Which of the values of a box are wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) component: u64,
    /// Values along each axis, without those of ghost cells.
    pub(super) size: [u32; 3],
    pub(super) ghosts: [u32; 3],
}

impl Part {
    /// Values along each axis in the file.
    fn stored(&self) -> [u64; 3] {
        [0, 1, 2].map(|i| u64::from(self.size[i]) + 2 * u64::from(self.ghosts[i]))
    }

    /// Bytes of `components` components in the file.
    pub(super) fn bytes(&self, format: RealFormat, components: u64) -> u128 {
        let [x, y, z] = self.stored().map(u128::from);
        // A product of two numbers below 2^32 and two below 2^64 may leave 128 bits.
        (x * y * z).saturating_mul(u128::from(components)).saturating_mul(format.sample.size() as u128)
    }
}

impl FabFile {
    pub(super) fn open(path: &Path) -> Result<Self, ReadError> {
        let file = open_at(path, 0)?;
        let length = file.metadata().map_err(|e| ReadError::io(path, "ask for the length", e))?.len();
        Ok(Self { path: path.to_owned(), file, length })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes in the file.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Reads the line before the values, which begins at byte `offset`.
    pub(super) fn header(&mut self, offset: u64) -> Result<FabHeader, ReadError> {
        let mut buffer = [0; MOST_LINE];
        let n = self.read_at(offset, &mut buffer)?;
        let Some(end) = buffer[..n].iter().position(|&b| b == b'\n') else {
            let expected = format!("a line 'FAB (…)' of at most {MOST_LINE} bytes");
            let found = format!("{n} bytes without its end");
            return Err(ReadError::mesh(&self.path, format!("byte {offset}"), expected, found));
        };
        let line = String::from_utf8_lossy(&buffer[..end]);
        let (format, corners, components) = self.line(offset, &line)?;
        Ok(FabHeader { format, corners, components, start: offset + end as u64 + 1 })
    }

    fn line(&self, offset: u64, line: &str) -> Result<(RealFormat, TypedBox, u64), ReadError> {
        let wrong = |expected: &str| {
            ReadError::mesh(&self.path, format!("byte {offset}"), expected, format!("'{line}'"))
        };
        let rest = line.trim_start().strip_prefix("FAB").ok_or_else(|| wrong("a line 'FAB (…)'"))?;
        if rest.trim_start().starts_with(':') {
            // Of the 1990s; the order of the bytes was an option of the program.
            let expected = "a line 'FAB (…)', which states the byte order";
            return Err(ReadError::unsupported(&self.path, "the oldest kind of FAB", expected, line));
        }
        let mut notation = Notation::new(rest);
        let format = notation.real_format();
        let format = format.ok_or_else(|| wrong("IEEE numbers of 32 or 64 bits, little- or big-endian"))?;
        let corners = notation.typed_box().ok_or_else(|| wrong("a box after the number format"))?;
        let components = notation.number().ok_or_else(|| wrong("a number of components after the box"))?;
        Ok((format, corners, components))
    }

    /// Reads one component of the values at byte `start`; `buffer` is scratch.
    pub(super) fn values(
        &mut self,
        start: u64,
        format: RealFormat,
        part: Part,
        buffer: &mut Vec<u8>,
        losses: &mut Losses,
    ) -> Result<Vec<f32>, ReadError> {
        let needed = part.bytes(format, part.component + 1);
        check_room(&self.path, self.length, start, needed)?;
        // The file is as long.
        let bytes = part.bytes(format, 1) as usize;
        buffer.resize(bytes, 0);
        let at = start + part.component * bytes as u64;
        let found = self.read_at(at, buffer)?;
        // Less than the length said, if somebody has shortened the file meanwhile.
        check_room(&self.path, at + found as u64, at, bytes as u128)?;
        if format.endian != Endian::NATIVE {
            swap_in_place(buffer, format.sample.size());
        }
        Ok(crop(buffer, format, part, losses))
    }

    /// Reads at byte `offset` until `buffer` is full or the file ends; the number of bytes.
    fn read_at(&mut self, offset: u64, buffer: &mut [u8]) -> Result<usize, ReadError> {
        self.file.seek(SeekFrom::Start(offset)).map_err(|e| ReadError::io(&self.path, "seek", e))?;
        let (n, result) = fill(&mut self.file as &mut dyn Read, buffer);
        result.map_err(|e| ReadError::io(&self.path, "read", e))?;
        Ok(n)
    }
}

/// Checks that `bytes` bytes follow byte `start` of a file of `length` bytes.
pub(super) fn check_room(path: &Path, length: u64, start: u64, bytes: u128) -> Result<(), ReadError> {
    let found = length.saturating_sub(start);
    if u128::from(found) >= bytes {
        return Ok(());
    }
    let expected = u64::try_from(bytes).unwrap_or(u64::MAX);
    let (path, what) = (path.to_owned(), "the values of a box");
    Err(ReadError::ShortData { path, what, expected, found, at_most: false })
}

/// Converts the values of one component, without those of ghost cells.
fn crop(bytes: &[u8], format: RealFormat, part: Part, losses: &mut Losses) -> Vec<f32> {
    let Part { size, ghosts, .. } = part;
    let [x, y, z] = size.map(|n| n as usize);
    let mut values = vec![0.0; x * y * z];
    if ghosts == [0; 3] {
        *losses += to_f32(bytes, format.sample, None, &mut values);
        return values;
    }
    let [row, rows, _] = part.stored().map(|n| n as usize);
    let [i, j, k] = ghosts.map(|n| n as usize);
    for (number, out) in values.chunks_exact_mut(x).enumerate() {
        let (y, z) = (number % y + j, number / y + k);
        let first = ((z * rows + y) * row + i) * format.sample.size();
        let from = &bytes[first..first + x * format.sample.size()];
        *losses += to_f32(from, format.sample, None, out);
    }
    values
}
