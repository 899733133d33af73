//! A camera, and the rays that it ought to send, computed again from the view alone.

use anyhow::Result;
use glam::{DAffine3, DVec3};
use isoray_render::{Camera, Projection, View};

/// A camera with its view.
pub(crate) struct Eye {
    pub(crate) camera: Camera,
    view: View,
}

/// Roundings of double precision in a ray of the world, relative to the largest coordinate: some twenty of 1.1·10⁻¹⁶ each.
const DOUBLE: f64 = 1e-14;
/// Rounding to single precision, and that of double precision before it.
const SINGLE: f64 = 1.0 / (1u32 << 24) as f64;

impl Eye {
    pub(crate) fn new(view: View, size: u32) -> Result<Self> {
        Ok(Self { camera: Camera::new(&view, [size; 2])?, view })
    }

    /// Origin and unit direction, in the world, of the ray through a pixel's centre.
    pub(crate) fn ray(&self, pixel: [u32; 2]) -> (DVec3, DVec3) {
        let View { eye, look_at, up, projection } = self.view;
        let size = self.camera.size().map(f64::from);
        let forward = (look_at - eye).normalize();
        let right = forward.cross(up).normalize();
        let up = right.cross(forward);
        // Halves of the picture's height, from its middle: y grows downwards.
        let [x, y] = [0, 1].map(|a| (2.0 * f64::from(pixel[a]) + 1.0 - size[a]) / size[1]);
        match projection {
            Projection::Perspective { fov } => {
                let half = (fov.to_radians() / 2.0).tan();
                (eye, (forward + (right * x - up * y) * half).normalize())
            }
            Projection::Orthographic { height } => (eye + (right * x - up * y) * (height / 2.0), forward),
        }
    }

    /// The direction of view; of length 1.
    pub(crate) fn forward(&self) -> DVec3 {
        (self.view.look_at - self.view.eye).normalize()
    }

    /// How wide a pixel is at a distance of one; or at any distance, if rays are parallel.
    pub(crate) fn pixel_width(&self) -> (f64, bool) {
        let height = f64::from(self.camera.size()[1]);
        match self.view.projection {
            Projection::Perspective { fov } => (2.0 * (fov.to_radians() / 2.0).tan() / height, false),
            Projection::Orthographic { height: of_all } => (of_all / height, true),
        }
    }

    /// The same, from so far to the right.
    pub(crate) fn moved(&self, by: f64) -> Result<Self> {
        let right = self.forward().cross(self.view.up).normalize() * by;
        let View { eye, look_at, .. } = self.view;
        Self::new(View { eye: eye + right, look_at: look_at + right, ..self.view }, self.camera.size()[0])
    }

    /// What is wrong with the camera's rays: more than rounding.
    pub(crate) fn failures(&self, index_to_world: &DAffine3) -> Option<String> {
        let [width, height] = self.camera.size();
        let to_index = index_to_world.inverse();
        let is_off = |&[x, y]: &[u32; 2]| {
            let (origin, direction) = self.ray([x, y]);
            let (found, toward) = self.camera.world_ray(x, y);
            let largest = origin.abs().max_element().max(1.0);
            let ray = self.camera.index_ray(&to_index, x, y);
            let is_rounded = |found: [f32; 3], exact: DVec3, largest: f64| {
                (0..3).all(|a| (f64::from(found[a]) - exact[a]).abs() <= SINGLE * exact[a].abs() + largest)
            };
            // What index space adds to the rounding of double precision is in proportion to the placement.
            let stretch = to_index.matrix3.to_cols_array().into_iter().fold(1.0, |m: f64, c| m.max(c.abs()));
            let far = largest * stretch + to_index.translation.abs().max_element();
            let is_right = (found - origin).abs().max_element() <= DOUBLE * largest
                && (toward - direction).abs().max_element() <= DOUBLE
                && is_rounded(ray.origin, to_index.transform_point3(origin), DOUBLE * far)
                && is_rounded(ray.direction, to_index.transform_vector3(direction), DOUBLE * stretch)
                && ray.t_min == 0.0
                && ray.t_max == f32::INFINITY;
            !is_right
        };
        let mut pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        let first = pixels.find(is_off)?;
        Some(format!("the ray of pixel {first:?} is not that of the view"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_that_stands_elsewhere_is_found_out() {
        let placement = DAffine3::from_scale(DVec3::new(1.3, 0.9, 0.7));
        for projection in [Projection::Perspective { fov: 40.0 }, Projection::Orthographic { height: 50.0 }] {
            let view = View {
                eye: DVec3::new(40.0, -20.0, 7.0),
                look_at: DVec3::ONE,
                projection,
                ..View::default()
            };
            let mut eye = Eye::new(view, 9).unwrap();
            assert_eq!(eye.failures(&placement), None);
            eye.view.eye.x += 1e-9;
            assert!(eye.failures(&placement).is_some());
        }
    }
}
