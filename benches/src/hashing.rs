//! Ways to find a sample in an octree, and to step from it to its neighbours, all over one structure: that of `isoray-octree`.
//!
//! - [`Method::TopDown`]: the position is compared with the centre of every node on the way (Glassner 1984).
//! - [`Method::FriskenPerry`]: locational codes (Frisken and Perry, "Simple and Efficient Traversal Methods for Quadtrees and Octrees", 2002): the
//!   bits of whole coordinates name the children on the way; a step goes up as long as a bit of the two codes differs.
//! - [`Method::Knoll2006`]: the same with the bit of every level from a table (Knoll 2006, appendices A.1, B.1 and B.2); a step goes up until the bits agree.
//! - [`Method::Jump`]: the highest bit that differs tells at once how far a step goes up. This is a copy of what [`Path::neighbor`](isoray_octree::Path::neighbor) does, so that it can be
//!   counted; that both end in the same block is tested.
//!
//! All get at nodes and at blocks in the same way, and differ in what they ask of coordinates. None of them stores anything beside the octree: for links to
//! parents, which this octree does not have either, they are given a [`Trail`] (2006, section 4.2).

pub mod lookups;
mod neighbor;
mod point;
pub mod queries;
#[cfg(test)]
mod tests;

use isoray_grid::Scalar;
use isoray_octree::{Block, CAP_EDGE, CAP_LEVEL, MAX_LEVELS, NODE_LEVEL, Node, OctreeView, octant_of};

/// How it is looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Comparisons with centres, from the root.
    TopDown,
    /// Locational codes.
    FriskenPerry,
    /// Masks of a table.
    Knoll2006,
    /// The highest bit that differs.
    Jump,
}

/// What a look-up reports as it goes; `()` counts nothing and costs nothing.
pub trait Visits {
    /// A node was read.
    fn node(&mut self);
    /// It was asked whether to go up a level.
    fn up(&mut self);
}

impl Visits for () {
    #[inline(always)]
    fn node(&mut self) {}
    #[inline(always)]
    fn up(&mut self) {}
}

/// Counts of what look-ups did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Nodes that were read.
    pub nodes: u64,
    /// Levels that were tried on the way up.
    pub levels: u64,
}

impl Visits for Count {
    fn node(&mut self) {
        self.nodes += 1;
    }
    fn up(&mut self) {
        self.levels += 1;
    }
}

/// An octree volume with what the methods keep at hand.
#[derive(Clone, Debug)]
pub struct Tree<'a, T: Scalar> {
    view: OctreeView<'a, T>,
    /// The nodes by depth, the root's being 0.
    nodes: [&'a [Node<T::Stored>]; MAX_LEVELS],
    /// The depth of the parents of caps.
    deepest: usize,
    /// The bit of a coordinate that chooses among the children of a node, by its depth (2006, A.1).
    child_bit_depth: [u32; MAX_LEVELS],
}

/// The way from the root to a lattice point, as a traversal has it.
#[derive(Clone, Copy, Debug)]
pub struct Trail<T> {
    /// Indices of nodes by depth (2006, the `parent_trace`).
    nodes: [u32; MAX_LEVELS],
    /// Of the last one.
    depth: usize,
    /// Of the region below that: of a cap, or of a scalar leaf.
    level: u32,
    /// The value of that leaf.
    value: T,
}

impl<'a, T: Scalar> Tree<'a, T> {
    /// That of `view`.
    ///
    /// # Panics
    /// If there is no root, as in damaged files only.
    pub fn new(view: OctreeView<'a, T>) -> Self {
        assert!(view.root().is_some(), "an octree has a root");
        let root = view.root_level();
        let deepest = (root - NODE_LEVEL) as usize;
        Self {
            nodes: std::array::from_fn(|depth| view.nodes(root.saturating_sub(depth as u32))),
            deepest,
            child_bit_depth: std::array::from_fn(
                |depth| if depth <= deepest { 1 << (root - 1) >> depth } else { 0 },
            ),
            view,
        }
    }

    fn root(&self) -> &'a Node<T::Stored> {
        &self.nodes[0][0]
    }

    /// The levels of nodes, from the root's down.
    pub fn levels(&self) -> impl Iterator<Item = u32> {
        (NODE_LEVEL..=self.view.root_level()).rev()
    }

    /// The level of nodes of a depth.
    #[inline(always)]
    fn level(&self, depth: usize) -> u32 {
        self.view.root_level() - depth as u32
    }

    /// The depth of nodes of a level.
    #[inline(always)]
    fn depth(&self, level: u32) -> usize {
        (self.view.root_level() - level) as usize
    }

    /// A node by its depth and its place among those of that depth.
    #[inline(always)]
    fn node_at(&self, depth: usize, index: usize) -> &'a Node<T::Stored> {
        &self.nodes[depth][index]
    }

    /// The sample at `p`, which must be in the lattice, from the root down.
    #[inline(always)]
    pub fn sample(&self, method: Method, p: [u32; 3], visits: &mut impl Visits) -> T {
        let block = match method {
            Method::TopDown => self.by_centers(p, visits),
            Method::FriskenPerry | Method::Jump => {
                self.by_codes(self.root(), self.view.root_level(), p, visits)
            }
            Method::Knoll2006 => self.by_masks(self.root(), 0, p, visits),
        };
        sample_of(&block, p)
    }

    /// The sample at `to`, from `from`, to which `trail` leads: a neighbour, of which no coordinate differs by more than one. Both must be in the lattice.
    #[inline(always)]
    pub fn neighbor(
        &self,
        method: Method,
        trail: &Trail<T>,
        [from, to]: [[u32; 3]; 2],
        visits: &mut impl Visits,
    ) -> T {
        let block = match method {
            Method::TopDown => self.by_centers(to, visits),
            Method::FriskenPerry => self.step_by_codes(trail, [from, to], visits),
            Method::Knoll2006 => self.step_by_masks(trail, [from, to], visits),
            Method::Jump => self.step_by_jump(trail, [from, to], visits),
        };
        sample_of(&block, to)
    }

    /// The way to `p`, and the nodes on it, from the root down.
    pub fn trail(&self, p: [u32; 3]) -> (Trail<T>, Vec<&'a Node<T::Stored>>) {
        let mut trail = Trail { nodes: [0; MAX_LEVELS], depth: 0, level: CAP_LEVEL, value: T::default() };
        let mut node = self.root();
        let mut nodes = vec![node];
        loop {
            let level = self.level(trail.depth);
            let octant = octant_of(p, level);
            if !node.is_stored(octant) {
                (trail.level, trail.value) = (level - 1, node.value(octant));
                return (trail, nodes);
            }
            if trail.depth == self.deepest {
                return (trail, nodes);
            }
            let index = node.child(octant);
            trail.depth += 1;
            trail.nodes[trail.depth] = index as u32;
            node = self.node_at(trail.depth, index);
            nodes.push(node);
        }
    }

    /// A node on the way.
    #[inline(always)]
    fn node_on(&self, trail: &Trail<T>, depth: usize) -> &'a Node<T::Stored> {
        self.node_at(depth, trail.nodes[depth] as usize)
    }

    /// Child `octant` of `node`, a parent of caps around `p`.
    #[inline(always)]
    fn block(&self, node: &'a Node<T::Stored>, p: [u32; 3], octant: u32) -> Block<'a, T> {
        self.view.block(node, p.map(|c| c & !((1 << NODE_LEVEL) - 1)), octant)
    }
}

impl<T: Scalar> Trail<T> {
    /// The level of the scalar leaf in which the way ends, and its value; `None` if it leads to a cap.
    pub fn leaf(&self) -> Option<(u32, T)> {
        (self.level > CAP_LEVEL).then_some((self.level, self.value))
    }
}

/// The sample at `p` of the block that holds it.
#[inline(always)]
pub fn sample_of<T: Scalar>(block: &Block<'_, T>, p: [u32; 3]) -> T {
    block.sample(p.map(|c| c % CAP_EDGE))
}
