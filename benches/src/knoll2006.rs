//! The single-ray renderer of Knoll, Wald, Parker and Hansen, 'Interactive Isosurface Ray Tracing of Large
//! Octree Volumes' (2006), as a reference for benchmarks.
//!
//! Structure, look-up, traversal and root finder are the paper's (sections 3 and 4, appendices A to C); the
//! engineering is what a careful programmer gives them today. It departs from the paper where that is wrong
//! or silent:
//!
//! - A node may hold the surface if `min < v` *and* `v ≤ max` (appendix C has *or*); a sample is inside where
//!   `s ≥ v`.
//! - Samples outside the domain do not exist (the paper defines them as zero, Figure 3): they take part in no
//!   range and no comparison, and rays are clipped to the domain.
//! - Neighbour finding stops at the first node whose coordinates agree with the destination's in *all* higher
//!   bits, not in one (B.2).
//! - The first child is found by comparing plane parameters, not positions, so that parent and child agree
//!   (C).
//! - The cubic is parametrised from entry to exit of each cell: in the ray's own parameter, single precision
//!   loses hits.
//!
//! All else, slow or imprecise as it may be, is left as it was.

mod build;
mod cell;
mod lookup;
mod traverse;

use isoray_grid::{Dims, Scalar};

/// Depths there can be: an axis has at most 2²¹ samples.
const MAX_DEPTH: usize = 21;

/// An interior node (appendix A). Octant `n` is the upper half along x if `n & 4`, y if `n & 2`, z if `n &
/// 1`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
struct OctNode<T> {
    /// The values of those children that are scalar leaves.
    child_scalars: [T; 8],
    /// Range of the children's cells, their forward neighbours included.
    child_mins: [T; 8],
    child_maxs: [T; 8],
    /// Index, at the next depth, of the first stored child.
    child_start: u32,
    /// Where from there each child is; [`LEAF`] for a scalar leaf.
    child_offset: [i8; 8],
}

/// The offset of a child that is not stored.
const LEAF: i8 = -1;

/// Eight samples at the deepest level, in octant order.
type OctCap<T> = [T; 8];

/// An octree volume in the layout of the paper (appendix A).
#[derive(Clone, Debug)]
pub struct PaperOctree<T> {
    dims: Dims,
    /// The root, a cube of 2^`max_depth` samples, has depth 0.
    max_depth: usize,
    /// Interior nodes by depth, the last ones being parents of caps.
    nodes: Vec<Vec<OctNode<T>>>,
    caps: Vec<OctCap<T>>,
    /// The bit of a coordinate that chooses among the children of a node, by the node's depth (A.1).
    child_bit_depth: [i32; MAX_DEPTH],
}

/// The first crossing of an isosurface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperHit {
    /// Where on the ray, in units of its direction's length.
    pub t: f32,
    /// Gradient of the cell's trilinear interpolant, per unit of index space.
    pub gradient: [f32; 3],
}

impl PaperHit {
    /// Lambert's cosine under a light at the eye (section 4.5): between 0 and 1, for a unit `direction`.
    pub fn lambert(&self, direction: [f32; 3]) -> f32 {
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let square = dot(self.gradient, self.gradient);
        if square > 0.0 { dot(self.gradient, direction).abs() / square.sqrt() } else { 0.0 }
    }
}

impl<T: Scalar> PaperOctree<T> {
    /// Bytes of nodes and caps, which is all that the structure stores.
    pub fn bytes(&self) -> usize {
        let nodes: usize = self.nodes.iter().map(Vec::len).sum();
        nodes * size_of::<OctNode<T>>() + self.caps.len() * size_of::<OctCap<T>>()
    }

    /// Size of the lattice.
    pub fn dims(&self) -> Dims {
        self.dims
    }
}

/// The octant of coordinates whose bit `bit` chooses (appendix B.1).
#[inline(always)]
fn octant([x, y, z]: [i32; 3], bit: i32) -> usize {
    usize::from(x & bit != 0) << 2 | usize::from(y & bit != 0) << 1 | usize::from(z & bit != 0)
}

/// The low corner of a child of the region at `cell`.
#[inline(always)]
fn child_cell([x, y, z]: [i32; 3], child: usize, bit: i32) -> [i32; 3] {
    let on = |shift: usize| if child >> shift & 1 == 1 { bit } else { 0 };
    [x | on(2), y | on(1), z | on(0)]
}
