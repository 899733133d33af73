//! What a build may hold in memory.

use isoray_grid::{Dims, Scalar};
use isoray_octree::{Counts, Node};

use crate::consolidate::Region;
use crate::strip::{BLOCK_EDGE, Place, Strip};

/// What a build holds at once. The result does not depend on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    /// Strips that are worked on, while as many others are stored.
    pub(crate) band: usize,
    /// Whether a source that is read in order is read while the last slab is worked on.
    pub(crate) reads_ahead: bool,
    /// Bytes of nodes that may wait for the end in memory.
    pub(crate) nodes: usize,
}

/// A limit that is too low, and the least that would do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TooLow(pub(crate) u64);

/// The process itself: stacks, buffers for reading and writing, and what the allocator keeps.
const OVERHEAD: u64 = 24 << 20;
/// Strips for each thread in a band, if there is room: enough that threads seldom wait for each other.
const STRIPS_A_THREAD: u64 = 8;
/// Nodes that wait in memory if there is no limit.
const NODES: u64 = 1 << 30;

impl Plan {
    /// For a volume of that size. `is_streamed`: the source is read in order; it holds `held` bytes itself.
    pub(crate) fn new<T: Scalar>(
        dims: Dims,
        threads: usize,
        limit: Option<u64>,
        is_streamed: bool,
        held: u64,
    ) -> Result<Self, TooLow> {
        let threads = threads as u64;
        let [blocks, rows] = Place { dims, layer: 0, row: 0 }.blocks().map(|n| n as u64);
        let layer_blocks = blocks * u64::from(dims.axes()[1]).div_ceil(BLOCK_EDGE as u64);
        // Two layers of every level, each a quarter of that below it; the nodes that come of them, and their copy that is to be
        // written.
        let levels = 3 * layer_blocks * (size_of::<Region<T>>() + 2 * size_of::<Node<T::Stored>>()) as u64;
        let slab = ((BLOCK_EDGE + 1) * dims.layer() * size_of::<T>()) as u64;
        let counts = Counts::<T>::BYTES as u64;
        // At most all samples of a strip, its regions, and room that growing leaves unused.
        let samples = blocks * rows * (BLOCK_EDGE * BLOCK_EDGE * BLOCK_EDGE * size_of::<T>()) as u64;
        let strip = 2 * (samples + blocks * rows * size_of::<Region<T>>() as u64);
        let fixed = held + OVERHEAD + levels + counts + threads * (Strip::<T>::bytes(dims) + counts);
        let slabs = if is_streamed { slab } else { 0 };
        let least = fixed + slabs + 2 * threads * strip;
        let limit = limit.unwrap_or(u64::MAX / 2);
        let Some(spare) = limit.checked_sub(least) else { return Err(TooLow(least)) };
        let reads_ahead = spare >= 2 * slabs;
        let spare = if reads_ahead { spare - slabs } else { spare };
        let band = threads + (spare / 4 / (2 * strip)).min((STRIPS_A_THREAD - 1) * threads);
        let nodes = (spare / 4).min(NODES);
        Ok(Self { band: band as usize, reads_ahead, nodes: nodes as usize })
    }
}
