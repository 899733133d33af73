//! The mesh.

use std::borrow::Borrow;

use glam::DAffine3;
use isoray_grid::Dims;

use crate::block::for_all;
use crate::boxes::{LevelBox, outlines};
use crate::bricks::{Brick, Bricks, EDGE, Layout, corners};
use crate::cells::{Border, Cells, averages};
use crate::error::MeshError;
use crate::hybrid::{Split, part_corners};
use crate::levels::Levels;
use crate::overlap::{Placed, disjoint, filled, left_of};
use crate::patches::{Centering, Patches};
use crate::skeleton::{LeafCell, Skeleton};
use crate::tree::{NoTree, Node, SplitRule, Tree};
use crate::vertices;

/// How a mesh is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshOptions {
    /// Of values at cells: what becomes of the field at the border of the domain.
    pub border: Border,
    /// How the tree is cut.
    pub rule: SplitRule,
}

/// An adaptive mesh with its field, which is continuous everywhere.
///
/// Its index space is the lattice of the finest cells, from the domain's low corner on: a cell of a coarser level is a cube of a power of two of them.
#[derive(Clone, Debug)]
pub struct Mesh {
    dims: Dims,
    index_to_world: DAffine3,
    levels: Levels,
    pub(crate) skeleton: Skeleton,
    outlines: Vec<LevelBox>,
    pub(crate) values: Vec<f32>,
    pub(crate) bricks: Bricks,
    /// By node of the tree: the least and the largest value; the first is larger if there is none.
    pub(crate) ranges: Vec<[f32; 2]>,
    /// By node: whether some of its cells are empty and some are not; nothing, if no cell of the mesh is empty.
    gaps: Vec<bool>,
    empty: u64,
}

/// What a mesh is made of, in numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshSize {
    /// Cells that no finer ones cover, by level.
    pub leaves: Vec<u64>,
    /// Of these, those that finer ones touch, so that they are taken apart.
    pub hybrid: u64,
    /// Boxes of cells of one level.
    pub blocks: u64,
    /// Nodes of the tree, boxes among them.
    pub nodes: u64,
    /// What all of it takes in memory.
    pub bytes: u64,
}

/// A cube in which the field is trilinear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Its low corner, in index space.
    pub low: [u32; 3],
    /// Its edge there, a power of two.
    pub edge: u32,
    /// The values at its corners, x fastest.
    pub corners: [f32; 8],
}

impl Mesh {
    /// Takes patches together. Of those that are handed over and not lent, the values are dropped as soon as they aren't needed, which keeps the peak of memory low.
    ///
    /// # Errors
    /// Patches that contradict each other or the domain, or that leave gaps; see [`MeshError`].
    pub fn new(patches: impl Borrow<Patches>, options: MeshOptions) -> Result<Self, MeshError> {
        let source: &Patches = patches.borrow();
        let centering = source.centering;
        let levels = Levels::new(source)?;
        let places = source.patches.iter().enumerate();
        let places: Vec<_> =
            places.map(|(number, patch)| levels.place(number, patch, centering)).collect::<Result<_, _>>()?;
        let placed = disjoint(&levels, &source.patches, &places, centering)?;
        let count = levels.count() as u32;
        let parts = filled(&placed, count);
        let tree = Tree::new(levels.domain, &parts, count, |level| levels.exponent(level), options.rule);
        let tree = tree.map_err(|none| refusal(none, &levels, &placed))?;
        let skeleton = Skeleton::new(&levels, &tree);
        let (dims, index_to_world) = (levels.dims()?, levels.index_to_world(source.index_to_world));
        let outlines = outlines(&levels, source, &places, &skeleton);
        let (values, empty) = match centering {
            Centering::Cells => {
                let averages = averages(&skeleton, &levels, &tree, (&source.patches, &places));
                drop(patches);
                let cells = Cells::new(&skeleton, averages, options.border);
                let values = vertices::from_cells(&skeleton, &cells);
                (values, cells.empty())
            }
            Centering::Vertices => {
                let of = vertices::from_vertices(&skeleton, &levels, &tree, &source.patches, &places);
                drop(patches);
                of
            }
        };
        let bricks = Bricks::new(&skeleton, &values, &empty);
        let ranges = ranges(&skeleton, &bricks);
        let empty = empty.count();
        let gaps = if empty > 0 { gaps(&skeleton, &bricks, &ranges) } else { Vec::new() };
        Ok(Self { dims, index_to_world, levels, skeleton, outlines, values, bricks, ranges, gaps, empty })
    }

    /// Points of the finest lattice along each axis.
    pub fn dims(&self) -> Dims {
        self.dims
    }

    /// From index space to the world.
    pub fn index_to_world(&self) -> DAffine3 {
        self.index_to_world
    }

    /// The least and the largest value of the field; `None` if all of it is empty.
    pub fn range(&self) -> Option<[f32; 2]> {
        self.ranges.first().copied().filter(|range| range[0] <= range[1])
    }

    /// How much of the volume has which values: as many finest cells, by the value at a corner, in equal bins over the range; the last one includes its upper end.
    pub fn histogram<const BINS: usize>(&self) -> [u64; BINS] {
        let mut bins = [0; BINS];
        let Some([low, high]) = self.range() else { return bins };
        let scale = BINS as f64 / (f64::from(high) - f64::from(low)).max(f64::MIN_POSITIVE);
        for block in &self.skeleton.blocks {
            for_all(block.cells(), |at| {
                let value = self.values[block.first + block.vertex_index(at)];
                if value.is_finite() {
                    let bin = ((f64::from(value) - f64::from(low)) * scale) as usize;
                    bins[bin.min(BINS - 1)] += 1 << (3 * block.exponent);
                }
            });
        }
        bins
    }

    /// The boxes that show what it is made of: the patches, in their order; or, if all of them are single cells, as those of an octree are, boxes that cells of one size make.
    pub fn outlines(&self) -> &[LevelBox] {
        &self.outlines
    }

    /// Whether some cells below a node are empty and some are not.
    pub(crate) fn has_gaps(&self, node: u32) -> bool {
        self.empty > 0 && self.gaps[node as usize]
    }

    /// Whether that may be so of a brick.
    pub(crate) fn may_have_gaps(&self, brick: &Brick) -> bool {
        self.empty > 0 && brick.own != u64::MAX && brick.range[0] <= brick.range[1]
    }

    /// Cells without a value of their own, which are not drawn.
    pub fn empty_cells(&self) -> u64 {
        self.empty
    }

    /// What it is made of.
    pub fn size(&self) -> MeshSize {
        let mut leaves = vec![0; self.levels.count()];
        for block in &self.skeleton.blocks {
            let level = (0..self.levels.count() as u32).find(|&l| self.levels.exponent(l) == block.exponent);
            leaves[level.unwrap_or_default() as usize] += block.cell_count() as u64;
        }
        let Bricks { bricks, first, splits } = &self.bricks;
        let bytes = size_of_val(&self.skeleton.nodes[..])
            + size_of_val(&self.skeleton.blocks[..])
            + size_of_val(&self.outlines[..])
            + size_of_val(&self.values[..])
            + size_of_val(&self.ranges[..])
            + size_of_val(&self.gaps[..])
            + size_of_val(&bricks[..])
            + size_of_val(&first[..])
            + size_of_val(&splits[..]);
        MeshSize {
            leaves,
            hybrid: bricks.iter().map(|brick| u64::from(brick.split.count_ones())).sum(),
            blocks: self.skeleton.blocks.len() as u64,
            nodes: self.skeleton.nodes.len() as u64,
            bytes: bytes as u64,
        }
    }

    /// The cube in which the field is trilinear around a point of the domain, in index space, towards the octant of these signs where several meet: bit `a` of `octant`
    /// for larger coordinates. `None` outside of the domain, and in an empty cell.
    pub fn piece(&self, point: [f64; 3], octant: u32) -> Option<Piece> {
        let (leaf, p, octant) = self.leaf_around(point, octant)?;
        self.piece_of_leaf(&leaf, p, octant)
    }

    /// The leaf there, the point of the lattice below, and towards which octant it is from that.
    fn leaf_around(&self, point: [f64; 3], octant: u32) -> Option<(LeafCell, [u32; 3], u32)> {
        let towards = |a: usize| octant >> a & 1 == 1;
        let floor = point.map(f64::floor);
        let is_inside =
            (0..3).all(|a| floor[a] >= 0.0 && floor[a] <= f64::from(self.skeleton.domain.high[a]));
        if !is_inside {
            return None;
        }
        let p = floor.map(|c| c as u32);
        // Between points of the lattice the octant is the upper one.
        let octant = (0..3).filter(|&a| point[a] > floor[a] || towards(a)).fold(0, |bits, a| bits | 1 << a);
        Some((self.skeleton.leaf(p, octant)?, p, octant))
    }

    /// The brick that a leaf is of, and its offset there.
    fn brick_of(&self, leaf: &LeafCell) -> (&Brick, u32) {
        let block = &self.skeleton.blocks[leaf.block as usize];
        let layout = Layout::new(block);
        let cell: [u32; 3] = std::array::from_fn(|a| layout.cells[0][a] + leaf.numbers[a]);
        let brick = self.bricks.first[leaf.block as usize] + layout.index(cell.map(|c| c / EDGE));
        let [x, y, z] = cell.map(|c| c % EDGE);
        (&self.bricks.bricks[brick as usize], x | y << 2 | z << 4)
    }

    fn piece_of_leaf(&self, leaf: &LeafCell, p: [u32; 3], octant: u32) -> Option<Piece> {
        let block = &self.skeleton.blocks[leaf.block as usize];
        let (brick, offset) = self.brick_of(leaf);
        if brick.own >> offset & 1 == 0 {
            return None;
        }
        let corners = corners(&self.values, block, leaf.numbers);
        let mut piece = Piece { low: leaf.low, edge: leaf.edge(), corners };
        let mut split = (brick.split >> offset & 1 == 1).then(|| {
            let before = brick.split & ((1 << offset) - 1);
            &self.bricks.splits[(brick.first + before.count_ones()) as usize]
        });
        while let Some(Split { values, .. }) = split {
            let half = piece.edge / 2;
            let middle = piece.low.map(|c| c + half);
            let part = (0..3)
                .filter(|&a| p[a] > middle[a] || p[a] == middle[a] && octant >> a & 1 == 1)
                .fold(0u32, |part, a| part | 1 << a);
            let low = std::array::from_fn(|a| piece.low[a] + if part >> a & 1 == 1 { half } else { 0 });
            piece = Piece { low, edge: half, corners: part_corners(values, part) };
            split = split.and_then(|split| split.part(part, &self.bricks.splits));
        }
        Some(piece)
    }

    /// What is known of the values around a point without looking at them, by which rays pass by: the range over the 4³ cells that it lies among.
    pub fn range_around(&self, point: [f64; 3], octant: u32) -> Option<[f32; 2]> {
        let (leaf, ..) = self.leaf_around(point, octant)?;
        Some(self.brick_of(&leaf).0.range)
    }

    /// The field at a point, in index space; towards the octant of these signs where several cells meet, which agree but for rounding.
    pub fn value(&self, point: [f64; 3], octant: u32) -> Option<f64> {
        let Piece { low, edge, corners } = self.piece(point, octant)?;
        let local: [f64; 3] = std::array::from_fn(|a| (point[a] - f64::from(low[a])) / f64::from(edge));
        let value = (0..8).map(|n| {
            let weight = |a: usize| if n >> a & 1 == 1 { local[a] } else { 1.0 - local[a] };
            weight(0) * weight(1) * weight(2) * f64::from(corners[n])
        });
        let value: f64 = value.sum();
        value.is_finite().then_some(value)
    }
}

/// By node: the range of the values below. Parts stand behind their whole.
fn ranges(skeleton: &Skeleton, bricks: &Bricks) -> Vec<[f32; 2]> {
    let join = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    let nothing = [f32::INFINITY, f32::NEG_INFINITY];
    let mut ranges = vec![nothing; skeleton.nodes.len()];
    for (number, node) in skeleton.nodes.iter().enumerate().rev() {
        ranges[number] = match *node {
            Node::Split { parts, .. } => join(ranges[parts[0] as usize], ranges[parts[1] as usize]),
            Node::Leaf(block) => {
                bricks.of_block(block).iter().fold(nothing, |range, brick| join(range, brick.range))
            }
        };
    }
    ranges
}

/// By node: whether some of the cells below are empty and some are not. Parts stand behind their whole.
fn gaps(skeleton: &Skeleton, bricks: &Bricks, ranges: &[[f32; 2]]) -> Vec<bool> {
    let mut has_empty = vec![false; skeleton.nodes.len()];
    for (number, node) in skeleton.nodes.iter().enumerate().rev() {
        has_empty[number] = match *node {
            Node::Split { parts, .. } => parts.iter().any(|&part| has_empty[part as usize]),
            Node::Leaf(block) => {
                let own = bricks.of_block(block).iter().map(|brick| brick.own.count_ones() as usize);
                own.sum::<usize>() < skeleton.blocks[block as usize].cell_count()
            }
        };
    }
    has_empty.iter().zip(ranges).map(|(&empty, range)| empty && range[0] <= range[1]).collect()
}

/// Why there is no tree of these patches.
fn refusal(none: NoTree, levels: &Levels, placed: &[Placed]) -> MeshError {
    match none {
        NoTree::Gap(place) => {
            let left = left_of(place, placed.iter().map(|part| part.place));
            let gap = left.first().copied().unwrap_or(place);
            let level = levels.count() as u32 - 1;
            let cells = [gap.low, gap.high.map(|c| c - 1)].map(|cell| levels.numbered(level, cell));
            MeshError::Gap { level, cells }
        }
        NoTree::Cuts(place, coarser) => {
            // Some patch has a face that is not one of these cells'.
            let edge = 1u32 << levels.exponent(coarser);
            let cut = |part: &Placed| {
                let inside = part.place.common(&place).filter(|_| part.level > coarser)?;
                let faces = |corner: [u32; 3]| (0..3).any(|a| !corner[a].is_multiple_of(edge));
                let corner = [inside.low, inside.high.map(|c| c - 1)];
                let is_cutting = [faces(inside.low), faces(inside.high)];
                let at = is_cutting.iter().position(|&cuts| cuts)?;
                Some((part.patch as usize, part.level, levels.numbered(coarser, corner[at])))
            };
            let found = placed.iter().find_map(cut);
            let (patch, level, cell) = found.unwrap_or((0, coarser, levels.numbered(coarser, place.low)));
            MeshError::Cuts { patch, level, coarser, cell }
        }
    }
}
