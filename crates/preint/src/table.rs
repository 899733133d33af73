//! Preintegration tables.

mod axes;
mod entry;
mod running;

use isoray_cell::fma;

use crate::{LinearPieces, Piece, TransferFunction};
pub use axes::{TableAxes, TableError};
pub use entry::Entry;
use running::Running;

/// Opacity and front- and back-weighted colours of pieces, sampled over the values at their ends and their length (Marchesin and Colin de
/// Verdière 2009, section 5).
///
/// # Error
///
/// *At the nodes*, entries are within [`NODE_ERROR`](Self::NODE_ERROR) of [`LinearPieces`], colours relative to the largest component of any
/// colour, plus half a step of the entry: 7.7·10⁻⁶ for `u16`, a rounding for `f32`.
///
/// *Between nodes*, look-up is trilinear, and the error is that of the interpolation: it depends on how the transfer function varies
/// between two sampled values, and has no bound but 1, since a step or a peak there may be seen or missed. Measured in `alpha`, over
/// 200 000 random pieces (the largest grows with their number):
#[doc = include_str!("table/error.md")]
#[derive(Clone, Debug)]
pub struct PreintegrationTable<E> {
    axes: TableAxes,
    /// What the largest entry of a colour stands for.
    scale: f32,
    /// `s1` fastest, then `s0`, then length: alpha, front, back, and one that fills the lane.
    entries: Vec<[E; 8]>,
}

impl<E: Entry> PreintegrationTable<E> {
    /// Bound on the difference of an entry, before it is rounded, from the integral in [`LinearPieces`] (whose own error is apart): what the
    /// series for a unit leave out, less than 10⁻⁸ of each unit's depth, is seen through the transmittance before it; the sum is at most
    /// `e^½` times as much. Added is the error of `LinearPieces` itself, which is used for thick units.
    pub const NODE_ERROR: f64 = 2e-8 + LinearPieces::ERROR;

    /// The greatest number of parts that a piece longer than the table's greatest length is cut into.
    pub const PARTS: usize = 64;

    /// A table of `transfer`, by running integrals.
    ///
    /// # Running integrals
    ///
    /// Lum, Wilson and Ma (2004) compute an entry from a part of the integral that is known already, instead of anew from its beginning.
    /// Let `n = |j − i|` be the number of *units*, steps between two sampled values, from `s0 = sᵢ` to `s1 = sⱼ`. All entries with
    /// the same `n` and length `l` are made of units of the same length `l/n`, so a unit looks the same in all of them, and an entry is the composition of `n` consecutive units.
    /// Front-to-back composition is associative:
    ///
    /// ```text
    /// alpha = alpha_a + (1 − alpha_a)·alpha_b
    /// C     = C_a     + (1 − alpha_a)·C_b
    /// X     = X_a     + (1 − alpha_a)·(X_b + n_a·C_b)         back = X/n,  front = C − X/n
    /// ```
    ///
    /// with `X` the first moment of the colour in units. A difference of two running integrals, divided by the transmittance before, would overflow
    /// where it is thick; instead the composition over a window of `n` units is that of two running ones (van Herk 1992, Gil and Werman 1993):
    /// units are cut into blocks of `n`, a window is the end of one block and the beginning of the next, and both are running compositions within
    /// their blocks. That is three compositions for an entry, and all terms are positive.
    ///
    /// A unit of length `λ` is a power series in `λ` whose coefficients, moments of the transfer function on the unit, are computed once
    /// for the whole table; a unit too thick for 8 terms is integrated by [`LinearPieces`].
    ///
    /// # Errors
    ///
    /// If an axis has fewer than two samples or no extent.
    pub fn new(transfer: &TransferFunction, axes: TableAxes) -> Result<Self, TableError> {
        axes.check()?;
        let mut table = Self::empty(transfer, axes);
        let pieces = LinearPieces::new(transfer);
        table.fill_diagonal(&pieces);
        let last = axes.values - 1;
        for falls in [false, true] {
            let mut running = Running::new(&pieces, &axes, falls);
            for k in 0..axes.lengths {
                for units in 1..axes.values {
                    let length = axes.length(k);
                    running.windows(&pieces, units, length, |start, numbers| {
                        let [i, j] =
                            if falls { [last - start, last - start - units] } else { [start, start + units] };
                        table.set(i, j, k, numbers);
                    });
                }
            }
        }
        Ok(table)
    }

    /// The same, each entry by [`LinearPieces`]: for comparison.
    ///
    /// # Errors
    ///
    /// As in [`new`](Self::new).
    pub fn entry_by_entry(transfer: &TransferFunction, axes: TableAxes) -> Result<Self, TableError> {
        axes.check()?;
        let mut table = Self::empty(transfer, axes);
        let pieces = LinearPieces::new(transfer);
        for k in 0..axes.lengths {
            let length = axes.length(k);
            for i in 0..axes.values {
                for j in 0..axes.values {
                    let sums = pieces.sums(axes.value(i), axes.value(j), length);
                    table.set(i, j, k, sums.numbers());
                }
            }
        }
        Ok(table)
    }

    fn empty(transfer: &TransferFunction, axes: TableAxes) -> Self {
        let black = transfer.largest_color() == 0.0;
        let scale = if black { 1.0 } else { transfer.largest_color() };
        let entries = vec![[E::default(); 8]; axes.values * axes.values * axes.lengths];
        Self { axes, scale, entries }
    }

    /// Entries between equal values.
    fn fill_diagonal(&mut self, pieces: &LinearPieces) {
        for k in 0..self.axes.lengths {
            let length = self.axes.length(k);
            for i in 0..self.axes.values {
                let value = self.axes.value(i);
                self.set(i, i, k, pieces.sums(value, value, length).numbers());
            }
        }
    }

    fn index(&self, i: usize, j: usize, k: usize) -> usize {
        (k * self.axes.values + i) * self.axes.values + j
    }

    /// Alpha, front and back.
    fn set(&mut self, i: usize, j: usize, k: usize, numbers: [f64; 7]) {
        let index = self.index(i, j, k);
        let inverse = 1.0 / f64::from(self.scale);
        let entry = &mut self.entries[index];
        entry[0] = E::encode(numbers[0]);
        for n in 1..7 {
            entry[n] = E::encode(numbers[n] * inverse);
        }
    }

    /// The axes.
    pub fn axes(&self) -> &TableAxes {
        &self.axes
    }

    /// The entry of the `i`-th value at the front, the `j`-th at the back, and the `k`-th length.
    pub fn node(&self, i: usize, j: usize, k: usize) -> Piece {
        self.decode(self.entries[self.index(i, j, k)].map(E::widen))
    }

    fn decode(&self, lanes: [f32; 8]) -> Piece {
        let [alpha, ..] = lanes.map(|x| x * E::UNIT);
        let color = |n: usize| lanes[n] * (E::UNIT * self.scale);
        Piece { alpha, front: [1, 2, 3].map(color), back: [4, 5, 6].map(color) }
    }

    /// Opacity and colour of the piece of world length `length ≥ 0` on which the value runs linearly from `s0` to `s1`: bilinear in
    /// the values, linear in the logarithm of the length.
    ///
    /// Values outside the range are taken as its nearest end. A length below the least gives the entry of the least, scaled by
    /// their ratio. A piece longer than the greatest is cut into equal parts that are not, at most [`PARTS`](Self::PARTS); a length for
    /// which these do not suffice is taken as `PARTS` times the greatest.
    pub fn look_up(&self, s0: f32, s1: f32, length: f32) -> Piece {
        if length <= self.axes.greatest_length {
            return self.within(s0, s1, length);
        }
        let parts = (length / self.axes.greatest_length).ceil().min(Self::PARTS as f32);
        let [mut sum, mut left] = [Piece::default(), Piece { alpha: 1.0, ..Piece::default() }];
        for n in 0..parts as usize {
            let ends = [n, n + 1].map(|n| n as f32 / parts);
            let [from, to] = ends.map(|x| fma(x, s1, (1.0 - x) * s0));
            let part = self.within(from, to, length / parts);
            // The weight within the part is linear in the weight along the piece.
            let back = part.shaded(ends[0], ends[1]);
            let front = part.shaded(1.0 - ends[0], 1.0 - ends[1]);
            for c in 0..3 {
                sum.front[c] = fma(left.alpha, front[c], sum.front[c]);
                sum.back[c] = fma(left.alpha, back[c], sum.back[c]);
            }
            sum.alpha = fma(left.alpha, part.alpha, sum.alpha);
            left.alpha *= 1.0 - part.alpha;
            if left.alpha < f32::EPSILON / 2.0 {
                break;
            }
        }
        sum
    }

    /// For lengths that the table reaches.
    fn within(&self, s0: f32, s1: f32, length: f32) -> Piece {
        let [(i, y), (j, x)] = [s0, s1].map(|s| self.axes.place_of_value(s));
        let (k, z, factor) = self.axes.place_of_length(length);
        let mut lanes = [0.0_f32; 8];
        for (k, z) in [(k, (1.0 - z) * factor), (k + 1, z * factor)] {
            for (i, y) in [(i, 1.0 - y), (i + 1, y)] {
                let row = self.index(i, j, k);
                for (entry, x) in self.entries[row..row + 2].iter().zip([1.0 - x, x]) {
                    for n in 0..8 {
                        lanes[n] = fma(x * y * z, entry[n].widen(), lanes[n]);
                    }
                }
            }
        }
        self.decode(lanes)
    }
}

#[cfg(test)]
mod tests;
