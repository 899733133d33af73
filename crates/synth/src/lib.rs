//! Volumes made by formula, layer by layer: to try a program, to test it, to measure it at any size.
//!
//! - [`Mixing`]: a turbulent mixing layer between two fluids, as in simulations of instabilities; most of it constant,
//!   the rest detailed down to two voxels.
//! - [`MarschnerLobb`]: the customary test signal of reconstruction.
//! - [`Sphere`]: the signed distance from a sphere.
//! - [`Ramp`]: a linear field.
//! - [`Noise`]: independent random samples.
//!
//! Each is a [`SlabSource`](isoray_grid::SlabSource) of `u8`, `u16` and `f32` samples ([`Sample`]) that fills layers on
//! all threads of the current rayon pool, gives any layers in any order, and holds none. The only error is to ask for
//! layers that the volume does not have.
//!
//! The samples are the same on every machine: nothing depends on the number of threads, on which layers are asked for
//! together, or on the instruction set. Arithmetic is addition, multiplication, division and square roots in `f32` or
//! `f64`, which IEEE 754 rounds in one way only, and which the compiler does not fuse; sines are computed here.
//!
//! ```
//! use isoray_grid::{Dims, SlabSource};
//! use isoray_synth::{Mixing, MixingParams};
//!
//! let dims = Dims::new([64, 64, 64])?;
//! let mut volume = Mixing::new(dims, MixingParams { seed: 7, time: 1.0 })?;
//!
//! // The light fluid is below, the heavy one above.
//! let mut layer = vec![0u8; dims.layer()];
//! volume.read_layers(0, &mut layer)?;
//! assert!(layer.iter().all(|&sample| sample == 10));
//! volume.read_layers(63, &mut layer)?;
//! assert!(layer.iter().all(|&sample| sample == 240));
//!
//! // In between they mix.
//! volume.read_layers(32, &mut layer)?;
//! assert!(layer.contains(&10) && layer.contains(&125) && layer.contains(&240));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cosine;
mod layers;
mod marschner_lobb;
mod mixing;
mod noise;
mod ramp;
mod random;
mod sample;
mod sphere;

pub use layers::LayersError;
pub use marschner_lobb::MarschnerLobb;
pub use mixing::{Mixing, MixingParams, TimeError};
pub use noise::Noise;
pub use ramp::{DirectionError, Ramp};
pub use sample::Sample;
pub use sphere::Sphere;
