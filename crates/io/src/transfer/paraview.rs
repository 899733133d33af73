//! ParaView's presets; the module above documents what of them is read, and how.

use serde_json::{Map, Value};

use super::color::{ColorSpace, Triple, decode};
use super::curve::{Curve, follow, looks_alike};
use super::error::{Source, TransferFileError};
use super::opacity::{OpacityPoint, extinctions};
use super::{MAX_POINTS, Parsed};

/// What the parser should have found.
const FORMAT: &str = "ParaView preset in JSON";
/// Numbers of a point in either list.
const STRIDE: usize = 4;

/// Reads the first preset of the text; opacities are per `unit` world units.
pub(crate) fn parse(source: Source<'_>, unit: f64) -> Result<Parsed, TransferFileError> {
    let root: Value = serde_json::from_str(source.text).map_err(|e| {
        let message = e.to_string();
        let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(what, _)| what);
        TransferFileError::Syntax {
            path: source.path.to_owned(),
            line: e.line(),
            column: e.column(),
            format: FORMAT,
            message: message.to_owned(),
        }
    })?;
    let preset = first_preset(source, &root)?;
    let space = color_space(source, preset)?;
    let colors = numbers(source, preset, "RGBPoints")?.ok_or_else(|| {
        let expected = "the colours of the preset, [value, red, green, blue, …]";
        match preset.contains_key("IndexedColors") {
            true => source.wrong("RGBPoints", expected, "only IndexedColors, which are for categories"),
            false => source.wrong("RGBPoints", expected, "no such key"),
        }
    })?;
    let colors = color_points(source, &colors)?;
    let span = [colors.first(), colors.last()].map(|p| p.map_or(0.0, |p| p.0));
    let opacities = match numbers(source, preset, "Points")? {
        Some(points) => opacity_points(source, &points)?,
        None => ramp(span),
    };
    Ok(Parsed {
        colors: color_curve(space, &colors),
        extinctions: extinctions(&opacities, unit),
        normalized: span == [0.0, 1.0] || span == [-1.0, 1.0],
    })
}

fn first_preset<'a>(
    source: Source<'_>,
    root: &'a Value,
) -> Result<&'a Map<String, Value>, TransferFileError> {
    const EXPECTED: &str = "a preset, {\"RGBPoints\": […], …}, or an array of presets";
    match root {
        Value::Object(preset) => Ok(preset),
        Value::Array(presets) => match presets.first() {
            Some(Value::Object(preset)) => Ok(preset),
            Some(other) => Err(source.wrong("[0]", EXPECTED, kind(other))),
            None => Err(source.wrong("preset", EXPECTED, "an empty array")),
        },
        other => Err(source.wrong("preset", EXPECTED, kind(other))),
    }
}

/// A short text for a value.
fn kind(value: &Value) -> String {
    match value {
        Value::Array(items) => format!("an array of {}", items.len()),
        Value::Object(_) => "an object".to_owned(),
        Value::String(text) => format!("'{text}'"),
        other => other.to_string(),
    }
}

fn color_space(source: Source<'_>, preset: &Map<String, Value>) -> Result<ColorSpace, TransferFileError> {
    let Some(value) = preset.get("ColorSpace") else { return Ok(ColorSpace::Rgb) };
    let name = value.as_str().unwrap_or_default().to_ascii_lowercase();
    match name.as_str() {
        "rgb" => Ok(ColorSpace::Rgb),
        "lab" | "cielab" => Ok(ColorSpace::Lab),
        "diverging" => Ok(ColorSpace::Diverging),
        "step" => Ok(ColorSpace::Step),
        _ => Err(source.wrong(
            "ColorSpace",
            "one of RGB, Lab, CIELAB, Diverging and Step (others are not supported)",
            kind(value),
        )),
    }
}

/// The numbers of a list of points, whole ones; none if there is no such list.
fn numbers(
    source: Source<'_>,
    preset: &Map<String, Value>,
    key: &str,
) -> Result<Option<Vec<f64>>, TransferFileError> {
    let items = match preset.get(key) {
        None | Some(Value::Null) => return Ok(None),
        Some(Value::Array(items)) => items,
        Some(other) => return Err(source.wrong(key, "an array of numbers", kind(other))),
    };
    if items.is_empty() || items.len() % STRIDE != 0 {
        let expected = format!("{STRIDE} numbers for each of at least one point");
        return Err(source.wrong(key, expected, format!("{} numbers", items.len())));
    }
    if items.len() / STRIDE > MAX_POINTS {
        let found = format!("{}", items.len() / STRIDE);
        return Err(source.wrong(key, format!("at most {MAX_POINTS} points"), found));
    }
    let number = |(n, item): (usize, &Value)| {
        let place = || format!("{key}[{n}]");
        item.as_f64().ok_or_else(|| source.wrong(place(), "a number", kind(item)))
    };
    let numbers: Vec<f64> = items.iter().enumerate().map(number).collect::<Result<_, _>>()?;
    for n in (0..numbers.len()).step_by(STRIDE) {
        let before = |back: usize| n.checked_sub(back * STRIDE).map(|m| numbers[m]);
        super::check_value(numbers[n], before(1), before(2))
            .map_err(|(expected, found)| source.wrong(format!("{key}[{n}]"), expected, found))?;
    }
    Ok(Some(numbers))
}

fn color_points(source: Source<'_>, numbers: &[f64]) -> Result<Vec<(f64, Triple)>, TransferFileError> {
    let point = |(i, p): (usize, &[f64])| {
        for (c, name) in ["red", "green", "blue"].into_iter().enumerate() {
            unit_interval(source, "RGBPoints", STRIDE * i + c + 1, name, p[c + 1])?;
        }
        Ok((p[0], [p[1], p[2], p[3]]))
    };
    numbers.chunks_exact(STRIDE).enumerate().map(point).collect()
}

fn opacity_points(source: Source<'_>, numbers: &[f64]) -> Result<Vec<OpacityPoint>, TransferFileError> {
    let point = |(i, p): (usize, &[f64])| {
        for (c, name) in ["opacity", "midpoint", "sharpness"].into_iter().enumerate() {
            unit_interval(source, "Points", STRIDE * i + c + 1, name, p[c + 1])?;
        }
        Ok(OpacityPoint { value: p[0], opacity: p[1], midpoint: p[2], sharpness: p[3] })
    };
    numbers.chunks_exact(STRIDE).enumerate().map(point).collect()
}

fn unit_interval(
    source: Source<'_>,
    key: &str,
    index: usize,
    name: &str,
    found: f64,
) -> Result<(), TransferFileError> {
    if (0.0..=1.0).contains(&found) {
        return Ok(());
    }
    // Vowels of the names that occur.
    let article = if name == "opacity" { "an" } else { "a" };
    Err(source.wrong(format!("{key}[{index}]"), format!("{article} {name} from 0 to 1"), found.to_string()))
}

/// What ParaView starts with: from transparent at the first value to opaque at the last.
fn ramp([low, high]: [f64; 2]) -> Vec<OpacityPoint> {
    let point = |value, opacity| OpacityPoint { value, opacity, midpoint: 0.5, sharpness: 0.0 };
    vec![point(low, 0.0), point(high, 1.0)]
}

/// Linear RGB through the points, of which there is at least one.
fn color_curve(space: ColorSpace, points: &[(f64, Triple)]) -> Curve<3> {
    let linear = |p: &(f64, Triple)| (p.0, p.1.map(decode));
    let mut curve: Vec<(f64, Triple)> = points.first().map(linear).into_iter().collect();
    for pair in points.windows(2) {
        let (&(x0, a), &(x1, b)) = (&pair[0], &pair[1]);
        if x0 == x1 {
            curve.push(linear(&(x1, b)));
            continue;
        }
        if space == ColorSpace::Step {
            curve.extend([linear(&(x0, b)), linear(&(x1, b))]);
            continue;
        }
        let mut positions = Vec::new();
        follow(&mut positions, [0.0, 1.0], &|s| space.between(a, b, s).map(decode), &looks_alike);
        curve.extend(positions.into_iter().map(|(s, y)| (x0 * (1.0 - s) + x1 * s, y)));
    }
    Curve::new(curve)
}
