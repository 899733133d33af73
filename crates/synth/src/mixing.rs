//! A turbulent mixing layer between two fluids.

mod cascade;
mod spectrum;
#[cfg(test)]
mod tests;

use isoray_grid::{Dims, SlabSource};

use crate::layers::{LayersError, count, fill_rows};
use crate::sample::Sample;
use cascade::{Cascade, Scratch};
use spectrum::Spectrum;

/// Grey values of the light fluid, below, and of the heavy one.
const FLUIDS: [f32; 2] = [10.0, 240.0];

/// What a [`Mixing`] depends on beside its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixingParams {
    /// Another seed, other turbulence.
    pub seed: u64,
    /// How far the mixing has come, from 0, a gently waving interface, to 1, full turbulence.
    pub time: f64,
}

impl Default for MixingParams {
    /// Seed 0, time 1.
    fn default() -> Self {
        Self { seed: 0, time: 1.0 }
    }
}

/// A time outside the mixing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("time {0}: expected a number from 0 to 1")]
pub struct TimeError(pub f64);

/// A light fluid (grey value 10) below a heavy one (240), and between them a layer in which they mix: plumes on large
/// scales, interfaces that fold over, and detail down to two voxels.
///
/// The interface lies at half height, in expectation, and everything scales with the number of layers `nz`, so that
/// volumes of different size look alike; what a larger one has more is detail. Let `ζ` be the height over the middle in
/// units of `nz`. The grey value is
///
/// ```text
/// 10 + 230 · clamp(½ + (ζ + D(x, y, z)) / δ, 0, 1)
/// ```
///
/// where `δ` is the thickness of the interface and `D` its displacement: noise with octaves of every spacing from two
/// voxels to some `nz/8`. An octave is a quadratic B-spline with random coefficients on a lattice of that spacing. Some
/// have the same coefficients at every height: they make waves. The others fade towards the faces of the layer, and
/// they fold: where `∂D/∂ζ < −1`, heavy fluid lies under light. Outside the layer every sample is exactly that of the
/// fluid.
///
/// With time the layer grows, and octaves set in, the largest first. At time 0 there are only waves.
///
/// Other types: see [`Sample`]; `f32` samples are not rounded.
#[derive(Clone, Debug)]
pub struct Mixing {
    dims: Dims,
    spectrum: Spectrum,
    cascade: Cascade,
}

impl Mixing {
    /// A mixing layer of size `dims`.
    ///
    /// # Errors
    /// A time outside `0..=1`.
    pub fn new(dims: Dims, params: MixingParams) -> Result<Self, TimeError> {
        if !(0.0..=1.0).contains(&params.time) {
            return Err(TimeError(params.time));
        }
        let spectrum = Spectrum::new(dims.axes()[2], params.time);
        let cascade = Cascade::new(dims, params.seed, spectrum.octaves.len());
        Ok(Self { dims, spectrum, cascade })
    }

    /// The height of layer `k` over the middle, in units of the volume's height.
    fn height(&self, k: u32) -> f64 {
        let layers = f64::from(self.dims.axes()[2]);
        (f64::from(k) - (layers - 1.0) / 2.0) / layers
    }
}

impl<T: Sample> SlabSource<T> for Mixing {
    type Error = LayersError;

    fn dims(&self) -> Dims {
        self.dims
    }

    /// Takes about as long a layer whichever are asked for, in any order, but a single layer some two or three times
    /// as long as one of eight.
    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), LayersError> {
        let layers = count(self.dims, first, out.len())?;
        let grey = T::FULL / 255.0;
        let [low, high] = FLUIDS.map(|fluid| fluid * grey);
        // The first layers in which there may be something else than the light fluid, and nothing but the heavy one.
        let reach = self.spectrum.reach();
        let first_above = |h| (first..first + layers).find(|&k| self.height(k) > h).unwrap_or(first + layers);
        let [start, end] = [-reach, reach].map(first_above);
        let (below, rest) = out.split_at_mut((start - first) as usize * self.dims.layer());
        let (between, above) = rest.split_at_mut((end - start) as usize * self.dims.layer());
        below.fill(T::nearest(low));
        above.fill(T::nearest(high));
        if between.is_empty() {
            return Ok(());
        }

        self.cascade.prepare(start, end, &self.spectrum);
        let this = &*self;
        let scale = (1.0 / this.spectrum.thickness) as f32;
        fill_rows(this.dims, start, between, Scratch::default, |scratch, [j, k], row| {
            let height = this.height(k) as f32;
            for (sample, displacement) in row.iter_mut().zip(this.cascade.row(j, k, scratch)) {
                let mixed = ((height + displacement) * scale + 0.5).clamp(0.0, 1.0);
                *sample = T::nearest(low + (high - low) * mixed);
            }
        });
        Ok(())
    }
}
