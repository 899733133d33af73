//! The test signal of Marschner and Lobb.

use isoray_grid::{Dims, SlabSource};
use rayon::prelude::*;

use crate::cosine::{cos_turns, sin_turns};
use crate::layers::{LayersError, count};
use crate::sample::Sample;

const FREQUENCY: f64 = 6.0;
const AMPLITUDE: f64 = 0.25;

/// The signal of Marschner and Lobb ("An evaluation of reconstruction filters for volume rendering", 1994), rings of
/// frequency 6 and amplitude ¼ on a slope, over `[−1, 1]³`: hard to sample, and hardly anything in it is constant.
///
/// ```text
/// ρ(x, y, z) = (1 − sin(πz/2) + ¼ (1 + cos(12π cos(π√(x² + y²)/2)))) / 2.5
/// ```
///
/// The samples are `ρ` times 255, or 65535 in `u16`; the customary isovalue is the middle, 127.5. Integers are rounded
/// to nearest.
#[derive(Clone, Debug)]
pub struct MarschnerLobb {
    dims: Dims,
}

impl MarschnerLobb {
    /// The signal at `dims` samples, the first and last of each axis at −1 and 1; the only one of an axis is at 0.
    pub fn new(dims: Dims) -> Self {
        Self { dims }
    }

    /// The signal at lattice point `p`, from 0 to 1.
    pub fn value(&self, p: [u32; 3]) -> f64 {
        scaled(self.slope(p[2]), self.ring(p[0], p[1]))
    }

    fn position(&self, axis: usize, i: u32) -> f64 {
        let last = self.dims.axes()[axis] - 1;
        if last == 0 { 0.0 } else { 2.0 * f64::from(i) / f64::from(last) - 1.0 }
    }

    fn slope(&self, k: u32) -> f64 {
        1.0 - sin_turns(self.position(2, k) / 4.0)
    }

    fn ring(&self, i: u32, j: u32) -> f64 {
        let [x, y] = [self.position(0, i), self.position(1, j)];
        AMPLITUDE * (1.0 + cos_turns(FREQUENCY * cos_turns((x * x + y * y).sqrt() / 4.0)))
    }
}

/// Neither part is negative; rounding errors may carry the largest sum beyond 1.
fn scaled(slope: f64, ring: f64) -> f64 {
    ((slope + ring) / (2.0 * (1.0 + AMPLITUDE))).clamp(0.0, 1.0)
}

impl<T: Sample> SlabSource<T> for MarschnerLobb {
    type Error = LayersError;

    fn dims(&self) -> Dims {
        self.dims
    }

    /// Most of the time is taken by the rings, which are computed once for all layers of a call.
    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), LayersError> {
        let layers = count(self.dims, first, out.len())?;
        let this = &*self;
        let width = this.dims.axes()[0] as usize;
        let slopes: Vec<f64> = (first..first + layers).map(|k| this.slope(k)).collect();
        // The rows at each j, one from every layer.
        let mut rows: Vec<Vec<&mut [T]>> = (0..this.dims.axes()[1]).map(|_| Vec::new()).collect();
        for layer in out.chunks_mut(this.dims.layer()) {
            layer.chunks_mut(width).zip(&mut rows).for_each(|(row, rows)| rows.push(row));
        }
        rows.into_par_iter().zip(0..this.dims.axes()[1]).for_each_init(Vec::new, |rings, (rows, j)| {
            rings.clear();
            rings.extend((0..this.dims.axes()[0]).map(|i| this.ring(i, j)));
            for (row, &slope) in rows.into_iter().zip(&slopes) {
                for (sample, &ring) in row.iter_mut().zip(rings.iter()) {
                    *sample = T::nearest_f64(scaled(slope, ring) * f64::from(T::FULL));
                }
            }
        });
        Ok(())
    }
}
