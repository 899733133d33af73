//! Sizes and positions in the octree.

use isoray_grid::{Dims, MAX_AXIS};

/// Base-2 logarithm of a cap's edge.
pub const CAP_LEVEL: u32 = 2;
/// Samples along the edge of a cap.
pub const CAP_EDGE: u32 = 1 << CAP_LEVEL;
/// Samples of a cap that lies wholly inside the domain.
pub const CAP_SAMPLES: usize = (CAP_EDGE * CAP_EDGE * CAP_EDGE) as usize;
/// The lowest level that has nodes: parents of caps.
pub const NODE_LEVEL: u32 = CAP_LEVEL + 1;
/// The highest possible level of a root.
pub const MAX_LEVEL: u32 = MAX_AXIS.ilog2();
/// Number of levels that can have nodes.
pub const MAX_LEVELS: usize = (MAX_LEVEL - NODE_LEVEL + 1) as usize;

/// The level of the root: the smallest power of two that holds the lattice, at least the parent of a cap.
pub fn root_level(dims: Dims) -> u32 {
    let longest = dims.axes().into_iter().max().unwrap_or(1);
    longest.next_power_of_two().ilog2().max(NODE_LEVEL)
}

/// Low corner of child `octant` of a node of level `level` at `origin`.
#[inline(always)]
pub fn child_origin(origin: [u32; 3], level: u32, octant: u32) -> [u32; 3] {
    let half = level - 1;
    [
        origin[0] | (octant & 1) << half,
        origin[1] | (octant >> 1 & 1) << half,
        origin[2] | (octant >> 2 & 1) << half,
    ]
}

/// The octant of the child that holds `p`, in any node of level `level` that does.
#[inline(always)]
pub fn octant_of(p: [u32; 3], level: u32) -> u32 {
    let half = level - 1;
    (p[0] >> half & 1) | (p[1] >> half & 1) << 1 | (p[2] >> half & 1) << 2
}

/// Samples along each axis of the part of the cube of edge `2^level` at `origin` that lies in the domain; zero
/// where it lies outside.
#[inline]
pub fn extent(dims: Dims, origin: [u32; 3], level: u32) -> [u32; 3] {
    std::array::from_fn(|a| dims.axes()[a].saturating_sub(origin[a]).min(1 << level))
}

/// Whether the whole cube of edge `2^level` at `origin` lies in the domain.
#[inline(always)]
pub fn is_whole(dims: Dims, origin: [u32; 3], level: u32) -> bool {
    let n = dims.axes();
    let edge = 1 << level;
    (origin[0] + edge <= n[0]) & (origin[1] + edge <= n[1]) & (origin[2] + edge <= n[2])
}

/// Number of samples in an extent.
#[inline]
pub fn product(extent: [u32; 3]) -> usize {
    extent.iter().map(|&e| e as usize).product()
}
