//! The samples of all pages as one stream.

use std::io::{self, Read};
use std::path::PathBuf;
use std::sync::Arc;

use super::{Page, Pages, open, page};

/// Decodes page after page; one of them is held.
pub(crate) struct PageReader {
    slices: Arc<[PathBuf]>,
    /// Number of files that have been opened.
    opened: usize,
    /// The last of them, if it may have more pages, and the number of its page.
    decoder: Option<(Pages, u64)>,
    first: Option<Page>,
    samples: Vec<u8>,
    /// The next of the bytes to hand out.
    at: usize,
}

impl PageReader {
    pub(crate) fn new(slices: Arc<[PathBuf]>) -> Self {
        Self { slices, opened: 0, decoder: None, first: None, samples: Vec::new(), at: 0 }
    }

    /// Decodes the next page; whether there is one.
    fn advance(&mut self) -> io::Result<bool> {
        loop {
            let (mut decoder, number) = match self.decoder.take() {
                Some((mut decoder, number)) if decoder.more_images() => {
                    let result = decoder.next_image();
                    result.map_err(|e| self.invalid(number + 1, &e))?;
                    (decoder, number + 1)
                }
                _ => {
                    let Some(slice) = self.slices.get(self.opened) else { return Ok(false) };
                    self.opened += 1;
                    (open(slice).map_err(io::Error::other)?, 0)
                }
            };
            let slice = &self.slices[self.opened - 1];
            let found = page(slice, number, &mut decoder).map_err(io::Error::other)?;
            if let Some(found) = found {
                let first = *self.first.get_or_insert(found);
                if found != first {
                    return Err(self.invalid(number, &format!("expected {first}, found {found}")));
                }
                // The page has been checked against the length of its file.
                self.samples.resize(usize::try_from(found.bytes()).unwrap_or(usize::MAX), 0);
                self.at = 0;
                let result = decoder.read_image_bytes(&mut self.samples);
                result.map_err(|e| self.invalid(number, &e))?;
            }
            self.decoder = Some((decoder, number));
            if found.is_some() {
                return Ok(true);
            }
        }
    }

    /// An error that names the file and the page.
    fn invalid(&self, page: u64, what: &dyn std::fmt::Display) -> io::Error {
        let path = self.slices[self.opened.saturating_sub(1)].display();
        io::Error::new(io::ErrorKind::InvalidData, format!("{path}: page {page}: {what}"))
    }
}

impl Read for PageReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() || (self.at == self.samples.len() && !self.advance()?) {
            return Ok(0);
        }
        let n = buffer.len().min(self.samples.len() - self.at);
        buffer[..n].copy_from_slice(&self.samples[self.at..self.at + n]);
        self.at += n;
        Ok(n)
    }
}
