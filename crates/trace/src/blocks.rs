//! What rays found out about blocks, for the next ray: which of their cells hold an isovalue, and what that took.

use isoray_grid::Scalar;
use isoray_octree::{Around, Block, NODE_LEVEL, Node, OctreeView};

use crate::branch::{BLOCK_LEVEL, Branch, Eight, STEP};
use crate::corner::{Corner, Facing, Key};
use crate::inside::Inside;
use crate::offset::{SPREAD, axes, lasts};
use crate::thresholds::Thresholds;
use crate::unpacked::{Slot, Unpacked};

/// Cubes on the way from the top to a block, by half their level.
pub(crate) type Branches<'a, T> = [Branch<'a, T>; WAY];
pub(crate) const WAY: usize = 16;

/// A block, and the way that leads to it.
pub struct Way<'w, 'a, T: Scalar> {
    pub(crate) view: &'a OctreeView<'a, T>,
    pub(crate) branches: &'w Branches<'a, T>,
    pub(crate) thresholds: &'w Thresholds<T>,
    pub(crate) corner: Corner,
}

impl<'a, T: Scalar> Way<'_, 'a, T> {
    /// The smallest cube on the way that holds `corner`, of a cube near the block, and its level.
    #[inline(always)]
    fn common(&self, corner: Corner) -> (&Branch<'a, T>, u32) {
        let (from, to) = (self.corner.coordinates(), corner.coordinates());
        let differing = (from[0] ^ to[0]) | (from[1] ^ to[1]) | (from[2] ^ to[2]);
        let level = (u32::BITS - differing.leading_zeros()).next_multiple_of(STEP).max(BLOCK_LEVEL + STEP);
        (&self.branches[(level / STEP) as usize % WAY], level)
    }

    /// A node around the block at `corner`, and its level, if it does not lie in a scalar leaf that is known already.
    pub(crate) fn node(&self, corner: Corner) -> Option<(&'a Node<T::Stored>, u32)> {
        let (branch, level) = self.common(corner);
        branch.node.map(|node| (node, level.min(self.view.root_level())))
    }

    /// The block at `corner`.
    #[inline(never)]
    fn block(&self, corner: Corner) -> Block<'a, T> {
        let (branch, level) = self.common(corner);
        branch.descend(self.view, level, corner.coordinates())
    }

    /// What is around `corner`.
    #[inline(always)]
    pub(crate) fn around(&self, corner: Corner, threshold: T) -> Around<'a, T> {
        let (branch, level) = self.common(corner);
        branch.around(self.view, level, corner.coordinates(), threshold)
    }

    /// The cube of edge 8 that holds the block.
    fn eight(&self) -> Eight<'a, T> {
        let branch = &self.branches[((BLOCK_LEVEL + STEP) / STEP) as usize];
        branch.eight(self.view, axes(self.corner.offset(BLOCK_LEVEL) >> 1))
    }
}

/// What is known about a block.
#[derive(Clone, Debug)]
#[repr(C)]
struct KnownBlock<'a, T: Scalar> {
    key: Key,
    /// The cells that hold an isovalue, in the order of the rays that it is kept for.
    mixed: u64,
    /// The samples that are inside for the first threshold.
    inside: u64,
    block: Block<'a, T>,
}

/// Blocks that are remembered, 200 KB of them; see [`Corner::block_slot`].
const SLOTS: usize = 4096;

/// Blocks, direct-mapped by place, so that those of one window of the volume do not displace each other.
#[derive(Clone, Debug)]
pub(crate) struct Blocks<'a, T: Scalar> {
    entries: Box<[KnownBlock<'a, T>; SLOTS]>,
    unpacked: Unpacked<T>,
}

/// The block at `corner`, if it is known.
#[inline(always)]
fn known<'e, 'a, T: Scalar>(
    entries: &'e [KnownBlock<'a, T>; SLOTS],
    corner: Corner,
) -> Option<&'e KnownBlock<'a, T>> {
    let entry = &entries[corner.block_slot() % SLOTS];
    entry.key.is_of_same_cube(Key::new(corner, BLOCK_LEVEL, entry.key.facing())).then_some(entry)
}

impl<'a, T: Scalar> Blocks<'a, T> {
    pub(crate) fn new() -> Self {
        let nobody = KnownBlock { key: Key::NONE, mixed: 0, inside: 0, block: Block::default() };
        let entries = vec![nobody; SLOTS].into_boxed_slice();
        let Ok(entries) = entries.try_into() else { unreachable!("made of that many") };
        Self { entries, unpacked: Unpacked::new() }
    }

    /// Forgets all that was found out.
    pub(crate) fn forget(&mut self) {
        self.entries.iter_mut().for_each(|entry| entry.key = Key::NONE);
    }

    /// Of the cells `met` of the block on the way, those that hold an isovalue; in the order of rays of this `facing`.
    #[inline(always)]
    pub(crate) fn mixed(&mut self, met: u64, way: &Way<'_, 'a, T>, facing: Facing) -> u64 {
        let slot = way.corner.block_slot() % SLOTS;
        let key = Key::new(way.corner, BLOCK_LEVEL, facing);
        if self.entries[slot].key != key {
            self.turn_to(key, way, facing);
        }
        self.entries[slot].mixed & met
    }

    /// The samples at the corners of the cell at `offset` of the block on the way, x fastest; that block has just been asked for its
    /// mixed cells.
    #[inline(always)]
    pub(crate) fn corners(&mut self, offset: u32, way: &Way<'_, 'a, T>) -> [f32; 8] {
        if lasts(offset) == 0 {
            self.entries[way.corner.block_slot() % SLOTS].block.corners(offset).map(T::to_f32)
        } else {
            self.border_corners(offset, way)
        }
    }

    // More than half of the cells of a block reach into others.
    #[inline(never)]
    fn border_corners(&mut self, offset: u32, way: &Way<'_, 'a, T>) -> [f32; 8] {
        let at_last = axes(lasts(offset));
        let mut slots = [self.unpacked(way.corner, way); 8];
        // The subsets of the axes along which the corners lie in the next block, the largest first.
        let mut direction = at_last;
        while direction != 0 {
            slots[direction as usize & 7] = self.unpacked(way.corner.neighbor(direction, BLOCK_LEVEL), way);
            direction = direction.wrapping_sub(1) & at_last;
        }
        std::array::from_fn(|n| {
            // Along those axes the corner is the first of its block, along the others as far on as it is in the cell.
            let direction = n as u32 & at_last;
            let lowest = offset & !(3 * SPREAD[direction as usize & 7]);
            let at = lowest + SPREAD[(n as u32 ^ direction) as usize & 7];
            self.unpacked.sample(slots[direction as usize & 7], at)
        })
    }

    /// The block at `corner`, unpacked.
    #[inline(always)]
    fn unpacked(&mut self, corner: Corner, way: &Way<'_, 'a, T>) -> Slot {
        let Self { entries, unpacked } = self;
        unpacked
            .slot(corner, || known(entries, corner).map_or_else(|| way.block(corner), |known| known.block))
    }

    /// Turns to the block on the way, or to another order of its cells.
    #[inline(never)]
    fn turn_to(&mut self, key: Key, way: &Way<'_, 'a, T>, facing: Facing) {
        let entry = &mut self.entries[way.corner.block_slot() % SLOTS];
        if entry.key.is_of_same_cube(key) {
            entry.mixed = facing.ordered(entry.key.facing().ordered(entry.mixed));
            entry.key = key;
        } else {
            self.find(way, facing);
        }
    }

    /// Finds out about the block on the way, and about those of the same cube of edge 8 that rays can have to look at: most will be met, and
    /// together they cost little more.
    fn find(&mut self, way: &Way<'_, 'a, T>, facing: Facing) {
        let thresholds = way.thresholds;
        let own = way.eight();
        let this = axes(way.corner.offset(BLOCK_LEVEL));
        let wanted = own.active(|node| thresholds.active(node)) | 1 << this;
        let first = Inside::new(way, &own, wanted, thresholds.first, |corner| {
            known(&self.entries, corner).map(|known| known.inside)
        });
        let mut mixed: [u64; 8] = std::array::from_fn(|octant| first.mixed(octant as u32));
        for &threshold in &thresholds.others {
            let inside = Inside::new(way, &own, wanted, threshold, |_| None);
            (0..8).zip(&mut mixed).for_each(|(octant, mixed)| *mixed |= inside.mixed(octant));
        }
        let corner = way.corner.around(NODE_LEVEL);
        for octant in 0..8 {
            let is_wanted = u64::from(wanted >> octant & 1).wrapping_neg();
            let block = corner.neighbor(octant, BLOCK_LEVEL);
            self.entries[block.block_slot() % SLOTS] = KnownBlock {
                key: Key::new(block, BLOCK_LEVEL, facing),
                mixed: facing.ordered(mixed[octant as usize & 7] & is_wanted),
                inside: first.of(octant),
                block: own.block(way.view, corner.coordinates(), octant),
            };
        }
    }
}
