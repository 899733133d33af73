//! Blocks with one layer of their forward neighbours' samples, as numbers to compute with.

use isoray_grid::Scalar;
use isoray_octree::{Block, CAP_EDGE, OctreeView, Path};
use isoray_preint::Visibility;

use crate::place::Place;

/// Samples along an edge: those at the corners of a block's cells.
const EDGE: usize = CAP_EDGE as usize + 1;

/// The samples at the corners of a block's cells, x fastest.
#[derive(Clone, Debug)]
pub(crate) struct Brick {
    /// Whose it is: [`Place::key`] of the block's place, or [`NOBODY`].
    key: u64,
    /// The cells that are visible and whose corners are finite, by offset.
    shown: u64,
    samples: [f32; EDGE * EDGE * EDGE],
}

/// No block's key.
const NOBODY: u64 = 0;

/// Bricks of the blocks that rays went through, for the next ray. Direct-mapped; a ray through a large volume and its neighbours meet some
/// hundred.
#[derive(Clone, Debug)]
pub(crate) struct Bricks {
    entries: Box<[Brick]>,
}

/// A megabyte of bricks, of which what a tile needs stays in the nearer caches.
const ENTRY_BITS: u32 = 11;

impl Bricks {
    pub(crate) fn new() -> Self {
        let nobody = Brick { key: NOBODY, shown: 0, samples: [0.0; EDGE * EDGE * EDGE] };
        Self { entries: vec![nobody; 1 << ENTRY_BITS].into_boxed_slice() }
    }

    /// The brick at `place`; `fill` makes one.
    #[inline(always)]
    pub(crate) fn of(&mut self, place: Place, fill: impl FnOnce(&mut Brick)) -> &Brick {
        let key = place.key();
        // Fibonacci hashing (Knuth, The Art of Computer Programming 3, section 6.4): blocks in a row along any axis are spread.
        let at = key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (u64::BITS - ENTRY_BITS);
        let entry = &mut self.entries[at as usize];
        if entry.key != key {
            fill(entry);
            entry.key = key;
        }
        entry
    }
}

/// As many are compared with all cells at once; of more, the one that each cell can meet is searched for.
const FEW_RANGES: usize = 8;

impl Brick {
    /// The cells that are to be integrated, by offset: `x + 4y + 16z`.
    #[inline(always)]
    pub(crate) fn shown(&self) -> u64 {
        self.shown
    }

    /// Corner values of the cell at `offset`, x fastest.
    #[inline(always)]
    pub(crate) fn corners(&self, offset: u32) -> [f32; 8] {
        let [x, y, z] = [offset & 3, offset >> 2 & 3, offset >> 4 & 3].map(|c| c as usize);
        let low = x + EDGE * (y + EDGE * z);
        // One check for all.
        const REACH: usize = 1 + EDGE + EDGE * EDGE + 1;
        let near = &self.samples[low..low + REACH];
        std::array::from_fn(|n| near[(n & 1) + EDGE * (n >> 1 & 1) + EDGE * EDGE * (n >> 2)])
    }

    /// Fetches the samples of the block at `place`, which is `own`, and of its neighbours.
    #[inline(never)]
    pub(crate) fn fill<'a, T: Scalar>(
        &mut self,
        view: &OctreeView<'a, T>,
        path: &Path<'a, T>,
        place: Place,
        own: Block<'a, T>,
        visible: &Visibility,
    ) {
        let from = place.corner();
        let dims = view.dims().axes();
        // Samples beyond the domain do not exist; cells that would have them are none.
        let inside: [usize; 3] =
            std::array::from_fn(|a| (dims[a] - from[a].min(dims[a])).min(EDGE as u32) as usize);
        if inside != [EDGE; 3] {
            self.samples.fill(f32::NAN);
        }
        for direction in 0..8u32 {
            let step: [usize; 3] = std::array::from_fn(|a| (direction >> a & 1) as usize);
            // Along an axis, samples 0 to 3 are the block's own, and sample 4 its neighbour's first.
            let range = |a: usize| if step[a] == 1 { 4..inside[a].max(4) } else { 0..inside[a].min(4) };
            if (0..3).any(|a| range(a).is_empty()) {
                continue;
            }
            let block = match direction {
                0 => own,
                _ => path.neighbor(view, from, std::array::from_fn(|a| from[a] + step[a] as u32 * CAP_EDGE)),
            };
            for z in range(2) {
                for y in range(1) {
                    for x in range(0) {
                        let bit = (x & 3 | (y & 3) << 2 | (z & 3) << 4) as u32;
                        self.samples[x + EDGE * (y + EDGE * z)] = block.sample_at(bit).to_f32();
                    }
                }
            }
        }
        self.shown = self.find_shown(visible);
    }

    fn find_shown(&self, visible: &Visibility) -> u64 {
        let lows = self.fold(|a, b| if a < b { a } else { b });
        let highs = self.fold(|a, b| if a > b { a } else { b });
        let mut shown = [false; 64];
        if visible.ranges().len() <= FEW_RANGES {
            for &[low, high] in visible.ranges() {
                for n in 0..64 {
                    shown[n] |= highs[n] >= low && lows[n] <= high;
                }
            }
        } else {
            shown = std::array::from_fn(|n| visible.is_visible(lows[n], highs[n]));
        }
        // Infinities and NaN as one: their product with zero is no number, and neither is a sum with that.
        if self.samples.iter().map(|s| s * 0.0).sum::<f32>() != 0.0 {
            for (offset, shown) in (0..).zip(&mut shown) {
                *shown &= self.corners(offset).iter().all(|c| c.is_finite());
            }
        }
        (0..).zip(shown).fold(0, |mask, (offset, shown)| mask | u64::from(shown) << offset)
    }

    /// Of the corners of each cell, by offset.
    fn fold(&self, of: impl Fn(f32, f32) -> f32) -> [f32; 64] {
        let s = &self.samples;
        let mut folded = [0.0; 64];
        let mut layer = [[0.0; 16]; EDGE];
        for (z, layer) in layer.iter_mut().enumerate() {
            let at = |x: usize, y: usize| s[x + EDGE * (y + EDGE * z)];
            for (n, sample) in layer.iter_mut().enumerate() {
                let (x, y) = (n & 3, n >> 2);
                *sample = of(of(at(x, y), at(x + 1, y)), of(at(x, y + 1), at(x + 1, y + 1)));
            }
        }
        for (n, sample) in folded.iter_mut().enumerate() {
            *sample = of(layer[n >> 4][n & 15], layer[(n >> 4) + 1][n & 15]);
        }
        folded
    }
}
