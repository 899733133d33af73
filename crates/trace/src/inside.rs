//! Which cells of the eight blocks of a cube of edge 8 hold an isovalue, by comparing whole blocks of samples.

use isoray_grid::Scalar;
use isoray_octree::{Around, NODE_LEVEL, Node};

use crate::blocks::Way;
use crate::branch::{BLOCK_LEVEL, Eight, spread};
use crate::corner::Corner;
use crate::offset::{LAST_PARTS, SPREAD, axes};

/// By the number of the block in the cube and behind it, `x + 4y + 16z`: the samples that are inside, as bits by their number in the block. 0 to 1
/// along each axis are the cube's own, 2 are the next cube's.
pub(crate) struct Inside([u64; 64]);

/// The blocks that are reached into from the eight first ones, in the cube in each direction.
const IN_DIRECTION: [u64; 8] = {
    let mut blocks = [0; 8];
    let mut n = 0;
    while n < 64 {
        let axes = n >> 1 & SPREAD[7];
        let direction = axes & 1 | axes >> 1 & 2 | axes >> 2 & 4;
        // Not the second ones of the next cube.
        if n & axes == 0 {
            blocks[direction as usize] |= 1 << n;
        }
        n += 1;
    }
    blocks
};

impl Inside {
    /// Of `own`, the cube of edge 8 around the block on the way, and of all blocks that hold corners of the cells of its `wanted` octants; `known`
    /// gives what is known already of the block at a corner.
    pub(crate) fn new<T: Scalar>(
        way: &Way<'_, '_, T>,
        own: &Eight<'_, T>,
        wanted: u32,
        threshold: T,
        known: impl Fn(Corner) -> Option<u64>,
    ) -> Self {
        let mut reached = spread(wanted);
        for step in [1, 4, 16] {
            reached |= reached << step;
        }
        let mut inside = Self([0; 64]);
        let corner = way.corner.around(NODE_LEVEL);
        let blocks = IN_DIRECTION[0];
        match own {
            Eight::Node(node) => inside.compare(blocks, way, corner, node, threshold),
            Eight::Constant { value, .. } => inside.fill(blocks, *value >= threshold),
        }
        for direction in 1..8 {
            let blocks = reached & IN_DIRECTION[direction as usize];
            if blocks == 0 || inside.is_known(blocks, corner, &known) {
                continue;
            }
            let corner = corner.neighbor(direction, NODE_LEVEL);
            match way.around(corner, threshold) {
                Around::OneSide { is_inside } => inside.fill(blocks, is_inside),
                Around::Constant(value) => inside.fill(blocks, value >= threshold),
                Around::Node(node) => inside.compare(blocks, way, corner, node, threshold),
            }
        }
        inside
    }

    /// Whether all of these blocks are known already; if so, adds them.
    #[inline(always)]
    fn is_known(&mut self, mut blocks: u64, corner: Corner, known: &impl Fn(Corner) -> Option<u64>) -> bool {
        while blocks != 0 {
            let number = blocks.trailing_zeros();
            blocks &= blocks - 1;
            let Some(inside) = known(corner.of_part(number, BLOCK_LEVEL)) else { return false };
            self.0[number as usize % 64] = inside;
        }
        true
    }

    #[inline(always)]
    fn fill(&mut self, mut blocks: u64, is_inside: bool) {
        if is_inside {
            while blocks != 0 {
                self.0[blocks.trailing_zeros() as usize % 64] = u64::MAX;
                blocks &= blocks - 1;
            }
        }
    }

    /// Adds blocks that are octants of a node whose low corner is at `corner`. What the ranges tell spares fetching the samples.
    #[inline(always)]
    fn compare<T: Scalar>(
        &mut self,
        mut blocks: u64,
        way: &Way<'_, '_, T>,
        corner: Corner,
        node: &Node<T::Stored>,
        threshold: T,
    ) {
        let [all, untold] = node.sides(threshold);
        while blocks != 0 {
            let number = blocks.trailing_zeros();
            blocks &= blocks - 1;
            let octant = axes(number);
            self.0[number as usize % 64] = match untold >> octant & 1 {
                0 => u64::from(all >> octant & 1).wrapping_neg(),
                _ => way.view.block(node, corner.coordinates(), octant).at_least(threshold),
            };
        }
    }

    /// Of own block `octant`: which of its samples are inside.
    pub(crate) fn of(&self, octant: u32) -> u64 {
        self.0[SPREAD[octant as usize & 7] as usize]
    }

    /// The cells of own block `octant` whose corners lie on both sides, all at once: some corner is inside, and not all.
    pub(crate) fn mixed(&self, octant: u32) -> u64 {
        let [last_x, last_y, last_z] = LAST_PARTS;
        let first = SPREAD[octant as usize & 7];
        let block = |direction: usize| self.0[(first + SPREAD[direction]) as usize % 64];
        // The samples one on along an axis, from a block and the next one.
        let on_x = |own: u64, next: u64| own >> 1 & !last_x | next << 3 & last_x;
        let on_y = |own: u64, next: u64| own >> 4 & !last_y | next << 12 & last_y;
        let on_z = |own: u64, next: u64| own >> 16 & !last_z | next << 48 & last_z;
        let fold = |of: fn(u64, u64) -> u64| {
            let along_x = |n: usize| of(block(n), on_x(block(n), block(n + 1)));
            let x = [along_x(0), along_x(2), along_x(4), along_x(6)];
            let y = [of(x[0], on_y(x[0], x[1])), of(x[2], on_y(x[2], x[3]))];
            of(y[0], on_z(y[0], y[1]))
        };
        fold(|a, b| a | b) & !fold(|a, b| a & b)
    }
}
