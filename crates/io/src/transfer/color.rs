//! Colour spaces of transfer-function files: sRGB, CIELAB, and Moreland's Msh.

use std::f64::consts::PI;

/// Red, green and blue, or three coordinates of another space.
pub(crate) type Triple = [f64; 3];

/// Light of a component from 0 to 1 as sRGB (IEC 61966-2-1) encodes it for a display.
pub(crate) fn decode(display: f64) -> f64 {
    if display <= 0.04045 { display / 12.92 } else { ((display + 0.055) / 1.055).powf(2.4) }
}

/// The inverse of [`decode`].
pub(crate) fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// How colours between two points are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ColorSpace {
    /// Linear in display colours.
    Rgb,
    /// Linear in CIELAB.
    Lab,
    /// Linear in Msh with a white between two hues that are far apart: K. Moreland, 'Diverging color maps for
    /// scientific visualization' (2009), <https://doi.org/10.1007/978-3-642-10520-3_9>.
    Diverging,
    /// Not at all: between two points all have the colour of the upper one.
    Step,
}

impl ColorSpace {
    /// The display colour at `s` from 0 to 1 between the display colours `a` and `b`.
    pub(crate) fn between(self, a: Triple, b: Triple, s: f64) -> Triple {
        match self {
            Self::Rgb => mix(a, b, s),
            Self::Lab => lab_to_rgb(mix(rgb_to_lab(a), rgb_to_lab(b), s)),
            Self::Diverging => diverging(rgb_to_lab(a), rgb_to_lab(b), s),
            Self::Step => b,
        }
    }
}

/// Linear interpolation.
pub(crate) fn mix<const N: usize>(a: [f64; N], b: [f64; N], s: f64) -> [f64; N] {
    std::array::from_fn(|n| a[n] * (1.0 - s) + b[n] * s)
}

fn multiply(matrix: &[Triple; 3], v: Triple) -> Triple {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// From linear sRGB to CIE XYZ, to the digits that VTK uses.
const TO_XYZ: [Triple; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
/// Its inverse, to more digits, so that the ends of an interpolation are kept.
const FROM_XYZ: [Triple; 3] = [
    [3.240_625_477_320, -1.537_207_972_210, -0.498_628_598_698],
    [-0.968_930_714_729, 1.875_756_060_885, 0.041_517_523_843],
    [0.055_710_120_446, -0.204_021_050_598, 1.056_995_942_254],
];
/// XYZ of the white D65.
const WHITE: Triple = [0.9505, 1.0, 1.089];
/// Ratio to white below which CIELAB is linear.
const DARK: f64 = 0.008_856;

/// CIELAB of a display colour.
fn rgb_to_lab(rgb: Triple) -> Triple {
    let xyz = multiply(&TO_XYZ, rgb.map(decode));
    let f = |n: usize| {
        let ratio: f64 = xyz[n] / WHITE[n];
        if ratio > DARK { ratio.cbrt() } else { 7.787 * ratio + 16.0 / 116.0 }
    };
    [116.0 * f(1) - 16.0, 500.0 * (f(0) - f(1)), 200.0 * (f(1) - f(2))]
}

/// The display colour of CIELAB coordinates; what no display can show is scaled down to the brightest that it can,
/// and negative components become 0.
fn lab_to_rgb([l, a, b]: Triple) -> Triple {
    let y = (l + 16.0) / 116.0;
    let f = [y + a / 500.0, y, y - b / 200.0];
    let xyz = std::array::from_fn(|n| {
        let cube = f[n] * f[n] * f[n];
        WHITE[n] * if cube > DARK { cube } else { (f[n] - 16.0 / 116.0) / 7.787 }
    });
    let rgb = multiply(&FROM_XYZ, xyz).map(encode);
    let brightest = rgb.iter().fold(1.0, |m: f64, &c| m.max(c));
    rgb.map(|c| (c / brightest).clamp(0.0, 1.0))
}

/// Saturation (an angle) below which a colour counts as grey.
const GREY: f64 = 0.05;
/// Least magnitude of the white in the middle.
const WHITE_MAGNITUDE: f64 = 88.0;

/// Msh, the polar form of CIELAB: magnitude, saturation and hue, both angles.
fn lab_to_msh([l, a, b]: Triple) -> Triple {
    let magnitude = (l * l + a * a + b * b).sqrt();
    let saturation = if magnitude > 0.001 { (l / magnitude).clamp(-1.0, 1.0).acos() } else { 0.0 };
    let hue = if saturation > 0.001 { b.atan2(a) } else { 0.0 };
    [magnitude, saturation, hue]
}

fn msh_to_rgb([m, s, h]: Triple) -> Triple {
    lab_to_rgb([m * s.cos(), m * s.sin() * h.cos(), m * s.sin() * h.sin()])
}

/// The hue that a grey of magnitude `grey` is given, so that the way to the colour `to` looks even.
fn hue_of_grey(to: Triple, grey: f64) -> f64 {
    let [magnitude, saturation, hue] = to;
    if magnitude >= grey - 0.1 {
        return hue;
    }
    let spin = saturation * (grey * grey - magnitude * magnitude).sqrt() / (magnitude * saturation.sin());
    // Away from blue for purple hues, towards it for the others.
    if hue > -0.3 * PI { hue + spin } else { hue - spin }
}

fn diverging(a: Triple, b: Triple, s: f64) -> Triple {
    let (mut a, mut b, mut s) = (lab_to_msh(a), lab_to_msh(b), s);
    let apart = (a[2] - b[2]).abs();
    if a[1] > GREY && b[1] > GREY && apart.min(2.0 * PI - apart) > 0.33 * PI {
        let white = [a[0].max(b[0]).max(WHITE_MAGNITUDE), 0.0, 0.0];
        if s < 0.5 {
            (b, s) = (white, 2.0 * s);
        } else {
            (a, s) = (white, 2.0 * s - 1.0);
        }
    }
    if a[1] < GREY && b[1] > GREY {
        a[2] = hue_of_grey(b, a[0]);
    } else if b[1] < GREY && a[1] > GREY {
        b[2] = hue_of_grey(a, b[0]);
    }
    msh_to_rgb(mix(a, b, s))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(a: Triple, b: Triple, tolerance: f64) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance), "{a:?} {b:?}");
    }

    #[test]
    fn spaces_agree_with_their_inverses_and_keep_the_ends() {
        let levels = [0.0, 0.01, 0.2, 0.5, 0.9, 1.0];
        for (r, g) in levels.into_iter().flat_map(|r| levels.map(|g| (r, g))) {
            let [a, b] = [[r, g, 0.3], [g, 0.7, r]];
            assert_near(a.map(decode).map(encode), a, 1e-7);
            assert_near(lab_to_rgb(rgb_to_lab(a)), a, 2e-5);
            for space in [ColorSpace::Rgb, ColorSpace::Lab, ColorSpace::Diverging] {
                assert_near(space.between(a, b, 0.0), a, 2e-5);
                assert_near(space.between(a, b, 1.0), b, 2e-5);
            }
        }
    }

    #[test]
    fn published_values() {
        // White and pure red in CIELAB (D65).
        assert_near(rgb_to_lab([1.0; 3]), [100.0, 0.0, 0.0], 0.02);
        assert_near(rgb_to_lab([1.0, 0.0, 0.0]), [53.24, 80.09, 67.20], 0.05);
        // Moreland's cool to warm: ends and middle of the table that goes with his paper.
        let [cool, warm] = [[59.0, 76.0, 192.0], [180.0, 4.0, 38.0]].map(|c| c.map(|b| b / 255.0));
        assert_near(ColorSpace::Diverging.between(cool, warm, 0.5), [221.0 / 255.0; 3], 1.5 / 255.0);
        let quarter = [141.0 / 255.0, 176.0 / 255.0, 254.0 / 255.0];
        assert_near(ColorSpace::Diverging.between(cool, warm, 0.25), quarter, 1.5 / 255.0);
    }
}
