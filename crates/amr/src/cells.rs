//! Averages of cells, and what follows from them at vertices.

use rayon::prelude::*;

use crate::block::for_all;
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
    /// By block: x fastest.
    values: Vec<Vec<f32>>,
    border: Border,
}

impl<'s> Cells<'s> {
    pub(crate) fn new(
        skeleton: &'s Skeleton,
        levels: &Levels,
        tree: &Tree,
        (patches, places): (&[Patch], &[Cuboid]),
        border: Border,
    ) -> Self {
        let values = skeleton.blocks.par_iter().zip(&tree.leaves).map(|(block, leaf)| {
            let mut values = vec![f32::NAN; block.cell_count()];
            for &patch in &leaf.patches {
                let (patch, place) = (&patches[patch as usize], &places[patch as usize]);
                let Some(common) = place.common(&block.place) else { continue };
                let count = common.edges().map(|n| n >> block.exponent);
                for_all([1, count[1], count[2]], |[_, y, z]| {
                    let row: [u32; 3] =
                        std::array::from_fn(|a| common.low[a] + ([0, y, z][a] << block.exponent));
                    let from = index(patch, place, row, levels, Centering::Cells);
                    let to = block.cell_index(block.cell_at(row, 7));
                    let count = count[0] as usize;
                    values[to..to + count].copy_from_slice(&patch.values[from..from + count]);
                });
            }
            values
        });
        Self { skeleton, values: values.collect(), border }
    }

    /// The leaves without an average.
    pub(crate) fn empty(&self) -> Empty {
        Empty::new(self.skeleton, |number, block, note| {
            for_all(block.cells(), |at| {
                if !self.values[number][block.cell_index(at)].is_finite() {
                    note(at);
                }
            });
        })
    }

    /// The average of a leaf, unless it is empty.
    fn value(&self, leaf: &LeafCell) -> Option<f64> {
        let block = &self.skeleton.blocks[leaf.block as usize];
        let value = self.values[leaf.block as usize][block.cell_index(leaf.numbers)];
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
            (0..3).fold(*value, |there, a| {
                let at = f64::from(p[a]) + if octant >> a & 1 == 1 { half } else { -half };
                let off = at - (f64::from(leaf.low[a]) + f64::from(leaf.edge()) / 2.0);
                if off == 0.0 { there } else { there + off * self.slope(leaf, *value, a) }
            })
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

    /// The same for a vertex inside a block, unless something there is empty: the mean of eight averages.
    #[inline]
    pub(crate) fn at_inner_vertex(&self, block: usize, numbers: [u32; 3]) -> Option<f32> {
        let of = &self.skeleton.blocks[block];
        let [nx, ny, _] = of.cells().map(|n| n as usize);
        let low = of.cell_index(numbers.map(|n| n - 1));
        let values = &self.values[block];
        let mut sum = 0.0;
        for n in 0..8 {
            sum += f64::from(values[low + (n & 1) + nx * ((n >> 1 & 1) + ny * (n >> 2))]);
        }
        sum.is_finite().then_some((sum / 8.0) as f32)
    }
}
