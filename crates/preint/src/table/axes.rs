//! What the entries of a table stand for.

/// The axes of a preintegration table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableAxes {
    /// Number of values, at the front and at the back, at least 2.
    pub values: usize,
    /// Number of lengths, at least 2.
    pub lengths: usize,
    /// The first value and the last, in the data's own units: value `i` is at `i/(values − 1)` of the way.
    pub range: [f32; 2],
    /// World length of the first entry: length `k` is `least·(greatest/least)^(k/(lengths − 1))`.
    pub least_length: f32,
    /// World length of the last entry.
    pub greatest_length: f32,
}

/// Why a table cannot have such axes.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TableError {
    /// Too few samples.
    #[error("expected from 2 to 4096 {axis}, found {found}")]
    Samples {
        /// Of what.
        axis: &'static str,
        /// How many.
        found: usize,
    },
    /// The values do not increase, or are no numbers.
    #[error("expected a range of two increasing values, found {found:?}")]
    Range {
        /// Its ends.
        found: [f32; 2],
    },
    /// The lengths do not increase, or are no positive numbers.
    #[error("expected two increasing lengths, both positive, found {found:?}")]
    Lengths {
        /// The least and the greatest.
        found: [f32; 2],
    },
}

impl TableAxes {
    /// 256 values and 32 lengths, the size in the paper, over the values from `range[0]` to `range[1]` and lengths up to `greatest_length`,
    /// the least being a thousandth of that.
    pub fn new(range: [f32; 2], greatest_length: f32) -> Self {
        Self { values: 256, lengths: 32, range, least_length: 1e-3 * greatest_length, greatest_length }
    }

    pub(super) fn check(&self) -> Result<(), TableError> {
        for (axis, found) in [("values", self.values), ("lengths", self.lengths)] {
            if !(2..=4096).contains(&found) {
                return Err(TableError::Samples { axis, found });
            }
        }
        let [low, high] = self.range;
        // Also of ends that are finite but too far apart.
        if !(low < high && (high - low).is_finite()) {
            return Err(TableError::Range { found: self.range });
        }
        let [least, greatest] = [self.least_length, self.greatest_length];
        if !(0.0 < least && least < greatest && (greatest / least).is_finite()) {
            return Err(TableError::Lengths { found: [least, greatest] });
        }
        Ok(())
    }

    /// Value `i`, in double precision.
    pub(super) fn value(&self, i: usize) -> f64 {
        let [low, high] = self.range.map(f64::from);
        let x = i as f64 / (self.values - 1) as f64;
        low * (1.0 - x) + high * x
    }

    /// Length `k`, in double precision.
    pub(super) fn length(&self, k: usize) -> f64 {
        let [least, greatest] = [self.least_length, self.greatest_length].map(f64::from);
        least * (greatest / least).powf(k as f64 / (self.lengths - 1) as f64)
    }

    /// The sample below a value, and how far it is to the next, from 0 to 1.
    pub(super) fn place_of_value(&self, value: f32) -> (usize, f32) {
        let [low, high] = self.range;
        place((value - low) / (high - low), self.values)
    }

    /// The sample below a length, how far it is to the next, and the factor for lengths below the first.
    pub(super) fn place_of_length(&self, length: f32) -> (usize, f32, f32) {
        let ratio = length / self.least_length;
        if ratio < 1.0 {
            return (0, 0.0, ratio);
        }
        let (k, z) = place(ratio.ln() / (self.greatest_length / self.least_length).ln(), self.lengths);
        (k, z, 1.0)
    }
}

/// The sample below `x` in `[0, 1]`, of `samples`, and the rest.
fn place(x: f32, samples: usize) -> (usize, f32) {
    let x = x.clamp(0.0, 1.0) * (samples - 1) as f32;
    let below = (x as usize).min(samples - 2);
    (below, x - below as f32)
}
