//! Ranges of the values in blocks of cells.

use rayon::prelude::*;

use crate::{Samples, Scalar};

/// How many parts a macrocell of each level has along an edge, from the lowest up, whose parts are cells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Branching(Vec<u32>);

/// A hierarchy that cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "macrocells of {0:?} parts along an edge, level by level: expected 1 to {MAX_LEVELS} levels of at least 2, and at most 2097152 in all"
)]
pub struct BranchingError(Vec<u32>);

/// The most levels: a product of more factors of two is longer than any axis.
const MAX_LEVELS: usize = 21;

impl Branching {
    /// # Errors
    /// No level, or too many; a level of fewer than two parts; macrocells longer than any axis.
    pub fn new(parts: &[u32]) -> Result<Self, BranchingError> {
        let edge = parts.iter().try_fold(1u32, |edge, &n| edge.checked_mul(n));
        let is_fine = (1..=MAX_LEVELS).contains(&parts.len())
            && parts.iter().all(|&n| n >= 2)
            && edge.is_some_and(|edge| edge <= crate::MAX_AXIS);
        if is_fine { Ok(Self(parts.to_vec())) } else { Err(BranchingError(parts.to_vec())) }
    }

    /// From the lowest level up.
    pub fn parts(&self) -> &[u32] {
        &self.0
    }
}

impl Default for Branching {
    /// Three levels, as the paper has them, of four parts each.
    fn default() -> Self {
        Self(vec![4; 3])
    }
}

/// The ranges of the values of a dense volume in macrocells, blocks of cells, in blocks of those, and so on: what a traversal needs to pass by
/// cells that cannot matter (Parker 1998, section 3.1, with any number of levels of any size).
///
/// Macrocell `(i, j, k)` of a level of edge `e` holds the cells whose coordinates are `e·(i, j, k)` and less than `e` more; its range is that of
/// the samples at their corners, the first samples of the next macrocells among them. Samples that are not finite take no part:
/// cells that touch them are empty. Macrocells beside the domain's far border are cut short.
///
/// With a lowest level of 4³ cells, ranges take about 1/32 of the bytes of the volume: 0.032 bytes a voxel of 8 bits, 0.063 of 16 and 0.127 of 32.
/// They are found in one pass.
#[derive(Clone, Debug)]
pub struct Macrocells<T> {
    levels: Vec<MacrocellLevel<T>>,
}

/// The macrocells of one size.
#[derive(Clone, Debug)]
pub struct MacrocellLevel<T> {
    /// Cells along an edge.
    edge: u32,
    blocks: [u32; 3],
    ranges: Vec<ValueRange<T>>,
}

/// The least and the greatest of some values; of none, the type's greatest and its least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueRange<T> {
    /// The least.
    pub min: T,
    /// The greatest.
    pub max: T,
}

impl<T: Scalar> ValueRange<T> {
    /// Of no values.
    pub const EMPTY: Self = Self { min: T::HIGHEST, max: T::LOWEST };

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.min > self.max
    }

    /// Adds a value, if it is finite. Without a branch, so that rows of values are added in lanes.
    #[inline(always)]
    fn add(&mut self, value: T) {
        let (min, max) = if value.is_finite() { (value, value) } else { (T::HIGHEST, T::LOWEST) };
        self.join(Self { min, max });
    }

    /// Adds the values of another range.
    #[inline(always)]
    fn join(&mut self, other: Self) {
        self.min = if other.min < self.min { other.min } else { self.min };
        self.max = if other.max > self.max { other.max } else { self.max };
    }
}

impl<T: Scalar> Macrocells<T> {
    /// The ranges of `volume`, in one pass over it.
    pub fn new(volume: &impl Samples<Sample = T>, branching: &Branching) -> Self {
        let mut parts = branching.0.iter();
        let mut levels = Vec::new();
        if let (Some(&cells), true) = (parts.next(), volume.dims().cells() > 0) {
            levels.push(MacrocellLevel::of_samples(volume, cells));
        }
        for &n in parts {
            levels.extend(levels.last().map(|level| level.coarser(n)));
        }
        Self { levels }
    }

    /// With as many levels, of `n` parts along an edge each, as there are up to a single macrocell.
    pub fn up_to_one(volume: &impl Samples<Sample = T>, n: u32) -> Self {
        let n = n.max(2);
        let mut all = Self::new(volume, &Branching(vec![n]));
        while let Some(last) = all.levels.last().filter(|level| level.blocks != [1; 3]) {
            all.levels.push(last.coarser(n));
        }
        all
    }

    /// The levels, smallest macrocells first. None if the volume has no cells.
    pub fn levels(&self) -> &[MacrocellLevel<T>] {
        &self.levels
    }

    /// Bytes of the ranges.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(level.ranges.as_slice())).sum()
    }
}

impl<T: Scalar> MacrocellLevel<T> {
    /// Cells along an edge of a macrocell.
    #[inline(always)]
    pub fn edge(&self) -> u32 {
        self.edge
    }

    /// Number of macrocells along x, y and z.
    #[inline(always)]
    pub fn blocks(&self) -> [u32; 3] {
        self.blocks
    }

    /// The ranges of all macrocells, x fastest.
    #[inline(always)]
    pub fn ranges(&self) -> &[ValueRange<T>] {
        &self.ranges
    }

    /// Macrocells of `edge³` cells.
    fn of_samples(volume: &impl Samples<Sample = T>, edge: u32) -> Self {
        let mut level = Self::empty(edge, volume.dims().axes().map(|n| (n - 1).div_ceil(edge)));
        let [bx, by, _] = level.blocks.map(|n| n as usize);
        level.ranges.par_chunks_mut(bx).enumerate().for_each_init(
            RowOfBlocks::default,
            |row, (n, ranges)| {
                row.find(volume, edge, [n % by, n / by].map(|n| n as u32), ranges);
            },
        );
        level
    }

    /// Macrocells of `n³` of these.
    fn coarser(&self, n: u32) -> Self {
        let mut level = Self::empty(self.edge.saturating_mul(n), self.blocks.map(|b| b.div_ceil(n)));
        let [nx, ny, _] = self.blocks.map(|n| n as usize);
        let [bx, by, _] = level.blocks.map(|n| n as usize);
        let n = n as usize;
        for (at, &range) in self.ranges.iter().enumerate() {
            let [x, y, z] = [at % nx / n, at / nx % ny / n, at / (nx * ny) / n];
            level.ranges[(z * by + y) * bx + x].join(range);
        }
        level
    }

    fn empty(edge: u32, blocks: [u32; 3]) -> Self {
        let count = blocks.iter().map(|&n| n as usize).product();
        Self { edge, blocks, ranges: vec![ValueRange::EMPTY; count] }
    }
}

/// Finds the ranges of a row of macrocells along x.
#[derive(Default)]
struct RowOfBlocks<T> {
    /// Some rows of samples.
    samples: Vec<T>,
    /// By x, the least and the greatest of all rows: apart, so that they are compared in lanes.
    mins: Vec<T>,
    maxs: Vec<T>,
}

/// Rows that are read at once, at most.
const STRIP: usize = 64;

impl<T: Scalar> RowOfBlocks<T> {
    /// Those at the given place along y and z.
    fn find(
        &mut self,
        volume: &impl Samples<Sample = T>,
        edge: u32,
        block: [u32; 2],
        ranges: &mut [ValueRange<T>],
    ) {
        let [nx, ny, nz] = volume.dims().axes();
        // The last samples are the first of the next macrocells.
        let [y, z] = [[block[0], ny], [block[1], nz]].map(|[block, n]| {
            let low = block * edge;
            low..n.min(low.saturating_add(edge).saturating_add(1))
        });
        let (width, Self { samples, mins, maxs }) = (nx as usize, self);
        mins.clear();
        mins.resize(width, T::HIGHEST);
        maxs.clear();
        maxs.resize(width, T::LOWEST);
        for (z, first) in z.flat_map(|z| y.clone().step_by(STRIP).map(move |y| (z, y))) {
            samples.resize((y.end - first).min(STRIP as u32) as usize * width, T::default());
            volume.read_rows(z, first, samples);
            for row in samples.chunks_exact(width) {
                for ((min, max), &value) in mins.iter_mut().zip(&mut *maxs).zip(row) {
                    let mut range = ValueRange { min: *min, max: *max };
                    range.add(value);
                    (*min, *max) = (range.min, range.max);
                }
            }
        }
        for (n, range) in ranges.iter_mut().enumerate() {
            let from = n * edge as usize;
            for x in from..width.min(from + edge as usize + 1) {
                range.join(ValueRange { min: mins[x], max: maxs[x] });
            }
        }
    }
}

/// A volume with its macrocells: what a traversal of it needs.
#[derive(Clone, Debug)]
pub struct GridVolume<S: Samples> {
    samples: S,
    macrocells: Macrocells<S::Sample>,
}

impl<S: Samples> GridVolume<S> {
    /// Finds the macrocells of `samples`, with the default branching.
    pub fn new(samples: S) -> Self {
        Self::with_branching(samples, &Branching::default())
    }

    /// The same with another branching.
    pub fn with_branching(samples: S, branching: &Branching) -> Self {
        let macrocells = Macrocells::new(&samples, branching);
        Self { samples, macrocells }
    }

    /// The samples.
    #[inline(always)]
    pub fn samples(&self) -> &S {
        &self.samples
    }

    /// The ranges of their values in blocks of cells.
    #[inline(always)]
    pub fn macrocells(&self) -> &Macrocells<S::Sample> {
        &self.macrocells
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DenseVolume, Dims};

    /// The next of a sequence of whole numbers below 2¹⁶ (Lehmer's generator).
    fn next(state: &mut u64) -> u16 {
        *state = *state * 48271 % 0x7fff_ffff;
        (*state >> 8) as u16
    }

    /// The range of the corners of the block's cells, cell by cell.
    fn by_brute_force<T: Scalar>(volume: &DenseVolume<'_, T>, edge: u32, block: [u32; 3]) -> ValueRange<T> {
        let cells = volume.dims().axes().map(|n| n - 1);
        let along = |a: usize| block[a] * edge..cells[a].min((block[a] + 1) * edge);
        let mut range = ValueRange::EMPTY;
        for z in along(2) {
            for y in along(1) {
                for x in along(0) {
                    for n in 0..8 {
                        range.add(volume.sample([x + (n & 1), y + (n >> 1 & 1), z + (n >> 2)]));
                    }
                }
            }
        }
        range
    }

    fn check<T: Scalar>(dims: [u32; 3], branching: &[u32], sample: impl FnMut() -> T) {
        let dims = Dims::new(dims).unwrap();
        let samples: Vec<T> = std::iter::repeat_with(sample).take(dims.samples()).collect();
        let volume = DenseVolume::new(dims, &samples).unwrap();
        let macrocells = Macrocells::new(&volume, &Branching::new(branching).unwrap());
        assert_eq!(macrocells.levels().len(), if dims.cells() == 0 { 0 } else { branching.len() }, "{dims}");
        let mut edge = 1;
        let mut bytes = 0;
        for (level, n) in macrocells.levels().iter().zip(branching) {
            edge *= n;
            assert_eq!((level.edge(), level.blocks()), (edge, dims.axes().map(|n| (n - 1).div_ceil(edge))));
            let [nx, ny, nz] = level.blocks();
            assert_eq!(level.ranges().len(), (nx * ny * nz) as usize);
            for (n, &range) in (0..).zip(level.ranges()) {
                let block = [n % nx, n / nx % ny, n / (nx * ny)];
                assert_eq!(range, by_brute_force(&volume, edge, block), "{dims}, {edge}, {block:?}");
            }
            bytes += level.ranges().len() * 2 * size_of::<T>();
        }
        assert_eq!(macrocells.bytes(), bytes);
        let whole = Macrocells::up_to_one(&volume, branching[0]);
        if let Some(level) = whole.levels().last() {
            assert_eq!(level.blocks(), [1; 3]);
            assert_eq!(whole.levels()[0].ranges(), macrocells.levels()[0].ranges());
        }
    }

    #[test]
    fn ranges_are_those_of_the_corners_of_the_cells() {
        let mut state = 5;
        for n in 0..60 {
            let dims = [(); 3].map(|()| 1 + u32::from(next(&mut state)) % [6, 23, 40][n % 3]);
            let branching: &[u32] = [&[4, 4, 4][..], &[2], &[3, 5], &[7, 2, 2, 3], &[64]][n % 5];
            check(dims, branching, || next(&mut state) as u8);
            check(dims, branching, || next(&mut state) as i16);
            check(dims, branching, || match next(&mut state) {
                v if v % 7 == 0 => [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][v as usize % 3],
                v => f32::from(v) - 30000.0,
            });
        }
        check([150, 3, 2], &[4, 4], || next(&mut state) as i8);
        check([2, 2, 70], &[5, 3], || next(&mut state));
    }

    #[test]
    fn a_block_without_finite_samples_has_an_empty_range() {
        check([5, 5, 5], &[4, 4], || f32::NAN);
        let volume = [f32::INFINITY; 8];
        let volume = DenseVolume::new(Dims::new([2; 3]).unwrap(), &volume).unwrap();
        assert!(GridVolume::new(volume).macrocells().levels()[0].ranges()[0].is_empty());
    }

    #[test]
    fn hierarchies_that_cannot_be() {
        for parts in [&[][..], &[1], &[4, 0], &[1 << 11, 1 << 11], &[2; 22], &[u32::MAX, u32::MAX]] {
            let error = Branching::new(parts).unwrap_err().to_string();
            assert!(error.contains("expected 1 to 21 levels"), "{error}");
        }
        assert_eq!(Branching::new(&[2; 21]).unwrap().parts().len(), 21);
    }
}
