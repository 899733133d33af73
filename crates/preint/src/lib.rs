//! Emission and absorption along a ray's segment in a hexahedral cell, with a bounded error.

mod bounded;
pub mod distortion;
mod fragment;
mod intervals;
mod lanes;
mod leaf;
mod lighting;
mod linear;
mod moments;
mod opacity;
mod piece;
mod refine;
mod segments;
mod shade;
mod table;

mod transfer;
mod visibility;

pub use bounded::{Bounded, LEAST_EPSILON};
pub use lighting::Lighting;
pub use linear::LinearPieces;
pub use opacity::opacity;
pub use piece::Piece;
pub use segments::{LANES, Radiance, Segments};
pub use table::{Entry, PreintegrationTable, TableAxes, TableError};

pub use transfer::{ControlPoint, LARGEST, TransferFunction, TransferFunctionError};
pub use visibility::Visibility;

/// A way to integrate emission and absorption along a ray's segments in cells.
pub trait Integrate: Sync {
    /// Adds `segments`, shaded if there is `lighting`, behind what `into` holds.
    fn integrate(&self, segments: &Segments, lighting: Option<&Lighting>, into: &mut Radiance);
}
