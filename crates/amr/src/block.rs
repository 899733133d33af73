//! Boxes of cells of one level.

use crate::cuboid::Cuboid;
use crate::skeleton::LeafCell;

/// A box of cells of one level, none of which is covered by finer ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) place: Cuboid,
    /// The binary logarithm of the edge of its cells.
    pub(crate) exponent: u32,
    /// Where its values begin among those of all blocks.
    pub(crate) first: usize,
}

impl Block {
    /// The edge of its cells.
    pub(crate) fn edge(&self) -> u32 {
        1 << self.exponent
    }

    /// Its cells along each axis.
    pub(crate) fn cells(&self) -> [u32; 3] {
        self.place.edges().map(|n| n >> self.exponent)
    }

    /// The number of its cells.
    pub(crate) fn cell_count(&self) -> usize {
        self.cells().iter().map(|&n| n as usize).product()
    }

    /// The number of its vertices.
    pub(crate) fn vertex_count(&self) -> usize {
        self.cells().iter().map(|&n| n as usize + 1).product()
    }

    /// The number, x fastest, of the cell towards `octant` from `p`, a point of its closure.
    #[inline]
    pub(crate) fn cell_at(&self, p: [u32; 3], octant: u32) -> [u32; 3] {
        std::array::from_fn(|a| {
            let along = p[a] - self.place.low[a];
            let towards = octant >> a & 1;
            // Just below a plane it is the cell before.
            (along + towards).wrapping_sub(1) >> self.exponent
        })
    }

    /// Where the cell of these numbers is among all.
    #[inline]
    pub(crate) fn cell_index(&self, [x, y, z]: [u32; 3]) -> usize {
        let [nx, ny, _] = self.cells().map(|n| n as usize);
        x as usize + nx * (y as usize + ny * z as usize)
    }

    /// Where the vertex of these numbers is among all.
    #[inline]
    pub(crate) fn vertex_index(&self, [x, y, z]: [u32; 3]) -> usize {
        let [nx, ny, _] = self.cells().map(|n| n as usize + 1);
        x as usize + nx * (y as usize + ny * z as usize)
    }

    /// The number of the vertex at `p`, if it is one of its lattice.
    #[inline]
    pub(crate) fn vertex_at(&self, p: [u32; 3]) -> Option<[u32; 3]> {
        let along: [u32; 3] = std::array::from_fn(|a| p[a] - self.place.low[a]);
        let is_vertex = along.iter().all(|&c| c & (self.edge() - 1) == 0);
        is_vertex.then(|| along.map(|c| c >> self.exponent))
    }

    /// The leaf of these numbers, if the block has this one.
    #[inline]
    pub(crate) fn leaf(&self, block: u32, numbers: [u32; 3]) -> LeafCell {
        LeafCell { block, numbers, low: self.point(numbers), exponent: self.exponent }
    }

    /// The point at a vertex or the low corner of a cell of these numbers.
    #[inline]
    pub(crate) fn point(&self, numbers: [u32; 3]) -> [u32; 3] {
        std::array::from_fn(|a| self.place.low[a] + (numbers[a] << self.exponent))
    }

    /// Whether the cell of these numbers has cells of the block on all sides: nothing else touches it.
    #[inline]
    pub(crate) fn is_inner_cell(&self, numbers: [u32; 3]) -> bool {
        let cells = self.cells();
        (0..3).all(|a| numbers[a] > 0 && numbers[a] + 1 < cells[a])
    }

    /// Whether the vertex of these numbers lies inside, away from all faces.
    #[inline]
    pub(crate) fn is_inner_vertex(&self, numbers: [u32; 3]) -> bool {
        let cells = self.cells();
        (0..3).all(|a| numbers[a] > 0 && numbers[a] < cells[a])
    }
}

/// Calls `each` for all points of a box of this many along each axis, x fastest.
pub(crate) fn for_all(count: [u32; 3], mut each: impl FnMut([u32; 3])) {
    for z in 0..count[2] {
        for y in 0..count[1] {
            for x in 0..count[0] {
                each([x, y, z]);
            }
        }
    }
}
