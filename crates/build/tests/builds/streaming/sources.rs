//! Volumes and ways to read them.

use isoray_grid::{Dims, RowSource, Scalar, SlabSource};

/// A failed read.
#[derive(Debug, thiserror::Error)]
#[error("the source fails at layer {layer}")]
pub(crate) struct Fails {
    pub(crate) layer: u32,
}

/// A sample type that can be made of any number.
pub(crate) trait Sample: Scalar {
    /// Number `n`; some of the floating-point type's are special values.
    fn of(n: u32) -> Self;
}

macro_rules! integers {
    ($($t:ty)*) => { $(
        impl Sample for $t {
            fn of(n: u32) -> Self {
                n as $t
            }
        }
    )* };
}
integers!(u8 i8 u16 i16);

impl Sample for f32 {
    fn of(n: u32) -> Self {
        match n % 1000 {
            0 => f32::NAN,
            1 => f32::NEG_INFINITY,
            2 => -0.0,
            _ => n as f32 * 0.37,
        }
    }
}

/// Noise here, gentle slopes there and one value in between, as in real volumes.
pub(crate) fn samples<T: Sample>(dims: Dims) -> Vec<T> {
    let [nx, ny, nz] = dims.axes();
    let mut state = 0x9e37_79b9_u32;
    let mut volume = Vec::with_capacity(dims.samples());
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let n = match (i / 11 + j / 19 + k / 13) % 3 {
                    0 => state >> 8,
                    1 => 7,
                    _ => 100 + (i + j + k) / 3,
                };
                volume.push(T::of(n));
            }
        }
    }
    volume
}

/// How samples are handed out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    /// In any order, to several threads.
    Rows,
    /// Layer after layer, never back.
    Stream,
}

/// An array as a source, which fails when a layer is asked for that it does not have.
pub(crate) struct Source<'a, T> {
    pub(crate) dims: Dims,
    pub(crate) samples: &'a [T],
    pub(crate) way: Way,
    /// The first layer that there is not.
    pub(crate) end: u32,
    /// The next layer of a stream.
    pub(crate) next: u32,
}

impl<'a, T: Scalar> Source<'a, T> {
    pub(crate) fn new(dims: Dims, samples: &'a [T], way: Way) -> Self {
        Self { dims, samples, way, end: dims.axes()[2], next: 0 }
    }
}

impl<T: Scalar> SlabSource<T> for Source<'_, T> {
    type Error = Fails;

    fn dims(&self) -> Dims {
        self.dims
    }

    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), Fails> {
        assert_eq!(self.way, Way::Stream, "a source with rows is read by rows");
        assert_eq!(first, self.next, "a stream goes forward only");
        let layers = out.len() / self.dims.layer();
        assert_eq!(layers * self.dims.layer(), out.len());
        self.next = first + layers as u32;
        if self.next > self.end {
            return Err(Fails { layer: self.end });
        }
        let begin = first as usize * self.dims.layer();
        out.copy_from_slice(&self.samples[begin..][..out.len()]);
        Ok(())
    }

    fn rows(&self) -> Option<&dyn RowSource<T, Error = Fails>> {
        (self.way == Way::Rows).then_some(self as _)
    }
}

impl<T: Scalar> RowSource<T> for Source<'_, T> {
    type Error = Fails;

    fn read_rows(&self, layer: u32, first: u32, out: &mut [T]) -> Result<(), Fails> {
        if layer >= self.end {
            return Err(Fails { layer });
        }
        let begin = self.dims.linear([0, first, layer]);
        out.copy_from_slice(&self.samples[begin..][..out.len()]);
        Ok(())
    }
}

/// Names of all files in a folder.
pub(crate) fn names(folder: &std::path::Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

/// Runs `f` with so many threads.
pub(crate) fn with_threads<R: Send>(threads: usize, f: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(f)
}
