//! Base64 text as bytes.

use std::io::{self, BufRead, Read};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Characters decoded at once: whole groups of four.
const PIECE: usize = 4 << 10;

/// Decodes base64 text up to the first character that is none, for instance the `<` of the next element.
///
/// Padding ends a run, not the text: the header of an array and the array are encoded one after the other.
pub(crate) struct Base64Reader<R> {
    input: R,
    /// Characters that have been read, a whole number of groups.
    text: Vec<u8>,
    /// The next of them to decode.
    next: usize,
    decoded: Vec<u8>,
    /// The next of them to hand out.
    at: usize,
}

impl<R: BufRead> Base64Reader<R> {
    pub(crate) fn new(input: R) -> Self {
        Self { input, text: Vec::new(), next: 0, decoded: Vec::new(), at: 0 }
    }

    /// Reads characters, without white space, up to a whole piece or the end of the text.
    fn collect(&mut self) -> io::Result<()> {
        self.text.clear();
        self.next = 0;
        while self.text.len() < PIECE {
            let bytes = self.input.fill_buf()?;
            let Some(&first) = bytes.first() else { break };
            if !first.is_ascii_whitespace() && !is_digit(first) {
                break;
            }
            let taken = bytes.iter().take(PIECE - self.text.len());
            let taken = taken.take_while(|b| b.is_ascii_whitespace() || is_digit(**b)).count();
            self.text.extend(bytes[..taken].iter().filter(|b| !b.is_ascii_whitespace()));
            self.input.consume(taken);
        }
        if !self.text.len().is_multiple_of(4) {
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the text ends inside a group of four"));
        }
        Ok(())
    }

    /// Decodes the next run of characters; whether there was one.
    fn decode(&mut self) -> io::Result<bool> {
        if self.next == self.text.len() {
            self.collect()?;
        }
        let rest = &self.text[self.next..];
        let run = rest.iter().position(|&b| b == b'=').map_or(rest.len(), |pad| (pad / 4 + 1) * 4);
        self.decoded.clear();
        self.at = 0;
        let decoded = STANDARD.decode_vec(&rest[..run], &mut self.decoded);
        decoded.map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))?;
        self.next += run;
        Ok(run > 0)
    }
}

fn is_digit(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'/' | b'=')
}

impl<R: BufRead> Read for Base64Reader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.at == self.decoded.len() {
            if buffer.is_empty() || !self.decode()? {
                return Ok(0);
            }
        }
        let n = buffer.len().min(self.decoded.len() - self.at);
        buffer[..n].copy_from_slice(&self.decoded[self.at..self.at + n]);
        self.at += n;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(text: &[u8]) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Base64Reader::new(text).read_to_end(&mut bytes).map(|_| bytes)
    }

    #[test]
    fn runs_white_space_and_ends() {
        assert_eq!(decode(b"").unwrap(), b"");
        assert_eq!(decode(b" SGVs\n bG8= V29ybGQ=\n").unwrap(), b"HelloWorld");
        assert_eq!(decode(b"SGVsbG8=</DataArray>").unwrap(), b"Hello");
        assert!(decode(b"SGVsbG8").is_err());
        assert!(decode(b"S===").is_err());
        assert!(decode(b"=AAA").is_err());
        let long: Vec<u8> = (0..50_000u32).map(|i| ((i * i) >> 7) as u8).collect();
        assert_eq!(decode(STANDARD.encode(&long).as_bytes()).unwrap(), long);
    }
}
