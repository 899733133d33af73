//! What is around a block: the levels that it meets there, and its samples on their faces.
//!
//! Directions are numbered `(dx + 1) + 3(dy + 1) + 9(dz + 1)`, and sets of them are bits.

use super::detail::Detail;
use super::resolve::{BLOCK_EDGE, BLOCK_SAMPLES};
use crate::geometry::{CAP_EDGE, CAP_SAMPLES};

/// By axis: the directions to neither side of it.
const BESIDE: [u32; 3] = [0o222_222_222, 0o070_070_070, 0o000_777_000];

/// The blocks of its size around one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Around {
    /// Where cells are of the next level.
    pub(crate) next: u32,
    /// Where they are of any other level.
    pub(crate) others: u32,
    /// Whether some are coarser by more than one level.
    pub(crate) is_steep: bool,
}

impl Around {
    /// Of the block of `level` at `corner`, in samples of its lattice, in a domain that ends at `last`.
    pub(crate) fn new(detail: &Detail, level: u32, corner: [u32; 3], last: [u32; 3]) -> Self {
        let [finest, coarsest] = [*detail.levels().start(), *detail.levels().end()];
        // By axis and step: the squares of distances, of the blocks of the level, of the next and of the one after that.
        let mut squares = [[[0.0; 3]; 3]; 3];
        let mut inside = u32::MAX;
        for a in 0..3 {
            for step in 0..3 {
                let at = (i64::from(corner[a]) + (step as i64 - 1) * i64::from(CAP_EDGE)) << level;
                if !(0..i64::from(last[a])).contains(&at) {
                    inside &= !directions(a, step);
                }
                squares[a][step] = [0, 1, 2].map(|above| detail.square_to_block(a, level + above, at));
            }
        }
        let starts = [0, 1, 2].map(|above| detail.start(level + above).powi(2));
        let (mut next, mut finer, mut is_steep) = (0, 0, false);
        for n in 0..27 {
            let [x, y, z] = [squares[0][n % 3], squares[1][n / 3 % 3], squares[2][n / 9]];
            let is_far = |above: usize| x[above] + y[above] + z[above] >= starts[above];
            let bit = 1 << n & inside;
            next |= if level < coarsest && is_far(1) { bit } else { 0 };
            finer |= if level > finest && !is_far(0) { bit } else { 0 };
            is_steep |= level + 1 < coarsest && bit != 0 && is_far(2);
        }
        Self { next, others: next | finer, is_steep }
    }

    /// The block's cells, bit `x + 4y + 16z`, that touch others of another level.
    pub(crate) fn joints(&self) -> u64 {
        each(reaching(self.others)).fold(0, |cells, n| cells | CELLS[n])
    }

    /// The directions in which samples touch cells of the next level.
    pub(crate) fn reached(&self) -> u32 {
        reaching(self.next)
    }
}

/// Gives samples on faces in some directions what is between the corners of the next level's cells there.
pub(crate) fn take_next(directions: u32, samples: &mut [f32; BLOCK_SAMPLES]) {
    for between in BETWEEN.iter().filter(|between| directions >> between.direction & 1 == 1) {
        samples[between.sample] = between.value(samples);
    }
}

/// The interpolant of the next level's cells, at all samples.
pub(crate) fn of_next(samples: &[f32; BLOCK_SAMPLES]) -> [f32; BLOCK_SAMPLES] {
    let mut next = *samples;
    for between in &BETWEEN {
        next[between.sample] = between.value(samples);
    }
    next
}

/// To that side along an axis: below, beside, above.
fn directions(a: usize, step: usize) -> u32 {
    let beside = BESIDE[a];
    match step {
        0 => beside >> 3u32.pow(a as u32),
        1 => beside,
        _ => beside << 3u32.pow(a as u32),
    }
}

/// With those directions that are made of some of these.
fn reaching(mut some: u32) -> u32 {
    for a in 0..3 {
        let (beside, step) = (some & BESIDE[a], 3u32.pow(a as u32));
        some |= beside << step | beside >> step;
    }
    some
}

fn each(mut directions: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let n = (directions != 0).then(|| directions.trailing_zeros() as usize);
        directions &= directions.wrapping_sub(1);
        n
    })
}

/// The direction in which what is at `index` reaches the faces of its block, between 0 and `last` along each axis.
pub(crate) const fn class(index: [usize; 3], last: usize) -> usize {
    let mut class = 0;
    let mut a = 3;
    while a > 0 {
        a -= 1;
        class = 3 * class + 1 + (index[a] == last) as usize - (index[a] == 0) as usize;
    }
    class
}

/// By direction: the cells that reach the faces there.
const CELLS: [u64; 27] = {
    let mut cells = [0; 27];
    let mut n = 0;
    while n < CAP_SAMPLES {
        cells[class([n & 3, n >> 2 & 3, n >> 4], CAP_EDGE as usize - 1)] |= 1 << n;
        n += 1;
    }
    cells
};

/// A sample that is not on the next level's lattice.
#[derive(Clone, Copy)]
struct Between {
    sample: usize,
    direction: usize,
    /// By axis: to its neighbours on both sides, if it lies between the lattice's planes; else none.
    strides: [usize; 3],
}

/// All of them.
const BETWEEN: [Between; BLOCK_SAMPLES - 27] = {
    let mut all = [Between { sample: 0, direction: 0, strides: [0; 3] }; BLOCK_SAMPLES - 27];
    let (mut count, mut n) = (0, 0);
    while n < BLOCK_SAMPLES {
        let index = [n % BLOCK_EDGE, n / BLOCK_EDGE % BLOCK_EDGE, n / (BLOCK_EDGE * BLOCK_EDGE)];
        let odd = [index[0] % 2, index[1] % 2, index[2] % 2];
        if odd[0] + odd[1] + odd[2] > 0 {
            let strides = [odd[0], odd[1] * BLOCK_EDGE, odd[2] * BLOCK_EDGE * BLOCK_EDGE];
            all[count] = Between { sample: n, direction: class(index, BLOCK_EDGE - 1), strides };
            count += 1;
        }
        n += 1;
    }
    assert!(count == all.len());
    all
};

impl Between {
    /// The same as the interpolant of the cell, bit for bit: halfway between two equal numbers is that number.
    fn value(&self, samples: &[f32; BLOCK_SAMPLES]) -> f32 {
        let [x, y, z] = self.strides;
        let first = self.sample - x - y - z;
        let corners: [f32; 8] = std::array::from_fn(|n| {
            samples[(first + 2 * ((n & 1) * x + (n >> 1 & 1) * y + (n >> 2) * z)) % BLOCK_SAMPLES]
        });
        if !corners.iter().all(|corner| corner.is_finite()) {
            return f32::NAN;
        }
        let halfway = |low: f64, high: f64| low + 0.5 * (high - low);
        let along_x: [f64; 4] =
            std::array::from_fn(|n| halfway(corners[2 * n].into(), corners[2 * n + 1].into()));
        let value = halfway(halfway(along_x[0], along_x[1]), halfway(along_x[2], along_x[3]));
        let [least, most] = [f32::min, f32::max].map(|of| corners.into_iter().reduce(of).unwrap_or(f32::NAN));
        (value as f32).clamp(least, most)
    }
}
