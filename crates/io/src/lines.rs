//! Text headers, line by line.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Take};
use std::path::{Path, PathBuf};

use crate::decode::open_at;
use crate::error::ReadError;

/// Longest text header that is read, in bytes; diffusion gradients and histories take some kilobytes.
const MAX_HEADER: u64 = 4 << 20;

/// The lines of a text header, and how many bytes of the file they took.
pub(crate) struct HeaderLines {
    path: PathBuf,
    input: Take<BufReader<File>>,
    taken: u64,
}

impl HeaderLines {
    /// Starts at the beginning of `path`.
    pub(crate) fn open(path: &Path) -> Result<Self, ReadError> {
        Self::open_within(path, MAX_HEADER)
    }

    /// Starts at the beginning of `path`, of which no more than `most` bytes are read.
    pub(crate) fn open_within(path: &Path, most: u64) -> Result<Self, ReadError> {
        let input = BufReader::new(open_at(path, 0)?).take(most);
        Ok(Self { path: path.to_owned(), input, taken: 0 })
    }

    /// The next line without its end; none at the end of the file or beyond the longest header.
    pub(crate) fn next_line(&mut self) -> Result<Option<String>, ReadError> {
        let mut bytes = Vec::new();
        let n = self.input.read_until(b'\n', &mut bytes).map_err(|e| ReadError::io(&self.path, "read", e))?;
        self.taken += n as u64;
        if n == 0 {
            return Ok(None);
        }
        while bytes.last().is_some_and(|b| matches!(b, b'\n' | b'\r')) {
            bytes.pop();
        }
        Ok(Some(String::from_utf8_lossy(&bytes).into_owned()))
    }

    /// The next line, which must be there.
    pub(crate) fn required(&mut self, expected: &'static str) -> Result<String, ReadError> {
        let found = self.taken;
        let short = || ReadError::ShortHeader { path: self.path.clone(), expected, found };
        let error = short();
        self.next_line()?.ok_or(error)
    }

    /// Bytes of the file that the lines so far took.
    pub(crate) fn taken(&self) -> u64 {
        self.taken
    }
}

/// The numbers of a white-space separated list of exactly `N`.
pub(crate) fn numbers<const N: usize>(
    path: &Path,
    field: &'static str,
    expected: &'static str,
    text: &str,
) -> Result<[f64; N], ReadError> {
    let parsed: Option<Vec<f64>> = text.split_whitespace().map(|t| t.parse().ok()).collect();
    parsed
        .and_then(|v| <[f64; N]>::try_from(v).ok())
        .ok_or_else(|| ReadError::field(path, field, expected, text))
}

/// Positive integers of a white-space separated list.
pub(crate) fn counts(
    path: &Path,
    field: &'static str,
    expected: &'static str,
    text: &str,
) -> Result<Vec<u64>, ReadError> {
    let parsed: Option<Vec<u64>> =
        text.split_whitespace().map(|t| t.parse().ok().filter(|&n| n > 0)).collect();
    parsed.ok_or_else(|| ReadError::field(path, field, expected, text))
}
