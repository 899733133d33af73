//! The distances between samples, where ImageJ has written them.

use std::path::Path;

use tiff::decoder::ifd::Value;
use tiff::tags::Tag;

use super::{Pages, failed};
use crate::error::ReadError;

/// Distances along x, y and z in the unit that the file names; 1 for what it does not state.
///
/// The resolution tags alone are no distance in the world of the data: scanners and editors put the dots per
/// inch of a screen or printer there. ImageJ says in the description that they are one.
pub(super) fn of(path: &Path, decoder: &mut Pages) -> Result<[f64; 3], ReadError> {
    let fail = |e| failed(path, 0, e);
    let Some(Value::Ascii(text)) = decoder.find_tag(Tag::ImageDescription).map_err(fail)? else {
        return Ok([1.0; 3]);
    };
    refuse_more_axes(path, &text)?;
    if !text.starts_with("ImageJ=") {
        return Ok([1.0; 3]);
    }
    let field = |key: &str| text.lines().find_map(|line| line.trim().strip_prefix(key)?.strip_prefix('='));
    let z = field("spacing").and_then(|z| z.trim().parse().ok()).map_or(1.0, f64::abs);
    if field("unit").is_none_or(|unit| unit.trim().is_empty() || unit.trim() == "pixel") {
        return Ok([1.0, 1.0, if z > 0.0 && z.is_finite() { z } else { 1.0 }]);
    }
    let mut across = |tag| {
        let resolution = match decoder.find_tag(tag).map_err(fail)? {
            Some(Value::Rational(dots, per)) => f64::from(dots) / f64::from(per),
            _ => 1.0,
        };
        Ok::<_, ReadError>(1.0 / resolution)
    };
    let spacing = [across(Tag::XResolution)?, across(Tag::YResolution)?, z];
    Ok(spacing.map(|s| if s > 0.0 && s.is_finite() { s } else { 1.0 }))
}

/// Images in the stack according to ImageJ; 0 if it does not say.
pub(super) fn images(path: &Path, decoder: &mut Pages) -> Result<u64, ReadError> {
    let description = decoder.find_tag(Tag::ImageDescription).map_err(|e| failed(path, 0, e))?;
    let Some(Value::Ascii(text)) =
        description.filter(|d| matches!(d, Value::Ascii(t) if t.starts_with("ImageJ=")))
    else {
        return Ok(0);
    };
    Ok(text.lines().find_map(|l| l.strip_prefix("images=")?.trim().parse().ok()).unwrap_or(0))
}

/// Refuses channels and time steps, whose pages would be taken for layers.
fn refuse_more_axes(path: &Path, description: &str) -> Result<(), ReadError> {
    const IMAGEJ: [&str; 2] = ["channels=", "frames="];
    const OME: [&str; 2] = ["SizeC=\"", "SizeT=\""];
    let keys = match description {
        text if text.starts_with("ImageJ=") => IMAGEJ,
        text if text.contains("<OME") => OME,
        _ => return Ok(()),
    };
    for key in keys {
        let count = description.split(key).nth(1).map(|rest| {
            let digits = rest.trim_start();
            &digits[..digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len())]
        });
        if let Some(count) = count.filter(|&count| count != "1") {
            let expected = "one channel and one time step";
            return Err(ReadError::unsupported(
                path,
                "a stack of more axes",
                expected,
                format!("{key}{count}"),
            ));
        }
    }
    Ok(())
}
