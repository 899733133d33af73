//! Samples of the blocks in which rays intersect cells, unpacked, for the next cells there.

use isoray_grid::Scalar;
use isoray_octree::{Block, CAP_SAMPLES};

use crate::corner::Corner;

/// Blocks that are remembered, 70 to 270 KB of them: those of a window of 4 by 16 by 16; see [`Corner::block_slot`].
const SLOTS: usize = 1024;

#[derive(Clone, Copy, Debug)]
#[repr(C)]
struct UnpackedBlock<T> {
    corner: Corner,
    /// `x + 4y + 16z`.
    samples: [T; CAP_SAMPLES],
}

/// Unpacked blocks, direct-mapped by place: the eight around a cell do not displace each other.
#[derive(Clone, Debug)]
pub(crate) struct Unpacked<T> {
    entries: Box<[UnpackedBlock<T>; SLOTS]>,
}

/// Where an unpacked block is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slot(usize);

impl<T: Scalar> Unpacked<T> {
    pub(crate) fn new() -> Self {
        let nobody = UnpackedBlock { corner: Corner::NONE, samples: [T::default(); CAP_SAMPLES] };
        let entries = vec![nobody; SLOTS].into_boxed_slice();
        let Ok(entries) = entries.try_into() else { unreachable!("made of that many") };
        Self { entries }
    }

    /// Where the block at `corner` is; `fetch` gets it if it is not there yet.
    #[inline(always)]
    pub(crate) fn slot<'a>(&mut self, corner: Corner, fetch: impl FnOnce() -> Block<'a, T>) -> Slot {
        let slot = corner.block_slot() % SLOTS;
        let entry = &mut self.entries[slot];
        if entry.corner != corner {
            *entry = UnpackedBlock { corner, samples: fetch().samples() };
        }
        Slot(slot)
    }

    #[inline(always)]
    pub(crate) fn sample(&self, Slot(slot): Slot, at: u32) -> f32 {
        self.entries[slot % SLOTS].samples[at as usize % CAP_SAMPLES].to_f32()
    }
}
