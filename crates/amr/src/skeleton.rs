//! Where the cells are that no finer ones cover.

use rayon::prelude::*;

use crate::block::Block;
use crate::cuboid::Cuboid;
use crate::levels::Levels;
use crate::tree::{Node, Tree};

/// The leaves of a mesh: cells that no finer ones cover, in boxes of one level, in a tree.
#[derive(Clone, Debug)]
pub(crate) struct Skeleton {
    pub(crate) domain: Cuboid,
    pub(crate) nodes: Vec<Node>,
    pub(crate) blocks: Vec<Block>,
}

/// A leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LeafCell {
    pub(crate) block: u32,
    /// Its numbers in the block.
    pub(crate) numbers: [u32; 3],
    pub(crate) low: [u32; 3],
    /// The binary logarithm of its edge.
    pub(crate) exponent: u32,
}

impl LeafCell {
    pub(crate) fn edge(&self) -> u32 {
        1 << self.exponent
    }

    pub(crate) fn place(&self) -> Cuboid {
        Cuboid { low: self.low, high: self.low.map(|c| c + self.edge()) }
    }

    pub(crate) fn has_corner(&self, p: [u32; 3]) -> bool {
        p.iter().all(|c| c & (self.edge() - 1) == 0)
    }
}

/// All octants around a point.
pub(crate) const OCTANTS: std::ops::Range<u32> = 0..8;

impl Skeleton {
    pub(crate) fn new(levels: &Levels, tree: &Tree) -> Self {
        let mut first = 0;
        let block = |leaf: &crate::tree::Leaf| {
            let block = Block { place: leaf.place, exponent: levels.exponent(leaf.level), first };
            first += block.vertex_count();
            block
        };
        let blocks = tree.leaves.iter().map(block).collect();
        Self { domain: levels.domain, nodes: tree.nodes.clone(), blocks }
    }

    /// As many values for each block as `count` tells, one block after the other, as `fill` makes them, which gets the block's number and room for its values.
    pub(crate) fn fill(
        &self,
        count: impl Fn(&Block) -> usize,
        fill: impl Fn(usize, &Block, &mut [f32]) + Sync,
    ) -> Vec<f32> {
        let mut values = vec![f32::NAN; self.blocks.iter().map(&count).sum()];
        let mut rest = values.as_mut_slice();
        let mut rooms = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let (room, others) = rest.split_at_mut(count(block));
            rooms.push(room);
            rest = others;
        }
        let blocks = self.blocks.par_iter().zip(rooms).enumerate();
        blocks.for_each(|(number, (block, room))| fill(number, block, room));
        values
    }

    /// The blocks that have a point in common with a box, its faces, edges and vertices included.
    pub(crate) fn touching(&self, place: &Cuboid) -> Vec<u32> {
        let (mut found, mut pending) = (Vec::new(), vec![0u32]);
        while let Some(node) = pending.pop() {
            match self.nodes[node as usize] {
                Node::Leaf(block) => found.push(block),
                Node::Split { axis, plane, parts } => {
                    let axis = axis as usize;
                    pending.extend((place.low[axis] <= plane).then_some(parts[0]));
                    pending.extend((place.high[axis] >= plane).then_some(parts[1]));
                }
            }
        }
        found
    }

    /// The finer blocks that touch one.
    pub(crate) fn finer_around(&self, block: &Block) -> Vec<Block> {
        let around = self.touching(&block.place).into_iter().map(|other| self.blocks[other as usize]);
        around.filter(|other| other.exponent < block.exponent).collect()
    }

    /// The leaf that holds the octant at `p` towards which `octant` points, if that is of the domain.
    #[inline]
    pub(crate) fn leaf(&self, p: [u32; 3], octant: u32) -> Option<LeafCell> {
        let is_outside = (0..3).any(|a| match octant >> a & 1 {
            0 => p[a] <= self.domain.low[a] || p[a] > self.domain.high[a],
            _ => p[a] >= self.domain.high[a],
        });
        if is_outside {
            return None;
        }
        let block = Tree::find(&self.nodes, p, octant);
        let of = &self.blocks[block as usize];
        Some(of.leaf(block, of.cell_at(p, octant)))
    }
}
