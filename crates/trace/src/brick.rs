//! Blocks with one layer of their forward neighbours' samples, as numbers to compute with.

use std::ops::Range;

use isoray_grid::Scalar;
use isoray_octree::{Block, CAP_EDGE, CAP_SAMPLES, OctreeView, Path};
use isoray_preint::Visibility;
use wide::f32x4;

use crate::place::Place;

/// Samples along an edge: those at the corners of a block's cells.
const EDGE: usize = CAP_EDGE as usize + 1;

/// All samples.
pub const SAMPLES: usize = EDGE * EDGE * EDGE;

/// The samples at the corners of a block's cells, x fastest.
#[derive(Clone, Debug)]
pub struct Brick {
    /// Whose it is, or [`NOBODY`].
    key: u64,
    /// The cells that are visible and whose corners are finite, by offset.
    shown: u64,
    samples: [f32; SAMPLES],
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
        Self { entries: vec![Brick::default(); 1 << ENTRY_BITS].into_boxed_slice() }
    }

    /// The brick of this key, which is not zero; `fill` makes one.
    #[inline(always)]
    pub(crate) fn of(&mut self, key: u64, fill: impl FnOnce(&mut Brick)) -> &Brick {
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

/// Rows of cells in a block.
const ROWS: usize = 16;

/// All bits of a number but the sign.
const SIGN_CLEARED: u32 = u32::MAX >> 1;

/// As many samples of a cap are worth fetching all of them at once.
const MANY: usize = 16;

/// As many are compared with all cells at once; of more, the one that each cell can meet is searched for.
const FEW_RANGES: usize = 8;

impl Default for Brick {
    fn default() -> Self {
        Self { key: NOBODY, shown: 0, samples: [0.0; SAMPLES] }
    }
}

impl Brick {
    /// The cells that are to be integrated, by offset: `x + 4y + 16z`.
    #[inline(always)]
    pub fn shown(&self) -> u64 {
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
        // Samples beyond the domain mean nothing, and no ray meets the cells that would have them.
        let from = place.corner();
        for direction in 0..8u32 {
            let step: [u32; 3] = std::array::from_fn(|a| direction >> a & 1);
            let block = match direction {
                0 => own,
                _ => path.neighbor(view, from, std::array::from_fn(|a| from[a] + step[a] * CAP_EDGE)),
            };
            // Along an axis, samples 0 to 3 are the block's own, and sample 4 its neighbour's first.
            let [x, y, z] = step.map(|step| if step == 1 { 4..5 } else { 0..4 });
            if x.start == 0 {
                self.copy(block, y, z, |samples, start, row: [f32; 4]| {
                    samples[start..start + 4].copy_from_slice(&row)
                });
            } else {
                self.copy(block, y, z, |samples, start, row: [f32; 1]| samples[start + 4] = row[0]);
            }
        }
        self.shown = self.find_shown(visible);
    }

    /// Fetches the samples of the block whose first one, in an array with rows and layers of the given lengths, is at `low`.
    #[inline(never)]
    pub(crate) fn fill_from_array<T: Scalar>(
        &mut self,
        array: &[T],
        low: usize,
        [row, layer]: [usize; 2],
        visible: &Visibility,
    ) {
        for (n, samples) in self.samples.as_chunks_mut::<EDGE>().0.iter_mut().enumerate() {
            let at = low + n % EDGE * row + n / EDGE * layer;
            // Beyond the domain they mean nothing, as in `fill`.
            match array.get(at..).and_then(<[T]>::first_chunk) {
                Some(stored) => *samples = stored.map(T::to_f32),
                None => {
                    let stored = |n| array.get(at + n).copied().unwrap_or_default();
                    *samples = std::array::from_fn(|n| stored(n).to_f32());
                }
            }
        }
        self.shown = self.find_shown(visible);
    }

    /// Takes the first samples of the rows of `block` at these `y` and `z`, all less than 4 or 4; `put` writes them to the row that
    /// starts at a given index.
    #[inline(always)]
    fn copy<T: Scalar, const N: usize>(
        &mut self,
        block: Block<'_, T>,
        y: Range<usize>,
        z: Range<usize>,
        put: impl Fn(&mut [f32; SAMPLES], usize, [f32; N]),
    ) {
        if let Some(value) = block.as_constant() {
            let value = value.to_f32();
            self.copy_rows(y, z, put, |_| [value; N]);
        } else if y.len() * z.len() * N >= MANY {
            let samples = block.samples();
            self.copy_rows(y, z, put, |first| {
                let row = &samples[first % CAP_SAMPLES..][..N];
                std::array::from_fn(|n| row[n].to_f32())
            });
        } else {
            self.copy_rows(y, z, put, |first| {
                std::array::from_fn(|n| block.sample_at((first + n) as u32).to_f32())
            });
        }
    }

    /// By the index of a row's first sample in a block.
    #[inline(always)]
    fn copy_rows<const N: usize>(
        &mut self,
        y: Range<usize>,
        z: Range<usize>,
        put: impl Fn(&mut [f32; SAMPLES], usize, [f32; N]),
        row: impl Fn(usize) -> [f32; N],
    ) {
        for z in z {
            for y in y.clone() {
                put(&mut self.samples, EDGE * (y + EDGE * z), row((y & 3) << 2 | (z & 3) << 4));
            }
        }
    }

    /// Takes the samples that `fill` writes, 5³, x fastest, of which the cells `among` are the block's, by offset.
    pub fn fill_with(&mut self, fill: impl FnOnce(&mut [f32; SAMPLES]), visible: &Visibility, among: u64) {
        fill(&mut self.samples);
        self.shown = self.find_shown(visible) & among;
    }

    /// As [`fill_with`](Self::fill_with), to show the cells whose corners lie on both sides of any isovalue.
    pub fn fill_mixed(&mut self, fill: impl FnOnce(&mut [f32; SAMPLES]), isovalues: &[f32], among: u64) {
        fill(&mut self.samples);
        let lows = self.fold(f32x4::fast_min);
        let highs = self.fold(f32x4::fast_max);
        self.shown = 0;
        for isovalue in isovalues.iter().map(|&v| f32x4::splat(v)) {
            for n in 0..ROWS {
                let mixed = lows[n].simd_lt(isovalue) & highs[n].simd_ge(isovalue);
                self.shown |= u64::from(mixed.to_bitmask()) << (4 * n);
            }
        }
        self.shown &= among & self.finite();
    }

    fn find_shown(&self, visible: &Visibility) -> u64 {
        let lows = self.fold(f32x4::fast_min);
        let highs = self.fold(f32x4::fast_max);
        let mut shown = 0;
        if visible.ranges().len() <= FEW_RANGES {
            for &[low, high] in visible.ranges() {
                let [low, high] = [low, high].map(f32x4::splat);
                for n in 0..ROWS {
                    let meets = highs[n].simd_ge(low) & lows[n].simd_le(high);
                    shown |= u64::from(meets.to_bitmask()) << (4 * n);
                }
            }
        } else {
            for n in 0..ROWS {
                let (low, high) = (lows[n].to_array(), highs[n].to_array());
                for x in 0..4 {
                    shown |= u64::from(visible.is_visible(low[x], high[x])) << (4 * n + x);
                }
            }
        }
        shown & self.finite()
    }

    /// The cells whose corners are finite.
    #[inline(always)]
    fn finite(&self) -> u64 {
        let largest = self.samples.iter().fold(0, |m, s| (s.to_bits() & SIGN_CLEARED).max(m));
        if largest < f32::INFINITY.to_bits() {
            return u64::MAX;
        }
        (0..64).fold(0, |finite, offset| {
            let is_finite = self.corners(offset).iter().all(|c| c.is_finite());
            finite | u64::from(is_finite) << offset
        })
    }

    /// Of the corners of each cell; four cells along x at a time, by offset.
    #[inline(always)]
    fn fold(&self, of: impl Fn(f32x4, f32x4) -> f32x4) -> [f32x4; ROWS] {
        let layer = |z: usize| -> [f32x4; 4] {
            let row = |y: usize| {
                let start = EDGE * (y + EDGE * z);
                let four = |from: usize| {
                    let s = &self.samples[from..from + 4];
                    f32x4::new([s[0], s[1], s[2], s[3]])
                };
                of(four(start), four(start + 1))
            };
            let rows: [f32x4; EDGE] = std::array::from_fn(row);
            std::array::from_fn(|y| of(rows[y], rows[y + 1]))
        };
        let layers: [[f32x4; 4]; EDGE] = std::array::from_fn(layer);
        std::array::from_fn(|n| of(layers[n >> 2][n & 3], layers[(n >> 2) + 1][n & 3]))
    }
}
