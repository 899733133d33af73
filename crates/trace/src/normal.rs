//! Central-difference gradients.

use isoray_cell::{STENCIL, stencil_gradient};
use isoray_grid::Scalar;
use isoray_octree::{Block, CAP_EDGE, OctreeView};

use crate::hit::Hit;

/// The gradient at a hit, interpolated between central differences at the cell's corners, per unit of index space
/// (*central* normals): continuous across cells, where the forward gradient jumps.
///
/// At the border of the domain, and beside samples that are not finite, differences are one-sided of second order.
pub fn central_gradient<T: Scalar>(view: &OctreeView<'_, T>, hit: &Hit) -> [f32; 3] {
    let samples = stencil(view, hit.cell);
    stencil_gradient(&samples.map(Option::unwrap_or_default), &samples.map(|s| s.is_some()), hit.local)
}

/// The 4³ samples around a cell, x fastest; `None` outside the domain and where they are not finite.
fn stencil<T: Scalar>(view: &OctreeView<'_, T>, cell: [u32; 3]) -> [Option<f32>; STENCIL.pow(3)] {
    let low = cell.map(|c| c.wrapping_sub(1));
    // Four samples in a row lie in at most two blocks along each axis; find each of the eight once.
    let block_of = |c: u32| c & !(CAP_EDGE - 1);
    let first = cell.map(|c| block_of(c.saturating_sub(1)));
    let dims = view.dims();
    let blocks: [Option<Block<'_, T>>; 8] = std::array::from_fn(|n| {
        let p: [u32; 3] = std::array::from_fn(|a| first[a] + (n >> a & 1) as u32 * CAP_EDGE);
        let is_needed = (0..3).all(|a| p[a] <= cell[a] + 2);
        (is_needed && dims.contains(p)).then(|| view.locate(p))
    });
    let sample = |p: [u32; 3]| {
        if !dims.contains(p) {
            return None;
        }
        let n: usize = (0..3).map(|a| usize::from(block_of(p[a]) != first[a]) << a).sum();
        let s = blocks[n]?.sample(p.map(|c| c & (CAP_EDGE - 1)));
        s.is_finite().then(|| s.to_f32())
    };
    let along =
        |axis: usize, n: usize| low[axis].wrapping_add((n / STENCIL.pow(axis as u32) % STENCIL) as u32);
    std::array::from_fn(|n| sample(std::array::from_fn(|axis| along(axis, n))))
}
