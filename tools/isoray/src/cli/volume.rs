//! Flags of volume rendering.

use std::fmt;

use clap::{Args, ValueEnum};
use isoray_preint::LEAST_EPSILON;

/// What `isoray render --volume` can be told beside its transfer function.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Volume rendering (with --volume)")]
pub(crate) struct VolumeArgs {
    /// Render the volume itself, as a transfer function shows it, instead of an isosurface
    #[arg(long)]
    pub(crate) volume: bool,
    /// How the colour of the volume depends on the light [default: diffuse]
    #[arg(long, value_enum)]
    pub(crate) shading: Option<ShadingArg>,
    /// Change of value per world unit that is lit like a surface [default: 99 % of all are less, measured]
    #[arg(long, value_name = "G", value_parser = parse_gradient_scale, allow_negative_numbers = true)]
    pub(crate) gradient_scale: Option<f64>,
    /// How rays are integrated: with errors of at most EPS (of linear light), by linear pieces between the
    /// extrema of each cell, or by N linear pieces in each cell [default: bounded:0.00196]
    #[arg(long, value_name = "bounded:EPS|adaptive|fixed:N", value_parser = parse_scheme)]
    pub(crate) scheme: Option<SchemeArg>,
    /// Schemes adaptive and fixed: transmittance at which a ray ends [default: 0.001]
    #[arg(long, value_name = "T", value_parser = parse_terminate, allow_negative_numbers = true)]
    pub(crate) terminate: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ShadingArg {
    /// The colours of the transfer function alone
    None,
    /// Brighter where the value changes toward the light
    Diffuse,
    /// The same with highlights
    Specular,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StructureArg {
    /// The compressed volume itself
    Octree,
    /// An array with macrocells
    Grid,
    /// The one that takes less memory
    Auto,
}

/// How rays are integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum SchemeArg {
    /// With an error of at most this much.
    Bounded(f64),
    /// Linear pieces between extrema.
    Adaptive,
    /// So many linear pieces in each cell.
    Fixed(u32),
}

/// Just under half a step of eight bits, 1/510, in linear light. The bound is of the worst case: README.md tells what
/// pictures really differ by.
const DEFAULT_EPSILON: f64 = 0.00196;
/// The largest bound: half the range of a colour. With more, nothing need be drawn at all.
const LARGEST_EPSILON: f64 = 0.5;
/// The most pieces of a cell.
const MOST_PIECES: u32 = 10_000;

impl Default for SchemeArg {
    fn default() -> Self {
        Self::Bounded(DEFAULT_EPSILON)
    }
}

/// As the flag is written.
impl fmt::Display for SchemeArg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bounded(epsilon) => write!(f, "bounded:{epsilon}"),
            Self::Adaptive => f.write_str("adaptive"),
            Self::Fixed(pieces) => write!(f, "fixed:{pieces}"),
        }
    }
}

fn parse_scheme(text: &str) -> Result<SchemeArg, String> {
    match text.split_once(':') {
        Some(("bounded", epsilon)) => match epsilon.parse() {
            Ok(epsilon) if (LEAST_EPSILON..=LARGEST_EPSILON).contains(&epsilon) => {
                Ok(SchemeArg::Bounded(epsilon))
            }
            _ => Err(format!(
                "expected an error bound from {LEAST_EPSILON:e} to {LARGEST_EPSILON} after bounded:, found '{epsilon}'"
            )),
        },
        Some(("fixed", pieces)) => match pieces.parse() {
            Ok(pieces) if (1..=MOST_PIECES).contains(&pieces) => Ok(SchemeArg::Fixed(pieces)),
            _ => {
                Err(format!("expected a whole number from 1 to {MOST_PIECES} after fixed:, found '{pieces}'"))
            }
        },
        None if text == "adaptive" => Ok(SchemeArg::Adaptive),
        _ => Err(format!(
            "expected bounded:EPS, like bounded:0.001, adaptive, or fixed:N, like fixed:4, found '{text}'"
        )),
    }
}

fn parse_terminate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(t) if (0.0..1.0).contains(&t) => Ok(t),
        _ => Err(format!("expected a number from 0 to less than 1, found '{text}'")),
    }
}

/// Scales between which products with the values of any volume stay finite.
const GRADIENT_SCALES: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

fn parse_gradient_scale(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(scale) if GRADIENT_SCALES.contains(&scale) => Ok(scale),
        _ => Err(format!("expected a number from 1e-30 to 1e30, found '{text}'")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schemes_are_read_as_they_are_written() {
        for text in
            ["bounded:0.00196", "bounded:0.0000002", "bounded:0.5", "adaptive", "fixed:1", "fixed:10000"]
        {
            assert_eq!(parse_scheme(text).unwrap().to_string(), text);
        }
        assert_eq!(parse_scheme(&SchemeArg::default().to_string()), Ok(SchemeArg::default()));
        assert_eq!(parse_scheme("bounded:2e-7"), Ok(SchemeArg::Bounded(LEAST_EPSILON)));
        for (text, part) in [
            ("", "adaptive"),
            ("bounded", "bounded:EPS"),
            ("adaptive:2", "found 'adaptive:2'"),
            ("bounded:", "found ''"),
            ("bounded:1.9e-7", "from 2e-7 to 0.5"),
            ("bounded:0.51", "found '0.51'"),
            ("bounded:nan", "found 'nan'"),
            ("fixed:0", "from 1 to 10000"),
            ("fixed:10001", "found '10001'"),
            ("fixed:1.5", "found '1.5'"),
        ] {
            let error = parse_scheme(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn numbers_out_of_range() {
        assert_eq!((parse_terminate("0"), parse_gradient_scale("1e-30")), (Ok(0.0), Ok(1e-30)));
        for text in ["-0.1", "1", "nan", "x"] {
            assert!(parse_terminate(text).unwrap_err().contains("less than 1"), "{text}");
        }
        for text in ["0", "-1", "nan", "inf", "1e31", "x"] {
            assert!(parse_gradient_scale(text).unwrap_err().contains("1e30"), "{text}");
        }
    }
}
