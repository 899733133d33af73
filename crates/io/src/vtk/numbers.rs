//! Numbers of a legacy VTK file, in text or binary.

use std::io::Read;
use std::path::Path;

use crate::decode::{TextReader, fill, open_between};
use crate::error::ReadError;
use crate::sample::{Endian, SampleType, swap_in_place};

/// Numbers that are decoded at once.
pub(super) const PIECE: usize = 8 << 10;

/// Numbers in a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbers {
    pub(super) sample: SampleType,
    /// How many there are; the file is known to be long enough.
    pub(super) count: u64,
    pub(super) span: [u64; 2],
    pub(super) ascii: bool,
}

impl Numbers {
    /// Hands out the numbers in pieces, as bytes in this machine's order.
    pub(super) fn pieces(
        self,
        path: &Path,
        mut take: impl FnMut(&[u8]) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let [start, end] = self.span;
        let size = self.sample.size();
        let mut input: Box<dyn Read> = if self.ascii {
            Box::new(TextReader::open(path, start, Some(end), self.sample)?)
        } else {
            Box::new(open_between(path, start, Some(end))?)
        };
        let mut buffer = vec![0; PIECE * size];
        let mut left = self.count;
        while left > 0 {
            let count = left.min(PIECE as u64);
            let piece = &mut buffer[..count as usize * size];
            let (filled, result) = fill(&mut input, piece);
            let decoded = (self.count - left) * size as u64 + filled as u64;
            if let Err(source) = result {
                let coding = "number of the stated type";
                return Err(ReadError::Corrupt { path: path.to_owned(), coding, decoded, source });
            }
            if filled < piece.len() {
                let (path, what, expected) = (path.to_owned(), "numbers", self.count * size as u64);
                return Err(ReadError::ShortData { path, what, expected, found: decoded, at_most: false });
            }
            if !self.ascii && Endian::NATIVE != Endian::Big {
                swap_in_place(piece, size);
            }
            take(piece)?;
            left -= count;
        }
        Ok(())
    }

    /// Hands out the numbers one by one; integers beyond 2^53 are rounded.
    pub(super) fn each(
        mut self,
        path: &Path,
        mut take: impl FnMut(f64) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        if self.ascii {
            // Whatever their type, the text says more exactly what is meant.
            self.sample = SampleType::F64;
        }
        let sample = self.sample;
        self.pieces(path, |bytes| {
            bytes.chunks_exact(sample.size()).try_for_each(|one| take(number(one, sample)))
        })
    }
}

/// The number in `bytes`, which are as many as `sample` has.
fn number(bytes: &[u8], sample: SampleType) -> f64 {
    fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
        bytes.try_into().unwrap_or([0; N])
    }
    match sample {
        SampleType::U8 => u8::from_ne_bytes(array(bytes)).into(),
        SampleType::I8 => i8::from_ne_bytes(array(bytes)).into(),
        SampleType::U16 => u16::from_ne_bytes(array(bytes)).into(),
        SampleType::I16 => i16::from_ne_bytes(array(bytes)).into(),
        SampleType::U32 => u32::from_ne_bytes(array(bytes)).into(),
        SampleType::I32 => i32::from_ne_bytes(array(bytes)).into(),
        SampleType::U64 => u64::from_ne_bytes(array(bytes)) as f64,
        SampleType::I64 => i64::from_ne_bytes(array(bytes)) as f64,
        SampleType::F32 => f32::from_ne_bytes(array(bytes)).into(),
        SampleType::F64 => f64::from_ne_bytes(array(bytes)),
    }
}
