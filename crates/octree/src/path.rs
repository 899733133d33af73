//! Neighbour finding (Knoll 2006, appendix B.2).

use isoray_grid::Scalar;

use crate::geometry::{CAP_LEVEL, MAX_LEVEL, MAX_LEVELS, NODE_LEVEL};
use crate::view::{Block, OctreeView};

/// The way from the root down to one block: the index of the node at each level, or the scalar leaf at which
/// the nodes end. Traversal fills it as it descends (the paper's `parent_trace`).
#[derive(Clone, Copy, Debug)]
pub struct Path<T> {
    nodes: [u32; MAX_LEVELS],
    /// Level of the scalar leaf that the way ends in; [`CAP_LEVEL`] if it reaches a parent of caps.
    leaf_level: u32,
    leaf_value: T,
}

impl<T: Scalar> Default for Path<T> {
    fn default() -> Self {
        Self { nodes: [0; MAX_LEVELS], leaf_level: MAX_LEVEL, leaf_value: T::default() }
    }
}

impl<T: Scalar> Path<T> {
    /// The value of the scalar leaf in which the way ends.
    #[inline(always)]
    pub fn leaf_value(&self) -> T {
        self.leaf_value
    }

    /// The way passes through node `index` of `level`, and what was known of lower levels is forgotten.
    #[inline(always)]
    pub fn enter_node(&mut self, level: u32, index: u32) {
        if let Some(node) = self.nodes.get_mut((level.wrapping_sub(NODE_LEVEL)) as usize) {
            *node = index;
        }
        self.leaf_level = CAP_LEVEL;
    }

    /// The way ends in a scalar leaf of `level`, which a node of `level + 1` holds.
    #[inline(always)]
    pub fn enter_leaf(&mut self, level: u32, value: T) {
        self.leaf_level = level;
        self.leaf_value = value;
    }

    /// The block that holds lattice point `to`, from that which holds `from`, to which this way leads: up to
    /// the lowest node that holds both, and down from there.
    ///
    /// The highest bit in which any coordinate differs tells that node's level at once; comparing one bit per
    /// level on the way up, as the paper's listing does, would need all higher bits to agree.
    #[inline]
    pub fn neighbor<'a>(&self, view: &OctreeView<'a, T>, from: [u32; 3], to: [u32; 3]) -> Block<'a, T> {
        let differing = (from[0] ^ to[0]) | (from[1] ^ to[1]) | (from[2] ^ to[2]);
        let level = (u32::BITS - differing.leading_zeros()).max(NODE_LEVEL);
        if level <= self.leaf_level {
            return Block::Constant(self.leaf_value);
        }
        let index = self.nodes.get((level - NODE_LEVEL) as usize).copied().unwrap_or(0);
        match view.nodes(level).get(index as usize) {
            Some(node) => view.descend(node, level, to),
            None => Block::Constant(T::default()),
        }
    }
}
