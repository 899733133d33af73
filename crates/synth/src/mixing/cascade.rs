//! The sum of all octaves, from the coarsest lattice to the voxels.
//!
//! A quadratic B-spline on a lattice is one on the lattice of half the spacing, too, with coefficients ¾·near + ¼·far
//! of the two nearest along each axis (Chaikin's rule). So the octaves need not be evaluated one by one: from the
//! coarsest on, refine the coefficients of the sum so far and add the next octave's. All lattices but the finest
//! together have a seventh of its points. What comes out at a spacing of one voxel is the displacement.
//!
//! Coefficient `i` on the lattice of spacing `2^n` is at `2^n (i + ½) − ½` voxels: no two lattices share a point, and
//! the splines, unlike interpolated random values, have no extrema at lattice points of their own. Every coefficient
//! is computed by the same expression whatever slab asks for it.

use isoray_grid::Dims;
use rayon::prelude::*;

use super::spectrum::Spectrum;
use crate::layers::rows_per_task;
use crate::random::Row;

/// Index of the first coefficient along x and y on every lattice: what refinement asks for, rounded to even.
const FIRST: i32 = -2;

/// Coefficients of the sum of octaves on the lattice of one of them, some layers.
#[derive(Clone, Debug)]
struct Lattice {
    /// Number of coefficients along x and y, even.
    width: usize,
    height: usize,
    /// Index of the first layer that is there.
    first: i32,
    values: Vec<f32>,
}

/// The octaves of a volume, and their coefficients for some layers.
#[derive(Clone, Debug)]
pub(super) struct Cascade {
    seed: u64,
    /// Of spacing 2, 4, 8, …, one for each octave.
    lattices: Vec<Lattice>,
}

impl Cascade {
    pub(super) fn new(dims: Dims, seed: u64, octaves: usize) -> Self {
        let [mut width, mut height] = [dims.axes()[0], dims.axes()[1]].map(|n| n.div_ceil(2) as usize + 3);
        let mut lattices = Vec::with_capacity(octaves);
        for _ in 0..octaves {
            [width, height] = [width, height].map(|n| n.next_multiple_of(2));
            lattices.push(Lattice { width, height, first: 0, values: Vec::new() });
            [width, height] = [width, height].map(|n| n / 2 + 2);
        }
        Self { seed, lattices }
    }

    /// Computes what [`row`](Self::row) needs for the layers from `first` to below `end`.
    pub(super) fn prepare(&mut self, first: u32, end: u32, spectrum: &Spectrum) {
        let (mut first, mut end) = (first as i32, end as i32);
        for lattice in &mut self.lattices {
            [first, end] = [(first - 1).div_euclid(2), end.div_euclid(2) + 1];
            lattice.first = first;
            lattice.values.resize((end - first) as usize * lattice.width * lattice.height, 0.0);
        }
        for n in (0..self.lattices.len()).rev() {
            let (lattices, coarser) = self.lattices.split_at_mut(n + 1);
            compute(&mut lattices[n], coarser.first(), self.seed, n, spectrum);
        }
    }

    /// The displacements along row `j` of layer `k`, one voxel each, and perhaps one more.
    pub(super) fn row<'a>(&self, j: u32, k: u32, scratch: &'a mut Scratch) -> &'a [f32] {
        let Scratch { blended, row } = scratch;
        let lattice = &self.lattices[0];
        row.resize(2 * (lattice.width - 3), 0.0);
        lattice.blend(j as i32, k as i32, blended);
        refine(&blended[1..], row);
        row
    }
}

/// Rows that are being worked on.
#[derive(Default)]
pub(super) struct Scratch {
    blended: Vec<f32>,
    row: Vec<f32>,
}

/// Fills the lattice of octave `n`: what comes from the coarser one, and the octave itself.
fn compute(lattice: &mut Lattice, coarser: Option<&Lattice>, seed: u64, n: usize, spectrum: &Spectrum) {
    let Lattice { width, height, first, ref mut values } = *lattice;
    let flat = spectrum.octaves[n].flat as f32;
    values.par_chunks_mut(width).with_min_len(rows_per_task(width)).enumerate().for_each_init(
        Vec::new,
        |blended, (at, row)| {
            let [j, k] = [FIRST + (at % height) as i32, first + (at / height) as i32];
            match coarser {
                Some(coarser) => {
                    coarser.blend(j, k, blended);
                    refine(blended, row);
                }
                None => row.fill(0.0),
            }
            // Lattices of different octaves, and waves and the rest, have different numbers.
            add_random(row, spectrum.solid(n, k) as f32, Row::new(seed, 2 * n as u32, j, k));
            add_random(row, flat, Row::new(seed, 2 * n as u32 + 1, j, 0));
        },
    );
}

fn add_random(row: &mut [f32], amplitude: f32, random: Row) {
    if amplitude != 0.0 {
        row.iter_mut().zip(0..).for_each(|(c, i)| *c += amplitude * random.signed(i));
    }
}

impl Lattice {
    fn row(&self, j: i32, k: i32) -> &[f32] {
        let at = ((k - self.first) as usize * self.height + (j - FIRST) as usize) * self.width;
        &self.values[at..at + self.width]
    }

    /// The row at `j`, `k` of the lattice of half the spacing, in the spacing of this one along x.
    fn blend(&self, j: i32, k: i32, out: &mut Vec<f32>) {
        let [[j0, j1], [k0, k1]] = [j, k].map(near_and_far);
        let [a, b, c, d] = [(j0, k0), (j1, k0), (j0, k1), (j1, k1)].map(|(j, k)| self.row(j, k));
        out.clear();
        out.extend(
            a.iter().zip(b).zip(c).zip(d).map(|(((a, b), c), d)| 0.5625 * a + 0.1875 * (b + c) + 0.0625 * d),
        );
    }
}

/// The coefficients on the coarser lattice between which `fine` lies: ¾ of the one, ¼ of the other.
fn near_and_far(fine: i32) -> [i32; 2] {
    let near = fine.div_euclid(2);
    [near, if fine % 2 == 0 { near - 1 } else { near + 1 }]
}

/// Halves the spacing along a row; `fine[0]` is the one before the middle of `coarse[1]`.
fn refine(coarse: &[f32], fine: &mut [f32]) {
    let (pairs, _) = fine.as_chunks_mut::<2>();
    let coarse = coarse.iter().zip(&coarse[1..]).zip(&coarse[2..]);
    for (pair, ((before, near), next)) in pairs.iter_mut().zip(coarse) {
        *pair = [0.75 * near + 0.25 * before, 0.75 * near + 0.25 * next];
    }
}
