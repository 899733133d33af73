//! Errors of values, coefficients and gradients.

use isoray_cell::{Cubic, VALUE_ERROR_UNITS, gradient, trilinear};
use isoray_oracle::{SegmentCubic, SplitMix64};

use crate::cases::{U, cell, point, segment};
use crate::exact;

const CASES: u64 = 400_000;

/// Largest error of evaluating a cubic, in units of `2⁻²⁴·max|corner|`; derived at `EXCURSION_UNITS`.
const EVALUATION_ERROR_UNITS: f64 = 9.0;

/// Largest error of [`gradient`], in units of `2⁻²⁴·max|corner|`.
///
/// A `lerp` adds at most 3 units of its greatest value, see [`VALUE_ERROR_UNITS`]. Along x: the difference of two corners, at
/// most twice the greatest, is rounded once, and interpolated twice: (1 + 3 + 3)·2. Along y: corners are interpolated
/// once, 3 each, subtracted, 2·3 + 2, and interpolated, 3·2. Along z: interpolated twice, 6 each, and subtracted,
/// 2·6 + 2. That is 14 each; one more covers terms of second order.
const GRADIENT_ERROR_UNITS: f64 = 15.0;

/// Error in units of `2⁻²⁴·magnitude`; whole numbers of the least denormal number are forgiven.
fn units(found: f32, exact: f64, magnitude: f64) -> f64 {
    const UNDERFLOW: f64 = 1e-44;
    ((f64::from(found) - exact).abs() - UNDERFLOW).max(0.0) / (U * magnitude.max(f64::MIN_POSITIVE))
}

#[test]
fn coefficients_and_values_are_within_the_documented_bound() {
    let mut rng = SplitMix64::new(1);
    let [mut of_coefficients, mut of_values, mut of_cubic] = [0.0_f64; 3];
    for seed in 0..CASES {
        let cell = cell(&mut rng, seed);
        let segment = segment(&mut rng);
        let found = Cubic::along(&cell.corners, &segment);
        let expected = cell.along(&segment);
        for n in 0..4 {
            of_coefficients = of_coefficients.max(units(found.0[n], expected.bernstein[n], cell.magnitude));
        }
        let p = point(&mut rng);
        let value = exact::trilinear(&cell.exact, p.map(f64::from));
        of_values = of_values.max(units(trilinear(&cell.corners, p), value, cell.magnitude));
        // The cubic's own evaluation, from the coefficients it has.
        let own = SegmentCubic { bernstein: found.0.map(f64::from), ..expected };
        of_cubic = of_cubic.max(units(found.at(p[0]), own.at(p[0].into()), cell.magnitude));
    }
    println!("units: coefficients {of_coefficients:.2}, values {of_values:.2}, cubic {of_cubic:.2}");
    assert!(of_coefficients <= f64::from(VALUE_ERROR_UNITS), "{of_coefficients}");
    assert!(of_values <= f64::from(VALUE_ERROR_UNITS), "{of_values}");
    assert!(of_cubic <= EVALUATION_ERROR_UNITS, "{of_cubic}");
}

#[test]
fn gradients_are_within_the_documented_bound() {
    let mut rng = SplitMix64::new(2);
    let mut most = 0.0_f64;
    for seed in 0..CASES {
        // Without the rounding of a difference from the isovalue, which is not the gradient's.
        let cell = cell(&mut rng, seed);
        let corners = cell.corners.map(f64::from);
        let p = point(&mut rng);
        let expected = exact::gradient(&corners, p.map(f64::from));
        let found = gradient(&cell.corners, p);
        for axis in 0..3 {
            most = most.max(units(found[axis], expected[axis], cell.magnitude));
        }
    }
    println!("units: gradients {most:.2}");
    assert!(most <= GRADIENT_ERROR_UNITS, "{most}");
}
