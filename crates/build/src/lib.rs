//! From a streamed volume to an octree volume.
//!
//! Consolidation is bottom-up (Knoll 2006, section 4.1), one slab of eight layers at a time: each block of 8³
//! samples becomes a parent of caps, and blocks whose samples are all bitwise equal, so that regions of NaN
//! merge as well, become scalar leaves of their parents. Value ranges take in the forward neighbours (section
//! 3.3), so a slab is read with the first layer of the next one. Nothing outside the domain is read, compared
//! or stored.
//!
//! Beside the result, memory holds nine layers of samples and, for every level, one layer of unfinished
//! nodes; the volume itself is never held twice. The result does not depend on the number of threads.
//!
//! [`mod@lossy`] makes volumes smaller that may lose something, within bounds.
//!
//! ```
//! use isoray_build::build;
//! use isoray_grid::{DenseVolume, Dims};
//!
//! let dims = Dims::new([20, 10, 9])?;
//! let samples: Vec<i16> = (0..1800).map(|n| if n % 20 < 12 { -5 } else { n }).collect();
//! let mut source = DenseVolume::new(dims, &samples)?;
//! let volume = build(&mut source, glam::DAffine3::IDENTITY, |_| {})?;
//! assert_eq!(volume.view().to_dense(), samples);
//! assert_eq!(volume.meta().range, Some([-5.0, 1799.0]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod block;
mod build;
mod consolidate;
mod error;
pub mod lossy;
mod pipeline;
mod plan;
mod slab;
mod strip;

pub use build::{FileOptions, build, build_file};
pub use error::{BuildError, Progress, StoreError};
pub use lossy::{Changes, Isovalues, Loss, LossError, Lossy, LossyError, SurfaceTolerance};
