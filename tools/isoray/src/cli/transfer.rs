//! Flags of transfer functions, and the command that looks at them.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{InputArgs, parse_size};

/// What colour and extinction values have; by default both are proposed from the histogram.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Transfer function (by default proposed from the histogram)")]
pub(crate) struct TransferArgs {
    /// Transfer function from a file: isoray's TOML, or a ParaView preset in JSON (of several the first)
    #[arg(long, value_name = "FILE", conflicts_with = "colormap")]
    pub(crate) tf: Option<PathBuf>,
    /// Built-in colour map, with the proposed extinctions; `isoray tf list` tells the names [default: viridis]
    #[arg(long, value_name = "NAME")]
    pub(crate) colormap: Option<String>,
    /// Values that the transfer function spans instead, from its first to its last point, like -100:400
    #[arg(long, value_name = "A:B", value_parser = parse_range, allow_hyphen_values = true)]
    pub(crate) tf_range: Option<[f32; 2]>,
    /// Equal distances in the transfer function are equal ratios of values (which must be positive)
    #[arg(long)]
    pub(crate) log: bool,
    /// Multiply every extinction: more than 1 is denser, less is clearer [default: 1]
    #[arg(long, value_name = "X", value_parser = parse_scale, allow_negative_numbers = true)]
    pub(crate) extinction_scale: Option<f32>,
}

/// `isoray tf`.
#[derive(Debug, Subcommand)]
pub(crate) enum TransferCommand {
    /// Draw a transfer function: its colours, and extinction over value, with the histogram of a volume
    Preview(Box<PreviewArgs>),
    /// List the built-in colour maps
    List,
}

#[derive(Debug, Args)]
pub(crate) struct PreviewArgs {
    /// The transfer function, as --tf
    #[arg(value_name = "FILE.toml|FILE.json", conflicts_with_all = ["tf", "colormap"])]
    pub(crate) file: Option<PathBuf>,
    /// Volume for the proposed extinctions, the range of relative values, and the histogram behind the curve
    #[arg(long, value_name = "VOLUME")]
    pub(crate) volume: Option<PathBuf>,
    /// The picture
    #[arg(short, long, value_name = "OUT.png")]
    pub(crate) output: PathBuf,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "800x400", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
    #[command(flatten)]
    pub(crate) transfer: TransferArgs,
    #[command(flatten)]
    pub(crate) source: InputArgs,
}

fn parse_range(text: &str) -> Result<[f32; 2], String> {
    let ends = text.split_once(':').and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    match ends {
        Some([low, high]) if f32::is_finite(low) && f32::is_finite(high) && low < high => Ok([low, high]),
        _ => Err(format!(
            "expected two numbers separated by a colon, the smaller one first, like -100:400, found '{text}'"
        )),
    }
}

fn parse_scale(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(scale) if scale > 0.0 && f32::is_finite(scale) => Ok(scale),
        _ => Err(format!("expected a finite number above 0, found '{text}'")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_scales() {
        assert_eq!(parse_range("-100:-1e1"), Ok([-100.0, -10.0]));
        for text in ["", "1", "1:1", "2:1", "1:nan", "-inf:0", "1:2:3", "1e39:1e40"] {
            assert!(parse_range(text).unwrap_err().contains("-100:400"), "{text}");
        }
        assert_eq!(parse_scale("2.5"), Ok(2.5));
        for text in ["0", "-1", "nan", "inf", "1e-60", "x"] {
            assert!(parse_scale(text).unwrap_err().contains("above 0"), "{text}");
        }
    }
}
