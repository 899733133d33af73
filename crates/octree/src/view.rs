//! The structure as traversal sees it: borrowed slices.

use isoray_grid::{Dims, RowSource, Samples, Scalar, Stencil};

use crate::cap::{Block, bytes_of, cap_reach, cap_unit, width};
use crate::geometry::{
    CAP_EDGE, CAP_LEVEL, CAP_SAMPLES, MAX_LEVELS, NODE_LEVEL, child_origin, extent, is_whole, octant_of,
    product,
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
    pub(crate) caps: &'a [u8],
}

/// What is around a lattice point: the cube of edge 2^[`NODE_LEVEL`] that holds it.
#[derive(Clone, Copy, Debug)]
pub enum Around<'a, T: Scalar> {
    /// Samples that are all at least a threshold, or all below it.
    OneSide {
        /// At least.
        is_inside: bool,
    },
    /// Samples that all have one value.
    Constant(T),
    /// The parent of the caps there.
    Node(&'a Node<T::Stored>),
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

    /// The bytes of all caps, and [`cap_reach`] zeros.
    pub fn caps(&self) -> &'a [u8] {
        self.caps
    }

    /// The bytes of all caps.
    pub(crate) fn caps_alone(&self) -> &'a [u8] {
        &self.caps[..self.caps.len().saturating_sub(cap_reach::<T>())]
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
            (whole_caps_before::<T>(node, octant), [CAP_EDGE; 3])
        } else {
            self.border_cap(node, origin, octant)
        };
        let start = node.first.get() as usize * cap_unit::<T>() + start;
        let cap =
            self.caps.get(start..).and_then(|bytes| Block::cap(bytes, node.range(octant as usize & 7), size));
        cap.unwrap_or_default()
    }

    /// Start, from the first cap of the parent, and size of a cap that may be cut short by the domain's border.
    #[cold]
    fn border_cap(&self, node: &Node<T::Stored>, origin: [u32; 3], octant: u32) -> (usize, [u32; 3]) {
        let size = |n| extent(self.dims, child_origin(origin, NODE_LEVEL, n), CAP_LEVEL);
        let bytes = |n: u32| bytes_of::<T>(width::<T>(node.range(n as usize)), product(size(n)));
        (node.stored_before(octant).map(bytes).sum(), size(octant))
    }

    /// The block that holds lattice point `p`, from the root down (Knoll 2006, appendix B.1); a constant block of
    /// the default value outside the lattice.
    pub fn locate(&self, p: [u32; 3]) -> Block<'a, T> {
        match self.root() {
            Some(root) if self.dims.contains(p) => self.descend(root, self.root_level, p),
            _ => Block::default(),
        }
    }

    /// The block that holds `p`, from a `node` of `level` that holds it. Ends on any bytes.
    #[inline(always)]
    pub fn descend(&self, mut node: &'a Node<T::Stored>, mut level: u32, p: [u32; 3]) -> Block<'a, T> {
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

    /// What is around `p`, from a `node` of `level` that holds it: mostly a range on the way tells that all finite samples there lie on one side of
    /// `threshold`. Ends on any bytes.
    #[inline(always)]
    pub fn around(
        &self,
        mut node: &'a Node<T::Stored>,
        mut level: u32,
        p: [u32; 3],
        threshold: T,
    ) -> Around<'a, T> {
        while level > NODE_LEVEL {
            let octant = octant_of(p, level);
            if let Some(is_inside) = node.side(octant, threshold) {
                return Around::OneSide { is_inside };
            }
            if !node.is_stored(octant) {
                return Around::Constant(node.value(octant));
            }
            level -= 1;
            match self.nodes(level).get(node.child(octant)) {
                Some(next) => node = next,
                None => return Around::Constant(T::default()),
            }
        }
        Around::Node(node)
    }

    /// The samples at the corners of the cell at `cell`, x fastest.
    pub fn corners(&self, cell: [u32; 3]) -> [T; 8] {
        let corner = |n: u32| std::array::from_fn(|a| cell[a] + (n >> a & 1));
        // The axes along which the cell reaches into the next block.
        let at_last = (0..3).fold(0, |axes, a| axes | u32::from(cell[a] % CAP_EDGE == CAP_EDGE - 1) << a);
        let mut blocks = [self.locate(cell); 8];
        for direction in (1..8).filter(|direction| direction & !at_last == 0) {
            blocks[direction as usize] = self.locate(corner(direction));
        }
        std::array::from_fn(|n| {
            let block = &blocks[n & at_last as usize];
            block.sample(corner(n as u32).map(|c| c % CAP_EDGE))
        })
    }

    /// The sample at lattice point `p`, from the root down; the default value outside the lattice.
    pub fn sample(&self, p: [u32; 3]) -> T {
        self.locate(p).sample(p.map(|c| c & (CAP_EDGE - 1)))
    }
}

impl<T: Scalar> Samples for OctreeView<'_, T> {
    type Sample = T;

    fn dims(&self) -> Dims {
        self.dims
    }

    fn sample(&self, p: [u32; 3]) -> T {
        OctreeView::sample(self, p)
    }

    fn corners(&self, cell: [u32; 3]) -> [T; 8] {
        OctreeView::corners(self, cell)
    }

    fn stencil(&self, cell: [u32; 3]) -> Stencil<T> {
        // Four samples in a row lie in at most two blocks along each axis: whether in the second one, where in it, and whether in the domain.
        let block_of = |c: u32| c & !(CAP_EDGE - 1);
        let first = cell.map(|c| block_of(c.saturating_sub(1)));
        let along: [[(usize, u32, bool); 4]; 3] = std::array::from_fn(|a| {
            std::array::from_fn(|n| {
                let p = (cell[a] + n as u32).wrapping_sub(1);
                (usize::from(block_of(p) != first[a]), p % CAP_EDGE, p < self.dims.axes()[a])
            })
        });
        let mut blocks = [[T::default(); CAP_SAMPLES]; 8];
        let mut known = 0u32;
        Stencil::new(|index| {
            let [x, y, z] = [0, 1, 2].map(|a| along[a][index[a] as usize % 4]);
            if !(x.2 && y.2 && z.2) {
                return None;
            }
            let block = x.0 | y.0 << 1 | z.0 << 2;
            if known >> block & 1 == 0 {
                known |= 1 << block;
                let corner = std::array::from_fn(|a| first[a] + (block as u32 >> a & 1) * CAP_EDGE);
                blocks[block] = self.locate(corner).samples();
            }
            Some(blocks[block][(x.1 + CAP_EDGE * (y.1 + CAP_EDGE * z.1)) as usize])
        })
    }

    fn read_rows(&self, layer: u32, first: u32, out: &mut [T]) {
        let Ok(()) = RowSource::read_rows(self, layer, first, out);
    }
}

/// Bytes of the caps before that of child `octant`, if all of them are whole.
#[inline(always)]
fn whole_caps_before<T: Scalar>(node: &Node<T::Stored>, octant: u32) -> usize {
    if !T::IS_INTEGER {
        return node.rank(octant) as usize * bytes_of::<T>(0, CAP_SAMPLES);
    }
    let before = u32::from(node.mask) & ((1 << octant) - 1);
    let width = |n: usize| if before >> n & 1 == 1 { width::<T>(node.range(n)) } else { 0 };
    bytes_of::<T>((0..8).map(width).sum(), CAP_SAMPLES)
}
