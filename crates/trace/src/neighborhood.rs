//! A block and its forward neighbours, and the cells in it.
//!
//! A cell's *offset* in its block has two bits an axis, x lowest: it is the place of its low corner in the block's mask. Sets of axes are
//! kept *spread*, on bits 0, 2 and 4, where they can be compared with an offset.

use isoray_grid::Scalar;
use isoray_octree::{Block, CAP_EDGE, OctreeView, Path};

use crate::place::Place;

/// Spread form of a set of axes.
pub(crate) const SPREAD: [u32; 8] = [0, 1, 4, 5, 16, 17, 20, 21];

/// The axes, spread, along which an offset is the last: 3.
#[inline(always)]
pub(crate) fn lasts(offset: u32) -> u32 {
    offset & offset >> 1 & SPREAD[7]
}

/// The plain form of a spread set.
#[inline(always)]
fn axes(spread: u32) -> u32 {
    spread & 1 | spread >> 1 & 2 | spread >> 2 & 4
}

/// What finding a neighbour of a block takes.
pub(crate) struct Find<'w, 'a, T: Scalar> {
    pub(crate) view: &'a OctreeView<'a, T>,
    /// The way down to the block.
    pub(crate) path: &'w Path<'a, T>,
    pub(crate) place: Place,
    pub(crate) threshold: T,
}

/// A block and its seven forward neighbours: which of their samples are inside, and those samples, both found when they are first
/// needed.
///
/// By direction: bit 0 the next block along x, bit 1 y, bit 2 z.
#[derive(Clone, Debug)]
pub(crate) struct Neighborhood<'a, T: Scalar> {
    /// Whose it is: [`Place::key`] of the block's place, or [`NOBODY`].
    key: u64,
    /// Of the block's cells, by offset: those looked at so far, and those among them whose corners lie on both sides of the isovalue.
    tested: u64,
    mixed: u64,
    /// Bit `n`: `inside[n]` is known; bit `8 + n`: `blocks[n]` is.
    known: u32,
    blocks: [Block<'a, T>; 8],
    inside: [u64; 8],
}

/// No block's key.
const NOBODY: u64 = 0;

/// What was found out about blocks that rays went through, for the next ray: of rays through neighbouring pixels most meet the same
/// blocks. Direct-mapped, by place, so that blocks of one window of the volume do not displace each other.
#[derive(Clone, Debug)]
pub(crate) struct Neighborhoods<'a, T: Scalar> {
    entries: Box<[Neighborhood<'a, T>; ENTRIES]>,
}

/// A window of 8³ blocks.
const ENTRIES: usize = 512;

impl<'a, T: Scalar> Neighborhoods<'a, T> {
    pub(crate) fn new() -> Self {
        let nobody = Neighborhood {
            key: NOBODY,
            tested: 0,
            mixed: 0,
            inside: [0; 8],
            blocks: [Block::default(); 8],
            known: 0,
        };
        let entries = vec![nobody; ENTRIES].into_boxed_slice();
        let Ok(entries) = entries.try_into() else { unreachable!("made of that many") };
        Self { entries }
    }

    /// Forgets all that was found out.
    pub(crate) fn forget(&mut self) {
        self.entries.iter_mut().for_each(|entry| entry.key = NOBODY);
    }

    /// What is known about the block at `place`; the block itself, `own`, is asked for if that is nothing.
    #[inline(always)]
    pub(crate) fn of(
        &mut self,
        place: Place,
        threshold: T,
        own: impl FnOnce() -> Block<'a, T>,
    ) -> &mut Neighborhood<'a, T> {
        let key = place.key();
        let entry = &mut self.entries[place.hash() % ENTRIES];
        if entry.key != key {
            let own = own();
            entry.key = key;
            (entry.tested, entry.mixed) = (0, 0);
            entry.inside[0] = own.at_least(threshold);
            entry.blocks[0] = own;
            entry.known = 1 | 1 << 8;
        }
        entry
    }
}

/// By the axes along which a cell touches the next block: the bits, relative to its low corner's, of those corners that lie in one
/// and the same block.
const CORNERS: [u64; 8] = {
    let mut masks = [0; 8];
    let mut at_last = 0;
    while at_last < 8 {
        let mut n = 0;
        while n < 8 {
            if n & at_last == 0 {
                masks[at_last] |= 1 << SPREAD[n];
            }
            n += 1;
        }
        at_last += 1;
    }
    masks
};

impl<'a, T: Scalar> Neighborhood<'a, T> {
    /// Whether the corners of the cell lie on both sides of the isovalue.
    #[inline(always)]
    pub(crate) fn is_mixed(&mut self, find: &Find<'_, 'a, T>, offset: u32) -> bool {
        if self.tested >> offset & 1 == 0 {
            let is_mixed = self.find_mixed(find, offset);
            self.tested |= 1 << offset;
            self.mixed |= u64::from(is_mixed) << offset;
        }
        self.mixed >> offset & 1 == 1
    }

    #[inline(never)]
    fn find_mixed(&mut self, find: &Find<'_, 'a, T>, offset: u32) -> bool {
        let at_last = lasts(offset);
        if at_last == 0 {
            let own = self.inside[0] >> offset & CORNERS[0];
            return own != 0 && own != CORNERS[0];
        }
        let at_last = axes(at_last);
        let corners = CORNERS[at_last as usize & 7];
        let own = self.inside[0] >> offset & corners;
        if own != 0 && own != corners {
            return true;
        }
        // The subsets of the axes, smallest first: those along which the corners lie in the next block.
        let mut direction = 0u32;
        while direction != at_last {
            direction = direction.wrapping_sub(at_last) & at_last;
            // Along those axes the corners are the first of that block.
            let lowest = offset & !(3 * SPREAD[direction as usize & 7]);
            if self.inside(find, direction) >> lowest & corners != own {
                return true;
            }
        }
        false
    }

    /// The eight corner samples of the cell, x fastest.
    #[inline(always)]
    pub(crate) fn corners(&mut self, find: &Find<'_, 'a, T>, offset: u32) -> [T; 8] {
        let at_last = lasts(offset);
        if at_last == 0 {
            return self.blocks[0].corners(offset);
        }
        let at_last = axes(at_last);
        let mut samples = [T::default(); 8];
        for (n, sample) in (0u32..).zip(&mut samples) {
            let direction = n & at_last;
            // Along the direction's axes the corner is the first of its block, along the others as far on as it is in the cell.
            let at = (offset & !(3 * SPREAD[direction as usize & 7])) + SPREAD[(n ^ direction) as usize & 7];
            *sample = self.block(find, direction).sample_at(at);
        }
        samples
    }

    #[inline(always)]
    fn inside(&mut self, find: &Find<'_, 'a, T>, direction: u32) -> u64 {
        if self.known >> direction & 1 == 0 {
            self.find_inside(find, direction);
        }
        self.inside[direction as usize & 7]
    }

    #[inline(always)]
    fn block(&mut self, find: &Find<'_, 'a, T>, direction: u32) -> &Block<'a, T> {
        if self.known >> (8 + direction) & 1 == 0 {
            self.find_block(find, direction);
        }
        &self.blocks[direction as usize & 7]
    }

    #[inline(never)]
    fn find_inside(&mut self, find: &Find<'_, 'a, T>, direction: u32) {
        let [from, to] = find.between(direction);
        self.inside[direction as usize & 7] =
            find.path.neighbor_at_least(find.view, from, to, find.threshold);
        self.known |= 1 << direction;
    }

    #[inline(never)]
    fn find_block(&mut self, find: &Find<'_, 'a, T>, direction: u32) {
        let [from, to] = find.between(direction);
        self.blocks[direction as usize & 7] = find.path.neighbor(find.view, from, to);
        self.known |= 1 << (8 + direction);
    }
}

impl<T: Scalar> Find<'_, '_, T> {
    /// Low corners of the block and of its neighbour in `direction`.
    #[inline(always)]
    fn between(&self, direction: u32) -> [[u32; 3]; 2] {
        let from = self.place.corner();
        [from, std::array::from_fn(|a| from[a] + (direction >> a & 1) * CAP_EDGE)]
    }
}
