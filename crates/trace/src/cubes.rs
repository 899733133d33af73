//! What rays found out about cubes, for the next ray: of rays through neighbouring pixels most meet the same ones.

use isoray_grid::Scalar;
use isoray_octree::OctreeView;

use crate::branch::{Branch, STEP};
use crate::content::Content;
use crate::corner::{Corner, Facing, Key};
use crate::thresholds::Thresholds;

/// Cubes that are remembered: 40 KB of them.
const SLOT_BITS: u32 = 10;

/// A cube above the blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KnownCube<'a, T: Scalar> {
    key: Key,
    /// The parts that matter, in the order of the rays that it is kept for.
    pub(crate) active: u64,
    pub(crate) branch: Branch<'a, T>,
}

/// Cubes above the blocks, direct-mapped.
#[derive(Clone, Debug)]
pub(crate) struct Cubes<'a, T: Scalar> {
    entries: Box<[KnownCube<'a, T>; 1 << SLOT_BITS]>,
}

impl<'a, T: Scalar> Cubes<'a, T> {
    pub(crate) fn new() -> Self {
        let nothing = KnownCube { key: Key::NONE, active: 0, branch: Branch::nothing() };
        let entries = vec![nothing; 1 << SLOT_BITS].into_boxed_slice();
        let Ok(entries) = entries.try_into() else { unreachable!("made of that many") };
        Self { entries }
    }

    /// Forgets all that was found out.
    pub(crate) fn forget(&mut self) {
        self.entries.iter_mut().for_each(|entry| entry.key = Key::NONE);
    }

    /// What is known about a cube already, if anything is.
    #[inline(always)]
    pub(crate) fn known(&self, corner: Corner, level: u32, facing: Facing) -> Option<&KnownCube<'a, T>> {
        let key = Key::new(corner, level, facing);
        let entry = &self.entries[key.slot(SLOT_BITS) % (1 << SLOT_BITS)];
        (entry.key == key).then_some(entry)
    }

    /// The cube at `corner`: the part at `offset` of `parent`, of `level`.
    #[inline(always)]
    pub(crate) fn part(
        &mut self,
        corner: Corner,
        facing: Facing,
        parent: &Parent<'_, 'a, T>,
        thresholds: &Thresholds<T>,
        content: &impl Content<'a, T>,
    ) -> &KnownCube<'a, T> {
        let key = Key::new(corner, parent.level - STEP, facing);
        let entry = &mut self.entries[key.slot(SLOT_BITS) % (1 << SLOT_BITS)];
        if entry.key != key {
            entry.fill(key, (corner, facing), parent, thresholds, content);
        }
        entry
    }
}

/// How to find a part of a cube.
pub(crate) struct Parent<'p, 'a, T: Scalar> {
    pub(crate) view: &'a OctreeView<'a, T>,
    pub(crate) branch: &'p Branch<'a, T>,
    pub(crate) level: u32,
    /// Of the part.
    pub(crate) offset: u32,
}

impl<'a, T: Scalar> KnownCube<'a, T> {
    #[inline(never)]
    fn fill(
        &mut self,
        key: Key,
        (corner, facing): (Corner, Facing),
        parent: &Parent<'_, 'a, T>,
        thresholds: &Thresholds<T>,
        content: &impl Content<'a, T>,
    ) {
        if self.key.is_of_same_cube(key) {
            self.active = facing.ordered(self.key.facing().ordered(self.active));
        } else {
            self.branch = parent.branch.part(parent.view, parent.level, parent.offset);
            let level = parent.level - STEP;
            let active = self.branch.active(parent.view, level, |node| thresholds.active(node));
            self.active = facing.ordered(content.parts(corner, level, active));
        }
        self.key = key;
    }
}
