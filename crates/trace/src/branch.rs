//! What the octree has of a cube.

use isoray_grid::Scalar;
use isoray_octree::{Around, Block, CAP_LEVEL, NODE_LEVEL, Node, OctreeView};

use crate::offset::{SPREAD, last_parts, octants};

/// The level of blocks, whose parts are cells.
pub(crate) const BLOCK_LEVEL: u32 = CAP_LEVEL;

/// Levels from a cube to its parts.
pub(crate) const STEP: u32 = 2;

/// The octants of a scalar leaf that are not constant: those at its upper faces.
const AT_UPPER_FACES: u32 = 0b1111_1110;

/// What the octree has of a cube of even level above [`BLOCK_LEVEL`], whose parts are its node's children's children: a node, or that it
/// lies in a scalar leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Branch<'a, T: Scalar> {
    /// The cube's node; of one that the root is an octant of, the root. None in a scalar leaf.
    pub(crate) node: Option<&'a Node<T::Stored>>,
    /// The leaf's value.
    pub(crate) leaf: T,
    /// Bit `a`: the cube's upper face of axis `a` is one of the leaf's. Only cells there are not constant.
    borders: u32,
}

/// A cube of eight blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Eight<'a, T: Scalar> {
    Node(&'a Node<T::Stored>),
    /// In a scalar leaf, some upper faces of which are its own: bit `a` for that of axis `a`.
    Constant {
        value: T,
        borders: u32,
    },
}

impl<'a, T: Scalar> Eight<'a, T> {
    /// The blocks in which something can matter, as `active` tells of the octants of a node.
    pub(crate) fn active(&self, active: impl Fn(&Node<T::Stored>) -> u32) -> u32 {
        match self {
            Self::Node(node) => active(node),
            &Self::Constant { borders, .. } => {
                (1..8).filter(|octant| octant & borders != 0).fold(0, |octants, octant| octants | 1 << octant)
            }
        }
    }

    /// The block that is an octant of it, if its low corner is at `origin`.
    #[inline(always)]
    pub(crate) fn block(&self, view: &OctreeView<'a, T>, origin: [u32; 3], octant: u32) -> Block<'a, T> {
        match *self {
            Self::Node(node) => view.block(node, origin, octant),
            Self::Constant { value, .. } => Block::constant(value),
        }
    }
}

/// What is below a node: a node, or a scalar leaf.
enum Child<'a, T: Scalar> {
    Node(&'a Node<T::Stored>),
    Leaf(T),
}

fn child<'a, T: Scalar>(
    view: &OctreeView<'a, T>,
    node: &Node<T::Stored>,
    level: u32,
    octant: u32,
) -> Child<'a, T> {
    if !node.is_stored(octant) {
        return Child::Leaf(node.value(octant));
    }
    // A link that leads nowhere reads as a constant region, as everywhere.
    view.nodes(level - 1).get(node.child(octant)).map_or(Child::Leaf(T::default()), Child::Node)
}

/// Eight octants as those 2³ of 4³ parts that begin at the low corner.
#[inline(always)]
pub(crate) fn spread(octants: u32) -> u64 {
    (0..4).fold(0, |parts, row| parts | u64::from(octants >> (2 * row) & 3) << SPREAD[2 * row as usize])
}

impl<'a, T: Scalar> Branch<'a, T> {
    /// Nothing: a constant region without cells.
    pub(crate) fn nothing() -> Self {
        Self { node: None, leaf: T::default(), borders: 0 }
    }

    /// That of the smallest cube around all of the volume, and its level.
    pub(crate) fn top(view: &OctreeView<'a, T>) -> (Self, u32) {
        let level = view.root_level().next_multiple_of(STEP).max(BLOCK_LEVEL + STEP);
        (Self { node: view.root(), ..Self::nothing() }, level)
    }

    /// The parts of the cube, of `level`, in which something can matter, as `active` tells of the octants of a node.
    pub(crate) fn active(
        &self,
        view: &OctreeView<'a, T>,
        level: u32,
        active: impl Fn(&Node<T::Stored>) -> u32,
    ) -> u64 {
        let Some(node) = self.node else { return last_parts(self.borders) };
        if level > view.root_level() {
            return spread(active(node));
        }
        let octants = active(node);
        (0..8).filter(|octant| octants >> octant & 1 == 1).fold(0, |parts, octant| {
            let below = match child(view, node, level, octant) {
                Child::Node(child) => active(child),
                Child::Leaf(_) => AT_UPPER_FACES,
            };
            parts | spread(below) << (2 * SPREAD[octant as usize & 7])
        })
    }

    /// The part at `offset` of this cube of `level`, a cube itself.
    pub(crate) fn part(&self, view: &OctreeView<'a, T>, level: u32, offset: u32) -> Self {
        let [octant, below] = octants(offset);
        let leaf = |leaf, borders| Self { node: None, leaf, borders };
        let Some(node) = self.node else {
            // At the cube's upper faces are the upper octants of its upper octants.
            return leaf(self.leaf, self.borders & octant & below);
        };
        let parent = match level > view.root_level() {
            true => Child::Node(node),
            false => child(view, node, level, octant),
        };
        match parent {
            Child::Leaf(value) => leaf(value, below),
            Child::Node(parent) => match child(view, parent, level - 1, below) {
                Child::Leaf(value) => leaf(value, 0b111),
                Child::Node(node) => Self { node: Some(node), ..Self::nothing() },
            },
        }
    }

    /// Octant `octant` of this cube, the smallest of those above the blocks: eight blocks.
    pub(crate) fn eight(&self, view: &OctreeView<'a, T>, octant: u32) -> Eight<'a, T> {
        let Some(node) = self.node else {
            return Eight::Constant { value: self.leaf, borders: self.borders & octant };
        };
        match view.root_level() {
            NODE_LEVEL => Eight::Node(node),
            _ => match child(view, node, NODE_LEVEL + 1, octant) {
                Child::Leaf(value) => Eight::Constant { value, borders: 0b111 },
                Child::Node(node) => Eight::Node(node),
            },
        }
    }

    /// What is around `p`, in this cube of `level`, by `threshold`.
    pub(crate) fn around(
        &self,
        view: &OctreeView<'a, T>,
        level: u32,
        p: [u32; 3],
        threshold: T,
    ) -> Around<'a, T> {
        match self.node {
            Some(node) => view.around(node, level.min(view.root_level()), p, threshold),
            None => Around::Constant(self.leaf),
        }
    }

    /// The block at `p`, from this cube of `level`, which holds it.
    pub(crate) fn descend(&self, view: &OctreeView<'a, T>, level: u32, p: [u32; 3]) -> Block<'a, T> {
        match self.node {
            Some(node) => view.descend(node, level.min(view.root_level()), p),
            None => Block::constant(self.leaf),
        }
    }
}
