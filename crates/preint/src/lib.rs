//! Emission and absorption along a ray's segment in a hexahedral cell, with a bounded error.

mod bounded;
mod fragment;
mod intervals;
mod lanes;
mod leaf;
mod lighting;
mod moments;
mod opacity;
mod refine;
mod segments;
mod shade;
mod transfer;
mod visibility;

pub use bounded::{Bounded, LEAST_EPSILON};
pub use lighting::Lighting;
pub use opacity::opacity;
pub use segments::{LANES, Radiance, Segments};
pub use transfer::{ControlPoint, LARGEST, TransferFunction, TransferFunctionError};
pub use visibility::Visibility;

/// A way to integrate emission and absorption along a ray's segments in cells.
pub trait Integrate: Sync {
    /// Adds `segments`, shaded if there is `lighting`, behind what `into` holds.
    fn integrate(&self, segments: &Segments, lighting: Option<&Lighting>, into: &mut Radiance);
}
