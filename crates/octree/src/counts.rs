//! How often each value occurs.

use std::marker::PhantomData;

use isoray_grid::Scalar;

use crate::volume::HISTOGRAM_BINS;

/// Leading bits of a sample that are told apart: all of an integer's; of a floating-point number the sign, the
/// exponent and the first eleven bits of the significand, so that it is counted at a value within 2⁻¹¹ of its own.
const MAX_BITS: u32 = 20;

/// The number of samples of every value.
///
/// It is filled in one pass, when the range of values that a histogram is to span is not yet known.
#[derive(Clone, Debug)]
pub struct Counts<T> {
    counts: Vec<u64>,
    sample: PhantomData<T>,
}

impl<T: Scalar> Default for Counts<T> {
    fn default() -> Self {
        Self { counts: vec![0; 1 << bits::<T>()], sample: PhantomData }
    }
}

/// Bits of `T` that are told apart.
const fn bits<T>() -> u32 {
    let bits = 8 * size_of::<T>() as u32;
    if bits < MAX_BITS { bits } else { MAX_BITS }
}

/// Bits of `T` that are not.
const fn shift<T>() -> u32 {
    8 * size_of::<T>() as u32 - bits::<T>()
}

impl<T: Scalar> Counts<T> {
    /// Bytes that one takes.
    pub const BYTES: usize = size_of::<u64>() << bits::<T>();

    /// Counts `times` samples of value `s`.
    #[inline(always)]
    pub fn add(&mut self, s: T, times: u64) {
        let at = s.to_bits() >> shift::<T>();
        if let Some(count) = self.counts.get_mut(at as usize) {
            *count += times;
        }
    }

    /// Adds what `other` has counted.
    pub fn join(&mut self, other: &Self) {
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            *count += more;
        }
    }

    /// Number of NaN and infinite samples.
    pub fn non_finite(&self) -> u64 {
        self.values().filter(|(value, _)| !value.is_finite()).map(|(_, count)| count).sum()
    }

    /// Counts of the finite samples in equal bins over `range`; the last bin includes its upper end.
    pub fn histogram(&self, range: [f64; 2]) -> Box<[u64; HISTOGRAM_BINS]> {
        let mut bins = Box::new([0; HISTOGRAM_BINS]);
        let scale = HISTOGRAM_BINS as f64 / (range[1] - range[0]).max(f64::MIN_POSITIVE);
        for (value, count) in self.values().filter(|(value, _)| value.is_finite()) {
            // The cast saturates, so a range that does not hold the value cannot do harm.
            let bin = (f64::from(value.to_f32()) - range[0]) * scale;
            bins[(bin as usize).min(HISTOGRAM_BINS - 1)] += count;
        }
        bins
    }

    /// The values that occur, those of floating-point numbers cut toward zero, and how often.
    fn values(&self) -> impl Iterator<Item = (T, u64)> {
        let counted = (0u32..).zip(&self.counts).filter(|&(_, &count)| count > 0);
        counted.map(|(at, &count)| (T::from_bits(at << shift::<T>()), count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_counted_near_their_value() {
        let mut counts = Counts::<f32>::default();
        for n in 0..1000 {
            counts.add(n as f32 + 0.5, 2);
        }
        for s in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            counts.add(s, 5);
        }
        counts.add(-0.0, 1);
        assert_eq!(counts.non_finite(), 15);
        let bins = counts.histogram([0.0, 1000.0]);
        assert_eq!(bins.iter().sum::<u64>(), 2001);
        // Of about four values each, one at most is near enough to an edge to be counted beside it.
        assert!(bins.iter().all(|&n| (5..=10).contains(&n)), "{bins:?}");
    }

    #[test]
    fn integers_are_counted_exactly() {
        let mut counts = Counts::<i16>::default();
        counts.add(-300, 7);
        counts.add(300, 8);
        let bins = counts.histogram([-300.0, 300.0]);
        assert_eq!((bins[0], bins[255], counts.non_finite()), (7, 8, 0));
    }
}
