//! Transfer functions: what colour and extinction a value has.

/// A control point of a transfer function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// In the data's own units.
    pub value: f32,
    /// Linear RGB, not negative.
    pub color: [f32; 3],
    /// Extinction `τ ≥ 0` per world unit of length.
    pub extinction: f32,
}

/// Colour and extinction as functions of the value: linear between control points, constant beyond the first and the last. Two points of
/// equal value are a step; the later one holds at and above it.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    points: Vec<ControlPoint>,
}

/// Why control points are not a transfer function.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TransferFunctionError {
    /// There are none.
    #[error("expected at least one control point, found none")]
    Empty,
    /// A number is NaN, infinite or too large for the sums that are made of it.
    #[error("control point {index}: expected a {what} between -1e30 and 1e30, found {found}")]
    NotFinite {
        /// Of the control point, from 0.
        index: usize,
        /// Which number.
        what: &'static str,
        /// Its value.
        found: f32,
    },
    /// A value is less than the one before.
    #[error(
        "control point {index}: expected a value of at least {before}, that of the point before, found {found}"
    )]
    Decreasing {
        /// Of the control point, from 0.
        index: usize,
        /// The value before it.
        before: f32,
        /// Its own.
        found: f32,
    },
    /// More than two points have the same value: those between the first and the last could never be seen.
    #[error(
        "control point {index}: expected at most two points of one value, found a third of value {value}"
    )]
    Crowded {
        /// Of the third, from 0.
        index: usize,
        /// The value.
        value: f32,
    },
    /// A colour or an extinction is less than zero.
    #[error("control point {index}: expected a {what} of at least 0, found {found}")]
    Negative {
        /// Of the control point, from 0.
        index: usize,
        /// Which number.
        what: &'static str,
        /// Its value.
        found: f32,
    },
}

impl TransferFunctionError {
    /// The control point at fault, from 0; `None` if there is none at all.
    pub fn index(&self) -> Option<usize> {
        match *self {
            Self::Empty => None,
            Self::NotFinite { index, .. }
            | Self::Decreasing { index, .. }
            | Self::Crowded { index, .. }
            | Self::Negative { index, .. } => Some(index),
        }
    }
}

/// The largest magnitude of a number in a control point: products of two, and their sums along a ray, stay finite.
pub const LARGEST: f32 = 1e30;

impl TransferFunction {
    /// The function through `points`, in the order of their values.
    ///
    /// # Errors
    ///
    /// If there is no point, values decrease, three are equal, or a number is out of range.
    pub fn new(points: Vec<ControlPoint>) -> Result<Self, TransferFunctionError> {
        use TransferFunctionError::{Crowded, Decreasing, Empty, Negative, NotFinite};
        if points.is_empty() {
            return Err(Empty);
        }
        for (index, point) in points.iter().enumerate() {
            let [r, g, b] = point.color;
            let numbers = [
                ("value", point.value),
                ("red", r),
                ("green", g),
                ("blue", b),
                ("extinction", point.extinction),
            ];
            for (n, (what, found)) in numbers.into_iter().enumerate() {
                // Also false for what is no number.
                if !(-LARGEST..=LARGEST).contains(&found) {
                    return Err(NotFinite { index, what, found });
                }
                if n > 0 && found < 0.0 {
                    return Err(Negative { index, what, found });
                }
            }
        }
        for index in 1..points.len() {
            let [before, found] = [points[index - 1].value, points[index].value];
            if found < before {
                return Err(Decreasing { index, before, found });
            }
            if index > 1 && points[index - 2].value == found {
                return Err(Crowded { index, value: found });
            }
        }
        Ok(Self { points })
    }

    /// The control points.
    pub fn points(&self) -> &[ControlPoint] {
        &self.points
    }

    /// Colour and extinction at `value`: the error of each is at most 4 roundings of the larger of the two that it lies between.
    pub fn at(&self, value: f32) -> ControlPoint {
        let above = self.points.partition_point(|p| p.value <= value);
        let Some(low) = above.checked_sub(1).map(|n| self.points[n]) else {
            return ControlPoint { value, ..self.points[0] };
        };
        let Some(high) = self.points.get(above) else { return ControlPoint { value, ..low } };
        let x = (f64::from(value) - f64::from(low.value)) / (f64::from(high.value) - f64::from(low.value));
        let mix = |a: f32, b: f32| (f64::from(a) * (1.0 - x) + f64::from(b) * x) as f32;
        ControlPoint {
            value,
            color: std::array::from_fn(|n| mix(low.color[n], high.color[n])),
            extinction: mix(low.extinction, high.extinction),
        }
    }

    /// The same with every extinction multiplied by `factor`.
    ///
    /// # Errors
    ///
    /// If the factor is negative or no number, or a product is out of range.
    pub fn with_extinction_scaled(&self, factor: f32) -> Result<Self, TransferFunctionError> {
        let scaled = |p: &ControlPoint| ControlPoint { extinction: p.extinction * factor, ..*p };
        Self::new(self.points.iter().map(scaled).collect())
    }

    /// The same extinctions, all of white.
    pub fn in_white(&self) -> Self {
        Self { points: self.points.iter().map(|p| ControlPoint { color: [1.0; 3], ..*p }).collect() }
    }

    /// The largest component of any colour.
    pub fn largest_color(&self) -> f32 {
        self.points.iter().flat_map(|p| p.color).fold(0.0, f32::max)
    }
}
