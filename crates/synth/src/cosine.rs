//! A cosine that is the same on every machine.

use std::f64::consts::TAU;

/// The cosine of `x` whole turns to within 4·10⁻¹⁶: the mathematics library's own differs between systems.
///
/// The reduction to an eighth of a turn is exact; after it, `2πx` is rounded once (10⁻¹⁶ of at most π/4) and the first
/// term left out of the series is below (π/4)¹⁸/18! = 2·10⁻¹⁸.
pub(crate) fn cos_turns(x: f64) -> f64 {
    let folded = (x - x.round()).abs();
    let (a, sign) = if folded > 0.25 { (0.5 - folded, -1.0) } else { (folded, 1.0) };
    sign * if a > 0.125 { sin_small(TAU * (0.25 - a)) } else { cos_small(TAU * a) }
}

/// The sine of `x` whole turns; see [`cos_turns`].
pub(crate) fn sin_turns(x: f64) -> f64 {
    cos_turns(x - 0.25)
}

/// The first nine coefficients of the series whose terms are powers of `−y²`, over `1, first (first + 1), …`.
const fn series(first: u32) -> [f64; 9] {
    let mut coefficients = [1.0; 9];
    let mut n = 1;
    while n < 9 {
        let a = (first + 2 * (n as u32 - 1)) as f64;
        coefficients[n] = coefficients[n - 1] / -(a * (a + 1.0));
        n += 1;
    }
    coefficients
}

const COSINE: [f64; 9] = series(1);
const SINE: [f64; 9] = series(2);

fn horner(coefficients: &[f64; 9], square: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * square + c)
}

fn cos_small(y: f64) -> f64 {
    horner(&COSINE, y * y)
}

fn sin_small(y: f64) -> f64 {
    y * horner(&SINE, y * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_library() {
        for n in -4000..=4000 {
            let x = f64::from(n) / 997.0;
            let within = 1e-15 + 1e-15 * x.abs() * TAU; // the library is given a rounded angle
            assert!((cos_turns(x) - (TAU * x).cos()).abs() < within, "{x}");
            assert!((sin_turns(x) - (TAU * x).sin()).abs() < within, "{x}");
        }
        for (x, cosine) in [(0.0, 1.0), (0.25, 0.0), (0.5, -1.0), (0.75, 0.0), (1.0, 1.0), (-2.0, 1.0)] {
            assert_eq!(cos_turns(x), cosine);
        }
    }
}
