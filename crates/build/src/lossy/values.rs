//! The values that a sample can have, and which of them is the roundest.

use isoray_grid::{Scalar, ScalarType};

/// The values of a sample type, as `f32`, which holds all of them exactly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Values {
    lowest: f32,
    highest: f32,
    is_integral: bool,
}

impl Values {
    pub(super) fn of<T: Scalar>() -> Self {
        let is_integral = T::TYPE != ScalarType::F32;
        Self { lowest: T::LOWEST.to_f32(), highest: T::HIGHEST.to_f32(), is_integral }
    }

    /// The least value `≥ v`, or the highest one there is; `v` may be infinite.
    pub(super) fn least_from(self, v: f64) -> f32 {
        let v = if self.is_integral { v.ceil() } else { v };
        self.within(if f64::from(v as f32) < v { (v as f32).next_up() } else { v as f32 })
    }

    /// The greatest value `< v`, or the lowest one there is; `v` may be infinite.
    pub(super) fn greatest_below(self, v: f64) -> f32 {
        let v = if self.is_integral { v.ceil() - 1.0 } else { v };
        let is_below = if self.is_integral { f64::from(v as f32) <= v } else { f64::from(v as f32) < v };
        self.within(if is_below { v as f32 } else { (v as f32).next_down() })
    }

    /// The values whose distance from `s` is at most `limit` in exact arithmetic; `limit` may be infinite.
    pub(super) fn around(self, s: f32, limit: f64) -> Interval {
        let exact = f64::from(s);
        if self.is_integral {
            // Exact where it matters: sums beyond the type's range are cut off.
            let limit = limit.floor();
            Interval { low: self.within((exact - limit) as f32), high: self.within((exact + limit) as f32) }
        } else {
            let low = -greatest_to(-exact, limit);
            Interval { low: self.within(low), high: self.within(greatest_to(exact, limit)) }
        }
    }

    /// The middle half of a finite interval, or all of it if there is no value in that.
    pub(super) fn central(self, interval: Interval) -> Interval {
        let Interval { low, high } = interval;
        let (middle, quarter) = (0.5 * low + 0.5 * high, 0.25 * high - 0.25 * low);
        let [from, to] = [middle - quarter, middle + quarter];
        let [from, to] = if self.is_integral { [from.ceil(), to.floor()] } else { [from, to] };
        let central = Interval { low: from, high: to }.and(interval);
        if central.is_empty() { interval } else { central }
    }

    fn within(self, v: f32) -> f32 {
        v.clamp(self.lowest, self.highest)
    }

    /// The value in `interval` with the most trailing zeros in its magnitude: for an integer as a number, for an `f32` as a bit
    /// pattern, so that it has the fewest bits in its mantissa.
    ///
    /// There is exactly one, as no two multiples of 2ⁿ are without a multiple of 2ⁿ⁺¹ between them; and the roundest of an interval is the
    /// roundest of every smaller one that contains it. Neighbouring blocks whose intervals overlap therefore tend to agree.
    pub(super) fn roundest(self, interval: Interval) -> f32 {
        let Interval { low, high } = interval;
        if low <= 0.0 && high >= 0.0 {
            return 0.0;
        }
        let (sign, least, most) = if low > 0.0 { (1.0, low, high) } else { (-1.0, -high, -low) };
        let magnitude = if self.is_integral {
            roundest_key(least as u32, most as u32) as f32
        } else {
            f32::from_bits(roundest_key(least.to_bits(), most.to_bits()))
        };
        sign * magnitude
    }
}

/// The greatest `f32` that is at most `s + limit` in exact arithmetic; infinite if that is beyond all.
fn greatest_to(s: f64, limit: f64) -> f32 {
    let sum = s + limit;
    if sum.is_infinite() {
        return f32::INFINITY;
    }
    // What the rounded sum lacks (Knuth's exact addition).
    let of_limit = sum - s;
    let missing = (s - (sum - of_limit)) + (limit - of_limit);
    let nearest = sum as f32;
    let wide = f64::from(nearest);
    if wide > sum || (wide == sum && missing < 0.0) { nearest.next_down() } else { nearest }
}

/// The integer of `least..=most` with the most trailing zeros; `least` is positive.
fn roundest_key(least: u32, most: u32) -> u32 {
    if least >= most {
        return least;
    }
    // The highest bit in which they differ: the multiples of 2^bit among them are `most` without its lower bits and, at most, `least`.
    let bit = (least ^ most).ilog2();
    if least.trailing_zeros() > bit { least } else { most >> bit << bit }
}

/// The sample of type `T` that `value`, one of its values, stands for.
pub(super) fn sample<T: Scalar>(value: f32) -> T {
    // The least sample that is not below `value` is the one; only below the lowest there is none.
    match T::threshold(value) {
        isoray_grid::Threshold::AtLeast(sample) => sample,
        isoray_grid::Threshold::NoSurface => T::LOWEST,
    }
}

/// Allowed values, both ends included; none if `low > high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub(super) low: f32,
    pub(super) high: f32,
}

impl Interval {
    /// All values.
    pub(super) const ALL: Self = Self { low: f32::NEG_INFINITY, high: f32::INFINITY };
    /// No value.
    pub(super) const NONE: Self = Self { low: f32::INFINITY, high: f32::NEG_INFINITY };

    pub(super) fn exactly(value: f32) -> Self {
        Self { low: value, high: value }
    }

    pub(super) fn and(self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    pub(super) fn contains(self, value: f32) -> bool {
        self.low <= value && value <= self.high
    }

    pub(super) fn is_empty(self) -> bool {
        self.low > self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roundest_of_every_interval_of_bytes() {
        let values = Values::of::<u8>();
        for low in 0u8..=255 {
            for high in low..=255 {
                let best = (low..=high).max_by_key(|v| v.trailing_zeros()).unwrap();
                let interval = Interval { low: low.into(), high: high.into() };
                assert_eq!(values.roundest(interval), f32::from(best), "{interval:?}");
            }
        }
    }

    #[test]
    fn roundest_is_inside_and_mirrored() {
        let ends = [f32::MIN, -1e30, -3.7, -1.0, -1e-40, -0.0, 0.0, 1e-45, 0.1, 1.0, 1.5, 1e9, f32::MAX];
        let values = Values::of::<f32>();
        for low in ends {
            for high in ends.into_iter().filter(|&high| high >= low) {
                let r = values.roundest(Interval { low, high });
                assert!(low <= r && r <= high, "{low} {r} {high}");
                assert_eq!(
                    values.roundest(Interval { low: -high, high: -low }),
                    if r == 0.0 { 0.0 } else { -r }
                );
            }
        }
        assert_eq!(values.roundest(Interval { low: 0.7, high: 1.1 }), 1.0);
        assert_eq!(Values::of::<i16>().roundest(Interval { low: -37.0, high: -30.0 }), -32.0);
    }

    #[test]
    fn the_middle_half_is_inside() {
        let central = |v: Values, low, high| v.central(Interval { low, high });
        assert_eq!(central(Values::of::<u8>(), 10.0, 18.0), Interval { low: 12.0, high: 16.0 });
        assert_eq!(central(Values::of::<u8>(), 2.0, 3.0), Interval { low: 2.0, high: 3.0 });
        let floats = Values::of::<f32>();
        for (low, high) in
            [(f32::MIN, f32::MAX), (1.0, 1f32.next_up()), (-0.1, 0.3), (0.0, f32::from_bits(1))]
        {
            let inner = central(floats, low, high);
            assert!(
                !inner.is_empty() && low <= inner.low && inner.high <= high,
                "{inner:?} in {low}..{high}"
            );
        }
    }

    #[test]
    fn neighbours_of_real_numbers() {
        let bytes = Values::of::<u8>();
        assert_eq!((bytes.least_from(3.0), bytes.greatest_below(3.0)), (3.0, 2.0));
        assert_eq!((bytes.least_from(3.5), bytes.greatest_below(3.5)), (4.0, 3.0));
        assert_eq!((bytes.least_from(1e300), bytes.greatest_below(f64::INFINITY)), (255.0, 255.0));
        assert_eq!((bytes.least_from(-5.0), bytes.greatest_below(-5.0)), (0.0, 0.0));
        let floats = Values::of::<f32>();
        assert_eq!((floats.least_from(1.0), floats.greatest_below(1.0)), (1.0, 1f32.next_down()));
        assert_eq!((floats.least_from(0.1), floats.greatest_below(0.1)), (0.1, 0.1f32.next_down()));
        assert_eq!(floats.greatest_below(0.0), -f32::from_bits(1));
    }

    #[test]
    fn distances_are_exact() {
        let floats = Values::of::<f32>();
        // 1 + 1e-300 is 1 in f64; the greatest value to it is 1, and so is the least from 1 - 1e-300.
        assert_eq!(floats.around(1.0, 1e-300), Interval::exactly(1.0));
        // Rounding to nearest would give 1e8 + 8, which is farther away than 7.
        assert_eq!(floats.around(1e8, 7.0), Interval::exactly(1e8));
        assert_eq!(floats.around(1e8, 8.0), Interval { low: 1e8 - 8.0, high: 1e8 + 8.0 });
        assert_eq!(floats.around(-1.0, f64::MAX), Interval { low: f32::MIN, high: f32::MAX });
        assert_eq!(floats.around(0.0, f64::INFINITY), Interval { low: f32::MIN, high: f32::MAX });
        let shorts = Values::of::<i16>();
        assert_eq!(shorts.around(-32760.0, 9.9), Interval { low: -32768.0, high: -32751.0 });
        assert_eq!(shorts.around(5.0, f64::INFINITY), Interval { low: -32768.0, high: 32767.0 });
    }

    #[test]
    fn samples_of_their_values() {
        for n in u8::MIN..=u8::MAX {
            assert_eq!(sample::<u8>(f32::from(n)), n);
            assert_eq!(sample::<i8>(f32::from(n.cast_signed())), n.cast_signed());
        }
        assert_eq!((sample::<i16>(-32768.0), sample::<u16>(65535.0)), (i16::MIN, u16::MAX));
        assert_eq!((sample::<f32>(f32::MIN), sample::<f32>(0.1)), (f32::MIN, 0.1));
    }
}
