//! The distance from a sphere.

use isoray_grid::{Dims, ScalarType, SlabSource};

use crate::layers::{LayersError, count, fill_rows};
use crate::sample::Sample;

/// The signed distance from a sphere around the centre of the domain, positive inside. Its radius is 0.8 of what has
/// room in the domain (axes of a single sample apart).
///
/// `f32` samples are the distance in voxels, and the sphere is the isosurface of 0. In `u8` and `u16` the middle of
/// the range, 127.5 or 32767.5, is the sphere, and the distance is scaled, and rounded, so that the larger of the
/// distances of the centre and of a corner is one end of the range.
#[derive(Clone, Debug)]
pub struct Sphere {
    dims: Dims,
    centre: [f64; 3],
    radius: f64,
    /// The largest distance from the sphere in the domain.
    farthest: f64,
}

impl Sphere {
    /// The sphere in a domain of size `dims`.
    pub fn new(dims: Dims) -> Self {
        let centre = dims.axes().map(|n| f64::from(n - 1) / 2.0);
        let room = centre.into_iter().filter(|&c| c > 0.0).min_by(f64::total_cmp).unwrap_or(0.0);
        let mut sphere = Self { dims, centre, radius: 0.8 * room, farthest: 0.0 };
        sphere.farthest = sphere.radius.max(-sphere.distance([0; 3]));
        sphere
    }

    /// Radius in voxels.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Signed distance of lattice point `p` in voxels, positive inside.
    pub fn distance(&self, p: [u32; 3]) -> f64 {
        let [x, y, z] = std::array::from_fn(|axis| self.square(axis, p[axis]));
        self.radius - (x + y + z).sqrt()
    }

    /// Square of the distance from the centre along one axis.
    fn square(&self, axis: usize, i: u32) -> f64 {
        let d = f64::from(i) - self.centre[axis];
        d * d
    }
}

impl<T: Sample> SlabSource<T> for Sphere {
    type Error = LayersError;

    fn dims(&self) -> Dims {
        self.dims
    }

    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), LayersError> {
        count(self.dims, first, out.len())?;
        let this = &*self;
        let (middle, divisor, scale) = match T::TYPE {
            ScalarType::F32 => (0.0, 1.0, 1.0),
            // A domain of one sample has no distances.
            _ => (f64::from(T::FULL) / 2.0, this.farthest.max(f64::MIN_POSITIVE), f64::from(T::FULL) / 2.0),
        };
        fill_rows(
            this.dims,
            first,
            out,
            || (),
            |(), [j, k], row| {
                let [y, z] = [this.square(1, j), this.square(2, k)];
                for (sample, i) in row.iter_mut().zip(0..) {
                    let distance = this.radius - (this.square(0, i) + y + z).sqrt();
                    *sample = T::nearest_f64(middle + distance / divisor * scale);
                }
            },
        );
        Ok(())
    }
}
