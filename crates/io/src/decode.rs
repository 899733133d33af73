//! Streams of decoded samples: gzip, zlib and text.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Take};
use std::path::Path;

use flate2::bufread::{GzDecoder, ZlibDecoder};

use crate::coding::DEFLATE_NAME;
use crate::error::ReadError;
use crate::sample::SampleType;

/// First bytes of a gzip member.
pub(crate) const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];
/// Bytes read from the file at once.
pub(crate) const FILE_BUFFER: usize = 256 << 10;
/// Longest number in a text file.
const MAX_TOKEN: usize = 64;

/// Opens `path` for reading from byte `offset` on.
pub(crate) fn open_at(path: &Path, offset: u64) -> Result<File, ReadError> {
    let mut file = File::open(path).map_err(|e| ReadError::io(path, "open the file", e))?;
    file.seek(SeekFrom::Start(offset)).map_err(|e| ReadError::io(path, "seek", e))?;
    Ok(file)
}

/// Opens `path` for reading from byte `offset` up to `end`, or else to the end of the file.
pub(crate) fn open_between(path: &Path, offset: u64, end: Option<u64>) -> Result<Take<File>, ReadError> {
    let length = end.map_or(u64::MAX, |end| end.saturating_sub(offset));
    Ok(open_at(path, offset)?.take(length))
}

/// Reads until `buffer` is full or the input ends; the number of bytes, and the error that stopped it.
pub(crate) fn fill(reader: &mut (impl Read + ?Sized), buffer: &mut [u8]) -> (usize, io::Result<()>) {
    let mut filled = 0;
    while filled < buffer.len() {
        match reader.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return (filled, Err(e)),
        }
    }
    (filled, Ok(()))
}

/// The decoder of the gzip or zlib stream that begins at byte `offset` of `path`.
pub(crate) fn inflate(path: &Path, offset: u64) -> Result<Box<dyn Read + Send>, ReadError> {
    let mut input = BufReader::with_capacity(FILE_BUFFER, open_at(path, offset)?);
    let head = input.fill_buf().map_err(|e| ReadError::io(path, "read", e))?;
    if head.starts_with(&GZIP_MAGIC) {
        Ok(Box::new(Gzip(Some(GzDecoder::new(input)))))
    } else if is_zlib(head) {
        Ok(Box::new(ZlibDecoder::new(input)))
    } else {
        let found = match head {
            [] => "the end of the file".to_owned(),
            [a] => format!("the byte {a:02x}"),
            [a, b, ..] => format!("the bytes {a:02x} {b:02x}"),
        };
        let source = io::Error::new(io::ErrorKind::InvalidData, format!("the stream begins with {found}"));
        Err(ReadError::Corrupt { path: path.to_owned(), coding: DEFLATE_NAME, decoded: 0, source })
    }
}

/// Bytes that one byte of a deflate stream decodes to at most (RFC 1951): a match gives up to 258 and takes at
/// least one bit for its length and one for its distance. Headers and checksums only lower the ratio.
pub(crate) const MAX_EXPANSION: u64 = 258 * 8 / 2;

/// Whether `head` begins with a zlib header (RFC 1950, section 2.2): method 8 and a multiple of 31.
fn is_zlib(head: &[u8]) -> bool {
    const METHOD_MASK: u8 = 0x0f;
    const DEFLATE: u8 = 8;
    const CHECK: u16 = 31;
    matches!(head, [a, b, ..]
        if a & METHOD_MASK == DEFLATE && u16::from_be_bytes([*a, *b]).is_multiple_of(CHECK))
}

/// All members of a gzip file one after the other; bytes after the last that are no member are left alone.
struct Gzip(Option<GzDecoder<BufReader<File>>>);

impl Read for Gzip {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while let Some(decoder) = &mut self.0 {
            let n = decoder.read(buffer)?;
            if n > 0 || buffer.is_empty() {
                return Ok(n);
            }
            let mut input = self.0.take().map(GzDecoder::into_inner);
            let another = match &mut input {
                Some(rest) => rest.fill_buf()?.first() == Some(&GZIP_MAGIC[0]),
                None => false,
            };
            if another {
                self.0 = input.map(GzDecoder::new);
            }
        }
        Ok(0)
    }
}

/// Numbers in text form as samples in this machine's byte order.
pub(crate) struct TextReader {
    input: BufReader<Take<File>>,
    sample: SampleType,
    /// Bytes of a sample that did not fit into the last buffer: the first `waiting` from the end.
    sample_bytes: [u8; 8],
    waiting: usize,
}

impl TextReader {
    /// Reads numbers of type `sample` from byte `offset` of `path` up to `end`.
    pub(crate) fn open(
        path: &Path,
        offset: u64,
        end: Option<u64>,
        sample: SampleType,
    ) -> Result<Self, ReadError> {
        let input = BufReader::with_capacity(FILE_BUFFER, open_between(path, offset, end)?);
        Ok(Self { input, sample, sample_bytes: [0; 8], waiting: 0 })
    }

    /// The next number's characters, or none at the end.
    fn token(&mut self) -> io::Result<Option<String>> {
        let mut token = String::new();
        loop {
            let bytes = self.input.fill_buf()?;
            let Some(&byte) = bytes.first() else { break };
            let separator = byte.is_ascii_whitespace() || byte == b',';
            if separator && !token.is_empty() {
                break;
            }
            self.input.consume(1);
            if !separator {
                token.push(char::from(byte));
            }
            if token.len() > MAX_TOKEN {
                break;
            }
        }
        Ok((!token.is_empty()).then_some(token))
    }
}

/// Writes the number in `token` to the last bytes of `out`, in this machine's byte order.
fn parse_into(token: &str, sample: SampleType, out: &mut [u8; 8]) -> bool {
    fn put<const N: usize>(bytes: [u8; N], out: &mut [u8; 8]) {
        out[8 - N..].copy_from_slice(&bytes);
    }
    match sample {
        SampleType::U8 => token.parse::<u8>().map(|v| put(v.to_ne_bytes(), out)).is_ok(),
        SampleType::I8 => token.parse::<i8>().map(|v| put(v.to_ne_bytes(), out)).is_ok(),
        SampleType::U16 => token.parse::<u16>().map(|v| put(v.to_ne_bytes(), out)).is_ok(),
        SampleType::I16 => token.parse::<i16>().map(|v| put(v.to_ne_bytes(), out)).is_ok(),
        SampleType::U32 => token.parse::<u32>().map(|v| put(v.to_ne_bytes(), out)).is_ok(),
        SampleType::I32 => token.parse::<i32>().map(|v| put(v.to_ne_bytes(), out)).is_ok(),
        SampleType::U64 => token.parse::<u64>().map(|v| put(v.to_ne_bytes(), out)).is_ok(),
        SampleType::I64 => token.parse::<i64>().map(|v| put(v.to_ne_bytes(), out)).is_ok(),
        SampleType::F32 => token.parse::<f32>().map(|v| put(v.to_ne_bytes(), out)).is_ok(),
        SampleType::F64 => token.parse::<f64>().map(|v| put(v.to_ne_bytes(), out)).is_ok(),
    }
}

impl Read for TextReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut filled = 0;
        while filled < buffer.len() {
            if self.waiting == 0 {
                let Some(token) = self.token()? else { break };
                if !parse_into(&token, self.sample, &mut self.sample_bytes) {
                    let found = crate::error::shown(&token);
                    let message = format!("expected a number of type {}, found '{found}'", self.sample);
                    return Err(io::Error::new(io::ErrorKind::InvalidData, message));
                }
                self.waiting = self.sample.size();
            }
            let n = self.waiting.min(buffer.len() - filled);
            let begin = self.sample_bytes.len() - self.waiting;
            buffer[filled..filled + n].copy_from_slice(&self.sample_bytes[begin..begin + n]);
            self.waiting -= n;
            filled += n;
        }
        Ok(filled)
    }
}
