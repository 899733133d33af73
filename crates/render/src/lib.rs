//! Pictures of isosurfaces: camera, tiles and threads, shading.
//!
//! A [`Camera`] lives in world space; [`render`] maps its rays into index space, where the octree volume is
//! traced, distributes tiles of pixels dynamically over the threads of the current rayon pool, shades the hits
//! and returns an [`Image`] with colour, depth and normal of every pixel.
//!
//! ```
//! use glam::{DAffine3, DVec3};
//! use isoray_build::build;
//! use isoray_grid::{DenseVolume, Dims};
//! use isoray_render::{Camera, Scene, View, render};
//!
//! // A ball of radius 10 in a volume of 32³ samples, seen from the front.
//! let dims = Dims::new([32; 3])?;
//! let distance = |n: i32| f64::from(n) - 15.5;
//! let samples: Vec<f32> = (0..32 * 32 * 32)
//!     .map(|n| -(distance(n % 32).powi(2) + distance(n / 32 % 32).powi(2) + distance(n / 1024).powi(2)).sqrt() as f32)
//!     .collect();
//! let volume = build(&mut DenseVolume::new(dims, &samples)?, DAffine3::IDENTITY, |_| {})?;
//!
//! let camera = Camera::new(
//!     &View { eye: DVec3::new(15.5, -40.0, 15.5), look_at: DVec3::splat(15.5), up: DVec3::Z, ..View::default() },
//!     [64, 64],
//! )?;
//! let image = render(&volume.view(), DAffine3::IDENTITY, &camera, &Scene::of(-10.0));
//! let centre = image.pixel(32, 32);
//! assert!((centre.depth - 45.5).abs() < 0.05); // 55.5 to the centre, less the radius
//! assert!(image.pixel(0, 0).depth.is_infinite());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Spaces and errors
//!
//! `t` is world distance from the eye (perspective) or from the plane through it (orthographic). A camera ray is computed in `f64`
//! and rounded once to the `f32` ray in index space that is traced; everything after that is `isoray-trace`'s, which
//! takes the rounded ray as exact. With `u = 2⁻²⁴`, rounding (to normal numbers, at least 2⁻¹²⁶)
//!
//! - moves the origin by at most `u` times its distance from the origin of index space;
//! - turns the direction by at most `u` radian (6·10⁻⁸) in index space, since a change `e` with `|eᵢ| ≤ u·|dᵢ|` for each
//!   component has `|e| ≤ u·|d|`. The bound is tight: directions at 45° to two axes approach it;
//! - turns it by at most `u` radian in the world as well if the lattice's axes are perpendicular there, whatever the
//!   spacings and however the lattice is rotated: unequal spacings scale `eᵢ` and `dᵢ` alike. If they are
//!   oblique, by at most `u` times the condition number of the matrix of their unit vectors.

mod camera;
mod clip;
mod frame;
mod gradient_scale;
mod image;
mod layers;
mod mesh_detail;
mod outlines;
mod scene;
mod shade;
mod sky;
mod source;
mod tiles;
mod volume;

pub use camera::{Camera, CameraError, Projection, View, frame_all};
pub use clip::{Clip, Plane};
pub use frame::{FrameStatistics, render, render_counted, render_with_progress};
pub use gradient_scale::gradient_scale;
pub use image::{Image, Pixel, encode_srgb};
pub use isoray_packet::{LANES, Slicing, Traversal};
pub use mesh_detail::mesh_detail;
pub use outlines::{Line, draw_lines};
pub use scene::{ColorField, LEVEL_COLORS, Light, Normals, SURFACE_COLOR, Scene, Surface};
pub use source::{ByLevel, FarShadowed, SurfaceSource, VolumeSource};
pub use volume::{VolumeScene, VolumeShading, VolumeStatistics, render_volume, render_volume_counted};
