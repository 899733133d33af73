//! One block of 8³ samples: eight children of 4³, their ranges and caps.

use isoray_grid::Scalar;
use isoray_octree::{
    CAP_EDGE, CAP_LEVEL, CAP_SAMPLES, Counts, NODE_LEVEL, Range, cap_unit, child_origin, extent, product,
    push_cap,
};

use crate::consolidate::Region;
use crate::strip::{BLOCK_EDGE, Strip};

/// What a strip becomes.
#[derive(Debug)]
pub(crate) struct Blocks<T: Scalar> {
    /// Row by row.
    pub(crate) regions: Vec<Region<T>>,
    /// The caps; links count from the start of them.
    pub(crate) caps: Vec<u8>,
    /// Of all samples.
    pub(crate) range: Range<T>,
}

/// Blocks of a tile along x: so many, of every row of a strip, lie together in the file, as they are looked at together.
const TILE: usize = 4;

impl<T: Scalar> Blocks<T> {
    pub(crate) fn new() -> Self {
        Self { regions: Vec::new(), caps: Vec::new(), range: Range::EMPTY }
    }

    /// Takes what was read; its samples are added to `counts`.
    pub(crate) fn take(&mut self, strip: &Strip<T>, counts: &mut Counts<T>) {
        let [columns, rows] = strip.place.blocks();
        self.caps.clear();
        self.range = Range::EMPTY;
        self.regions.clear();
        self.regions.resize_with(columns * rows, Region::default);
        for tile in (0..columns).step_by(TILE) {
            for row in 0..rows {
                for column in tile..columns.min(tile + TILE) {
                    let region = self.block(strip, [column, row], counts);
                    self.regions[row * columns + column] = region;
                }
            }
        }
        self.caps.resize(self.caps.len().next_multiple_of(cap_unit::<T>()), 0);
    }

    fn block(&mut self, strip: &Strip<T>, [column, row]: [usize; 2], counts: &mut Counts<T>) -> Region<T> {
        let dims = strip.place.dims;
        let origin =
            [(column * BLOCK_EDGE) as u32, strip.place.row + (row * BLOCK_EDGE) as u32, strip.place.layer];
        let cap = |n: usize| [2 * column + (n & 1), 2 * row + (n >> 1 & 1), n >> 2];
        let sizes: [[u32; 3]; 8] =
            std::array::from_fn(|n| extent(dims, child_origin(origin, NODE_LEVEL, n as u32), CAP_LEVEL));
        let ranges: [Range<T>; 8] = std::array::from_fn(|n| match product(sizes[n]) {
            0 => Range::EMPTY,
            _ => strip.range(cap(n)),
        });
        self.range = ranges.into_iter().fold(self.range, Range::union);
        // Most blocks of most volumes.
        let first = ranges[0].min;
        let is_inner = has_cells(strip, origin.map(|c| c + BLOCK_EDGE as u32 - 1));
        if T::IS_INTEGER && is_inner && ranges.iter().all(|r| r.min == first && r.max == first) {
            counts.add(first, BLOCK_EDGE.pow(3) as u64);
            return Region::constant(first, ranges[0]);
        }
        self.caps.resize(self.caps.len().next_multiple_of(cap_unit::<T>()), 0);
        let first = (self.caps.len() / cap_unit::<T>()) as u32;
        let mut mask = 0;
        let mut values = [T::default(); 8];
        let mut cell_ranges = [Range::EMPTY; 8];
        for n in 0..8 {
            let count = product(sizes[n]);
            if count == 0 {
                values[n] = values[0];
                continue;
            }
            if has_cells(strip, child_origin(origin, NODE_LEVEL, n as u32)) {
                cell_ranges[n] = ranges[n];
            }
            if T::IS_INTEGER && ranges[n].min == ranges[n].max {
                values[n] = ranges[n].min;
                counts.add(values[n], count as u64);
                continue;
            }
            let samples = gather(strip, cap(n), sizes[n]);
            values[n] = samples[0];
            if samples[..count].iter().fold(0, |m, s| m | (s.to_bits() ^ values[n].to_bits())) == 0 {
                counts.add(values[n], count as u64);
            } else {
                mask |= 1 << n;
                push_cap(&samples, sizes[n], cell_ranges[n], &mut self.caps);
                samples[..count].iter().for_each(|&s| counts.add(s, 1));
            }
        }
        Region::of_children(cell_ranges, values, first, mask)
    }
}

/// Whether the region at `corner` has cells.
fn has_cells<T: Scalar>(strip: &Strip<T>, corner: [u32; 3]) -> bool {
    let n = strip.place.dims.axes();
    (0..3).all(|a| corner[a] + 1 < n[a])
}

/// The samples of a cap, x fastest.
#[inline(always)]
fn gather<T: Scalar>(strip: &Strip<T>, cap: [usize; 3], size: [u32; 3]) -> [T; CAP_SAMPLES] {
    const EDGE: usize = CAP_EDGE as usize;
    let mut samples = [T::default(); CAP_SAMPLES];
    let [x, y, z] = cap.map(|c| c * EDGE);
    if size == [CAP_EDGE; 3] {
        for (n, out) in samples.as_chunks_mut::<EDGE>().0.iter_mut().enumerate() {
            let row = strip.row(z + n / EDGE, y + n % EDGE);
            if let Some(&four) = row.get(x..).and_then(<[T]>::first_chunk) {
                *out = four;
            }
        }
        return samples;
    }
    let size = size.map(|n| n as usize);
    for (n, out) in samples.chunks_exact_mut(size[0]).take(size[1] * size[2]).enumerate() {
        out.copy_from_slice(&strip.row(z + n / size[1], y + n % size[1])[x..x + size[0]]);
    }
    samples
}
