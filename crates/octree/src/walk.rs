//! Passes over the whole structure: decoding and the histogram.

use isoray_grid::Scalar;

use crate::cap::Block;
use crate::geometry::{NODE_LEVEL, child_origin, extent, product};
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
        if let Some(root) = self.root() {
            self.leaves_below(root, self.root_level, [0; 3], &mut f);
        }
    }

    fn leaves_below(
        &self,
        node: &'a Node<T::Stored>,
        level: u32,
        origin: [u32; 3],
        f: &mut impl FnMut(Leaf<'a, T>),
    ) {
        for octant in 0..8 {
            let corner = child_origin(origin, level, octant);
            let size = extent(self.dims, corner, level - 1);
            if product(size) == 0 {
                continue;
            }
            if level > NODE_LEVEL && node.is_stored(octant) {
                if let Some(child) = self.nodes(level - 1).get(node.child(octant)) {
                    self.leaves_below(child, level - 1, corner, f);
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
        self.for_each_leaf(|leaf| {
            for z in 0..leaf.extent[2] {
                for y in 0..leaf.extent[1] {
                    let [x0, y0, z0] = leaf.origin;
                    let start = self.dims.linear([x0, y0 + y, z0 + z]);
                    for (x, slot) in (0..).zip(&mut out[start..start + leaf.extent[0] as usize]) {
                        *slot = leaf.block.sample([x, y, z]);
                    }
                }
            }
        });
        out
    }
}
