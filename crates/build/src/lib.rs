//! From a streamed volume to an octree volume.
//!
//! Consolidation is bottom-up (Knoll 2006, section 4.1): each block of 8³ samples becomes a parent of caps, and blocks
//! whose samples are all bitwise equal, so that regions of NaN merge as well, become scalar leaves of their parents. Value ranges take in the
//! forward neighbours (section 3.3). Nothing outside the domain is read, compared or stored.
//!
//! The volume is read once, in *strips*: four rows of blocks of one layer of blocks, with the samples that come next in y and z. All threads
//! work on strips, each on one at a time, while the strips before them are stored in order; so neither the number of threads nor the memory that may be
//! used changes a byte of the result. A source that hands out rows in any order ([`RowSource`](isoray_grid::RowSource)) is read by all threads, straight
//! into a strip; of one that only goes forward nine layers are held, and nine more are read meanwhile.
//!
//! [`build`] makes a volume in memory, [`build_file`] a file, and then the volume itself is never in memory: there are strips, finished and unfinished nodes of one
//! layer of each level, and the nodes to be written in the end, which go to a nameless temporary file beyond a part of the limit.
//!
//! [`Lossy`] stands between a source and either of them and makes samples equal within bounds.
//!
//! Coarse samples are the volume's own by default and cost nothing; those that are means of others, which [`FileOptions::coarse`] asks for,
//! are made by a second pass over the nodes (see [`mod@isoray_octree::lod`]).
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
mod levels;
pub mod lossy;
mod pipeline;
mod plan;
mod slab;
mod strip;

pub use build::{FileOptions, build, build_file, build_with};
pub use error::{BuildError, Progress, StoreError};
pub use lossy::{Changes, Isovalues, Loss, LossError, Lossy, LossyError, SurfaceTolerance};
