//! Uniform random samples.

use isoray_grid::{Dims, SlabSource};

use crate::layers::{LayersError, count, fill_rows};
use crate::random::Row;
use crate::sample::Sample;

/// Independent samples, each value as likely as any other: nothing compresses, and every cell is crossed.
///
/// `u8` and `u16` samples take all values of their type; `f32` samples are multiples of 255/2²⁴ from 0 to below 255.
#[derive(Clone, Debug)]
pub struct Noise {
    dims: Dims,
    seed: u64,
}

impl Noise {
    /// Noise of size `dims`; another seed gives other samples.
    pub fn new(dims: Dims, seed: u64) -> Self {
        Self { dims, seed }
    }
}

impl<T: Sample> SlabSource<T> for Noise {
    type Error = LayersError;

    fn dims(&self) -> Dims {
        self.dims
    }

    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), LayersError> {
        count(self.dims, first, out.len())?;
        fill_rows(
            self.dims,
            first,
            out,
            || (),
            |(), [j, k], row| {
                let random = Row::new(self.seed, 0, j as i32, k as i32);
                row.iter_mut().zip(0..).for_each(|(sample, i)| *sample = T::from_random(random.bits(i)));
            },
        );
        Ok(())
    }
}
