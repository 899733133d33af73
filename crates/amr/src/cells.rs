//! Averages of cells, and what follows from them at vertices.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::block::{Block, for_all};
use crate::cuboid::Cuboid;
use crate::levels::Levels;
use crate::overlap::index;
use crate::patches::{Centering, Patch};
use crate::skeleton::{LeafCell, OCTANTS, Skeleton};
use crate::tree::Tree;
use crate::vertices::Empty;

/// What a field made of the averages of cells does at the border of the domain, where no rule is both exact for linear fields and bounded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Border {
    /// It goes on as it does inside: exact for linear fields, and possibly beyond all averages.
    #[default]
    Linear,
    /// It ends with what is there: within the averages, and flat.
    Bounded,
}

/// The averages of all leaves.
pub(crate) struct Cells<'s> {
    skeleton: &'s Skeleton,
    /// See [`averages`].
    values: Vec<f32>,
    /// By block: where its values begin.
    first: Vec<usize>,
    /// By block: the gradients in leaves that finer ones touch, or the border of the domain, by their index.
    slopes: Vec<HashMap<u32, [f64; 3]>>,
    border: Border,
}

/// The averages of all leaves, block after block, x fastest, from patches and their places: all in one, since what many small ones leave behind is not soon given back.
pub(crate) fn averages(
    skeleton: &Skeleton,
    levels: &Levels,
    tree: &Tree,
    (patches, places): (&[Patch], &[Cuboid]),
) -> Vec<f32> {
    skeleton.fill(Block::cell_count, |number, block, values| {
        for &patch in &tree.leaves[number].patches {
            let (patch, place) = (&patches[patch as usize], &places[patch as usize]);
            let Some(common) = place.common(&block.place) else { continue };
            let count = common.edges().map(|n| n >> block.exponent);
            for_all([1, count[1], count[2]], |[_, y, z]| {
                let row: [u32; 3] = std::array::from_fn(|a| common.low[a] + ([0, y, z][a] << block.exponent));
                let from = index(patch, place, row, levels, Centering::Cells);
                let to = block.cell_index(block.cell_at(row, 7));
                let count = count[0] as usize;
                values[to..to + count].copy_from_slice(&patch.values[from..from + count]);
            });
        }
    })
}

impl<'s> Cells<'s> {
    /// Of the averages that [`averages`] gathers.
    pub(crate) fn new(skeleton: &'s Skeleton, values: Vec<f32>, border: Border) -> Self {
        let mut begin = 0;
        let first = skeleton.blocks.iter().map(|block| {
            begin += block.cell_count();
            begin - block.cell_count()
        });
        let mut cells = Self { skeleton, values, first: first.collect(), slopes: Vec::new(), border };
        cells.slopes = (0..skeleton.blocks.len() as u32).into_par_iter().map(|n| cells.slopes(n)).collect();
        cells
    }

    /// The gradients in the leaves of a block that finer ones touch, or the border of the domain.
    fn slopes(&self, number: u32) -> HashMap<u32, [f64; 3]> {
        let block = &self.skeleton.blocks[number as usize];
        let finer = self.skeleton.finer_around(block);
        let domain = &self.skeleton.domain;
        let is_at_border =
            (0..3).any(|a| block.place.low[a] == domain.low[a] || block.place.high[a] == domain.high[a]);
        let mut slopes = HashMap::new();
        if finer.is_empty() && !is_at_border {
            return slopes;
        }
        for_all(block.cells(), |numbers| {
            if block.is_inner_cell(numbers) {
                return;
            }
            let leaf = block.leaf(number, numbers);
            let place = leaf.place();
            let is_inside = (0..3).all(|a| place.low[a] > domain.low[a] && place.high[a] < domain.high[a]);
            if is_inside && !finer.iter().any(|other| place.touches(&other.place)) {
                return;
            }
            if let Some(value) = self.value(&leaf) {
                let slope = |a| self.slope(&leaf, value, a);
                slopes.insert(block.cell_index(numbers) as u32, [slope(0), slope(1), slope(2)]);
            }
        });
        slopes
    }

    /// The leaves without an average.
    pub(crate) fn empty(&self) -> Empty {
        Empty::new(self.skeleton, |number, block, note| {
            for_all(block.cells(), |at| {
                if !self.of_block(number)[block.cell_index(at)].is_finite() {
                    note(at);
                }
            });
        })
    }

    /// From the first average of a block on.
    #[inline]
    fn of_block(&self, block: usize) -> &[f32] {
        &self.values[self.first[block]..]
    }

    /// The average of a leaf, unless it is empty.
    fn value(&self, leaf: &LeafCell) -> Option<f64> {
        let block = &self.skeleton.blocks[leaf.block as usize];
        let value = self.of_block(leaf.block as usize)[block.cell_index(leaf.numbers)];
        value.is_finite().then_some(f64::from(value))
    }

    /// The average over a cube, if it is of the domain and made of leaves none of which is empty.
    fn average(&self, low: [u32; 3], exponent: u32) -> Option<f64> {
        let leaf = self.skeleton.leaf(low, 7)?;
        if leaf.exponent == exponent {
            return self.value(&leaf);
        }
        // Not in a coarser one.
        let half = exponent.checked_sub(1).filter(|&half| leaf.exponent <= half)?;
        let mut sum = 0.0;
        for octant in OCTANTS {
            let part = std::array::from_fn(|a| low[a] + ((octant >> a & 1) << half));
            sum += self.average(part, half)?;
        }
        Some(sum / 8.0)
    }

    /// The gradient in a leaf, along one axis, per edge of the finest cells: from the cubes of its size on both sides, or on one, or else none.
    fn slope(&self, leaf: &LeafCell, value: f64, axis: usize) -> f64 {
        let edge = leaf.edge();
        let beside = |is_above: bool| {
            let mut low = leaf.low;
            low[axis] = if is_above { low[axis].checked_add(edge)? } else { low[axis].checked_sub(edge)? };
            self.average(low, leaf.exponent)
        };
        let edge = f64::from(edge);
        match (beside(false), beside(true)) {
            (Some(below), Some(above)) => (above - below) / (2.0 * edge),
            (Some(below), None) => (value - below) / edge,
            (None, Some(above)) => (above - value) / edge,
            (None, None) => 0.0,
        }
    }

    /// The value at a vertex, with `h` the edge of the smallest leaf that touches it: the mean of what each octant around it has at the distance h/2 along all
    /// axes; a leaf that is larger is taken as linear there. At least the least average of what touches it, and at most the largest.
    ///
    /// Octants that are not of the domain, or empty, have what the nearest others have, of which there may be several: these go on linearly, and then the value need not
    /// be bounded; or, if it must be, what they have themselves counts once more. Not a number where all that touches it is empty.
    pub(crate) fn at_vertex(&self, p: [u32; 3]) -> f32 {
        let leaves: [Option<(LeafCell, f64)>; 8] = std::array::from_fn(|octant| {
            let leaf = self.skeleton.leaf(p, octant as u32)?;
            Some((leaf, self.value(&leaf)?))
        });
        let found = || leaves.iter().flatten();
        let Some(half) = found().map(|(leaf, _)| f64::from(leaf.edge()) / 2.0).reduce(f64::min) else {
            return f32::NAN;
        };
        // What the leaf in one octant has where another one asks.
        let there = |(leaf, value): &(LeafCell, f64), octant: u32| {
            let off: [f64; 3] = std::array::from_fn(|a| {
                let at = f64::from(p[a]) + if octant >> a & 1 == 1 { half } else { -half };
                at - (f64::from(leaf.low[a]) + f64::from(leaf.edge()) / 2.0)
            });
            if off == [0.0; 3] {
                return *value;
            }
            let index = self.skeleton.blocks[leaf.block as usize].cell_index(leaf.numbers) as u32;
            let known = self.slopes[leaf.block as usize].get(&index).copied();
            // Beside an empty leaf.
            let slopes = known.unwrap_or_else(|| [0, 1, 2].map(|a| self.slope(leaf, *value, a)));
            (0..3).fold(*value, |there, a| there + off[a] * slopes[a])
        };
        let is_linear = self.border == Border::Linear;
        let mut sum = 0.0;
        for octant in OCTANTS {
            let nearest = (0..8u32).filter(|&other| leaves[other as usize].is_some());
            let Some(steps) = nearest.clone().map(|other| (other ^ octant).count_ones()).min() else {
                continue;
            };
            let (mut of_octant, mut count) = (0.0, 0.0);
            for other in nearest.filter(|other| (other ^ octant).count_ones() == steps) {
                let Some(leaf) = &leaves[other as usize] else { continue };
                of_octant += there(leaf, if is_linear { octant } else { other });
                count += 1.0;
            }
            sum += of_octant / count;
        }
        let mean = sum / 8.0;
        if is_linear && found().count() < 8 {
            return mean as f32;
        }
        let least = found().map(|(_, value)| *value).fold(f64::INFINITY, f64::min);
        let largest = found().map(|(_, value)| *value).fold(f64::NEG_INFINITY, f64::max);
        mean.clamp(least, largest) as f32
    }

    /// The averages of a block and of the cells of its size around it.
    pub(crate) fn padded(&self, number: usize) -> Padded {
        let block = &self.skeleton.blocks[number];
        let count = block.cells().map(|n| n as usize + 2);
        let mut padded = Padded { values: vec![f32::NAN; count.iter().product()], count };
        for other in self.skeleton.touching(&block.place) {
            let of = &self.skeleton.blocks[other as usize];
            if of.exponent != block.exponent {
                continue;
            }
            // In cells of the level.
            let own = block.place.low.map(|c| c >> block.exponent);
            let low = of.place.low.map(|c| c >> block.exponent);
            let begin: [u32; 3] = std::array::from_fn(|a| low[a].max(own[a].saturating_sub(1)));
            let end: [u32; 3] =
                std::array::from_fn(|a| (low[a] + of.cells()[a]).min(own[a] + block.cells()[a] + 1));
            let cells: [u32; 3] = std::array::from_fn(|a| end[a].saturating_sub(begin[a]));
            if cells.contains(&0) {
                continue;
            }
            for_all([1, cells[1], cells[2]], |[_, y, z]| {
                let row = [begin[0], begin[1] + y, begin[2] + z];
                let from = of.cell_index(std::array::from_fn(|a| row[a] - low[a]));
                let to = padded.index(std::array::from_fn(|a| (row[a] + 1 - own[a]) as usize));
                let count = cells[0] as usize;
                let values = &self.of_block(other as usize)[from..from + count];
                padded.values[to..to + count].copy_from_slice(values);
            });
        }
        padded
    }
}

/// Averages of cells of one size, where there are such.
pub(crate) struct Padded {
    values: Vec<f32>,
    count: [usize; 3],
}

impl Padded {
    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.count[0] * (y + self.count[1] * z)
    }

    /// What [`Cells::at_vertex`] gives for a vertex of the block if all that touches it is here: the mean of eight averages.
    #[inline]
    pub(crate) fn at_vertex(&self, numbers: [u32; 3]) -> Option<f32> {
        let low = self.index(numbers.map(|n| n as usize));
        let mut sum = 0.0;
        for n in 0..8 {
            sum += f64::from(self.values[low + self.index([n & 1, n >> 1 & 1, n >> 2])]);
        }
        sum.is_finite().then_some((sum / 8.0) as f32)
    }
}
