//! Built-in colour maps.

use colorgrad::{Gradient, preset};
use isoray_preint::{TransferFunction, TransferFunctionError};

use super::color::{Triple, decode};
use super::curve::{Curve, finish, follow, join, looks_alike};

/// A colour map without opacities: linear RGB over positions from 0 to 1, within 1/1024 (in display colours) of the
/// map it is named for; `turbo` and `cividis`, which are only known in whole levels of 8 bits, within 1/200.
#[derive(Clone, Debug)]
pub struct Colormap {
    curve: Curve<3>,
}

/// A name that is no colour map's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a colour map, one of {}, found '{name}'", COLORMAPS.join(", "))]
pub struct UnknownColormap {
    /// What was asked for, shortened.
    pub name: String,
}

/// Display colours over positions from 0 to 1.
type Display = Box<dyn Fn(f64) -> Triple>;

fn boxed(gradient: impl Gradient + 'static) -> Display {
    Box::new(move |t| {
        let color = gradient.at(t as f32);
        [color.r, color.g, color.b].map(|c| f64::from(c).clamp(0.0, 1.0))
    })
}

/// Pieces of a map in whole levels, and places over which each of their ends is averaged.
const KNOTS: [u32; 2] = [128, 16];

/// A map that comes in whole levels of 8 bits, without their steps: straight between the means around some places.
fn smoothed(gradient: impl Gradient + 'static) -> Display {
    let [count, places] = KNOTS;
    let exact = boxed(gradient);
    let knot = |n: u32| {
        // No mean at the ends: it would be one of one side.
        let width = if n == 0 || n == count { 0.0 } else { 1.0 };
        let around = |m: u32| (f64::from(m) + 0.5) / f64::from(places) - 0.5;
        let colors = (0..places).map(|m| exact((f64::from(n) + width * around(m)) / f64::from(count)));
        let sum = colors.fold([0.0; 3], |sum, c| std::array::from_fn(|i| sum[i] + c[i]));
        (f64::from(n) / f64::from(count), sum.map(|c| c / f64::from(places)))
    };
    let curve = Curve::new((0..=count).map(knot).collect());
    Box::new(move |t| curve.at(t))
}

/// Names of the built-in colour maps: perceptually uniform ones, those of one or two hues from ColorBrewer, diverging
/// ones from ColorBrewer, and cyclic or rainbow-like ones.
pub const COLORMAPS: [&str; 24] = [
    "viridis",
    "inferno",
    "magma",
    "plasma",
    "cividis",
    "turbo",
    "cubehelix",
    "gray",
    "blues",
    "greens",
    "oranges",
    "purples",
    "reds",
    "ylgnbu",
    "ylorrd",
    "spectral",
    "rdbu",
    "rdylbu",
    "brbg",
    "piyg",
    "warm",
    "cool",
    "rainbow",
    "sinebow",
];

fn display(name: &str) -> Option<Display> {
    Some(match name {
        "viridis" => boxed(preset::viridis()),
        "inferno" => boxed(preset::inferno()),
        "magma" => boxed(preset::magma()),
        "plasma" => boxed(preset::plasma()),
        "cividis" => smoothed(preset::cividis()),
        "turbo" => smoothed(preset::turbo()),
        "cubehelix" => boxed(preset::cubehelix_default()),
        "gray" => Box::new(|t| [t; 3]),
        "blues" => boxed(preset::blues()),
        "greens" => boxed(preset::greens()),
        "oranges" => boxed(preset::oranges()),
        "purples" => boxed(preset::purples()),
        "reds" => boxed(preset::reds()),
        "ylgnbu" => boxed(preset::yl_gn_bu()),
        "ylorrd" => boxed(preset::yl_or_rd()),
        "spectral" => boxed(preset::spectral()),
        "rdbu" => boxed(preset::rd_bu()),
        "rdylbu" => boxed(preset::rd_yl_bu()),
        "brbg" => boxed(preset::br_bg()),
        "piyg" => boxed(preset::pi_yg()),
        "warm" => boxed(preset::warm()),
        "cool" => boxed(preset::cool()),
        "rainbow" => boxed(preset::rainbow()),
        "sinebow" => boxed(preset::sinebow()),
        _ => return None,
    })
}

/// Pieces of a map that are looked at each for itself, so that none of its waves is missed.
const PIECES: u32 = 16;

/// The colour map of that name, one of [`COLORMAPS`]; case, `-` and `_` do not matter.
///
/// # Errors
///
/// If there is none; the error lists them.
pub fn colormap(name: &str) -> Result<Colormap, UnknownColormap> {
    let plain: String =
        name.chars().filter(|c| !matches!(c, '-' | '_')).collect::<String>().to_ascii_lowercase();
    let display = display(&plain).ok_or_else(|| UnknownColormap { name: crate::error::shown(name) })?;
    let linear = |t: f64| display(t).map(decode);
    let mut points = vec![(0.0, linear(0.0))];
    for n in 0..PIECES {
        let span = [n, n + 1].map(|n| f64::from(n) / f64::from(PIECES));
        follow(&mut points, span, &linear, &looks_alike);
    }
    Ok(Colormap { curve: Curve::new(points) })
}

impl Colormap {
    /// Positions from 0 to 1 and linear RGB; colours are linear between them.
    pub fn points(&self) -> impl Iterator<Item = (f32, [f32; 3])> {
        self.curve.points().iter().map(|&(x, y)| (x as f32, y.map(|c| c as f32)))
    }

    /// The linear RGB colour at a position, constant beyond 0 and 1.
    pub fn at(&self, position: f32) -> [f32; 3] {
        self.curve.at(f64::from(position)).map(|c| c as f32)
    }

    /// A transfer function over positions from 0 to 1 with these colours, and extinctions (per world unit) that are
    /// linear between pairs of position and extinction. [`Remap`](super::Remap) brings it to the data's values.
    ///
    /// # Errors
    ///
    /// If there is no extinction, one is negative or no number, or positions are no numbers or decrease.
    pub fn with_extinctions(
        &self,
        extinctions: &[[f32; 2]],
    ) -> Result<TransferFunction, TransferFunctionError> {
        let point = |&[value, extinction]: &[f32; 2]| isoray_preint::ControlPoint {
            value,
            color: [0.0; 3],
            extinction,
        };
        // Refuses what is no transfer function by itself.
        let checked = TransferFunction::new(extinctions.iter().map(point).collect())?;
        let curve =
            checked.points().iter().map(|p| (f64::from(p.value), [f64::from(p.extinction)])).collect();
        finish(&join(&self.curve, &Curve::new(curve)))
    }

    /// The colours over the values of `span`.
    pub(crate) fn over(&self, [low, high]: [f64; 2]) -> Curve<3> {
        Curve::new(self.curve.points().iter().map(|&(u, y)| (low * (1.0 - u) + high * u, y)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::color::encode;
    use crate::transfer::curve::COLOR_TOLERANCE;

    #[test]
    fn maps_in_whole_levels_are_smoothed() {
        for (name, exact) in [("turbo", boxed(preset::turbo())), ("cividis", boxed(preset::cividis()))] {
            let smooth = display(name).unwrap();
            let errors = (0..=4000)
                .map(|n| f64::from(n) / 4000.0)
                .map(|t| exact(t).iter().zip(smooth(t)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max));
            let error = errors.fold(0.0, f64::max);
            assert!(error <= 1.0 / 255.0, "{name}: {error}");
        }
    }

    #[test]
    fn every_map_is_followed() {
        for name in COLORMAPS {
            let (exact, map) = (display(name).unwrap(), colormap(name).unwrap());
            let count = map.points().count();
            assert!((17..300).contains(&count), "{name}: {count}");
            for n in 0..=4000 {
                let t = f64::from(n) / 4000.0;
                let found = map.curve.at(t).map(encode);
                let error = exact(t).iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(error <= COLOR_TOLERANCE, "{name} at {t}: {error}");
            }
        }
    }

    #[test]
    fn names() {
        assert!(colormap("Viridis").is_ok() && colormap("RdBu").is_ok() && colormap("rd_yl-bu").is_ok());
        let error = colormap("jet").unwrap_err().to_string();
        assert!(error.contains("viridis, inferno") && error.ends_with("found 'jet'"), "{error}");
    }

    #[test]
    fn extinctions_join_the_colours() {
        let map = colormap("gray").unwrap();
        let function = map.with_extinctions(&[[0.3, 0.0], [0.6, 2.0]]).unwrap();
        assert_eq!(function.at(0.2).extinction, 0.0);
        assert!((function.at(0.45).extinction - 1.0).abs() < 1e-6);
        assert_eq!(function.at(2.0).extinction, 2.0);
        assert_eq!(function.at(1.0).color, [1.0; 3]);
        assert!(map.with_extinctions(&[]).is_err() && map.with_extinctions(&[[0.0, -1.0]]).is_err());
    }
}
