//! A block and its forward neighbours.

use isoray_grid::Scalar;
use isoray_octree::{Block, CAP_EDGE, CAP_SAMPLES, OctreeView, Path};

use crate::block::{LAST, STRIDES, Steps};

/// What finding a neighbour of a block takes.
pub(crate) struct Find<'w, 'a, T: Scalar> {
    pub(crate) view: &'a OctreeView<'a, T>,
    /// The way down to the block.
    pub(crate) path: &'w Path<'a, T>,
    /// Its low corner.
    pub(crate) origin: [u32; 3],
    pub(crate) threshold: T,
}

/// A block, and which of its samples are inside.
#[derive(Clone, Copy, Debug)]
struct Neighbor<'a, T: Scalar> {
    block: Block<'a, T>,
    inside: u64,
}

/// A block and its seven forward neighbours, found when they are first needed. Kept from block to block, so
/// that nothing need be cleared.
#[derive(Clone, Debug)]
pub(crate) struct Neighborhood<'a, T: Scalar> {
    /// By direction: bit 0 the next block along x, bit 1 y, bit 2 z.
    blocks: [Neighbor<'a, T>; 8],
    /// Bit `n`: `blocks[n]` is known.
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
                masks[at_last as usize] |= 1 << corner_bit(n);
            }
            n += 1;
        }
        at_last += 1;
    }
    masks
};

/// Distance of corner `n` from the low corner in a block's mask.
const fn corner_bit(n: u32) -> u32 {
    (n & 1) * STRIDES[0] + (n >> 1 & 1) * STRIDES[1] + (n >> 2 & 1) * STRIDES[2]
}

impl<'a, T: Scalar> Neighborhood<'a, T> {
    pub(crate) fn new() -> Self {
        Self { blocks: [Neighbor { block: Block::default(), inside: 0 }; 8], known: 0 }
    }

    #[inline(always)]
    pub(crate) fn begin(&mut self, own: Block<'a, T>, threshold: T) {
        self.blocks[0] = Neighbor { block: own, inside: own.at_least(threshold) };
        self.known = 1;
    }

    /// Whether the corners of the cell lie on both sides of the isovalue.
    #[inline(always)]
    pub(crate) fn is_mixed(&mut self, find: &Find<'_, 'a, T>, steps: &Steps, at_last: u32) -> bool {
        let corners = CORNERS[at_last as usize];
        let own = self.blocks[0].inside >> steps.bit() & corners;
        if own != 0 && own != corners {
            return true;
        }
        // The subsets of the axes, smallest first: those along which the corners lie in the next block.
        let mut direction = 0u32;
        while direction != at_last {
            direction = direction.wrapping_sub(at_last) & at_last;
            let next = self.neighbor(find, direction).inside >> bit_in(steps, direction) & corners;
            if next != own {
                return true;
            }
        }
        false
    }

    /// The eight corner samples, x fastest, once [`is_mixed`](Self::is_mixed) has not found the cell to be of one side.
    #[inline(always)]
    pub(crate) fn corners(&mut self, find: &Find<'_, 'a, T>, steps: &Steps, at_last: u32) -> [T; 8] {
        if let (0, Some(cap)) = (at_last, self.blocks[0].block.whole_cap()) {
            let low = steps.bit();
            return std::array::from_fn(|n| {
                cap[((low + corner_bit(n as u32)) & (CAP_SAMPLES as u32 - 1)) as usize].into()
            });
        }
        let mut samples = [T::default(); 8];
        for n in 0..8 {
            let direction = n & at_last;
            let at: [u32; 3] = std::array::from_fn(|a| (steps.offset(a) + (n >> a & 1)) & LAST);
            samples[n as usize] = self.neighbor(find, direction).block.sample(at);
        }
        samples
    }

    #[inline(always)]
    fn neighbor(&mut self, find: &Find<'_, 'a, T>, direction: u32) -> &Neighbor<'a, T> {
        if self.known >> direction & 1 == 0 {
            self.look_up(find, direction);
        }
        &self.blocks[direction as usize & 7]
    }

    #[inline(never)]
    fn look_up(&mut self, find: &Find<'_, 'a, T>, direction: u32) {
        let to = std::array::from_fn(|a| find.origin[a] + (direction >> a & 1) * CAP_EDGE);
        let block = find.path.neighbor(find.view, find.origin, to);
        self.blocks[direction as usize & 7] = Neighbor { block, inside: block.at_least(find.threshold) };
        self.known |= 1 << direction;
    }
}

/// Bit, in the mask of the block in `direction`, of the corner of the cell that is lowest there.
#[inline(always)]
fn bit_in(steps: &Steps, direction: u32) -> u32 {
    (0..3).map(|a| if direction >> a & 1 == 1 { 0 } else { steps.offset(a) * STRIDES[a] }).sum()
}
