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

/// What was proposed, in one line.
pub(crate) fn summary(args: &TransferArgs, function: &TransferFunction) -> String {
    let name = args.colormap.as_deref().unwrap_or(DEFAULT_COLORMAP);
    let densest = function.points().iter().map(|p| p.extinction).fold(0.0, f32::max);
    let clear = function.points().iter().rev().find(|p| p.extinction == 0.0);
    let what = match (clear, function.points().last()) {
        (Some(clear), Some(last)) => format!(
            "clear up to {}, its extinction rises to {densest:.4} per world unit at {}",
            clear.value, last.value
        ),
        _ => format!("of one extinction, {densest:.4} per world unit"),
    };
    format!(
        "transfer function {name}, proposed from the histogram: {what} (choose with --tf, --colormap or --tf-range)"
    )
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
pub(crate) const DEFAULT_COLORMAP: &str = "viridis";

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

/// Optical depth of half the width of what is visible, gathered in a cube: 1 − e⁻³ or 95 % of what is behind it is hidden.
const HALF_DEPTH: f64 = 3.0;
/// Share of the samples above the background that lie above the ramp: metal in a CT scan, a spike in a simulation.
const ABOVE_RAMP: f64 = 0.001;
/// Share of the colour map, from its beginning, that no visible value has: most maps are all but black there, and so would
/// be what is just above the background.
const DARK: f64 = 0.25;

/// A transfer function that shows something of any volume. Values up to Otsu's threshold, which is where most of them and
/// the air around a scan are, are clear. From there extinction rises linearly, up to the value that all but 0.1 % of the
/// samples above the threshold are below, and stays there; the same values have the colours of the map beyond
/// [`DARK`]. `--tf-range` takes their place, with all of the map. Where all samples are equal there is no background;
/// they become a haze of one colour.
///
/// Extinction is scaled to the volume's size, and to how much of it is visible and how far up the ramp (see [`HALF_DEPTH`]),
/// so that neither a block nor a wire is too faint.
fn proposed(args: &TransferArgs, meta: Option<&Meta>) -> Result<TransferFunction> {
    let map = map(args)?;
    let (visible, dark) = match (args.tf_range, meta) {
        (Some(range), _) => (Some(range), 0.0),
        (None, None) => (Some([0.0, 1.0]), 0.0),
        (None, Some(meta)) => (visible(meta), DARK),
    };
    // A cube of this diagonal has this width.
    let width = meta.map_or(1.0, |m| diagonal(m) / 3f64.sqrt());
    let width = if width.is_normal() { width } else { 1.0 };
    let largest = |filling| (HALF_DEPTH / (0.5 * width * filling)) as f32;
    let Some(range) = visible else {
        let value = meta.and_then(|m| m.range).map_or(0.0, |[low, _]| low as f32);
        let point = ControlPoint { value, color: map.at(ONE_COLOR), extinction: largest(1.0) };
        return TransferFunction::new(vec![point]).context("no transfer function can be proposed");
    };
    let largest = largest(filling(meta, range, args.log));
    let ramp = map
        .with_extinctions(&[[0.0, 0.0], [dark as f32, 0.0], [1.0, largest]][usize::from(dark == 0.0)..])
        .context("no extinction fits the volume")?;
    Remap { range: Some(begun_earlier(range, dark, args.log)), log: args.log }.apply(&ramp).map_err(|e| {
        match e {
            RemapError::NotPositive { .. } => usage(format!("--log: {e}; choose one with --tf-range")),
            e => anyhow::Error::new(e).context("no transfer function can be proposed; choose --tf-range"),
        }
    })
}

/// Where in the colour map the colour of a volume of one value is.
const ONE_COLOR: f32 = 0.75;

/// The mean optical depth across a volume of which a value's share of the range is the extinction, if all that is visible
/// were gathered in a cube: its width, as a share of the volume's, times the mean extinction in it. Without a volume, or where
/// none is visible, that of a full cube of all values.
fn filling(meta: Option<&Meta>, [low, high]: [f32; 2], log: bool) -> f64 {
    const FULL: f64 = 0.5;
    let Some((meta, [least, greatest])) = meta.and_then(|m| Some((m, m.range?))) else { return FULL };
    let scale = |v: f64| if log { v.ln() } else { v };
    let [low, high] = [low, high].map(|v| scale(f64::from(v)));
    let bins = meta.histogram.len() as f64;
    let (mut all, mut visible, mut sum) = (0.0, 0.0, 0.0);
    for (bin, &n) in (0..).zip(meta.histogram.iter()) {
        let middle = least + (greatest - least) * (f64::from(bin) + 0.5) / bins;
        let ramp = (scale(middle) - low) / (high - low);
        all += n as f64;
        // Also false for what has no logarithm.
        if ramp > 0.0 {
            visible += n as f64;
            sum += ramp.min(1.0) * n as f64;
        }
    }
    let filling = f64::cbrt(visible / all) * (sum / visible);
    if filling.is_normal() { filling } else { FULL }
}

/// The range of which the last part, all but a share of `dark`, is `range`; that itself where there is no such range.
fn begun_earlier([low, high]: [f32; 2], dark: f64, log: bool) -> [f32; 2] {
    let [l, h] = [low, high].map(f64::from);
    let begin = match log {
        true if low > 0.0 => l * (l / h).powf(dark / (1.0 - dark)),
        true => l,
        false => l - (h - l) * dark / (1.0 - dark),
    };
    [begin as f32, high]
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
    use isoray_octree::{Coarse, Fidelity, HISTOGRAM_BINS};

    use super::*;

    fn meta(range: Option<[f64; 2]>, filled: &[(usize, u64)]) -> Meta {
        let mut histogram = Box::new([0; HISTOGRAM_BINS]);
        filled.iter().for_each(|&(bin, n)| histogram[bin] = n);
        let dims = Dims::new([101, 101, 101]).unwrap();
        let index_to_world = DAffine3::from_scale(DVec3::splat(0.02));
        let (fidelity, coarse) = (Fidelity::LOSSLESS, Coarse::Injected);
        Meta { dims, index_to_world, range, non_finite: 0, histogram, fidelity, coarse }
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
        // Two units across; what is visible, gathered in a cube, hides 95 % in half its width.
        let width = 2.0 * (38_007f32 / 138_007.0).cbrt();
        let mean = [110.0, 120.0, 130.0].map(|v| function.at(v + 0.5).extinction);
        let mean = (9000.0 * (mean[0] + mean[2]) + 20_000.0 * mean[1]) / 38_000.0;
        assert!((0.5 * width * mean - 3.0).abs() < 0.01, "{width} {mean}");
        assert_eq!(function, build(&meta(Some([0.0, 256.0]), &filled)));
    }

    #[test]
    fn nothing_visible_is_black() {
        let filled = [(10, 90_000), (100, 5000), (200, 5000)];
        for log in [false, true] {
            let args = TransferArgs { log, ..Default::default() };
            let function = transfer_function(&args, &meta(Some([1.0, 257.0]), &filled)).unwrap();
            // A bin above the threshold, and at the end of the ramp.
            let clear = function.points().iter().rev().find(|p| p.extinction == 0.0).unwrap().value;
            let [first, last] = [clear, 202.0].map(|v| function.at(v).color);
            let viridis = colormap("viridis").unwrap();
            for (found, position) in [(first, 0.25), (last, 1.0)] {
                let expected = viridis.at(position);
                assert!((0..3).all(|n| (found[n] - expected[n]).abs() < 2e-3), "{found:?} {expected:?}");
            }
            let text = summary(&args, &function);
            assert!(text.contains(&format!("clear up to {clear}, ")) && text.contains("at 202 "), "{text}");
        }
    }

    #[test]
    fn what_is_rare_is_dense() {
        let dense =
            |n: u64| build(&meta(Some([0.0, 256.0]), &[(10, 1_000_000 - n), (200, n)])).at(255.0).extinction;
        // An eighth of the volume has half its width.
        assert!((dense(1000) / dense(8000) - 2.0).abs() < 1e-3);
        // A range without any sample is as dense as a full cube: two units across, at half the ramp.
        let args = TransferArgs { tf_range: Some([300.0, 400.0]), ..Default::default() };
        let function = transfer_function(&args, &meta(Some([0.0, 256.0]), &[(10, 9), (200, 5)])).unwrap();
        assert!((function.at(400.0).extinction - 6.0).abs() < 1e-4);
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
