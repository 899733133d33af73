//! From flags to a transfer function, and the one that is proposed without any.

use anyhow::{Context, Result};
use glam::DVec3;
use isoray_io::transfer::{Colormap, Remap, RemapError, colormap};
use isoray_io::{TransferOptions, read_transfer_function};
use isoray_octree::Meta;
use isoray_preint::{ControlPoint, TransferFunction};

use crate::cli::TransferArgs;
use crate::failure::usage;
use crate::isovalue::propose;

/// The transfer function that the flags describe, for a volume; what they leave open is proposed from its histogram.
pub(crate) fn transfer_function(args: &TransferArgs, meta: &Meta) -> Result<TransferFunction> {
    build(args, Some(meta))
}

/// The same; without a volume values and lengths are relative: from 0 to 1, and one unit across.
pub(crate) fn build(args: &TransferArgs, meta: Option<&Meta>) -> Result<TransferFunction> {
    check(args)?;
    let function = match &args.tf {
        Some(path) => {
            let options = TransferOptions {
                unit_distance: meta.map_or(1.0, cell_diagonal),
                data_range: meta.and_then(|m| m.range).map(|r| r.map(|v| v as f32)),
                remap: Remap { range: args.tf_range, log: args.log },
            };
            read_transfer_function(path, &options)?
        }
        None => proposed(args, meta)?,
    };
    match args.extinction_scale {
        Some(scale) => {
            function.with_extinction_scaled(scale).context("--extinction-scale: too large a number")
        }
        None => Ok(function),
    }
}

/// Refuses flags that make no sense for any volume or file, before one is read.
pub(crate) fn check(args: &TransferArgs) -> Result<()> {
    if let Some(range) = args.tf_range.filter(|r| args.log && r[0] <= 0.0) {
        let [low, high] = range;
        return Err(usage(format!("--log: {}", RemapError::NotPositive { low, high })));
    }
    map(args).map(drop)
}

/// Colours that leave no value black, and look even in grey.
const DEFAULT_COLORMAP: &str = "viridis";

fn map(args: &TransferArgs) -> Result<Colormap> {
    let name = args.colormap.as_deref().unwrap_or(DEFAULT_COLORMAP);
    colormap(name).map_err(|e| usage(format!("--colormap: {e}")))
}

/// What ParaView takes for the length of a cell, which its opacities are for: the diagonal of the domain, in the world,
/// over the cube root of the number of cells.
fn cell_diagonal(meta: &Meta) -> f64 {
    let length = diagonal(meta) / (meta.dims.cells().max(1) as f64).cbrt();
    if length.is_normal() { length } else { 1.0 }
}

/// Of the domain, in world units, as if its edges were perpendicular.
fn diagonal(meta: &Meta) -> f64 {
    let last = DVec3::from_array(meta.dims.axes().map(|n| f64::from(n - 1)));
    let [x, y, z] =
        [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| meta.index_to_world.transform_vector3(last * axis));
    (x.length_squared() + y.length_squared() + z.length_squared()).sqrt()
}

/// Optical depth that half of the volume's width has where it is filled with values at [`MIDDLE`] of the ramp: 1 − e⁻²
/// or 86 % of what is behind it is hidden.
const HALF_DEPTH: f64 = 2.0;
/// How far up the ramp that is.
const MIDDLE: f64 = 0.75;
/// Share of the samples above the background that lie above the ramp: metal in a CT scan, a spike in a simulation.
const ABOVE_RAMP: f64 = 0.001;

/// A transfer function that shows something of any volume. Values up to Otsu's threshold, which is where most of them and
/// the air around a scan are, are clear. From there extinction rises linearly, up to the value that all but 0.1 % of the
/// samples above the threshold are below, and stays there; the colour map spans the same values. `--tf-range` takes
/// their place. Extinction is scaled to the size of the volume: see [`HALF_DEPTH`]. Where all samples are equal there is no
/// background; they become a haze of one colour.
fn proposed(args: &TransferArgs, meta: Option<&Meta>) -> Result<TransferFunction> {
    let map = map(args)?;
    // A cube of this diagonal has this width.
    let width = meta.map_or(1.0, |m| diagonal(m) / 3f64.sqrt());
    let width = if width.is_normal() { width } else { 1.0 };
    let largest = (HALF_DEPTH / (0.5 * width * MIDDLE)) as f32;
    let visible = match (args.tf_range, meta) {
        (Some(range), _) => Some(range),
        (None, None) => Some([0.0, 1.0]),
        (None, Some(meta)) => visible(meta),
    };
    match visible {
        Some(range) => {
            let ramp = map
                .with_extinctions(&[[0.0, 0.0], [1.0, largest]])
                .context("no extinction fits the volume")?;
            Remap { range: Some(range), log: args.log }.apply(&ramp).map_err(|e| match e {
                RemapError::NotPositive { .. } => usage(format!("--log: {e}; choose one with --tf-range")),
                e => anyhow::Error::new(e).context("no transfer function can be proposed; choose --tf-range"),
            })
        }
        None => {
            let value = meta.and_then(|m| m.range).map_or(0.0, |[low, _]| low as f32);
            let (color, extinction) = (map.at(MIDDLE as f32), MIDDLE as f32 * largest);
            TransferFunction::new(vec![ControlPoint { value, color, extinction }])
                .context("no transfer function can be proposed")
        }
    }
}

/// The values between the background and the rare ones at the upper end; none if all samples are equal.
fn visible(meta: &Meta) -> Option<[f32; 2]> {
    let [low, high] = meta.range?;
    let threshold = propose(&meta.histogram[..], [low, high])?;
    let bins = meta.histogram.len() as f64;
    let border = |bin: usize| (low + (high - low) * bin as f64 / bins) as f32;
    let above: u64 =
        meta.histogram.iter().enumerate().filter(|&(bin, _)| border(bin) >= threshold).map(|(_, &n)| n).sum();
    let rare = (above as f64 * ABOVE_RAMP) as u64;
    let mut beyond = 0;
    for (bin, &n) in meta.histogram.iter().enumerate().rev() {
        beyond += n;
        let top = border(bin + 1);
        if beyond > rare && top > threshold {
            return Some([threshold, top]);
        }
        if top <= threshold {
            break;
        }
    }
    // Both round to the same number.
    None
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;
    use isoray_grid::Dims;
    use isoray_octree::HISTOGRAM_BINS;

    use super::*;

    fn meta(range: Option<[f64; 2]>, filled: &[(usize, u64)]) -> Meta {
        let mut histogram = Box::new([0; HISTOGRAM_BINS]);
        filled.iter().for_each(|&(bin, n)| histogram[bin] = n);
        let dims = Dims::new([101, 101, 101]).unwrap();
        let index_to_world = DAffine3::from_scale(DVec3::splat(0.02));
        Meta { dims, index_to_world, range, non_finite: 0, histogram }
    }

    fn build(meta: &Meta) -> TransferFunction {
        transfer_function(&TransferArgs::default(), meta).unwrap()
    }

    #[test]
    fn background_is_clear_and_the_rest_rises() {
        // Air about 10, tissue about 120, and a few samples of metal.
        let filled = [(9, 5000), (10, 90_000), (11, 5000), (110, 9000), (120, 20_000), (130, 9000), (255, 7)];
        let function = build(&meta(Some([0.0, 256.0]), &filled));
        assert_eq!(function.at(12.0).extinction, 0.0);
        let [tissue, end, metal] = [120.0, 131.0, 255.0].map(|v| function.at(v).extinction);
        assert!(tissue > 0.8 * end && end == metal, "{tissue} {end} {metal}");
        // Two units across; three quarters of the largest extinction fill half of it.
        assert!((0.75 * end * 1.0 - 2.0).abs() < 1e-4, "{end}");
        assert_eq!(function, build(&meta(Some([0.0, 256.0]), &filled)));
    }

    #[test]
    fn one_value_and_none() {
        for (range, filled) in [(Some([5.0, 5.0]), &[(0, 10)][..]), (None, &[])] {
            let function = build(&meta(range, filled));
            assert_eq!(function.points().len(), 1, "{range:?}");
            assert!(function.at(5.0).extinction > 1.0 && function.at(5.0).extinction < 4.0);
        }
        // Two values that are all but the same.
        let next = f64::from(f32::from_bits(1f32.to_bits() + 1));
        let function = build(&meta(Some([1.0, next]), &[(0, 5), (255, 5)]));
        assert!(function.at(0.0).extinction == 0.0 && function.at(2.0).extinction > 1.0);
    }

    #[test]
    fn flags_change_it() {
        let meta = meta(Some([-10.0, 1000.0]), &[(0, 1000), (200, 100)]);
        let build = |args: TransferArgs| transfer_function(&args, &meta);
        let plain = build(TransferArgs::default()).unwrap();
        let dense = build(TransferArgs { extinction_scale: Some(3.0), ..Default::default() }).unwrap();
        assert_eq!(dense.at(1e3).extinction, 3.0 * plain.at(1e3).extinction);
        let range =
            build(TransferArgs { tf_range: Some([1.0, 100.0]), log: true, ..Default::default() }).unwrap();
        assert!((range.at(10.0).extinction / range.at(100.0).extinction - 0.5).abs() < 2e-3);
        for (args, part) in [
            (
                TransferArgs { tf_range: Some([-1.0, 5.0]), log: true, ..Default::default() },
                "found the range -1 to 5",
            ),
            (TransferArgs { colormap: Some("jet".into()), ..Default::default() }, "found 'jet'"),
        ] {
            let error = build(args).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }
}
