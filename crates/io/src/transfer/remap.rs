//! Moving a transfer function to another range of values.

use isoray_preint::{LARGEST, TransferFunction, TransferFunctionError};

use super::curve::{Curve, Function, finish};

/// Where the values of a transfer function are put. The default leaves them where they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Remap {
    /// The values that the function's first and last value become, in the data's units; `None` leaves them. Points
    /// of a single value come to the lower end.
    pub range: Option<[f32; 2]>,
    /// Equal distances in the function become equal ratios of values. The range must be positive then. Points are
    /// inserted so that between two points of the function, colour and extinction follow the logarithm within a
    /// 1024th of their difference.
    pub log: bool,
}

/// Why a transfer function cannot be moved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RemapError {
    /// The range is empty, or its ends are no numbers or too large.
    #[error(
        "expected a range of two numbers between -1e30 and 1e30, the smaller one first, found {low} to {high}"
    )]
    Range {
        /// First value.
        low: f32,
        /// Last value.
        high: f32,
    },
    /// The logarithm of zero or less.
    #[error("expected positive values to map by their logarithm, found the range {low} to {high}")]
    NotPositive {
        /// First value.
        low: f32,
        /// Last value.
        high: f32,
    },
    /// The points that come out are no transfer function.
    #[error(transparent)]
    Function(#[from] TransferFunctionError),
}

/// Reciprocal of the share of a difference by which a chord may miss the logarithm.
const LOG_PRECISION: f64 = 1024.0;

impl Remap {
    /// The transfer function with its values moved.
    ///
    /// # Errors
    ///
    /// If the range, or without one the function's own values, are not increasing numbers of moderate size, or are
    /// not positive where their logarithm is asked for.
    pub fn apply(&self, function: &TransferFunction) -> Result<TransferFunction, RemapError> {
        let point = |p: &isoray_preint::ControlPoint| {
            let [r, g, b] = p.color.map(f64::from);
            (f64::from(p.value), [r, g, b, f64::from(p.extinction)])
        };
        let points = Curve::new(function.points().iter().map(point).collect());
        let own = points.span();
        let range = self.range.unwrap_or(own.map(|v| v as f32));
        check(range, self.range.is_some(), self.log)?;
        if self.range.is_none() && !self.log {
            return Ok(function.clone());
        }
        Ok(finish(&spread(&points.normalized(own), range, self.log))?)
    }
}

/// Refuses a range that nothing can be spread over; `strictly` also one of a single value.
pub(crate) fn check([low, high]: [f32; 2], strictly: bool, log: bool) -> Result<(), RemapError> {
    let numbers = -LARGEST..=LARGEST;
    let ordered = if strictly { low < high } else { low <= high };
    if !(numbers.contains(&low) && numbers.contains(&high) && ordered) {
        return Err(RemapError::Range { low, high });
    }
    if log && low <= 0.0 { Err(RemapError::NotPositive { low, high }) } else { Ok(()) }
}

/// A function of positions from 0 to 1 as one of the values of `range`.
pub(crate) fn spread(positions: &Function, range: [f32; 2], log: bool) -> Function {
    let [low, high] = range.map(f64::from);
    let value = |u: f64| {
        if log { low.powf(1.0 - u) * high.powf(u) } else { low * (1.0 - u) + high * u }.clamp(low, high)
    };
    let mut points = Vec::with_capacity(positions.points().len());
    let mut before: Option<(f64, [f64; 4])> = None;
    for &(u, y) in positions.points() {
        if let Some((u0, y0)) = before
            && log
        {
            let pieces = log_pieces((high / low).ln() * (u - u0));
            for n in 1..pieces {
                let s = f64::from(n) / f64::from(pieces);
                points.push((value(u0 + (u - u0) * s), super::color::mix(y0, y, s)));
            }
        }
        points.push((value(u), y));
        before = Some((u, y));
    }
    // Rounding of the power could swap two neighbours by a unit in the last place.
    let mut least = low;
    for point in &mut points {
        point.0 = point.0.max(least);
        least = point.0;
    }
    Curve::new(points)
}

/// Into how many pieces of equal ratio a span of `logarithm` is cut: a chord over a ratio `e^l` misses the logarithm
/// by at most `l / 8` of the piece (the series of the maximum; the rest of it is negative).
fn log_pieces(logarithm: f64) -> u32 {
    (logarithm * (LOG_PRECISION / 8.0)).sqrt().ceil().max(1.0) as u32
}

#[cfg(test)]
mod tests {
    use isoray_preint::ControlPoint;

    use super::*;

    fn ramp(low: f32, high: f32) -> TransferFunction {
        let point = |value, y: f32| ControlPoint { value, color: [y; 3], extinction: y };
        TransferFunction::new(vec![point(low, 0.0), point(high, 1.0)]).unwrap()
    }

    #[test]
    fn the_logarithm_is_followed() {
        for (low, high) in [(1.0, 1.001), (1.0, 10.0), (1e-3, 1e3), (1e-30, 1e30)] {
            let moved = Remap { range: Some([low, high]), log: true }.apply(&ramp(-5.0, 7.0)).unwrap();
            assert_eq!(moved.points().first().unwrap().value, low);
            assert_eq!(moved.points().last().unwrap().value, high);
            let [a, b] = [low, high].map(|v| f64::from(v).ln());
            for n in 0..=5000 {
                let u = f64::from(n) / 5000.0;
                let value = (a * (1.0 - u) + b * u).exp() as f32;
                // What rounding the value to f32 does to the position.
                let slack = 1e-6 / (b - a).min(1.0);
                let error = (f64::from(moved.at(value).extinction) - u).abs();
                assert!(error <= 1.0 / 1024.0 + slack, "{low} to {high} at {u}: {error}");
            }
        }
    }

    #[test]
    fn ranges_that_make_no_sense() {
        let apply = |range, log| Remap { range, log }.apply(&ramp(-1.0, 1.0));
        for range in [[1.0, 1.0], [2.0, 1.0], [f32::NAN, 1.0], [0.0, f32::INFINITY]] {
            assert!(matches!(apply(Some(range), false), Err(RemapError::Range { .. })), "{range:?}");
        }
        assert_eq!(apply(Some([0.0, 1.0]), true), Err(RemapError::NotPositive { low: 0.0, high: 1.0 }));
        assert_eq!(apply(None, true), Err(RemapError::NotPositive { low: -1.0, high: 1.0 }));
        assert_eq!(apply(None, false), Ok(ramp(-1.0, 1.0)));
        assert_eq!(apply(Some([3.0, 4.0]), false), Ok(ramp(3.0, 4.0)));
    }
}
