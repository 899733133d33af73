//! What is known of the cells of a block, 4³ at a time.

use rayon::prelude::*;

use crate::block::{Block, for_all};
use crate::hybrid::Split;
use crate::skeleton::Skeleton;
use crate::vertices::Empty;

/// Cells along the edge of a brick.
pub(crate) const EDGE: u32 = 4;

/// Up to 4³ cells of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Brick {
    /// The least and the largest value in its cells; the first is larger if no cell has a value.
    pub(crate) range: [f32; 2],
    /// The cells that are taken apart, by offset: x + 4y + 16z.
    pub(crate) split: u64,
    /// The cells that are empty.
    pub(crate) empty: u64,
    /// The split of the first of them among all; the others follow it.
    pub(crate) first: u32,
}

/// Bricks of a block along each axis.
pub(crate) fn bricks_along(block: &Block) -> [u32; 3] {
    block.cells().map(|n| n.div_ceil(EDGE))
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
        let of_blocks: Vec<(Vec<Brick>, Vec<Split>)> = (0..skeleton.blocks.len())
            .into_par_iter()
            .map(|number| {
                let block = &skeleton.blocks[number];
                let mut splits = Vec::new();
                let mut bricks = Vec::new();
                for_all(bricks_along(block), |at| {
                    let of = OfBlock { skeleton, values, empty, number: number as u32, block };
                    bricks.push(of.brick(at, &mut splits));
                });
                (bricks, splits)
            })
            .collect();
        let (mut all, mut first) = (Self { bricks: Vec::new(), first: Vec::new(), splits: Vec::new() }, 0);
        for (bricks, splits) in of_blocks {
            all.first.push(all.bricks.len() as u32);
            all.bricks.extend(bricks.into_iter().map(|brick| Brick { first: brick.first + first, ..brick }));
            all.splits.extend(splits.into_iter().map(|split| Split { first: split.first + first, ..split }));
            first = all.splits.len() as u32;
        }
        all
    }
}

/// A block, and where it belongs.
struct OfBlock<'s> {
    skeleton: &'s Skeleton,
    values: &'s [f32],
    empty: &'s Empty,
    number: u32,
    block: &'s Block,
}

impl OfBlock<'_> {
    fn brick(&self, at: [u32; 3], splits: &mut Vec<Split>) -> Brick {
        let cells = self.block.cells();
        let low = at.map(|c| c * EDGE);
        let count: [u32; 3] = std::array::from_fn(|a| EDGE.min(cells[a] - low[a]));
        let mut brick = Brick { range: [f32::INFINITY, f32::NEG_INFINITY], split: 0, empty: 0, first: 0 };
        let mut own = Vec::new();
        for_all(count, |offset| {
            let numbers: [u32; 3] = std::array::from_fn(|a| low[a] + offset[a]);
            let bit = 1u64 << (offset[0] | offset[1] << 2 | offset[2] << 4);
            if self.empty.has_cell(self.number, self.block, numbers) {
                brick.empty |= bit;
                return;
            }
            let corners = corners(self.values, self.block, numbers);
            corners.iter().for_each(|&value| widen(&mut brick.range, value));
            let is_inside = (0..3).all(|a| numbers[a] > 0 && numbers[a] + 1 < cells[a]);
            if is_inside {
                return;
            }
            let cell = (self.block.point(numbers), self.block.exponent);
            let before = splits.len();
            if let Some(split) = Split::new(self.skeleton, (self.values, self.empty), cell, &corners, splits)
            {
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
    let low = block.first + block.vertex_index(numbers);
    std::array::from_fn(|n| values[low + (n & 1) + nx * ((n >> 1 & 1) + ny * (n >> 2))])
}
