//! The values at the vertices of all leaves.

use std::collections::HashSet;

use rayon::prelude::*;

use crate::block::{Block, for_all};
use crate::cells::Cells;
use crate::cuboid::Cuboid;
use crate::levels::Levels;
use crate::overlap::index;
use crate::patches::{Centering, Patch};
use crate::skeleton::{LeafCell, OCTANTS, Skeleton};
use crate::tree::Tree;

/// From the averages of cells.
pub(crate) fn from_cells(skeleton: &Skeleton, cells: &Cells<'_>) -> Vec<f32> {
    skeleton.fill(Block::vertex_count, |number, block, room| {
        let padded = cells.padded(number);
        let mut vertex = 0;
        for_all(block.cells().map(|n| n + 1), |at| {
            room[vertex] = padded.at_vertex(at).unwrap_or_else(|| cells.at_vertex(block.point(at)));
            vertex += 1;
        });
    })
}

/// From values at vertices: the finest leaf that has a vertex tells its value. Of leaves of one size that do not agree, which they should, one
/// of them does, always the same. Leaves of which some value is not finite are empty, and tell nothing.
pub(crate) fn from_vertices(
    skeleton: &Skeleton,
    levels: &Levels,
    tree: &Tree,
    patches: &[Patch],
    places: &[Cuboid],
) -> (Vec<f32>, Empty) {
    let within = |number: usize| {
        let block = &skeleton.blocks[number];
        let parts = tree.leaves[number].patches.iter().map(|&patch| patch as usize);
        parts.filter_map(move |patch| {
            let common = places[patch].common(&block.place)?;
            Some((&patches[patch], &places[patch], common, common.edges().map(|n| n >> block.exponent)))
        })
    };
    let point = |block: &Block, low: [u32; 3], at: [u32; 3]| -> [u32; 3] {
        std::array::from_fn(|a| low[a] + (at[a] << block.exponent))
    };
    let own = skeleton.fill(Block::vertex_count, |number, block, room| {
        for (patch, place, common, cells) in within(number) {
            for_all(cells.map(|n| n + 1), |at| {
                let p = point(block, common.low, at);
                let value = patch.values[index(patch, place, p, levels, Centering::Vertices)];
                if let Some(at) = block.vertex_at(p)
                    && value.is_finite()
                {
                    room[block.vertex_index(at)] = value;
                }
            });
        }
    });
    // By what the patch itself says: others may know more of its vertices.
    let empty = Empty::new(skeleton, |number, block, note| {
        for (patch, place, common, cells) in within(number) {
            if patch.values.iter().all(|value| value.is_finite()) {
                continue;
            }
            for_all(cells, |at| {
                let corner = |n: u32| point(block, common.low, std::array::from_fn(|a| at[a] + (n >> a & 1)));
                let value = |n| patch.values[index(patch, place, corner(n), levels, Centering::Vertices)];
                if !OCTANTS.map(value).all(|value| value.is_finite()) {
                    note(block.cell_at(corner(0), 7));
                }
            });
        }
    });
    let values = skeleton.fill(Block::vertex_count, |_, block, room| {
        room.copy_from_slice(&own[block.first..block.first + room.len()]);
        let mut number = 0;
        for_all(block.cells().map(|n| n + 1), |at| {
            if !block.is_inner_vertex(at)
                && let Some(value) = owned(skeleton, &own, &empty, block.point(at))
            {
                room[number] = value;
            }
            number += 1;
        });
    });
    (values, empty)
}

/// The value at `p` by the finest of the leaves that have it as a corner and are not empty, if there are any.
pub(crate) fn owned(skeleton: &Skeleton, values: &[f32], empty: &Empty, p: [u32; 3]) -> Option<f32> {
    let leaves = OCTANTS.filter_map(|octant| skeleton.leaf(p, octant));
    let leaves = leaves.filter(|leaf| leaf.has_corner(p) && !empty.has(skeleton, leaf));
    let finest = leaves.min_by_key(|leaf| (leaf.exponent, leaf.block))?;
    let block = &skeleton.blocks[finest.block as usize];
    Some(values[block.first + block.vertex_index(block.vertex_at(p)?)])
}

/// The leaves that have no value.
#[derive(Clone, Debug)]
pub(crate) struct Empty(HashSet<(u32, u32)>);

impl Empty {
    /// `find` is given a block, and what to call for each of its cells that is empty, with its numbers.
    pub(crate) fn new(
        skeleton: &Skeleton,
        find: impl Fn(usize, &Block, &mut dyn FnMut([u32; 3])) + Sync,
    ) -> Self {
        let blocks = skeleton.blocks.par_iter().enumerate();
        let found = blocks.flat_map_iter(|(number, block)| {
            let mut found = Vec::new();
            find(number, block, &mut |at| found.push((number as u32, block.cell_index(at) as u32)));
            found
        });
        Self(found.collect())
    }

    pub(crate) fn has(&self, skeleton: &Skeleton, leaf: &LeafCell) -> bool {
        self.has_cell(leaf.block, &skeleton.blocks[leaf.block as usize], leaf.numbers)
    }

    pub(crate) fn has_cell(&self, number: u32, block: &Block, numbers: [u32; 3]) -> bool {
        !self.0.is_empty() && self.0.contains(&(number, block.cell_index(numbers) as u32))
    }

    pub(crate) fn count(&self) -> u64 {
        self.0.len() as u64
    }
}
