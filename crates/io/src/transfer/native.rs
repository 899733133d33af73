//! isoray's own TOML files; the module above documents them.

use serde::Deserialize;
use toml::{Spanned, Value};

use super::color::{Triple, decode};
use super::colormap::colormap;
use super::curve::Curve;
use super::error::{Source, TransferFileError};
use super::opacity::extinction;
use super::{MAX_POINTS, Parsed, UNIT_DISTANCES};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    color_space: Notation,
    colormap: Option<Spanned<String>>,
    unit_distance: Option<Spanned<f64>>,
    #[serde(default)]
    normalized: bool,
    points: Spanned<Vec<Point>>,
}

/// What three numbers of a colour mean.
#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Notation {
    #[default]
    Srgb,
    Linear,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Point {
    value: Spanned<f64>,
    color: Option<Spanned<Value>>,
    extinction: Option<Spanned<f64>>,
    opacity: Option<Spanned<f64>>,
}

/// What is wrong with a value: what was expected, and what was found.
type Wrong = (String, String);

/// Reads the text; opacities are per `unit` world units unless it says otherwise.
pub(crate) fn parse(source: Source<'_>, unit: f64) -> Result<Parsed, TransferFileError> {
    let file: File = toml::from_str(source.text).map_err(|e| {
        let [line, column] = source.line_column(e.span().map_or(0, |s| s.start));
        let message = e.message().trim().replace('\n', "; ");
        let format = "transfer function in TOML";
        TransferFileError::Syntax { path: source.path.to_owned(), line, column, format, message }
    })?;
    let unit = match &file.unit_distance {
        Some(distance) if !UNIT_DISTANCES.contains(distance.get_ref()) => {
            let (at, found) = (distance.span().start, distance.get_ref().to_string());
            return Err(source.wrong_at(at, "unit_distance", "a length between 1e-20 and 1e20", found));
        }
        Some(distance) => *distance.get_ref(),
        None => unit,
    };
    let points = file.points.get_ref();
    if points.is_empty() || points.len() > MAX_POINTS {
        let (at, expected) = (file.points.span().start, format!("from 1 to {MAX_POINTS} points"));
        return Err(source.wrong_at(at, "points", expected, points.len().to_string()));
    }
    let mut values: Vec<f64> = Vec::with_capacity(points.len());
    let (mut colors, mut extinctions) = (Vec::new(), Vec::new());
    for (n, point) in points.iter().enumerate() {
        let at = point.value.span().start;
        let value = *point.value.get_ref();
        let before = |back: usize| n.checked_sub(back).map(|m| values[m]);
        super::check_value(value, before(1), before(2)).map_err(|(expected, found)| {
            source.wrong_at(at, format!("points[{n}].value"), expected, found)
        })?;
        values.push(value);
        colors.extend(color(source, &file, n)?.map(|c| (value, c)));
        extinctions.push((value, [extinction_of(source, point, n, unit)?]));
    }
    let extinctions = Curve::new(extinctions);
    let colors = match &file.colormap {
        Some(name) => colormap(name.get_ref())
            .map_err(|e| {
                let expected = format!("one of {}", super::COLORMAPS.join(", "));
                source.wrong_at(name.span().start, "colormap", expected, format!("'{}'", e.name))
            })?
            .over(extinctions.span()),
        None => Curve::new(colors),
    };
    Ok(Parsed { colors, extinctions, normalized: file.normalized })
}

/// The colour of a point; none if a colour map gives it.
fn color(source: Source<'_>, file: &File, n: usize) -> Result<Option<Triple>, TransferFileError> {
    let point = &file.points.get_ref()[n];
    let place = format!("points[{n}].color");
    match (&point.color, &file.colormap) {
        (None, Some(_)) => Ok(None),
        (Some(color), Some(_)) => Err(source.wrong_at(
            color.span().start,
            place,
            "no colour beside a colormap",
            source.snippet(color.span()),
        )),
        (None, None) => Err(source.wrong_at(
            point.value.span().start,
            place,
            "a colour at each point, or a colormap for all",
            "neither",
        )),
        (Some(color), None) => {
            let wrong =
                |(expected, found): Wrong| source.wrong_at(color.span().start, place, expected, found);
            linear(color.get_ref(), source.snippet(color.span()), file.color_space).map(Some).map_err(wrong)
        }
    }
}

/// Linear RGB of a colour in the file; `text` is how it stands there.
fn linear(color: &Value, text: &str, notation: Notation) -> Result<Triple, Wrong> {
    let wrong = || {
        let expected = "[red, green, blue] or \"#rrggbb\"".to_owned();
        Err((expected, text.to_owned()))
    };
    match color {
        Value::String(digits) => match hex(digits) {
            Some(bytes) => Ok(bytes.map(|b| decode(f64::from(b) / 255.0))),
            None => wrong(),
        },
        Value::Array(items) => {
            let number = |v: &Value| v.as_float().or_else(|| v.as_integer().map(|n| n as f64));
            let numbers: Option<Vec<f64>> = items.iter().map(number).collect();
            let Some(Ok(rgb)) = numbers.map(<[f64; 3]>::try_from) else { return wrong() };
            let (most, what) = match notation {
                Notation::Srgb => (1.0, "from 0 to 1"),
                Notation::Linear => (f64::from(isoray_preint::LARGEST), "of at least 0"),
            };
            match rgb.iter().find(|c| !(0.0..=most).contains(*c)) {
                Some(bad) => Err((format!("components {what}"), bad.to_string())),
                None => Ok(match notation {
                    Notation::Srgb => rgb.map(decode),
                    Notation::Linear => rgb,
                }),
            }
        }
        _ => wrong(),
    }
}

/// The linear colour of `#rrggbb`, an sRGB colour as in style sheets and in transfer functions; `None` if it is written otherwise.
pub fn hex_color(text: &str) -> Option<[f32; 3]> {
    Some(hex(text)?.map(|byte| decode(f64::from(byte) / 255.0) as f32))
}

/// The bytes of `#rrggbb`.
fn hex(text: &str) -> Option<[u8; 3]> {
    let digits =
        text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let number = u32::from_str_radix(digits, 16).ok()?;
    let [_, r, g, b] = number.to_be_bytes();
    Some([r, g, b])
}

/// The extinction of a point, given as such or as an opacity.
fn extinction_of(source: Source<'_>, point: &Point, n: usize, unit: f64) -> Result<f64, TransferFileError> {
    let place = |key: &str| format!("points[{n}].{key}");
    match (&point.extinction, &point.opacity) {
        (Some(given), None) => {
            let largest = f64::from(isoray_preint::LARGEST);
            match *given.get_ref() {
                found if (0.0..=largest).contains(&found) => Ok(found),
                found => {
                    let expected = "an extinction of at least 0, and at most 1e30";
                    Err(source.wrong_at(given.span().start, place("extinction"), expected, found.to_string()))
                }
            }
        }
        (None, Some(given)) => match *given.get_ref() {
            found if (0.0..=1.0).contains(&found) => Ok(extinction(found, unit)),
            found => {
                let expected = "an opacity from 0 to 1";
                Err(source.wrong_at(given.span().start, place("opacity"), expected, found.to_string()))
            }
        },
        (Some(_), Some(given)) => {
            let expected = "either an extinction or an opacity";
            Err(source.wrong_at(given.span().start, place("opacity"), expected, "both"))
        }
        (None, None) => {
            let expected = "an extinction or an opacity";
            Err(source.wrong_at(point.value.span().start, place("extinction"), expected, "neither"))
        }
    }
}
