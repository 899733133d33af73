//! Piecewise linear curves, and the points that make one follow another function.

use isoray_preint::{ControlPoint, TransferFunction, TransferFunctionError};

use super::color::{Triple, encode, mix};

/// A function of a value: linear between points, constant beyond them. Several points of equal value are a step from
/// the first to the last.
#[derive(Clone, Debug)]
pub(crate) struct Curve<const N: usize>(Vec<(f64, [f64; N])>);

impl<const N: usize> Curve<N> {
    /// At least one point, of finite values in their order.
    pub(crate) fn new(points: Vec<(f64, [f64; N])>) -> Self {
        debug_assert!(!points.is_empty() && points.is_sorted_by(|a, b| a.0 <= b.0));
        Self(points)
    }

    pub(crate) fn points(&self) -> &[(f64, [f64; N])] {
        &self.0
    }

    /// The first and the last value.
    pub(crate) fn span(&self) -> [f64; 2] {
        [self.0.first(), self.0.last()].map(|p| p.map_or(0.0, |p| p.0))
    }

    /// The same over positions from 0 to 1, the places of `low` to `high`; all at 0 if these are equal.
    pub(crate) fn normalized(&self, [low, high]: [f64; 2]) -> Self {
        let at = |x: f64| if high > low { ((x - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
        Self(self.0.iter().map(|&(x, y)| (at(x), y)).collect())
    }

    /// The limit from below (`above` false) or the one from above, which is the function's value.
    fn limit(&self, x: f64, above: bool) -> [f64; N] {
        let next = self.0.partition_point(|p| if above { p.0 <= x } else { p.0 < x });
        match (next.checked_sub(1).map(|n| self.0[n]), self.0.get(next)) {
            (Some((x0, y0)), Some(&(x1, y1))) => mix(y0, y1, (x - x0) / (x1 - x0)),
            (Some((_, y)), None) | (None, Some(&(_, y))) => y,
            (None, None) => [0.0; N],
        }
    }

    /// The value at `x`.
    pub(crate) fn at(&self, x: f64) -> [f64; N] {
        self.limit(x, true)
    }
}

/// Colour and extinction of control points, in this order.
pub(crate) type Function = Curve<4>;

/// Colours and extinctions as one function, with the points of both.
pub(crate) fn join(colors: &Curve<3>, extinctions: &Curve<1>) -> Function {
    let mut values: Vec<f64> =
        colors.0.iter().map(|p| p.0).chain(extinctions.0.iter().map(|p| p.0)).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let mut points = Vec::with_capacity(values.len());
    for x in values {
        let [below, above] = [false, true].map(|side| {
            let ([r, g, b], [extinction]) = (colors.limit(x, side), extinctions.limit(x, side));
            (x, [r, g, b, extinction])
        });
        points.push(below);
        if above.1 != below.1 {
            points.push(above);
        }
    }
    Curve(points)
}

/// The transfer function of these points; of those whose values round to the same `f32`, the first and the last stay.
pub(crate) fn finish(function: &Function) -> Result<TransferFunction, TransferFunctionError> {
    let mut points: Vec<ControlPoint> = Vec::with_capacity(function.0.len());
    for &(value, [r, g, b, extinction]) in &function.0 {
        let color = [r, g, b].map(|c| c as f32);
        let point = ControlPoint { value: value as f32, color, extinction: extinction as f32 };
        if let [.., first, last] = &mut points[..]
            && first.value == point.value
            && last.value == point.value
        {
            *last = point;
        } else {
            points.push(point);
        }
    }
    TransferFunction::new(points)
}

/// Places between two neighbouring points at which their chord is compared with the function.
const CHECKS: u32 = 7;
/// Most halvings of a piece: a kink in it is then a 4096th wide, less than a display has pixels.
const HALVINGS: u32 = 12;
/// Share of a tolerance that the comparison at some places may use up; the rest is for those between.
const SHARE: f64 = 0.75;

/// Largest deviation of a colour from the function that is followed, in display colours from 0 to 1: a quarter of a
/// level of 8 bits.
pub(crate) const COLOR_TOLERANCE: f64 = 1.0 / 1024.0;

/// Whether a chord's linear colour looks like the one it stands for.
pub(crate) fn looks_alike(exact: &Triple, chord: &Triple) -> bool {
    exact.iter().zip(chord).all(|(&a, &b)| (encode(a) - encode(b)).abs() <= SHARE * COLOR_TOLERANCE)
}

/// Largest deviation of an extinction, relative to it.
const EXTINCTION_TOLERANCE: f64 = 0.01;
/// The same relative to the larger end of the piece: where the extinction vanishes no chord could be close to it.
const EXTINCTION_FLOOR: f64 = 1e-4;

/// Whether a chord's extinction is close to the one it stands for; `largest` is the larger one of the piece's ends.
pub(crate) fn is_close(exact: f64, chord: f64, largest: f64) -> bool {
    (exact - chord).abs() <= SHARE * EXTINCTION_TOLERANCE * exact + EXTINCTION_FLOOR * largest
}

/// Appends points after `span[0]` up to and with `span[1]`, so that the chords between them follow `function` over
/// these values, where the first point is already there.
pub(crate) fn follow<const N: usize>(
    points: &mut Vec<(f64, [f64; N])>,
    [low, high]: [f64; 2],
    function: &dyn Fn(f64) -> [f64; N],
    alike: &dyn Fn(&[f64; N], &[f64; N]) -> bool,
) {
    let piece = [(low, function(low)), (high, function(high))];
    halve(points, piece, function, alike, HALVINGS);
}

fn halve<const N: usize>(
    points: &mut Vec<(f64, [f64; N])>,
    [a, b]: [(f64, [f64; N]); 2],
    function: &dyn Fn(f64) -> [f64; N],
    alike: &dyn Fn(&[f64; N], &[f64; N]) -> bool,
    halvings: u32,
) {
    let straight = (1..=CHECKS).all(|n| {
        let s = f64::from(n) / f64::from(CHECKS + 1);
        alike(&function(a.0 * (1.0 - s) + b.0 * s), &mix(a.1, b.1, s))
    });
    let middle = 0.5 * (a.0 + b.0);
    if straight || halvings == 0 || middle <= a.0 || middle >= b.0 {
        points.push(b);
        return;
    }
    let middle = (middle, function(middle));
    halve(points, [a, middle], function, alike, halvings - 1);
    halve(points, [middle, b], function, alike, halvings - 1);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_followed_with_few_points() {
        let square = |x: f64| [x * x];
        let mut points = vec![(0.0, [0.0])];
        follow(&mut points, [0.0, 1.0], &square, &|a, b| (a[0] - b[0]).abs() < 1e-3);
        // Chords of a parabola of length h are off by h² / 4.
        assert_eq!(points.len(), 17);
        let curve = Curve::new(points);
        assert!(
            (0..=1000)
                .all(|n| (curve.at(f64::from(n) / 1e3)[0] - square(f64::from(n) / 1e3)[0]).abs() < 1e-3)
        );
    }

    #[test]
    fn joining_keeps_steps_of_either_side() {
        let colors = Curve::new(vec![(0.0, [0.0; 3]), (2.0, [1.0; 3]), (2.0, [0.5; 3])]);
        let extinctions = Curve::new(vec![(1.0, [2.0]), (1.0, [4.0]), (3.0, [0.0])]);
        let joined = join(&colors, &extinctions);
        let expected = [
            (0.0, [0.0, 0.0, 0.0, 2.0]),
            (1.0, [0.5, 0.5, 0.5, 2.0]),
            (1.0, [0.5, 0.5, 0.5, 4.0]),
            (2.0, [1.0, 1.0, 1.0, 2.0]),
            (2.0, [0.5, 0.5, 0.5, 2.0]),
            (3.0, [0.5, 0.5, 0.5, 0.0]),
        ];
        assert_eq!(joined.points(), expected);
    }

    #[test]
    fn values_that_round_to_one_become_a_step() {
        let points = (0..5).map(|n| (1.0 + f64::from(n) * 1e-12, [f64::from(n); 4])).collect();
        let function = finish(&Curve::new(points)).unwrap();
        let extinctions: Vec<f32> = function.points().iter().map(|p| p.extinction).collect();
        assert_eq!(extinctions, [0.0, 4.0]);
    }
}
