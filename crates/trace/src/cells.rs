//! Samples at the corners of cells that rays intersected, for the next ray.

use crate::corner::Corner;

/// Cells that are remembered: 160 KB of them.
const SLOT_BITS: u32 = 12;

#[derive(Clone, Copy, Debug)]
#[repr(C)]
struct KnownCell {
    cell: Corner,
    samples: [f32; 8],
}

/// Cells, direct-mapped. What is known stays so whatever the isovalue.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    entries: Box<[KnownCell; 1 << SLOT_BITS]>,
}

impl Cells {
    pub(crate) fn new() -> Self {
        let entries =
            vec![KnownCell { cell: Corner::NONE, samples: [0.0; 8] }; 1 << SLOT_BITS].into_boxed_slice();
        let Ok(entries) = entries.try_into() else { unreachable!("made of that many") };
        Self { entries }
    }

    /// The samples at the corners of a cell, x fastest; `fetch` gets them if they are not known.
    #[inline(always)]
    pub(crate) fn corners(&mut self, cell: Corner, fetch: impl FnOnce() -> [f32; 8]) -> [f32; 8] {
        let entry = &mut self.entries[cell.slot(SLOT_BITS) % (1 << SLOT_BITS)];
        if entry.cell == cell {
            return entry.samples;
        }
        let samples = fetch();
        *entry = KnownCell { cell, samples };
        samples
    }
}
