//! What is known of the cells of a block, 4³ at a time.
//!
//! Bricks lie on the lattice of their level at multiples of four, so that those at a block's faces may have cells that are not of it.

use rayon::prelude::*;

use crate::block::{Block, for_all};
use crate::hybrid::Split;
use crate::skeleton::Skeleton;
use crate::vertices::Empty;

/// Blocks that threads share.
const AT_A_TIME: usize = 256;

/// Cells along the edge of a brick.
pub(crate) const EDGE: u32 = 4;

/// Up to 4³ cells of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Brick {
    /// The least and the largest value in its cells; the first is larger if no cell has a value.
    pub(crate) range: [f32; 2],
    /// The cells that are taken apart, by offset: x + 4y + 16z.
    pub(crate) split: u64,
    /// The cells that are of the block, and not empty.
    pub(crate) own: u64,
    /// The split of the first of them among all; the others follow it.
    pub(crate) first: u32,
}

/// Where the bricks of a block are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// The number of the first along each axis, from the domain's low corner on.
    pub(crate) first: [u32; 3],
    /// How many there are.
    pub(crate) count: [u32; 3],
    /// The block's lowest cell, and the one behind the last.
    pub(crate) cells: [[u32; 3]; 2],
}

impl Layout {
    #[inline]
    pub(crate) fn new(block: &Block) -> Self {
        let cells = [block.place.low, block.place.high].map(|p| p.map(|c| c >> block.exponent));
        let first = cells[0].map(|c| c / EDGE);
        let count = std::array::from_fn(|a| cells[1][a].div_ceil(EDGE) - first[a]);
        Self { first, count, cells }
    }

    /// Where the brick of these numbers is among those of the block.
    #[inline]
    pub(crate) fn index(&self, numbers: [u32; 3]) -> u32 {
        let [x, y, z]: [u32; 3] = std::array::from_fn(|a| numbers[a] - self.first[a]);
        x + self.count[0] * (y + self.count[1] * z)
    }
}

/// Calls `each` for the cells of a block in the brick of these numbers, with the offset in the brick and the numbers in the block.
pub(crate) fn cells_of(layout: &Layout, numbers: [u32; 3], mut each: impl FnMut(u32, [u32; 3])) {
    let [low, high] = layout.cells;
    let begin: [u32; 3] = std::array::from_fn(|a| low[a].max(numbers[a] * EDGE));
    let end: [u32; 3] = std::array::from_fn(|a| high[a].min(numbers[a] * EDGE + EDGE));
    for_all(std::array::from_fn(|a| end[a] - begin[a]), |at| {
        let [x, y, z]: [u32; 3] = std::array::from_fn(|a| (begin[a] + at[a]) % EDGE);
        each(x | y << 2 | z << 4, std::array::from_fn(|a| begin[a] + at[a] - low[a]));
    });
}

/// The bricks of all blocks, by block, x fastest, and what the cells are taken apart into.
#[derive(Clone, Debug)]
pub(crate) struct Bricks {
    pub(crate) bricks: Vec<Brick>,
    /// By block: its first.
    pub(crate) first: Vec<u32>,
    pub(crate) splits: Vec<Split>,
}

impl Bricks {
    pub(crate) fn new(skeleton: &Skeleton, values: &[f32], empty: &Empty) -> Self {
        let of_block = |number: usize| {
            let block = &skeleton.blocks[number];
            let (mut bricks, mut splits) = (Vec::new(), Vec::new());
            let layout = Layout::new(block);
            let finer = skeleton.finer_around(block);
            let of = OfBlock { skeleton, values, empty, number: number as u32, block, layout, finer };
            for_all(layout.count, |at| bricks.push(of.brick(at, &mut splits)));
            (bricks, splits)
        };
        let mut all = Self { bricks: Vec::new(), first: Vec::new(), splits: Vec::new() };
        // Some at a time, so that not all of them are there twice.
        for begin in (0..skeleton.blocks.len()).step_by(AT_A_TIME) {
            let end = skeleton.blocks.len().min(begin + AT_A_TIME);
            let of_blocks: Vec<_> = (begin..end).into_par_iter().map(of_block).collect();
            of_blocks.into_iter().for_each(|(bricks, splits)| all.append(bricks, splits));
        }
        all.splits.shrink_to_fit();
        all
    }

    /// Appends those of the next block.
    fn append(&mut self, bricks: Vec<Brick>, splits: Vec<Split>) {
        let before = self.splits.len() as u32;
        self.first.push(self.bricks.len() as u32);
        self.bricks.extend(bricks.into_iter().map(|brick| Brick { first: brick.first + before, ..brick }));
        self.splits.extend(splits.into_iter().map(|split| Split { first: split.first + before, ..split }));
    }

    /// Those of a block.
    pub(crate) fn of_block(&self, block: u32) -> &[Brick] {
        let begin = self.first[block as usize] as usize;
        let end = self.first.get(block as usize + 1).map_or(self.bricks.len(), |&next| next as usize);
        &self.bricks[begin..end]
    }
}

/// A block, and where it belongs.
pub(crate) struct OfBlock<'s> {
    pub(crate) skeleton: &'s Skeleton,
    pub(crate) values: &'s [f32],
    pub(crate) empty: &'s Empty,
    number: u32,
    block: &'s Block,
    layout: Layout,
    /// The finer ones that touch it.
    finer: Vec<Block>,
}

impl OfBlock<'_> {
    fn brick(&self, at: [u32; 3], splits: &mut Vec<Split>) -> Brick {
        let mut brick = Brick { range: [f32::INFINITY, f32::NEG_INFINITY], split: 0, own: 0, first: 0 };
        let mut own = Vec::new();
        let brick_numbers = std::array::from_fn(|a| self.layout.first[a] + at[a]);
        cells_of(&self.layout, brick_numbers, |offset, numbers| {
            let bit = 1u64 << offset;
            if self.empty.has_cell(self.number, self.block, numbers) {
                return;
            }
            brick.own |= bit;
            let corners = corners(self.values, self.block, numbers);
            corners.iter().for_each(|&value| widen(&mut brick.range, value));
            if self.block.is_inner_cell(numbers) {
                return;
            }
            let leaf = self.block.leaf(self.number, numbers);
            let finer = self.finer.iter().filter(|other| leaf.place().touches(&other.place));
            let finer: Vec<_> = finer.copied().collect();
            let cell = (leaf.low, leaf.exponent);
            let before = splits.len();
            if let Some(split) = Split::new(self, cell, &corners, &finer, splits) {
                for part in splits[before..].iter().chain([&split]) {
                    part.values.iter().for_each(|&value| widen(&mut brick.range, value));
                }
                brick.split |= bit;
                own.push(split);
            }
        });
        brick.first = splits.len() as u32;
        splits.append(&mut own);
        brick
    }
}

/// Takes in a value that is finite.
fn widen(range: &mut [f32; 2], value: f32) {
    if value.is_finite() {
        *range = [range[0].min(value), range[1].max(value)];
    }
}

/// The values at the corners of the cell of these numbers, x fastest.
#[inline]
pub(crate) fn corners(values: &[f32], block: &Block, numbers: [u32; 3]) -> [f32; 8] {
    let [nx, ny, _] = block.cells().map(|n| n as usize + 1);
    corners_at(values, block.first + block.vertex_index(numbers), [nx, nx * ny])
}

/// The same, from the first of them on, with the distances along y and z.
#[inline(always)]
pub(crate) fn corners_at(values: &[f32], first: usize, [y, z]: [usize; 2]) -> [f32; 8] {
    // One check for all.
    let near = &values[first..first + y + z + 2];
    [near[0], near[1], near[y], near[y + 1], near[z], near[z + 1], near[y + z], near[y + z + 1]]
}
