//! Distances in units in the last place.

/// The number of steps from one f32 to the next that lead from `a` to `b`.
///
/// Zeros of both signs are one number, infinities follow the largest finite numbers, and a NaN is
/// `u64::MAX` away from everything.
pub fn ulps_f32(a: f32, b: f32) -> u64 {
    if a.is_nan() || b.is_nan() {
        return u64::MAX;
    }
    rank(a).abs_diff(rank(b))
}

/// The place of a number in the order of all f32, zero at 0.
fn rank(x: f32) -> i64 {
    let magnitude = i64::from(x.abs().to_bits());
    if x < 0.0 { -magnitude } else { magnitude }
}

/// `|t - exact|` in units of the spacing of f32 just above `|t|`.
///
/// Zero where both are the same infinity, infinite where just one of them is not finite, or is NaN.
pub fn error_in_ulps(t: f32, exact: f64) -> f64 {
    let wide = f64::from(t);
    if wide == exact {
        return 0.0;
    }
    if !wide.is_finite() || !exact.is_finite() {
        return f64::INFINITY;
    }
    (wide - exact).abs() / spacing(t)
}

/// The distance from a finite `|t|` to the next larger f32, were the exponent unbounded.
fn spacing(t: f32) -> f64 {
    const FRACTION_BITS: i32 = 23;
    const BIAS: i32 = 127;
    let exponent = ((t.abs().to_bits() >> FRACTION_BITS) as i32).max(1) - BIAS;
    2_f64.powi(exponent - FRACTION_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_between_neighbours_and_across_zero() {
        assert_eq!(ulps_f32(1.0, 1.0_f32.next_up()), 1);
        assert_eq!(ulps_f32(0.0, -0.0), 0);
        assert_eq!(ulps_f32(0.0_f32.next_up(), 0.0_f32.next_down()), 2);
        assert_eq!(ulps_f32(f32::MAX, f32::INFINITY), 1);
        assert_eq!(ulps_f32(f32::NAN, f32::NAN), u64::MAX);
        assert_eq!(ulps_f32(1.0, 2.0), 1 << 23);
    }

    #[test]
    fn errors_are_fractions_of_the_spacing() {
        let spacing = f64::from(f32::EPSILON);
        assert_eq!(error_in_ulps(1.0, 1.0 + 0.25 * spacing), 0.25);
        assert_eq!(error_in_ulps(-2.0, -2.0 - spacing), 0.5);
        assert_eq!(error_in_ulps(0.0, 2.0_f64.powi(-149)), 1.0);
        assert_eq!(error_in_ulps(f32::MAX, f64::from(f32::MAX) - 2.0_f64.powi(104)), 1.0);
        assert_eq!(error_in_ulps(f32::INFINITY, f64::INFINITY), 0.0);
        assert_eq!(error_in_ulps(f32::NAN, 1.0), f64::INFINITY);
    }
}
