//! From a node down to the block that holds a lattice point.

use isoray_grid::Scalar;
use isoray_octree::{Block, NODE_LEVEL, Node};

use super::{Tree, Visits};

impl<'a, T: Scalar> Tree<'a, T> {
    /// From the root, by comparing the position with the centres of nodes.
    #[inline(always)]
    pub(super) fn by_centers(&self, p: [u32; 3], visits: &mut impl Visits) -> Block<'a, T> {
        let position = p.map(|c| c as f32);
        let mut half = self.child_bit_depth[0] as f32;
        let mut center = [half; 3];
        let (mut node, mut depth) = (self.root(), 0);
        loop {
            visits.node();
            let mut octant = 0;
            half *= 0.5;
            for a in 0..3 {
                let is_upper = position[a] >= center[a];
                octant |= u32::from(is_upper) << a;
                center[a] += if is_upper { half } else { -half };
            }
            if depth == self.deepest {
                return self.block(node, p, octant);
            }
            if !node.is_stored(octant) {
                return Block::constant(node.value(octant));
            }
            depth += 1;
            node = self.node_at(depth, node.child(octant));
        }
    }

    /// From a node of `depth`, by masks of a table (2006, B.1, with its precedence and its *or* corrected).
    #[inline(always)]
    pub(super) fn by_masks(
        &self,
        mut node: &'a Node<T::Stored>,
        mut depth: usize,
        p: [u32; 3],
        visits: &mut impl Visits,
    ) -> Block<'a, T> {
        loop {
            visits.node();
            let bit = self.child_bit_depth[depth];
            let is_upper = |a: usize| u32::from(p[a] & bit != 0);
            let octant = is_upper(0) | is_upper(1) << 1 | is_upper(2) << 2;
            if depth == self.deepest {
                return self.block(node, p, octant);
            }
            if !node.is_stored(octant) {
                return Block::constant(node.value(octant));
            }
            depth += 1;
            node = self.node_at(depth, node.child(octant));
        }
    }

    /// From a node of `level`, by the bits of the locational codes, moved to their places.
    #[inline(always)]
    pub(super) fn by_codes(
        &self,
        mut node: &'a Node<T::Stored>,
        mut level: u32,
        [x, y, z]: [u32; 3],
        visits: &mut impl Visits,
    ) -> Block<'a, T> {
        loop {
            visits.node();
            let next = level - 1;
            let branch_bit = 1 << next;
            let octant =
                (x & branch_bit) >> next | (y & branch_bit) >> next << 1 | (z & branch_bit) >> next << 2;
            if level == NODE_LEVEL {
                return self.block(node, [x, y, z], octant);
            }
            if !node.is_stored(octant) {
                return Block::constant(node.value(octant));
            }
            level = next;
            node = self.node_at(self.depth(level), node.child(octant));
        }
    }
}
