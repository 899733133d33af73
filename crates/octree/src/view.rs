//! The structure as traversal sees it: borrowed slices.

use isoray_grid::{Dims, Scalar};
use zerocopy::FromBytes;

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
pub struct Block<'a, T: Scalar> {
    /// One sample of a constant block, all of a cap, x fastest; at the domain's far border a cap is shorter than [`CAP_EDGE`]. A cap
    /// has more than one, since it is not constant.
    samples: &'a [T::Stored],
    /// Distance of neighbours along y and z in `samples`.
    row: u32,
    layer: u32,
}

impl<T: Scalar> Default for Block<'_, T> {
    /// What a link that leads nowhere reads as: a block of zeros.
    #[inline(always)]
    fn default() -> Self {
        /// Enough for one sample of the largest type.
        static ZEROS: [u8; 4] = [0; 4];
        Self::constant(<[T::Stored]>::ref_from_bytes(&ZEROS[..T::TYPE.size()]).unwrap_or(&[]))
    }
}

impl<'a, T: Scalar> Block<'a, T> {
    /// A block whose samples all have the one value that `samples` holds.
    #[inline(always)]
    pub(crate) fn constant(samples: &'a [T::Stored]) -> Self {
        Self { samples, row: 0, layer: 0 }
    }

    #[inline(always)]
    fn cap(samples: &'a [T::Stored], size: [u32; 3]) -> Self {
        Self { samples, row: size[0], layer: size[0] * size[1] }
    }

    /// The value of all samples, unless the block is a cap.
    #[inline(always)]
    pub fn as_constant(&self) -> Option<T> {
        match self.samples {
            [value] => Some((*value).into()),
            _ => None,
        }
    }

    /// The samples of a cap that lies wholly inside the domain, x fastest.
    #[inline(always)]
    pub fn whole_cap(&self) -> Option<&'a [T::Stored; CAP_SAMPLES]> {
        // A cap that is cut short along any axis has fewer.
        self.samples.try_into().ok()
    }

    /// The sample at offset `(x, y, z)` from the block's low corner.
    ///
    /// The offset must lie in the block and in the domain. Beyond the end of a cap that the domain's border cuts
    /// short it may give another sample of the same cap, or the type's default value: it is in bounds, but means
    /// nothing. A constant block gives its value at any offset.
    #[inline(always)]
    pub fn sample(&self, [x, y, z]: [u32; 3]) -> T {
        if let [value] = self.samples {
            return (*value).into();
        }
        let at = z * self.layer + y * self.row + x;
        self.samples.get(at as usize).map_or(T::default(), |&s| s.into())
    }

    /// [`sample`](Self::sample) by the bit of an offset in [`at_least`](Self::at_least): `x + 4y + 16z`.
    #[inline(always)]
    pub fn sample_at(&self, bit: u32) -> T {
        match self.whole_cap() {
            Some(cap) => cap[bit as usize % CAP_SAMPLES].into(),
            None => self.sample([bit & 3, bit >> 2 & 3, bit >> 4 & 3]),
        }
    }

    /// Which samples are `≥ threshold`: bit `x + 4y + 16z`. Those outside the domain have no meaning.
    #[inline(always)]
    pub fn at_least(&self, threshold: T) -> u64 {
        if let Some(samples) = self.whole_cap() {
            T::at_least_64(samples, threshold)
        } else if let Some(value) = self.as_constant() {
            if value >= threshold { u64::MAX } else { 0 }
        } else {
            self.at_least_at_border(threshold)
        }
    }

    /// [`at_least`](Self::at_least) of a cap that is not whole. By value: a reference would keep the caller's block in memory.
    #[cold]
    fn at_least_at_border(self, threshold: T) -> u64 {
        let edge = 0..CAP_EDGE;
        let mut mask = 0;
        for z in edge.clone() {
            for y in edge.clone() {
                for x in edge.clone() {
                    mask |=
                        u64::from(self.sample([x, y, z]) >= threshold) << (x + CAP_EDGE * (y + CAP_EDGE * z));
                }
            }
        }
        mask
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
    pub fn block(&self, node: &'a Node<T::Stored>, origin: [u32; 3], octant: u32) -> Block<'a, T> {
        if !node.is_stored(octant) {
            return Block::constant(node.value(octant));
        }
        // No branch may return the block of a function that is not inlined: the block would go through memory, whichever
        // branch is taken, and be read there before its parts have arrived.
        let (start, size) = if is_whole(self.dims, origin, NODE_LEVEL) {
            (node.first.get() as usize * CAP_UNIT + node.rank(octant) as usize * CAP_SAMPLES, [CAP_EDGE; 3])
        } else {
            self.border_cap(node, origin, octant)
        };
        self.cap_at(start, size)
    }

    /// Start and size of a cap that may be cut short by the domain's border.
    #[cold]
    fn border_cap(&self, node: &Node<T::Stored>, origin: [u32; 3], octant: u32) -> (usize, [u32; 3]) {
        let size = |n| extent(self.dims, child_origin(origin, NODE_LEVEL, n), CAP_LEVEL);
        let before: usize = (0..octant).filter(|&n| node.is_stored(n)).map(|n| product(size(n))).sum();
        (node.first.get() as usize * CAP_UNIT + before, size(octant))
    }

    #[inline(always)]
    fn cap_at(&self, start: usize, size: [u32; 3]) -> Block<'a, T> {
        match self.caps.get(start..).and_then(|rest| rest.get(..product(size))) {
            Some(samples) => Block::cap(samples, size),
            None => Block::default(),
        }
    }

    /// The block that holds lattice point `p`, from the root down (Knoll 2006, appendix B.1); a constant block of
    /// the default value outside the lattice.
    pub fn locate(&self, p: [u32; 3]) -> Block<'a, T> {
        match self.root() {
            Some(root) if self.dims.contains(p) => self.descend(root, self.root_level, p),
            _ => Block::default(),
        }
    }

    /// The block that holds `p`, from a `node` of `level` that holds it.
    #[inline(always)]
    pub(crate) fn descend(&self, mut node: &'a Node<T::Stored>, mut level: u32, p: [u32; 3]) -> Block<'a, T> {
        while level > NODE_LEVEL {
            let octant = octant_of(p, level);
            if !node.is_stored(octant) {
                return Block::constant(node.value(octant));
            }
            level -= 1;
            match self.nodes(level).get(node.child(octant)) {
                Some(next) => node = next,
                None => return Block::default(),
            }
        }
        let origin = p.map(|c| c & !((1 << NODE_LEVEL) - 1));
        self.block(node, origin, octant_of(p, NODE_LEVEL))
    }

    /// [`Block::at_least`] of the block that holds `p`, from a `node` of `level` that holds it. Ends as soon as a range tells that a
    /// region lies on one side, which mostly spares fetching the samples.
    #[inline(always)]
    pub(crate) fn descend_at_least(
        &self,
        mut node: &'a Node<T::Stored>,
        mut level: u32,
        p: [u32; 3],
        threshold: T,
    ) -> u64 {
        let uniform = |inside| if inside { u64::MAX } else { 0 };
        loop {
            let octant = octant_of(p, level);
            if let Some(inside) = node.side(octant, threshold) {
                return uniform(inside);
            }
            level -= 1;
            if level == CAP_LEVEL {
                let origin = p.map(|c| c & !((1 << NODE_LEVEL) - 1));
                return self.block(node, origin, octant).at_least(threshold);
            }
            if !node.is_stored(octant) {
                return Block::<T>::constant(node.value(octant)).at_least(threshold);
            }
            match self.nodes(level).get(node.child(octant)) {
                Some(next) => node = next,
                None => return Block::<T>::default().at_least(threshold),
            }
        }
    }

    /// The sample at lattice point `p`, from the root down; the default value outside the lattice.
    pub fn sample(&self, p: [u32; 3]) -> T {
        self.locate(p).sample(p.map(|c| c & (CAP_EDGE - 1)))
    }
}
