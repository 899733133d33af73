//! From opacities per unit of length to extinctions.

use super::curve::{Curve, follow, is_close};

/// Smallest transmittance per unit of length that an opacity stands for, 2⁻¹⁰: a quarter of a level of 8 bits. An
/// opacity of 1, for which no extinction is large enough, becomes 10 ln 2 per unit.
const LEAST_TRANSMITTANCE: f64 = 1.0 / 1024.0;

/// The extinction, per world unit, of which `unit` (world units) have this opacity.
pub(crate) fn extinction(opacity: f64, unit: f64) -> f64 {
    -(-opacity).max(LEAST_TRANSMITTANCE - 1.0).ln_1p() / unit
}

/// A point of an opacity function, with the shape of what follows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OpacityPoint {
    pub(crate) value: f64,
    /// From 0 to 1.
    pub(crate) opacity: f64,
    /// Where, from this point (0) to the next (1), the mean of both opacities lies.
    pub(crate) midpoint: f64,
    /// From 0, a straight line, to 1, a step at the midpoint.
    pub(crate) sharpness: f64,
}

/// Sharpness from which on there is a step at the midpoint.
const STEP: f64 = 0.99;
/// Sharpness below which there are straight lines.
const LINE: f64 = 0.01;
/// Least distance of a midpoint from the points on either side.
const MARGIN: f64 = 1e-5;

/// How far, from 0 to 1, the opacity has come from that of `point` to that of the next at a position `s` from 0 to 1:
/// the rule of VTK's `vtkPiecewiseFunction`. Position is bent to have the midpoint at ½; with sharpness, it is drawn to
/// the ends by a power, and a cubic with slopes of 1 − sharpness at its ends takes the place of the line.
fn progress(point: &OpacityPoint, s: f64) -> f64 {
    let middle = point.midpoint.clamp(MARGIN, 1.0 - MARGIN);
    let s = if s < middle { 0.5 * s / middle } else { 0.5 + 0.5 * (s - middle) / (1.0 - middle) };
    if point.sharpness < LINE {
        return s;
    }
    let power = 1.0 + 10.0 * point.sharpness;
    let half = |s: f64| 0.5 * (2.0 * s).powf(power);
    let s = if s < 0.5 { half(s) } else { 1.0 - half(1.0 - s) };
    let slope = 1.0 - point.sharpness;
    // Hermite's cubic from 0 to 1 with equal slopes.
    let smooth = s * s * (3.0 - 2.0 * s) + slope * s * (1.0 - s) * (1.0 - 2.0 * s);
    smooth.clamp(0.0, 1.0)
}

/// The extinctions of an opacity function of at least one point, values in order: within 1 % of each (and 10⁻⁴ of the
/// larger one of two neighbouring points).
pub(crate) fn extinctions(points: &[OpacityPoint], unit: f64) -> Curve<1> {
    let of = |p: &OpacityPoint| (p.value, [extinction(p.opacity, unit)]);
    let mut curve: Vec<(f64, [f64; 1])> = points.first().map(of).into_iter().collect();
    for pair in points.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let place = |s: f64| a.value * (1.0 - s) + b.value * s;
        let middle = a.midpoint.clamp(MARGIN, 1.0 - MARGIN);
        if a.value == b.value || a.opacity == b.opacity {
            curve.push(of(b));
        } else if a.sharpness > STEP {
            curve.extend([(place(middle), of(a).1), (place(middle), of(b).1), of(b)]);
        } else {
            let function = |s: f64| {
                let share = progress(a, s);
                [extinction(a.opacity * (1.0 - share) + b.opacity * share, unit)]
            };
            let largest = of(a).1[0].max(of(b).1[0]);
            let close = |exact: &[f64; 1], chord: &[f64; 1]| is_close(exact[0], chord[0], largest);
            let mut positions = Vec::new();
            follow(&mut positions, [0.0, middle], &function, &close);
            follow(&mut positions, [middle, 1.0], &function, &close);
            curve.extend(positions.into_iter().map(|(s, y)| (place(s), y)));
        }
    }
    Curve::new(curve)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(from: f64, to: f64, midpoint: f64, sharpness: f64) -> [OpacityPoint; 2] {
        [
            OpacityPoint { value: 10.0, opacity: from, midpoint, sharpness },
            OpacityPoint { value: 30.0, opacity: to, midpoint: 0.5, sharpness: 0.0 },
        ]
    }

    #[test]
    fn opacity_of_the_extinction_is_the_opacity() {
        for opacity in [0.0, 1e-12, 0.1, 0.5, 0.999] {
            let back = -(-2.5 * extinction(opacity, 2.5)).exp_m1();
            assert!((back - opacity).abs() <= 1e-14 + 1e-14 * opacity, "{opacity}: {back}");
        }
        assert_eq!(extinction(1.0, 1.0), 10.0 * 2f64.ln());
        assert_eq!(extinction(0.0, 1.0).to_bits(), 0);
    }

    #[test]
    fn extinction_follows_the_opacity_within_a_percent() {
        for (from, to) in [(0.0, 1.0), (1.0, 0.2), (0.0, 0.01), (0.9, 0.95)] {
            for (midpoint, sharpness) in [(0.5, 0.0), (0.1, 0.0), (0.5, 0.3), (0.7, 0.9)] {
                let points = pair(from, to, midpoint, sharpness);
                let curve = extinctions(&points, 3.0);
                assert!(curve.points().len() < 120, "{}", curve.points().len());
                let largest = extinction(from.max(to), 3.0);
                for n in 0..=4000 {
                    let s = f64::from(n) / 4000.0;
                    let share = progress(&points[0], s);
                    let exact = extinction(from * (1.0 - share) + to * share, 3.0);
                    let error = (curve.at(10.0 + 20.0 * s)[0] - exact).abs();
                    assert!(error <= 0.01 * exact + 2e-4 * largest, "{from} {to} {midpoint} {sharpness} {s}");
                }
            }
        }
    }

    #[test]
    fn midpoint_and_sharpness() {
        let at = |midpoint, sharpness, s| progress(&pair(0.0, 1.0, midpoint, sharpness)[0], s);
        assert_eq!(at(0.5, 0.0, 0.3), 0.3);
        assert_eq!(at(0.2, 0.0, 0.2), 0.5);
        assert_eq!(at(0.2, 0.4, 0.2), 0.5);
        assert!(at(0.5, 0.5, 0.25) < 0.05 && at(0.5, 0.5, 0.75) > 0.95);
        let curve = extinctions(&pair(0.25, 0.75, 0.5, 1.0), 1.0);
        let expected = [(10.0, 0.25), (20.0, 0.25), (20.0, 0.75), (30.0, 0.75)];
        assert_eq!(curve.points(), expected.map(|(x, o)| (x, [extinction(o, 1.0)])));
    }
}
