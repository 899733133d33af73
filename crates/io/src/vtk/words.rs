//! Words of a text file in which binary data may stand.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::decode::{FILE_BUFFER, open_at};
use crate::error::ReadError;

/// Longest word or line that is read, in bytes.
const MAX_WORD: usize = 4 << 10;

/// Reads white-space separated words, and knows at which byte of the file it is.
pub(super) struct WordReader {
    path: PathBuf,
    input: BufReader<File>,
    position: u64,
    length: u64,
}

impl WordReader {
    pub(super) fn open(path: &Path) -> Result<Self, ReadError> {
        let file = open_at(path, 0)?;
        let length = file.metadata().map_err(|e| ReadError::io(path, "ask for the length", e))?.len();
        let input = BufReader::with_capacity(FILE_BUFFER, file);
        Ok(Self { path: path.to_owned(), input, position: 0, length })
    }

    pub(super) fn position(&self) -> u64 {
        self.position
    }

    fn peek(&mut self) -> Result<Option<u8>, ReadError> {
        let bytes = self.input.fill_buf().map_err(|e| ReadError::io(&self.path, "read", e))?;
        Ok(bytes.first().copied())
    }

    fn advance(&mut self, count: usize) {
        self.input.consume(count);
        self.position += count as u64;
    }

    /// Bytes up to the first for which `ends` holds, which is not taken; at most [`MAX_WORD`].
    fn until(&mut self, ends: impl Fn(u8) -> bool) -> Result<String, ReadError> {
        let mut found = Vec::new();
        while let Some(byte) = self.peek()?
            && !ends(byte)
        {
            if found.len() == MAX_WORD {
                let text = String::from_utf8_lossy(&found);
                return Err(ReadError::field(&self.path, "line", "at most 4096 bytes", text));
            }
            found.push(byte);
            self.advance(1);
        }
        Ok(String::from_utf8_lossy(&found).into_owned())
    }

    /// The next word; none at the end of the file.
    pub(super) fn word(&mut self) -> Result<Option<String>, ReadError> {
        while self.peek()?.is_some_and(|b| b.is_ascii_whitespace()) {
            self.advance(1);
        }
        let word = self.until(|b| b.is_ascii_whitespace())?;
        Ok((!word.is_empty()).then_some(word))
    }

    /// The next word, which must be there.
    pub(super) fn required(&mut self, what: &'static str) -> Result<String, ReadError> {
        let found = self.position;
        let short = || ReadError::ShortHeader { path: self.path.clone(), expected: what, found };
        let error = short();
        self.word()?.ok_or(error)
    }

    /// The next word as a number.
    pub(super) fn number<T: FromStr>(&mut self, what: &'static str) -> Result<T, ReadError> {
        let word = self.required(what)?;
        word.parse().map_err(|_| ReadError::field(&self.path, what, "a number", word))
    }

    /// The next words as numbers.
    pub(super) fn numbers<T: FromStr, const N: usize>(
        &mut self,
        what: &'static str,
    ) -> Result<[T; N], ReadError> {
        let mut found = Vec::with_capacity(N);
        for _ in 0..N {
            found.push(self.number(what)?);
        }
        found.try_into().map_err(|_| ReadError::missing(&self.path, what))
    }

    /// The rest of the line, whose end is taken.
    pub(super) fn line(&mut self) -> Result<String, ReadError> {
        let line = self.until(|b| b == b'\n')?;
        if self.peek()?.is_some() {
            self.advance(1);
        }
        Ok(line)
    }

    /// Passes over `count` words; whether there were so many.
    pub(super) fn skip_words(&mut self, count: u128) -> Result<bool, ReadError> {
        let mut left = count;
        let mut inside = false;
        while left > 0 {
            let bytes = self.input.fill_buf().map_err(|e| ReadError::io(&self.path, "read", e))?;
            if bytes.is_empty() {
                return Ok(inside && left == 1);
            }
            let mut taken = 0;
            for byte in bytes {
                let space = byte.is_ascii_whitespace();
                if inside && space {
                    left -= 1;
                }
                inside = !space;
                if left == 0 {
                    break;
                }
                taken += 1;
            }
            self.advance(taken);
        }
        Ok(true)
    }

    /// Passes over `count` bytes; whether there were so many.
    pub(super) fn skip_bytes(&mut self, count: u128) -> Result<bool, ReadError> {
        let left = self.length.saturating_sub(self.position);
        let Some(count) = i64::try_from(count).ok().filter(|&n| n.unsigned_abs() <= left) else {
            return Ok(false);
        };
        self.input.seek_relative(count).map_err(|e| ReadError::io(&self.path, "seek", e))?;
        self.position += count.unsigned_abs();
        Ok(true)
    }
}
