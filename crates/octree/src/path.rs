//! Neighbour finding (Knoll 2006, appendix B.2).

use isoray_grid::Scalar;

use crate::cap::Block;
use crate::geometry::{CAP_LEVEL, MAX_LEVEL, MAX_LEVELS, NODE_LEVEL};
use crate::node::Node;
use crate::view::OctreeView;

/// The way from the root down to one block: the node at each level, or the scalar leaf at which
/// the nodes end. Traversal fills it as it descends (the paper's `parent_trace`).
#[derive(Clone, Copy, Debug)]
pub struct Path<'a, T: Scalar> {
    nodes: [Option<&'a Node<T::Stored>>; MAX_LEVELS],
    /// Level of the scalar leaf that the way ends in; [`CAP_LEVEL`] if it reaches a parent of caps.
    leaf_level: u32,
    leaf_value: T,
}

impl<T: Scalar> Default for Path<'_, T> {
    fn default() -> Self {
        Self { nodes: [None; MAX_LEVELS], leaf_level: MAX_LEVEL, leaf_value: T::default() }
    }
}

impl<'a, T: Scalar> Path<'a, T> {
    /// A block of the scalar leaf in which the way ends.
    #[inline(always)]
    pub fn leaf_block(&self) -> Block<'a, T> {
        Block::constant(self.leaf_value)
    }

    /// The way passes through `node` of `level`, and what was known of lower levels is forgotten.
    #[inline(always)]
    pub fn enter_node(&mut self, level: u32, node: &'a Node<T::Stored>) {
        if let Some(slot) = self.nodes.get_mut((level.wrapping_sub(NODE_LEVEL)) as usize) {
            *slot = Some(node);
        }
        self.leaf_level = CAP_LEVEL;
    }

    /// The way ends in a scalar leaf of `level`: child `octant` of `parent`.
    #[inline(always)]
    pub fn enter_leaf(&mut self, level: u32, parent: &'a Node<T::Stored>, octant: u32) {
        self.leaf_level = level;
        self.leaf_value = parent.value(octant);
    }

    /// The block that holds lattice point `to`, from that which holds `from`, to which this way leads: up to
    /// the lowest node that holds both, and down from there.
    ///
    /// The highest bit in which any coordinate differs tells that node's level at once; comparing one bit per
    /// level on the way up, as the paper's listing does, would need all higher bits to agree.
    #[inline(always)]
    pub fn neighbor(&self, view: &OctreeView<'a, T>, from: [u32; 3], to: [u32; 3]) -> Block<'a, T> {
        match self.common(from, to) {
            Common::Leaf => self.leaf_block(),
            Common::Node(node, level) => view.descend(node, level, to),
            Common::Nowhere => Block::default(),
        }
    }

    /// The lowest region on the way that holds both points.
    #[inline(always)]
    fn common(&self, from: [u32; 3], to: [u32; 3]) -> Common<'a, T> {
        let differing = (from[0] ^ to[0]) | (from[1] ^ to[1]) | (from[2] ^ to[2]);
        let level = (u32::BITS - differing.leading_zeros()).max(NODE_LEVEL);
        if level <= self.leaf_level {
            return Common::Leaf;
        }
        match self.nodes.get((level - NODE_LEVEL) as usize) {
            Some(Some(node)) => Common::Node(node, level),
            _ => Common::Nowhere,
        }
    }
}

/// What two points have in common.
enum Common<'a, T: Scalar> {
    /// The scalar leaf that the way ends in.
    Leaf,
    /// A node, with its level.
    Node(&'a Node<T::Stored>, u32),
    /// A node that the way has not passed: the points are not both in the domain.
    Nowhere,
}
