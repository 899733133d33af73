//! Dense scalar volumes: the sample types, the lattice, borrowed arrays and the trait that streams one.
//!
//! A structured volume is `nx × ny × nz` samples at integer *index* coordinates `(i, j, k)`, `i` fastest
//! in memory. Cell `(i, j, k)` is the unit cube `[i, i+1] × [j, j+1] × [k, k+1]`, so there are
//! `(nx−1)(ny−1)(nz−1)` cells; nothing exists outside `[0, nx−1] × [0, ny−1] × [0, nz−1]`.
//!
//! - [`Scalar`] is implemented by the five sample types and says how each compares with an isovalue.
//! - [`Dims`] is a checked lattice size.
//! - [`DenseVolume`] borrows an array; [`SlabSource`] hands out layers of constant `k` in order, from an
//!   array, a file or a generator, so that a consumer never needs the whole volume in memory.
//! - [`BrickedVolume`] keeps an array in bricks, so that what lies near in space lies near in memory; [`Samples`] is what both, and a compressed
//!   volume, can be asked for.
//! - [`Macrocells`] holds the ranges of values in blocks of cells, by which a traversal passes by what cannot matter.
//!
//! ```
//! use isoray_grid::{DenseVolume, Dims, SlabSource};
//!
//! let dims = Dims::new([4, 3, 2])?;
//! let samples: Vec<u8> = (0..24).collect();
//! let volume = DenseVolume::new(dims, &samples)?;
//! assert_eq!(volume.sample([1, 2, 1]), 1 + 4 * (2 + 3));
//!
//! // The same samples, streamed one layer at a time.
//! let mut source = volume;
//! let mut layer = vec![0u8; 12];
//! source.read_layers(1, &mut layer)?;
//! assert_eq!(layer[0], 12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bricked;
mod dims;
mod macrocells;
mod map;
mod natural;
mod output;
mod samples;
mod scalar;
mod slab;
mod volume;

pub use bricked::{BrickError, BrickSizes, BrickedVolume};
pub use dims::{Dims, DimsError, MAX_AXIS};
pub use macrocells::{Branching, BranchingError, GridVolume, MacrocellLevel, Macrocells, ValueRange};
pub use map::{Access, MappedFile, map_file};
pub use natural::natural_order;
pub use output::{OutputFile, folder_of};
pub use samples::{STENCIL, Samples, Stencil};
pub use scalar::{Scalar, ScalarType, Threshold};
pub use slab::{RowSource, SlabSource};
pub use volume::{DenseVolume, LengthError};
