//! Linear fields.

use isoray_grid::{Dims, ScalarType, SlabSource};

use crate::layers::{LayersError, count, fill_rows};
use crate::sample::Sample;

/// A field that grows linearly along a direction `d` (index space), from 0 at the corner of the domain where it is
/// least: trilinear interpolation reproduces it, and its isosurfaces are planes.
///
/// | type | sample at `p` |
/// |---|---|
/// | `f32` | `d·(p − corner)`, computed in `f64` and rounded once |
/// | `u8`, `u16` | the same, exactly, if `d` is in whole numbers and the largest value has room in the type |
/// | | otherwise scaled to fill the range of the type, from 0 to 255 or 65535, and rounded to nearest |
#[derive(Clone, Debug)]
pub struct Ramp {
    dims: Dims,
    direction: [f64; 3],
    /// The value at the corner where it is largest.
    span: f64,
}

/// A direction along which nothing can grow.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "direction {0}, {1}, {2}: expected three numbers, not all zero, whose ramp does not exceed the range of f32"
)]
pub struct DirectionError(pub f64, pub f64, pub f64);

impl Ramp {
    /// The direction that is as good as any other, with a different slope along each axis.
    pub const DIRECTION: [f64; 3] = [1.0, 2.0, 3.0];

    /// A ramp of size `dims` with this growth per voxel along x, y and z.
    ///
    /// # Errors
    /// A direction that is zero or not finite, or a largest value above that of `f32`.
    pub fn new(dims: Dims, direction: [f64; 3]) -> Result<Self, DirectionError> {
        let [x, y, z] = direction;
        let mut ramp = Self { dims, direction, span: 0.0 };
        let corner = dims.axes();
        let far = std::array::from_fn(|a| if direction[a] > 0.0 { corner[a] - 1 } else { 0 });
        ramp.span = ramp.value(far);
        let is_direction = direction.iter().all(|c| c.is_finite()) && direction.iter().any(|&c| c != 0.0);
        if is_direction && ramp.span <= f64::from(f32::MAX) { Ok(ramp) } else { Err(DirectionError(x, y, z)) }
    }

    /// The value at lattice point `p`, which must be inside, before it is scaled or rounded.
    pub fn value(&self, p: [u32; 3]) -> f64 {
        let [x, y, z] = std::array::from_fn(|axis| self.along(axis, p[axis]));
        x + y + z
    }

    /// What one axis adds.
    fn along(&self, axis: usize, i: u32) -> f64 {
        let slope = self.direction[axis];
        let steps = if slope < 0.0 { self.dims.axes()[axis] - 1 - i } else { i };
        slope.abs() * f64::from(steps)
    }

    /// Whether samples of the type are the values themselves.
    fn is_unscaled<T: Sample>(&self) -> bool {
        let is_whole = self.direction.iter().all(|c| c.fract() == 0.0);
        T::TYPE == ScalarType::F32 || (is_whole && self.span <= f64::from(T::FULL))
    }
}

impl<T: Sample> SlabSource<T> for Ramp {
    type Error = LayersError;

    fn dims(&self) -> Dims {
        self.dims
    }

    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), LayersError> {
        count(self.dims, first, out.len())?;
        let this = &*self;
        // By a division, of which the largest value makes exactly 1.
        let (divisor, full) = if this.is_unscaled::<T>() {
            (1.0, 1.0)
        } else {
            (this.span.max(f64::MIN_POSITIVE), T::FULL.into())
        };
        fill_rows(
            this.dims,
            first,
            out,
            || (),
            |(), [j, k], row| {
                let [y, z] = [this.along(1, j), this.along(2, k)];
                for (sample, i) in row.iter_mut().zip(0..) {
                    *sample = T::nearest_f64((this.along(0, i) + y + z) / divisor * full);
                }
            },
        );
        Ok(())
    }
}
