//! The structure as traversal sees it: borrowed slices.

use isoray_grid::{Dims, Scalar};

use crate::geometry::{
    CAP_EDGE, CAP_LEVEL, CAP_SAMPLES, CAP_UNIT, MAX_LEVELS, NODE_LEVEL, child_origin, extent, is_whole,
    octant_of, product,
};
use crate::node::Node;

/// An octree volume, borrowed from memory or from a mapped file.
///
/// Links are checked at every step: whatever the bytes, look-ups stay in bounds and end. A link that
/// leads nowhere reads as a constant region of the type's default value.
#[derive(Clone, Copy, Debug)]
pub struct OctreeView<'a, T: Scalar> {
    pub(crate) dims: Dims,
    pub(crate) root_level: u32,
    /// Nodes by level, `NODE_LEVEL` first; those above the root are empty.
    pub(crate) levels: [&'a [Node<T::Stored>]; MAX_LEVELS],
    pub(crate) caps: &'a [T::Stored],
}

/// A region of the size of a cap, aligned like one: all of one value, or stored sample by sample.
#[derive(Clone, Copy, Debug)]
pub enum Block<'a, T: Scalar> {
    /// Every sample has this value.
    Constant(T),
    /// A cap.
    Cap(Cap<'a, T>),
}

/// The samples of a cap, x fastest; at the domain's far border it is shorter than [`CAP_EDGE`].
#[derive(Clone, Copy, Debug)]
pub struct Cap<'a, T: Scalar> {
    samples: &'a [T::Stored],
    row: u32,
    layer: u32,
}

impl<T: Scalar> Cap<'_, T> {
    /// The sample at offset `(x, y, z)` from the cap's low corner; the default value outside the domain.
    #[inline(always)]
    pub fn sample(&self, [x, y, z]: [u32; 3]) -> T {
        let at = z * self.layer + y * self.row + x;
        self.samples.get(at as usize).map_or(T::default(), |&s| s.into())
    }

    /// The samples of a whole cap, x fastest; `None` at the domain's far border.
    #[inline(always)]
    pub fn whole(&self) -> Option<&[T::Stored; CAP_SAMPLES]> {
        if self.row == CAP_EDGE && self.layer == CAP_EDGE * CAP_EDGE {
            self.samples.try_into().ok()
        } else {
            None
        }
    }
}

impl<T: Scalar> Block<'_, T> {
    /// The sample at offset `p` from the block's low corner.
    #[inline(always)]
    pub fn sample(&self, p: [u32; 3]) -> T {
        match self {
            Self::Constant(value) => *value,
            Self::Cap(cap) => cap.sample(p),
        }
    }
}

impl<'a, T: Scalar> OctreeView<'a, T> {
    /// Size of the lattice.
    #[inline(always)]
    pub fn dims(&self) -> Dims {
        self.dims
    }

    /// The root's level: it spans `2^level` samples along each axis.
    #[inline(always)]
    pub fn root_level(&self) -> u32 {
        self.root_level
    }

    /// The nodes of `level`, from [`NODE_LEVEL`] to the root's.
    #[inline(always)]
    pub fn nodes(&self, level: u32) -> &'a [Node<T::Stored>] {
        self.levels.get((level.wrapping_sub(NODE_LEVEL)) as usize).copied().unwrap_or(&[])
    }

    /// All caps' samples.
    pub fn caps(&self) -> &'a [T::Stored] {
        self.caps
    }

    /// The root; `None` only in a corrupt file.
    #[inline(always)]
    pub fn root(&self) -> Option<&'a Node<T::Stored>> {
        self.nodes(self.root_level).first()
    }

    /// Child `octant` of `node`, a parent of caps at `origin`, as a block.
    #[inline(always)]
    pub fn block(&self, node: &Node<T::Stored>, origin: [u32; 3], octant: u32) -> Block<'a, T> {
        if !node.is_stored(octant) {
            return Block::Constant(node.values[octant as usize].into());
        }
        if is_whole(self.dims, origin, NODE_LEVEL) {
            let start = node.first.get() as usize * CAP_UNIT + node.rank(octant) as usize * CAP_SAMPLES;
            return self.cap_at(start, [CAP_EDGE; 3]);
        }
        self.border_block(node, origin, octant)
    }

    /// [`block`](Self::block) where caps may be cut short by the domain's border.
    #[cold]
    fn border_block(&self, node: &Node<T::Stored>, origin: [u32; 3], octant: u32) -> Block<'a, T> {
        let size = |n| extent(self.dims, child_origin(origin, NODE_LEVEL, n), CAP_LEVEL);
        let before: usize = (0..octant).filter(|&n| node.is_stored(n)).map(|n| product(size(n))).sum();
        self.cap_at(node.first.get() as usize * CAP_UNIT + before, size(octant))
    }

    #[inline(always)]
    fn cap_at(&self, start: usize, size: [u32; 3]) -> Block<'a, T> {
        match self.caps.get(start..).and_then(|rest| rest.get(..product(size))) {
            Some(samples) => Block::Cap(Cap { samples, row: size[0], layer: size[0] * size[1] }),
            None => Block::Constant(T::default()),
        }
    }

    /// The block that holds lattice point `p`, from the root down (Knoll 2006, appendix B.1).
    pub fn locate(&self, p: [u32; 3]) -> Block<'a, T> {
        match self.root() {
            Some(root) => self.descend(root, self.root_level, p),
            None => Block::Constant(T::default()),
        }
    }

    /// The block that holds `p`, from a `node` of `level` that holds it.
    #[inline]
    pub(crate) fn descend(&self, node: &Node<T::Stored>, level: u32, p: [u32; 3]) -> Block<'a, T> {
        let mut node = *node;
        let mut level = level;
        while level > NODE_LEVEL {
            let octant = octant_of(p, level);
            if !node.is_stored(octant) {
                return Block::Constant(node.values[octant as usize].into());
            }
            level -= 1;
            match self.nodes(level).get(node.child(octant)) {
                Some(next) => node = *next,
                None => return Block::Constant(T::default()),
            }
        }
        let origin = p.map(|c| c & !((1 << NODE_LEVEL) - 1));
        self.block(&node, origin, octant_of(p, NODE_LEVEL))
    }

    /// The sample at lattice point `p`, from the root down; the default value outside the lattice.
    pub fn sample(&self, p: [u32; 3]) -> T {
        if !self.dims.contains(p) {
            return T::default();
        }
        self.locate(p).sample(p.map(|c| c & (CAP_EDGE - 1)))
    }
}
