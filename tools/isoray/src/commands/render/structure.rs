//! What rays go through.

use isoray_grid::{GridVolume, Samples, Scalar};
use isoray_octree::OctreeVolume;

use crate::cli::StructureArg;

/// Bytes of ranges per byte of samples, in macrocells of 4³ cells.
const RANGES: f64 = 1.0 / 32.0;

/// Whether rays go through the samples as an array with macrocells instead of the octree.
///
/// Without a choice that is done where it takes less memory, which is so for noise alone: there the two are about as fast, and on everything else
/// the octree is up to twice as fast (`cargo xtask bench single`).
pub(super) fn is_grid<T: Scalar>(structure: Option<StructureArg>, volume: &OctreeVolume<T>) -> bool {
    match structure.unwrap_or(StructureArg::Auto) {
        StructureArg::Octree => false,
        StructureArg::Grid => true,
        StructureArg::Auto => volume.structure_bytes() as f64 > volume.raw_bytes() as f64 * (1.0 + RANGES),
    }
}

/// Bytes of the array and its ranges.
pub(super) fn grid_bytes<S: Samples>(grid: &GridVolume<S>) -> u64 {
    (grid.samples().dims().samples() * size_of::<S::Sample>() + grid.macrocells().bytes()) as u64
}
