//! The camera.

use glam::{DAffine3, DVec3, DVec4};
use isoray_grid::Dims;
use isoray_octree::lod::PixelWidth;
use isoray_trace::{Beam, Ray};
use wide::f64x8;

/// How the world is mapped to the image plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Pinhole; the vertical field of view in degrees.
    Perspective {
        /// Angle between the upper and the lower image border, in degrees.
        fov: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// Distance between the upper and the lower image border, in world units.
        height: f64,
    },
}

/// Where a camera stands and looks, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position of the eye.
    pub eye: DVec3,
    /// The point in the middle of the image.
    pub look_at: DVec3,
    /// The direction that is up in the image, as far as the view direction allows.
    pub up: DVec3,
    /// Perspective or orthographic.
    pub projection: Projection,
}

impl Default for View {
    /// From the origin along +y, +z up, 45 degrees high.
    fn default() -> Self {
        Self {
            eye: DVec3::ZERO,
            look_at: DVec3::Y,
            up: DVec3::Z,
            projection: Projection::Perspective { fov: 45.0 },
        }
    }
}

/// A camera that sees nothing, or an image that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// A number that is not finite.
    #[error("the camera's {0} is not finite")]
    NotFinite(&'static str),
    /// No direction.
    #[error("the camera's eye and look-at point are the same: {0}")]
    NoDirection(DVec3),
    /// No way to tell which side is up.
    #[error("the camera's up vector {up} is zero or parallel to the view direction {direction}")]
    Up {
        /// The up vector.
        up: DVec3,
        /// From the eye to the look-at point.
        direction: DVec3,
    },
    /// A field of view no lens has.
    #[error("field of view of {0} degrees: expected more than 0 and less than 180")]
    Fov(f64),
    /// An image without extent.
    #[error("orthographic height of {0}: expected more than 0")]
    Height(f64),
    /// Too many pixels, or none.
    #[error("image size {0}x{1}: expected at least 1x1 and at most {max} pixels in all", max = Camera::MAX_PIXELS)]
    Size(u32, u32),
}

/// A checked camera with its image size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    eye: DVec3,
    forward: DVec3,
    /// Half the image's width and height, on the plane at distance 1 or, orthographic, in world units.
    right: DVec3,
    up: DVec3,
    is_perspective: bool,
    size: [u32; 2],
}

impl Camera {
    /// The most pixels an image can have: a buffer of all channels then takes 8 GiB.
    pub const MAX_PIXELS: u64 = 1 << 28;

    /// A camera with `size = [width, height]` pixels; they are square.
    ///
    /// # Errors
    /// A view without direction or extent, or a size that no image has.
    pub fn new(view: &View, size: [u32; 2]) -> Result<Self, CameraError> {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        if pixels == 0 || pixels > Self::MAX_PIXELS {
            return Err(CameraError::Size(size[0], size[1]));
        }
        for (name, v) in [("eye", view.eye), ("look-at point", view.look_at), ("up vector", view.up)] {
            if !v.is_finite() {
                return Err(CameraError::NotFinite(name));
            }
        }
        let direction = view.look_at - view.eye;
        let forward = direction.try_normalize().ok_or(CameraError::NoDirection(view.eye))?;
        let up = view.up.try_normalize().unwrap_or(DVec3::ZERO);
        let right = forward.cross(up);
        // Below this sine the cross product is mostly rounding error.
        const PARALLEL: f64 = 1e-9;
        if right.length() < PARALLEL {
            return Err(CameraError::Up { up: view.up, direction });
        }
        let right = right.normalize();
        let half_height = match view.projection {
            Projection::Perspective { fov } if fov > 0.0 && fov < 180.0 => (fov.to_radians() / 2.0).tan(),
            Projection::Perspective { fov } => return Err(CameraError::Fov(fov)),
            Projection::Orthographic { height } if height > 0.0 && height.is_finite() => height / 2.0,
            Projection::Orthographic { height } => return Err(CameraError::Height(height)),
        };
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        Ok(Self {
            eye: view.eye,
            forward,
            right: right * half_height * aspect,
            up: right.cross(forward) * half_height,
            is_perspective: matches!(view.projection, Projection::Perspective { .. }),
            size,
        })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// How wide a pixel is in the middle of the image, where it is widest as seen from the eye.
    pub fn pixel_width(&self) -> PixelWidth {
        let width = self.width_of_pixel(1.0);
        match self.is_perspective {
            true => PixelWidth::PerDistance(width, self.eye),
            false => PixelWidth::Constant(width),
        }
    }

    /// The direction of view, in world space; a unit vector.
    pub fn forward(&self) -> DVec3 {
        self.forward
    }

    /// Origin and unit direction of the ray through the centre of pixel `(x, y)`, row 0 at the top, in world space.
    pub fn world_ray(&self, x: u32, y: u32) -> (DVec3, DVec3) {
        let [across, upward] = self.across_and_upward([x, y]);
        if self.is_perspective {
            (self.eye, (self.forward + across + upward).normalize())
        } else {
            (self.eye + across + upward, self.forward)
        }
    }

    /// The ray through the centre of pixel `(x, y)` in the index space of a volume, rounded to `f32`; its `t` is world distance.
    ///
    /// Rounding multiplies each component by at most `1 ± 2⁻²⁴`; see the crate's front page for what that does to the
    /// ray.
    pub fn index_ray(&self, world_to_index: &DAffine3, x: u32, y: u32) -> Ray {
        let (origin, direction) = self.world_ray(x, y);
        into_index_space(world_to_index, origin, direction)
    }

    /// Adds [`index_ray`](Self::index_ray) of each pixel to `rays`.
    pub(crate) fn add_index_rays(&self, world_to_index: &DAffine3, pixels: &[[u32; 2]], rays: &mut Vec<Ray>) {
        let (eights, rest) = pixels.as_chunks();
        rays.extend(eights.iter().flat_map(|eight| self.index_rays(world_to_index, eight)));
        rays.extend(rest.iter().map(|&[x, y]| self.index_ray(world_to_index, x, y)));
    }

    /// That of eight pixels: the same, bit for bit.
    fn index_rays(&self, world_to_index: &DAffine3, pixels: &[[u32; 2]; 8]) -> [Ray; 8] {
        if !self.is_perspective {
            return pixels.map(|[x, y]| self.index_ray(world_to_index, x, y));
        }
        let along =
            |a: usize| f64x8::new(pixels.map(|p| 2.0 * (f64::from(p[a]) + 0.5) / f64::from(self.size[a])));
        let (across, upward) = (along(0) - f64x8::splat(1.0), f64x8::splat(1.0) - along(1));
        let [forward, right, up] =
            [self.forward, self.right, self.up].map(|v| v.to_array().map(f64x8::splat));
        let [x, y, z] = [0, 1, 2].map(|a| forward[a] + right[a] * across + up[a] * upward);
        let inverse = f64x8::splat(1.0) / (x * x + y * y + z * z).sqrt();
        let [x, y, z] = [x * inverse, y * inverse, z * inverse];
        let rows = world_to_index.matrix3.transpose().to_cols_array_2d();
        let direction = rows.map(|row| {
            let [u, v, w] = row.map(f64x8::splat);
            (u * x + v * y + w * z).to_array()
        });
        let origin = world_to_index.transform_point3(self.eye).to_array().map(|c| c as f32);
        std::array::from_fn(|n| Ray {
            origin,
            direction: [0, 1, 2].map(|a| direction[a][n] as f32),
            t_min: 0.0,
            t_max: f32::INFINITY,
        })
    }
}

impl Camera {
    /// The hull of the rays through all pixels from `low` to before `high` in the index space of a volume, `None` unless they run to the same side along every axis. Before
    /// they are made to unit length, which does not change what they meet, origins and directions are linear in the pixel, so that those at the corners are
    /// the outermost; the bounds are wide enough for all roundings of the rays.
    pub(crate) fn hull(&self, world_to_index: &DAffine3, [low, high]: [[u32; 2]; 2]) -> Option<Beam> {
        let mut bounds = [[[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]; 2];
        for corner in 0..4 {
            let pixel: [u32; 2] = std::array::from_fn(|a| [low[a], high[a] - 1][corner >> a & 1]);
            let [across, upward] = self.across_and_upward(pixel);
            let (origin, direction) = match self.is_perspective {
                true => (self.eye, self.forward + across + upward),
                false => (self.eye + across + upward, self.forward),
            };
            let origin = world_to_index.transform_point3(origin);
            let direction = world_to_index.transform_vector3(direction);
            for (bounds, of) in bounds.iter_mut().zip([origin, direction]) {
                for a in 0..3 {
                    bounds[0][a] = bounds[0][a].min(of[a]);
                    bounds[1][a] = bounds[1][a].max(of[a]);
                }
            }
        }
        // Rounding to single precision takes 2⁻²⁴ of a component. What came before, in double precision, takes less of the largest one.
        let [origins, directions] = bounds.map(|bounds| {
            let largest = bounds.iter().flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
            let slack = |c: f64| c.abs() / (1u32 << 22) as f64 + largest / (1u64 << 40) as f64;
            [bounds[0].map(|c| c - slack(c)), bounds[1].map(|c| c + slack(c))]
        });
        Beam::between(origins, directions, [0.0, f64::INFINITY])
    }

    /// Where a point of the world is: to the right and upward, in halves of the image, both times the weight that comes third, and how far ahead of the eye. All are
    /// linear in the point.
    pub(crate) fn projected(&self, point: DVec3) -> DVec4 {
        let from_eye = point - self.eye;
        let along = |axis: DVec3| from_eye.dot(axis) / axis.length_squared();
        let ahead = from_eye.dot(self.forward);
        DVec4::new(along(self.right), along(self.up), if self.is_perspective { ahead } else { 1.0 }, ahead)
    }

    /// World distance along the ray of a pixel to where it is this far ahead of the eye.
    pub(crate) fn distance(&self, pixel: [u32; 2], ahead: f64) -> f64 {
        if !self.is_perspective {
            return ahead;
        }
        let [across, upward] = self.across_and_upward(pixel);
        (self.forward + across + upward).length() * ahead
    }

    /// How wide a pixel is this far ahead of the eye, in world units.
    pub(crate) fn width_of_pixel(&self, ahead: f64) -> f64 {
        let width = 2.0 * self.up.length() / f64::from(self.size[1]);
        if self.is_perspective { width * ahead } else { width }
    }

    /// From the middle of the image to the centre of a pixel.
    fn across_and_upward(&self, [x, y]: [u32; 2]) -> [DVec3; 2] {
        let across = self.right * (2.0 * (f64::from(x) + 0.5) / f64::from(self.size[0]) - 1.0);
        let upward = self.up * (1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(self.size[1]));
        [across, upward]
    }
}

/// A ray of the world in the index space of a volume, rounded to `f32`.
pub(crate) fn into_index_space(world_to_index: &DAffine3, origin: DVec3, direction: DVec3) -> Ray {
    Ray {
        origin: world_to_index.transform_point3(origin).to_array().map(|c| c as f32),
        direction: world_to_index.transform_vector3(direction).to_array().map(|c| c as f32),
        t_min: 0.0,
        t_max: f32::INFINITY,
    }
}

/// The eight corners of the domain, in world space.
fn domain_corners(dims: Dims, index_to_world: &DAffine3) -> [DVec3; 8] {
    let last = dims.axes().map(|n| f64::from(n - 1));
    std::array::from_fn(|n| {
        let pick = |a: usize| if n >> a & 1 == 1 { last[a] } else { 0.0 };
        index_to_world.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
    })
}

/// Extents below this share of a voxel's edge are rounding errors of a domain that has none.
const NO_EXTENT: f64 = 1e-9;

/// The point at which `view` looks and the distance from which it looks, chosen so that the whole domain just fits an image of
/// `size`; the direction from eye to look-at point, the up vector and the field of view are kept. An orthographic height is replaced.
///
/// The eye is never the point that it looks at: where the domain has no extent to be framed, as that of a single
/// sample, the longest edge of a voxel takes its place.
pub fn frame_all(view: &View, size: [u32; 2], dims: Dims, index_to_world: &DAffine3) -> View {
    /// Empty border, as a share of the distance.
    const MARGIN: f64 = 1.03;
    let corners = domain_corners(dims, index_to_world);
    let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let forward = (view.look_at - view.eye).try_normalize().unwrap_or(DVec3::Y);
    let right = forward.cross(view.up).try_normalize().unwrap_or(DVec3::X);
    let up = right.cross(forward);
    let aspect = f64::from(size[0].max(1)) / f64::from(size[1].max(1));
    let axes = index_to_world.matrix3;
    let voxel = axes.x_axis.length().max(axes.y_axis.length()).max(axes.z_axis.length());
    let largest = |f: &dyn Fn(DVec3) -> f64| {
        let extent = corners.iter().map(|&c| f(c - centre)).fold(0.0, f64::max);
        if extent > NO_EXTENT * voxel { extent } else { voxel }
    };
    let lateral = |c: DVec3| (c.dot(right).abs() / aspect).max(c.dot(up).abs());
    let (distance, projection) = match view.projection {
        Projection::Perspective { fov } => {
            let slope = (fov.to_radians() / 2.0).tan();
            // Each corner must lie inside the cone of the image borders.
            (largest(&|c| lateral(c) / slope - c.dot(forward)) * MARGIN, view.projection)
        }
        Projection::Orthographic { .. } => {
            let height = 2.0 * MARGIN * largest(&lateral);
            (2.0 * largest(&|c| c.length()), Projection::Orthographic { height })
        }
    };
    // Far from the world's origin a short distance would be lost in the rounding of the eye's position.
    let distance = distance.max(4.0 * f64::EPSILON * centre.abs().max_element());
    View { eye: centre - forward * distance, look_at: centre, up: view.up, projection }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_rays_of_a_rectangle_lie_in_its_hull() {
        let axes = glam::DMat3::from_cols_array(&[0.7, 0.1, 0.0, -0.2, 1.3, 0.4, 0.05, -0.3, 2.0]);
        let world_to_index = DAffine3 { matrix3: axes, translation: DVec3::new(3.0, -70.0, 11.0) };
        let mut hulls = 0;
        for n in 0..200u32 {
            let eye = DVec3::new(100.3 - f64::from(n), 20.1 + f64::from(n * n % 50), f64::from(n % 7) - 7.7);
            let projection = match n % 2 {
                0 => Projection::Perspective { fov: 10.0 + f64::from(n) / 2.0 },
                _ => Projection::Orthographic { height: 50.0 },
            };
            let view = View { eye, look_at: DVec3::new(1.0, 2.0, 3.0), up: DVec3::Z, projection };
            let camera = Camera::new(&view, [123, 77]).unwrap();
            let low = [n * 31 % 120, n * 17 % 75];
            let high = [(low[0] + 1 + n % 16).min(123), (low[1] + 1 + n % 13).min(77)];
            let Some(hull) = camera.hull(&world_to_index, [low, high]) else { continue };
            hulls += 1;
            for (x, y) in (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| (x, y))) {
                let ray = camera.index_ray(&world_to_index, x, y);
                let direction = ray.direction.map(f64::from);
                // Some length of the direction lies between the bounds along all axes.
                let (mut least, mut most) = (0.0f64, f64::INFINITY);
                for a in 0..3 {
                    let origin = f64::from(ray.origin[a]);
                    assert!(hull.origins[0][a] <= origin && origin <= hull.origins[1][a]);
                    assert_eq!(direction[a] < 0.0, hull.backward >> a & 1 == 1);
                    least = least.max(hull.speeds[0][a] / direction[a].abs());
                    most = most.min(hull.speeds[1][a] / direction[a].abs());
                }
                assert!(least <= most, "{ray:?} of pixel {x}, {y}: {hull:?}");
            }
        }
        assert!(hulls > 100, "only {hulls}");
    }

    #[test]
    fn eight_rays_are_those_of_their_pixels() {
        let axes = glam::DMat3::from_cols_array(&[0.7, 0.1, 0.0, -0.2, 1.3, 0.4, 0.05, -0.3, 2.0]);
        let world_to_index = DAffine3 { matrix3: axes, translation: DVec3::new(3.0, -70.0, 11.0) };
        let (eye, look_at) = (DVec3::new(100.3, 20.1, -7.7), DVec3::new(1.0, 2.0, 3.0));
        for projection in [Projection::Perspective { fov: 40.0 }, Projection::Orthographic { height: 50.0 }] {
            let view = View { eye, look_at, up: DVec3::Z, projection };
            let camera = Camera::new(&view, [123, 77]).unwrap();
            for first in 0..100u32 {
                let pixels = std::array::from_fn(|n| [(first + n as u32) % 123, first * 7 % 77]);
                let alone = pixels.map(|[x, y]| camera.index_ray(&world_to_index, x, y));
                assert_eq!(camera.index_rays(&world_to_index, &pixels), alone);
            }
        }
    }
}
