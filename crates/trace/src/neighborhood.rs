//! A block and its forward neighbours, and the cells in it.
//!
//! A cell's *offset* in its block has two bits an axis, x lowest: it is the place of its low corner in the block's mask. Sets of axes are
//! kept *spread*, on bits 0, 2 and 4, where they can be compared with an offset.

use isoray_grid::Scalar;
use isoray_octree::{Block, CAP_EDGE, CAP_SAMPLES, OctreeView, Path};

use crate::place::Place;

/// Spread form of a set of axes.
pub(crate) const SPREAD: [u32; 8] = [0, 1, 4, 5, 16, 17, 20, 21];

/// A bit that no spread set of axes has.
pub(crate) const ALWAYS: u32 = 1 << 6;

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
/// needed. Kept from block to block, so that nothing need be cleared.
///
/// By direction: bit 0 the next block along x, bit 1 y, bit 2 z.
#[derive(Clone, Debug)]
pub(crate) struct Neighborhood<'a, T: Scalar> {
    inside: [u64; 8],
    blocks: [Block<'a, T>; 8],
    /// Bit `n`: `inside[n]` is known; bit `8 + n`: `blocks[n]` is.
    known: u32,
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
    pub(crate) fn new() -> Self {
        Self { inside: [0; 8], blocks: [Block::default(); 8], known: 0 }
    }

    #[inline(always)]
    pub(crate) fn begin(&mut self, own: Block<'a, T>, threshold: T) {
        self.inside[0] = own.at_least(threshold);
        self.blocks[0] = own;
        self.known = 1 | 1 << 8;
    }

    /// Whether the corners of the cell lie on both sides of the isovalue.
    #[inline(always)]
    pub(crate) fn is_mixed(&mut self, find: &Find<'_, 'a, T>, offset: u32) -> bool {
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
        if let (0, Some(cap)) = (at_last, self.blocks[0].whole_cap()) {
            return std::array::from_fn(|n| cap[(offset + SPREAD[n]) as usize & (CAP_SAMPLES - 1)].into());
        }
        let at_last = axes(at_last);
        let mut samples = [T::default(); 8];
        for (n, sample) in (0..).zip(&mut samples) {
            let at = std::array::from_fn(|a| ((offset >> (2 * a) & 3) + (n >> a & 1)) & 3);
            *sample = self.block(find, n & at_last).sample(at);
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
