//! Arrays compressed in blocks.
//!
//! The header is a table of words: the number of blocks, the size of each but the last, the size of the last
//! (0 if it is as large as the others), and the compressed size of every block. The blocks follow without gaps.
//! As base64 text, the table is one run and all blocks together are another.

use std::io::{self, BufRead, ErrorKind, Read};
use std::path::Path;

use flate2::bufread::ZlibDecoder;

use crate::decode::fill;
use crate::error::ReadError;
use crate::sample::Endian;
use crate::vtk::section;

/// How the words of a header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Words {
    /// 64 bits instead of 32.
    pub(crate) wide: bool,
    pub(crate) endian: Endian,
}

impl Words {
    /// Bytes of one.
    pub(crate) fn size(self) -> usize {
        if self.wide { 8 } else { 4 }
    }

    /// The next one.
    pub(crate) fn read(self, input: &mut (impl Read + ?Sized)) -> io::Result<u64> {
        let mut bytes = [0; 8];
        let word = &mut bytes[..self.size()];
        input.read_exact(word)?;
        if self.endian == Endian::Big {
            word.reverse();
        }
        Ok(u64::from_le_bytes(bytes))
    }
}

/// The compressor of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Codec {
    Zlib,
    Lz4,
}

/// How the blocks of an array are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Packing {
    pub(crate) codec: Codec,
    pub(crate) words: Words,
    pub(crate) base64: bool,
}

/// Bytes that one byte of an LZ4 block decodes to at most: each byte of a match length stands for 255.
pub(crate) const LZ4_EXPANSION: u64 = 255;
/// Largest LZ4 block that is decoded, in bytes: it is held as a whole. VTK writes blocks of 32 KiB by default.
const MOST_LZ4: u64 = 64 << 20;

/// The blocks of an array, decoded one after the other.
pub(crate) struct BlockReader {
    codec: Codec,
    words: Words,
    /// The rest of the table.
    table: Box<dyn BufRead + Send>,
    /// The blocks; none while a decoder has them.
    data: Option<Box<dyn BufRead + Send>>,
    block: Block,
    blocks_left: u64,
    /// Decoded size of all blocks but the last, and of the last.
    sizes: [u64; 2],
}

/// The block being read.
enum Block {
    Done,
    /// The decoder, and the bytes that are still to come from it.
    Zlib(ZlibDecoder<io::Take<Box<dyn BufRead + Send>>>, u64),
    /// Decoded bytes, and the next of them.
    Lz4(Vec<u8>, usize),
}

impl BlockReader {
    /// The array of `expected` decoded bytes from byte `start` of `path` up to `end`.
    pub(crate) fn open(
        path: &Path,
        start: u64,
        end: Option<u64>,
        packing: Packing,
        expected: u64,
    ) -> Result<Self, ReadError> {
        let Packing { codec, words, base64 } = packing;
        let mut table = section(path, start, end, base64)?;
        let mut word = || {
            words.read(&mut table).map_err(|e| match e.kind() {
                ErrorKind::UnexpectedEof | ErrorKind::InvalidData => {
                    ReadError::missing(path, "table of compressed blocks")
                }
                _ => ReadError::io(path, "read", e),
            })
        };
        let (blocks, size, last) = (word()?, word()?, word()?);
        let last = if last == 0 { size } else { last };
        let total = match blocks.checked_sub(1) {
            None => 0,
            Some(full) => u128::from(full) * u128::from(size) + u128::from(last),
        };
        if total != u128::from(expected) {
            let found = format!("{total} bytes in blocks for {expected} in the extent");
            return Err(ReadError::field(path, "size of the array", "that of the extent", found));
        }
        let mut data = section(path, start, end, base64)?;
        // The table is in the file, or reading the last of it fails before any block is read.
        let table_bytes = (3 + u128::from(blocks)) * words.size() as u128;
        let table_bytes = u64::try_from(table_bytes).unwrap_or(u64::MAX);
        let skipped = io::copy(&mut (&mut data).take(table_bytes), &mut io::sink());
        match skipped {
            Ok(n) if n == table_bytes => {}
            Err(e) if !matches!(e.kind(), ErrorKind::UnexpectedEof | ErrorKind::InvalidData) => {
                return Err(ReadError::io(path, "read", e));
            }
            _ => return Err(ReadError::missing(path, "table of compressed blocks")),
        }
        let (data, block) = (Some(data), Block::Done);
        Ok(Self { codec, words, table, data, block, blocks_left: blocks, sizes: [size, last] })
    }

    /// Goes to the next block; whether there is one.
    fn advance(&mut self) -> io::Result<bool> {
        let broken = || io::Error::new(ErrorKind::UnexpectedEof, "no block follows");
        if let Block::Zlib(decoder, _) = std::mem::replace(&mut self.block, Block::Done) {
            let mut rest = decoder.into_inner();
            // A block may be padded.
            io::copy(&mut rest, &mut io::sink())?;
            self.data = Some(rest.into_inner());
        }
        if self.blocks_left == 0 {
            return Ok(false);
        }
        self.blocks_left -= 1;
        let size = self.sizes[usize::from(self.blocks_left == 0)];
        let packed = self.words.read(&mut self.table)?;
        let mut data = self.data.take().ok_or_else(broken)?;
        self.block = match self.codec {
            Codec::Zlib => Block::Zlib(ZlibDecoder::new(data.take(packed)), size),
            Codec::Lz4 => {
                let block = lz4_block(&mut data, packed, size)?;
                self.data = Some(data);
                Block::Lz4(block, 0)
            }
        };
        Ok(true)
    }
}

/// Decodes a block of `packed` bytes to `size` bytes.
fn lz4_block(data: &mut dyn BufRead, packed: u64, size: u64) -> io::Result<Vec<u8>> {
    let invalid = |message: String| io::Error::new(ErrorKind::InvalidData, message);
    if size > MOST_LZ4 {
        return Err(invalid(format!("expected LZ4 blocks of at most {MOST_LZ4} bytes, found {size}")));
    }
    // Incompressible bytes take one more for every 255, and a few.
    let most = size + size / LZ4_EXPANSION + 16;
    if packed > most || packed.saturating_mul(LZ4_EXPANSION) < size {
        return Err(invalid(format!("{packed} bytes cannot be an LZ4 block of {size}")));
    }
    let mut bytes = Vec::new();
    data.take(packed).read_to_end(&mut bytes)?;
    if bytes.len() as u64 != packed {
        return Err(ErrorKind::UnexpectedEof.into());
    }
    // Bounded above.
    let mut block = vec![0; size as usize];
    match lz4_flex::block::decompress_into(&bytes, &mut block) {
        Ok(n) if n == block.len() => Ok(block),
        Ok(n) => Err(invalid(format!("expected an LZ4 block of {size} bytes, found {n}"))),
        Err(e) => Err(io::Error::new(ErrorKind::InvalidData, e)),
    }
}

impl Read for BlockReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        loop {
            match &mut self.block {
                Block::Zlib(decoder, left) if *left > 0 => {
                    let most = usize::try_from(*left).unwrap_or(usize::MAX).min(buffer.len());
                    let n = decoder.read(&mut buffer[..most])?;
                    if n == 0 {
                        let message = format!("a block ends {left} bytes early");
                        return Err(io::Error::new(ErrorKind::InvalidData, message));
                    }
                    *left -= n as u64;
                    if *left == 0 {
                        // One byte more makes the decoder verify the checksum.
                        let (more, result) = fill(decoder, &mut [0]);
                        result?;
                        if more > 0 {
                            let message = "a block goes on after its size";
                            return Err(io::Error::new(ErrorKind::InvalidData, message));
                        }
                    }
                    return Ok(n);
                }
                Block::Lz4(block, at) if *at < block.len() => {
                    let n = buffer.len().min(block.len() - *at);
                    buffer[..n].copy_from_slice(&block[*at..*at + n]);
                    *at += n;
                    return Ok(n);
                }
                _ => {
                    if !self.advance()? {
                        return Ok(0);
                    }
                }
            }
        }
    }
}
