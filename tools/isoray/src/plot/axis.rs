//! Value axes: where a number lies, and which numbers are written at them.

/// A range of numbers along one side of a plot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
    log: bool,
}

impl Axis {
    /// From `low` to the larger `high`; with `log`, which needs positive ends, equal ratios are equally far apart.
    pub(crate) fn new([low, high]: [f64; 2], log: bool) -> Self {
        Self { low, high, log }
    }

    /// The range with a share of itself added at both ends, or, if it is a single value, with something around it.
    pub(crate) fn with_margin([low, high]: [f64; 2], log: bool, share: f64) -> Self {
        if log && high > low {
            let more = (high / low).powf(share);
            Self::new([low / more, high * more], true)
        } else {
            let more = if high > low { share * (high - low) } else { 0.5 * low.abs().max(1.0) };
            Self::new([low - more, high + more], false)
        }
    }

    /// 0 at the lower and 1 at the upper end, beyond them outside of that.
    pub(crate) fn place(&self, value: f64) -> f64 {
        match self.log {
            true => (value.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln(),
            false => (value - self.low) / (self.high - self.low),
        }
    }

    /// The inverse of [`place`](Self::place).
    pub(crate) fn value(&self, place: f64) -> f64 {
        match self.log {
            true => self.low * (self.high / self.low).powf(place),
            false => self.low * (1.0 - place) + self.high * place,
        }
    }

    /// At most about `count` round numbers on the axis, and how they are written.
    pub(crate) fn ticks(&self, count: u32) -> Vec<(f64, String)> {
        let decades = if self.log { (self.high / self.low).log10() } else { 0.0 };
        if decades < 1.0 {
            return self.even_ticks(count);
        }
        let every = (decades / f64::from(count)).ceil().max(1.0) as i32;
        let powers =
            (self.low.log10().ceil() as i32..=self.high.log10().floor() as i32).filter(|p| p % every == 0);
        powers.map(|p| 10f64.powi(p)).map(|v| (v, label(v, v))).collect()
    }

    fn even_ticks(&self, count: u32) -> Vec<(f64, String)> {
        let least = (self.high - self.low) / f64::from(count.max(1));
        let power = 10f64.powf(least.log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= least).unwrap_or(least);
        let first = (self.low / step).ceil();
        // Negative zero has a sign that nobody wants to read.
        let numbers = (0..=count).map(|n| (first + f64::from(n)) * step + 0.0);
        numbers.take_while(|v| *v <= self.high).map(|v| (v, label(v, step))).collect()
    }
}

/// A number with as many digits as its distance to the next one needs.
fn label(value: f64, step: f64) -> String {
    let digits = -step.abs().log10().floor();
    if value == 0.0 {
        "0".to_owned()
    } else if value.abs() >= 1e6 || digits > 4.0 {
        let digits = (value.abs().log10().floor() + digits).clamp(0.0, 12.0);
        format!("{value:.*e}", digits as usize)
    } else {
        format!("{value:.*}", digits.max(0.0) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: Axis, count: u32) -> Vec<String> {
        axis.ticks(count).into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn round_numbers() {
        assert_eq!(labels(Axis::new([-0.45, 1.3], false), 5), ["0", "0.5", "1.0"]);
        assert_eq!(
            labels(Axis::new([-40.0, 1296.0], false), 7),
            ["0", "200", "400", "600", "800", "1000", "1200"]
        );
        assert_eq!(labels(Axis::new([0.0, 3e-7], false), 3), ["0", "1e-7", "2e-7", "3e-7"]);
        assert_eq!(labels(Axis::new([1e8, 1.3e8], false), 3), ["1.0e8", "1.1e8", "1.2e8", "1.3e8"]);
        assert_eq!(labels(Axis::new([0.01, 2e3], true), 9), ["0.01", "0.1", "1", "10", "100", "1000"]);
        assert_eq!(
            labels(Axis::new([1e-20, 1e20], true), 4),
            ["1e-20", "1e-10", "0", "1e10", "1e20"].map(|t| if t == "0" { "1" } else { t })
        );
    }

    #[test]
    fn places_and_values() {
        for axis in [Axis::with_margin([-2.0, 3.0], false, 0.1), Axis::with_margin([1.0, 1e6], true, 0.1)] {
            assert!((axis.value(axis.place(2.5)) - 2.5).abs() < 1e-9);
        }
        assert_eq!(Axis::with_margin([5.0, 5.0], true, 0.1).place(5.0), 0.5);
    }
}
