//! Passes over the structure, and decoding.

use std::convert::Infallible;

use isoray_grid::{Dims, RowSource, Scalar, SlabSource};

use crate::cap::Block;
use crate::geometry::{NODE_LEVEL, child_origin, extent};
use crate::node::Node;
use crate::view::OctreeView;

/// A part of the domain that is of one value, or a cap.
#[derive(Clone, Copy, Debug)]
pub struct Leaf<'a, T: Scalar> {
    /// Low corner.
    pub origin: [u32; 3],
    /// Samples along each axis, inside the domain.
    pub extent: [u32; 3],
    /// Its samples.
    pub block: Block<'a, T>,
}

impl<'a, T: Scalar> OctreeView<'a, T> {
    /// Calls `f` once for every leaf; together they cover each sample of the domain once. (In a damaged
    /// structure a part whose link leads nowhere is left out.)
    pub fn for_each_leaf(&self, mut f: impl FnMut(Leaf<'a, T>)) {
        self.for_each_leaf_in([[0; 3], self.dims.axes()], &mut f);
    }

    /// The leaves that hold a sample between two corners, of which the second is outside.
    fn for_each_leaf_in(&self, bounds: [[u32; 3]; 2], f: &mut impl FnMut(Leaf<'a, T>)) {
        if let Some(root) = self.root() {
            self.leaves_below(root, self.root_level, [0; 3], bounds, f);
        }
    }

    fn leaves_below(
        &self,
        node: &'a Node<T::Stored>,
        level: u32,
        origin: [u32; 3],
        bounds: [[u32; 3]; 2],
        f: &mut impl FnMut(Leaf<'a, T>),
    ) {
        for octant in 0..8 {
            let corner = child_origin(origin, level, octant);
            let size = extent(self.dims, corner, level - 1);
            let [low, high] = bounds;
            if (0..3).any(|a| corner[a] >= high[a] || corner[a] + size[a] <= low[a]) {
                continue;
            }
            if level > NODE_LEVEL && node.is_stored(octant) {
                if let Some(child) = self.nodes(level - 1).get(node.child(octant)) {
                    self.leaves_below(child, level - 1, corner, bounds, f);
                }
            } else {
                let block = match level {
                    NODE_LEVEL => self.block(node, origin, octant),
                    _ => Block::constant(node.value(octant)),
                };
                f(Leaf { origin: corner, extent: size, block });
            }
        }
    }

    /// The whole volume as a dense array, x fastest: `dims().samples()` of them, which can be far more than
    /// the structure takes.
    pub fn to_dense(&self) -> Vec<T> {
        let mut out = vec![T::default(); self.dims.samples()];
        self.copy_box([[0; 3], self.dims.axes()], &mut out);
        out
    }

    /// The samples between two corners, of which the second is outside; x fastest.
    pub(crate) fn copy_box(&self, bounds: [[u32; 3]; 2], out: &mut [T]) {
        let [low, high] = bounds;
        let size: [u32; 3] = std::array::from_fn(|a| high[a] - low[a]);
        self.for_each_leaf_in(bounds, &mut |leaf: Leaf<'a, T>| {
            let end = |a: usize| (leaf.origin[a] + leaf.extent[a]).min(high[a]);
            let [x, y, z] = std::array::from_fn(|a| leaf.origin[a].max(low[a])..end(a));
            for (z, y) in z.flat_map(|z| y.clone().map(move |y| (z, y))) {
                let row = (z - low[2]) * size[1] + (y - low[1]);
                let start = row as usize * size[0] as usize + (x.start - low[0]) as usize;
                let Some(slots) = out.get_mut(start..start + x.len()) else { continue };
                match leaf.block.as_constant() {
                    Some(value) => slots.fill(value),
                    None => x.clone().zip(slots).for_each(|(x, slot)| {
                        let at = std::array::from_fn(|a| [x, y, z][a] - leaf.origin[a]);
                        *slot = leaf.block.sample(at);
                    }),
                }
            }
        });
    }
}

/// The samples of an octree volume, read as those of any other.
impl<T: Scalar> SlabSource<T> for OctreeView<'_, T> {
    type Error = Infallible;

    fn dims(&self) -> Dims {
        self.dims
    }

    fn read_layers(&mut self, first: u32, out: &mut [T]) -> Result<(), Infallible> {
        let [nx, ny, _] = self.dims.axes();
        let layers = (out.len() / self.dims.layer()) as u32;
        self.copy_box([[0, 0, first], [nx, ny, first + layers]], out);
        Ok(())
    }

    fn rows(&self) -> Option<&dyn RowSource<T, Error = Infallible>> {
        Some(self)
    }
}

impl<T: Scalar> RowSource<T> for OctreeView<'_, T> {
    type Error = Infallible;

    fn read_rows(&self, layer: u32, first: u32, out: &mut [T]) -> Result<(), Infallible> {
        let nx = self.dims.axes()[0];
        let rows = (out.len() / nx as usize) as u32;
        self.copy_box([[0, first, layer], [nx, first + rows, layer + 1]], out);
        Ok(())
    }
}
