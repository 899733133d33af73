//! What the blocks of a volume are to a traversal.

use isoray_cell::{Cubic, Segment, relative};
use isoray_grid::Scalar;
use isoray_octree::OctreeView;

use crate::blocks::{Blocks, Way};
use crate::cells::Cells;
use crate::corner::{Corner, Facing};
use crate::ray::ClippedRay;
use crate::region::Region;
use crate::thresholds::Thresholds;

/// The blocks of a volume or of one of its levels of detail, and what rays found out about them.
pub trait Content<'a, T: Scalar> {
    /// Whether what it found out holds for these isovalues.
    fn is_for(&self, isovalues: &[f32]) -> bool;

    /// Turns to other isovalues, and forgets what it found out.
    fn turn_to(&mut self, isovalues: &[f32]);

    /// A box of all that can matter.
    fn region(&self, view: &'a OctreeView<'a, T>, thresholds: &Thresholds<T>) -> Option<Region>;

    /// The parts that matter of a cube of `level` at `corner`, in the order of the lattice, if by their ranges those `active` do.
    fn parts(&self, corner: Corner, level: u32, active: u64) -> u64;

    /// Of the cells `met` of the block on the way, those that hold an isovalue; in the order of rays of this `facing`.
    fn mixed(&mut self, met: u64, way: &Way<'_, 'a, T>, facing: Facing) -> u64;

    /// The samples at the corners of the cell at `offset` of the block on the way, x fastest; that block has just been asked for its mixed cells.
    fn samples(&mut self, offset: u32, way: &Way<'_, 'a, T>) -> [f32; 8];

    /// The same, from the root down to each corner; or as they are, where they cannot be found so.
    fn samples_afresh(&mut self, offset: u32, way: &Way<'_, 'a, T>) -> [f32; 8] {
        self.samples(offset, way)
    }

    /// The cells of that block, in the order of the lattice, that cannot be intersected like others.
    fn peculiar(&self, way: &Way<'_, 'a, T>) -> u64;

    /// What the ray sees just before and just behind its stretch in the cell at `offset` of that block, where other arithmetic goes there.
    fn beyond(
        &mut self,
        ray: &ClippedRay,
        way: &Way<'_, 'a, T>,
        offset: u32,
        interval: [f64; 2],
    ) -> [Option<Beyond>; 2];
}

/// The stretch before or behind one, in a cell whose values on the common face are the same but for rounding.
#[derive(Clone, Copy, Debug)]
pub struct Beyond {
    /// At the cell's corners.
    pub samples: [f32; 8],
    /// Cell-local.
    pub segment: Segment,
}

impl Beyond {
    /// Whether the stretch begins inside of the isosurface, and ends there.
    pub(crate) fn sides(&self, isovalue: f32) -> [bool; 2] {
        let cubic = Cubic::along(&relative(&self.samples, isovalue), &self.segment);
        [cubic.starts_inside(), cubic.ends_inside()]
    }

    /// Whether the cell has corners on both sides, so that it is visited too.
    pub(crate) fn is_mixed(&self, isovalue: f32) -> bool {
        let inside = self.samples.iter().filter(|&&s| s >= isovalue).count();
        !matches!(inside, 0 | 8)
    }
}

/// The samples of an octree volume, as they are.
#[derive(Clone, Debug)]
pub struct Finest<'a, T: Scalar> {
    blocks: Blocks<'a, T>,
    cells: Cells,
}

impl<T: Scalar> Finest<'_, T> {
    pub(crate) fn new() -> Self {
        Self { blocks: Blocks::new(), cells: Cells::new() }
    }
}

impl<'a, T: Scalar> Content<'a, T> for Finest<'a, T> {
    /// The thresholds tell.
    #[inline(always)]
    fn is_for(&self, _: &[f32]) -> bool {
        true
    }

    fn turn_to(&mut self, _: &[f32]) {
        self.blocks.forget();
    }

    fn region(&self, view: &'a OctreeView<'a, T>, thresholds: &Thresholds<T>) -> Option<Region> {
        Region::new(view, |node| thresholds.active(node))
    }

    #[inline(always)]
    fn parts(&self, _: Corner, _: u32, active: u64) -> u64 {
        active
    }

    #[inline(always)]
    fn mixed(&mut self, met: u64, way: &Way<'_, 'a, T>, facing: Facing) -> u64 {
        self.blocks.mixed(met, way, facing)
    }

    #[inline(always)]
    fn samples(&mut self, offset: u32, way: &Way<'_, 'a, T>) -> [f32; 8] {
        self.cells.corners(way.corner.of_part(offset, 0), || self.blocks.corners(offset, way))
    }

    fn samples_afresh(&mut self, offset: u32, way: &Way<'_, 'a, T>) -> [f32; 8] {
        way.view.corners(way.corner.of_part(offset, 0).coordinates()).map(T::to_f32)
    }

    #[inline(always)]
    fn peculiar(&self, _: &Way<'_, 'a, T>) -> u64 {
        0
    }

    #[inline(always)]
    fn beyond(&mut self, _: &ClippedRay, _: &Way<'_, 'a, T>, _: u32, _: [f64; 2]) -> [Option<Beyond>; 2] {
        [None, None]
    }
}
