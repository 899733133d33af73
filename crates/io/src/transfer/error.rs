//! Why a transfer-function file cannot be used.

use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use isoray_preint::TransferFunctionError;

use super::RemapError;
use crate::error::shown;

/// Why a transfer-function file could not be read: the file, the place in it, what was expected and what was found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TransferFileError {
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
    /// The file is longer than any transfer function.
    #[error("{}: expected a transfer function of at most {most} bytes, found a longer file", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Bytes that are read.
        most: u64,
    },
    /// There is nothing but white space.
    #[error("{}: expected a transfer function, found an empty file", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file is no text.
    #[error("{}: expected a transfer function as text (TOML, or a ParaView preset in JSON), found none: byte {at} is not UTF-8", path.display())]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first byte that is none of a text, from 0.
        at: usize,
    },
    /// The text breaks the rules of its format, a key is missing or unknown, or a value is of the wrong type.
    #[error("{}:{line}:{column}: expected a {format}, found: {message}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Character of the line, from 1.
        column: usize,
        /// What the file should be.
        format: &'static str,
        /// What the parser says.
        message: String,
    },
    /// A value of the file is wrong.
    #[error("{}{}: {place}: expected {expected}, found {found}", path.display(), position(at))]
    Value {
        /// The file.
        path: PathBuf,
        /// Line and character, from 1, where they are known.
        at: Option<[usize; 2]>,
        /// Name of the value, with indices from 0.
        place: String,
        /// What would have been legal.
        expected: String,
        /// What is there, shortened.
        found: String,
    },
    /// An option is wrong, or wrong for this file.
    #[error("{}: {reason}", path.display())]
    Remap {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: RemapError,
    },
    /// The unit distance of opacities is no length, or one that no extinction can be found for.
    #[error("{}: expected a unit distance between 1e-20 and 1e20, found {found}", path.display())]
    UnitDistance {
        /// The file.
        path: PathBuf,
        /// The distance given.
        found: f64,
    },
    /// The points that come out are no transfer function.
    #[error("{}: {reason}", path.display())]
    Function {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: TransferFunctionError,
    },
}

fn position(at: &Option<[usize; 2]>) -> String {
    at.map_or(String::new(), |[line, column]| format!(":{line}:{column}"))
}

/// A text and the file that it is from.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    /// A wrong value at a place of which only the name is known.
    pub(crate) fn wrong(
        self,
        place: impl Into<String>,
        expected: impl Into<String>,
        found: impl AsRef<str>,
    ) -> TransferFileError {
        TransferFileError::Value {
            path: self.path.to_owned(),
            at: None,
            place: place.into(),
            expected: expected.into(),
            found: shown(found.as_ref()),
        }
    }

    /// A wrong value at a byte of the text.
    pub(crate) fn wrong_at(
        self,
        byte: usize,
        place: impl Into<String>,
        expected: impl Into<String>,
        found: impl AsRef<str>,
    ) -> TransferFileError {
        TransferFileError::Value {
            path: self.path.to_owned(),
            at: Some(self.line_column(byte)),
            place: place.into(),
            expected: expected.into(),
            found: shown(found.as_ref()),
        }
    }

    /// A part of the text.
    pub(crate) fn snippet(&self, span: Range<usize>) -> &str {
        self.text.get(span).unwrap_or_default()
    }

    /// Line and character of a byte, from 1.
    pub(crate) fn line_column(self, byte: usize) -> [usize; 2] {
        let before = &self.text.as_bytes()[..byte.min(self.text.len())];
        let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
        let start = before.iter().rposition(|&b| b == b'\n').map_or(0, |n| n + 1);
        [line, String::from_utf8_lossy(&before[start..]).chars().count() + 1]
    }
}
