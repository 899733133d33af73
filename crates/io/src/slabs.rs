//! Streaming samples layer by layer.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::marker::PhantomData;
use std::path::PathBuf;

use isoray_grid::{Dims, RowSource, Scalar, SlabSource};
use zerocopy::{FromBytes, IntoBytes};

use crate::coding::{Coding, open_stream};
use crate::decode::{fill, open_at};
use crate::error::{ReadError, Warning};
use crate::layout::{Layout, Order};
use crate::rows::Rows;
use crate::sample::{Endian, Losses, pick, swap_in_place, to_f32};

/// Bytes converted at once: small enough for a second-level cache, large enough for the system call.
const PIECE: usize = 128 << 10;

/// The samples of a [`Dataset`](crate::Dataset), read some layers of constant `k` at a time.
///
/// Layers may be asked for in any order; a compressed or text file is decoded again from its start for each
/// step back. Besides the caller's slab less than a megabyte is held; of a VTK file with LZ4 blocks also a
/// block, of a TIFF stack also a page.
pub struct Slabs<T> {
    path: PathBuf,
    layout: Layout,
    /// Byte of the data file at which samples or their stream begin.
    offset: u64,
    input: Input,
    scratch: Vec<u8>,
    losses: Losses,
    goes_on: bool,
    rows: Option<Rows>,
    sample: PhantomData<T>,
}

/// An open data file.
enum Input {
    /// None yet, or none usable after an error.
    Closed,
    /// Uncoded samples.
    File(File),
    /// A decoder and the number of stored bytes that it has handed out.
    Stream(Box<dyn Read + Send>, u64),
}

impl<T> std::fmt::Debug for Slabs<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Slabs")
            .field("path", &self.path)
            .field("layout", &self.layout)
            .finish_non_exhaustive()
    }
}

impl<T: Scalar> Slabs<T> {
    /// `layout` has been checked; `offset` is its resolved start.
    pub(crate) fn new(path: PathBuf, layout: Layout, offset: u64) -> Self {
        let (input, scratch, losses) = (Input::Closed, Vec::new(), Losses::default());
        let mut slabs = Self {
            path,
            layout,
            offset,
            input,
            scratch,
            losses,
            goes_on: false,
            rows: None,
            sample: PhantomData,
        };
        slabs.rows = Rows::open(&slabs.layout, offset + slabs.component_start());
        slabs
    }

    /// What has been noticed since the last read that began with layer 0.
    pub fn warnings(&self) -> Vec<Warning> {
        let path = &self.layout.data;
        let mut warnings = self.losses.warnings(path);
        if self.goes_on {
            warnings.push(Warning::ExtraStream { path: path.clone() });
        }
        warnings
    }

    /// Reads consecutive samples of a file that stores them as they are handed out.
    fn read_plain(&mut self, first: u64, out: &mut [T]) -> Result<(), ReadError> {
        let size = self.layout.sample.size();
        let begin = self.component_start() + first * size as u64;
        let bytes = out.as_mut_bytes();
        self.read_stored(begin, bytes)?;
        if self.layout.endian != Endian::NATIVE {
            swap_in_place(bytes, size);
        }
        Ok(())
    }

    /// Reads consecutive samples through a buffer, in pieces: component, byte order, type.
    fn read_pieces(&mut self, first: u64, out: &mut [T]) -> Result<(), ReadError> {
        let size = self.layout.sample.size();
        // Samples in the file from one of the component to the next; `choose` has bounded it.
        let stride = if self.layout.is_contiguous() { 1 } else { self.layout.components as usize };
        let chosen = if stride > 1 { self.layout.component as usize } else { 0 };
        let tuple = size * stride;
        let piece = (PIECE / tuple).max(1);
        let mut scratch = std::mem::take(&mut self.scratch);
        scratch.resize(piece.min(out.len()) * (tuple + size), 0);
        let mut begin = self.component_start() + first * tuple as u64;
        for part in out.chunks_mut(piece) {
            let (tuples, picked) = scratch.split_at_mut(part.len() * tuple);
            self.read_stored(begin, tuples)?;
            begin += tuples.len() as u64;
            let samples = if stride > 1 {
                let picked = &mut picked[..part.len() * size];
                pick(tuples, size, stride, chosen, picked);
                picked
            } else {
                tuples
            };
            if self.layout.endian != Endian::NATIVE {
                swap_in_place(samples, size);
            }
            if self.layout.is_unconverted() {
                part.as_mut_bytes().copy_from_slice(samples);
            } else if let Ok(floats) = <[f32]>::mut_from_bytes(part.as_mut_bytes()) {
                // Conversions hand out `f32` only: `T` is that type, or the constructor had refused it.
                self.losses += to_f32(samples, self.layout.sample, self.layout.scale, floats);
            }
        }
        self.scratch = scratch;
        Ok(())
    }

    /// Stored bytes before the first one of the chosen component, if components are whole volumes.
    fn component_start(&self) -> u64 {
        match self.layout.order {
            Order::Interleaved => 0,
            Order::Planar => self.layout.stored_bytes() / self.layout.components * self.layout.component,
        }
    }

    /// Fills `buffer` with stored bytes from number `begin` on.
    fn read_stored(&mut self, begin: u64, buffer: &mut [u8]) -> Result<(), ReadError> {
        // An input that fails is dropped, so that the next read starts over.
        let (mut input, position) = match std::mem::replace(&mut self.input, Input::Closed) {
            Input::Stream(stream, position) if position <= begin => {
                (Input::Stream(stream, position), position)
            }
            Input::File(file) => (Input::File(file), 0),
            _ => (open_input(&self.layout, self.offset)?, 0),
        };
        let end = begin + buffer.len() as u64;
        match &mut input {
            Input::Closed => {}
            Input::File(file) => {
                let seek = file.seek(SeekFrom::Start(self.offset + begin));
                seek.map_err(|e| ReadError::io(&self.layout.data, "seek", e))?;
                let (filled, result) = fill(file, buffer);
                self.check(begin, filled, buffer.len(), result)?;
            }
            Input::Stream(stream, at) => {
                let (skipped, result) = skip(stream, begin - position);
                self.check(position, skipped as usize, (begin - position) as usize, result)?;
                let (filled, result) = fill(stream, buffer);
                self.check(begin, filled, buffer.len(), result)?;
                *at = end;
                if end == self.layout.stored_bytes() {
                    // One byte more makes the decoder verify the stream's checksum, or shows that it goes on.
                    let (more, result) = fill(stream, &mut [0]);
                    self.check(end, more, more, result)?;
                    self.goes_on = more > 0;
                    *at += more as u64;
                }
            }
        }
        self.input = input;
        Ok(())
    }

    /// Turns a read of `filled` of `wanted` bytes from stored byte `begin` on into an error, if it is one.
    fn check(
        &self,
        begin: u64,
        filled: usize,
        wanted: usize,
        result: io::Result<()>,
    ) -> Result<(), ReadError> {
        let path = self.layout.data.clone();
        let found = begin + filled as u64;
        let (coding, what) = self.layout.coding.names();
        let expected = self.layout.stored_bytes();
        let short = ReadError::ShortData { path: path.clone(), what, expected, found, at_most: false };
        match result {
            Ok(()) if filled == wanted => Ok(()),
            Ok(()) => Err(short),
            Err(e) if e.kind() == io::ErrorKind::UnexpectedEof && filled < wanted => Err(short),
            Err(source) if self.layout.coding == Coding::Raw => Err(ReadError::io(&path, "read", source)),
            Err(source) => Err(ReadError::Corrupt { path, coding, decoded: found, source }),
        }
    }
}

/// Opens the data file and, for a stream, passes over the bytes before the first sample.
fn open_input(layout: &Layout, offset: u64) -> Result<Input, ReadError> {
    if layout.coding == Coding::Raw {
        return Ok(Input::File(open_at(&layout.data, offset)?));
    }
    let mut stream = open_stream(layout, offset)?;
    let (skipped, result) = skip(&mut stream, layout.stream_skip);
    match result {
        Ok(()) if skipped == layout.stream_skip => Ok(Input::Stream(stream, 0)),
        Err(source) if source.kind() != io::ErrorKind::UnexpectedEof => Err(ReadError::Corrupt {
            path: layout.data.clone(),
            coding: layout.coding.names().0,
            decoded: skipped,
            source,
        }),
        _ => Err(ReadError::ShortData {
            path: layout.data.clone(),
            what: "decoded bytes before the samples",
            expected: layout.stream_skip,
            found: skipped,
            at_most: false,
        }),
    }
}

/// Checks that the data file of a coded layout can be opened and begins like one.
pub(crate) fn probe(layout: &Layout, offset: u64) -> Result<(), ReadError> {
    open_input(layout, offset).map(drop)
}

/// Decodes and drops `count` bytes; the number there were, and the error that stopped it.
fn skip(stream: &mut (impl Read + ?Sized), count: u64) -> (u64, io::Result<()>) {
    let mut buffer = vec![0; PIECE.min(usize::try_from(count).unwrap_or(PIECE))];
    let mut done = 0;
    while done < count {
        let n = usize::try_from(count - done).map_or(buffer.len(), |left| left.min(buffer.len()));
        let (filled, result) = fill(stream, &mut buffer[..n]);
        done += filled as u64;
        if result.is_err() || filled < n {
            return (done, result);
        }
    }
    (done, Ok(()))
}

impl<T: Scalar> SlabSource<T> for Slabs<T> {
    type Error = ReadError;

    fn dims(&self) -> Dims {
        self.layout.dims
    }

    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), ReadError> {
        let (layer, layers) = (self.layout.dims.layer(), self.layout.dims.axes()[2]);
        let whole = out.len().is_multiple_of(layer);
        if !whole || u64::from(first) + (out.len() / layer) as u64 > u64::from(layers) {
            let (path, samples) = (self.path.clone(), out.len());
            return Err(ReadError::Layers { path, layer, layers, first, samples });
        }
        if first == 0 {
            self.losses = Losses::default();
            self.goes_on = false;
        }
        let sample = u64::from(first) * layer as u64;
        if out.is_empty() {
            Ok(())
        } else if self.layout.is_unconverted() && self.layout.is_contiguous() {
            self.read_plain(sample, out)
        } else {
            self.read_pieces(sample, out)
        }
    }

    fn rows(&self) -> Option<&dyn RowSource<T, Error = ReadError>> {
        self.rows.as_ref().map(|rows| rows as _)
    }
}
