//! Colour and extinction as functions of the value.

/// A control point of a transfer function.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TransferPoint {
    /// In the data's own units.
    pub value: f64,
    /// Linear RGB, not negative.
    pub color: [f64; 3],
    /// Extinction `τ ≥ 0` per world unit of length.
    pub extinction: f64,
}

impl TransferPoint {
    /// Colour and extinction a fraction `x` of the way to `other`; the value is not interpolated.
    pub(super) fn mixed(&self, other: &Self, x: f64) -> Self {
        let mix = |a: f64, b: f64| a * (1.0 - x) + b * x;
        Self {
            value: self.value,
            color: std::array::from_fn(|n| mix(self.color[n], other.color[n])),
            extinction: mix(self.extinction, other.extinction),
        }
    }
}

/// A transfer function by its control points, values ascending: linear between them, constant beyond the first and the last.
///
/// Two points of equal value are a step; the later one holds at and above it. No points at all are a function that is zero.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferPoints(pub Vec<TransferPoint>);

/// What the function is made of between two neighbouring control points, or beyond an end, where both are the same.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval<'a> {
    pub(super) from: &'a TransferPoint,
    pub(super) to: &'a TransferPoint,
}

impl Interval<'_> {
    /// Width in value; zero beyond an end.
    pub(super) fn width(&self) -> f64 {
        self.to.value - self.from.value
    }
}

impl TransferPoints {
    /// Colour and extinction at `value`, to some roundings of the larger of the two points that it lies between.
    pub fn at(&self, value: f64) -> TransferPoint {
        let at = self.interval(self.0.partition_point(|p| p.value <= value)).map(|i| {
            let x = if i.width() > 0.0 { (value - i.from.value) / i.width() } else { 0.0 };
            i.from.mixed(i.to, x)
        });
        TransferPoint { value, ..at.unwrap_or_default() }
    }

    /// The interval in front of control point `index`, the last being that behind all of them; `None` if there are no points.
    pub(super) fn interval(&self, index: usize) -> Option<Interval<'_>> {
        let to = self.0.get(index).or(self.0.last())?;
        let from = index.checked_sub(1).map_or(to, |n| &self.0[n]);
        Some(Interval { from, to })
    }

    /// Whether there is no extinction at values between `low` and `high`, both included.
    pub(super) fn is_clear(&self, low: f64, high: f64) -> bool {
        let first = self.0.partition_point(|p| p.value <= low).saturating_sub(1);
        let visible = self.0[first.min(self.0.len())..]
            .iter()
            .take_while(|p| p.value <= high)
            .find(|p| p.extinction != 0.0);
        visible.is_none() && self.at(low).extinction == 0.0 && self.at(high).extinction == 0.0
    }
}
