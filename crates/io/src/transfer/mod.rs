//! Transfer-function files: isoray's own, in TOML, and presets of ParaView, in JSON. The first characters tell which.
//!
//! # TOML
//!
//! ```toml
//! color_space = "srgb"    # what [red, green, blue] are: "srgb" (the default), from 0 to 1, or "linear", from 0
//! unit_distance = 2.0     # world units of length that opacities are for
//! normalized = false      # whether values are relative to the range of the data
//!
//! [[points]]              # one for each control point, in the order of their values
//! value = 500             # in the data's own units
//! color = "#3b4cc0"       # always sRGB; or [red, green, blue]
//! extinction = 0.0        # per world unit of length, at least 0
//!
//! [[points]]
//! value = 1300
//! color = [0.9, 0.8, 0.6]
//! opacity = 0.4           # instead of extinction
//! ```
//!
//! | key | required | meaning |
//! |---|---|---|
//! | `points` | yes | from 1 to 16384 points; two of equal value are a step, the later one holds at and above it |
//! | `points.value` | yes | between −10³⁰ and 10³⁰, not less than the one before |
//! | `points.color` | unless there is a `colormap` | `"#rrggbb"` in sRGB, or three numbers as `color_space` says |
//! | `points.extinction` | one of these two | per world unit of length, from 0 to 10³⁰ |
//! | `points.opacity` | | from 0 to 1: what a homogeneous layer, `unit_distance` thick, hides of what is behind it |
//! | `color_space` | no | `"srgb"`, display colours, or `"linear"` light; `"srgb"` if it is missing |
//! | `colormap` | no | one of [`COLORMAPS`], spread over the values from the first to the last point |
//! | `unit_distance` | no | world units; if it is missing, [`TransferOptions::unit_distance`] |
//! | `normalized` | no | `true`: the values are mapped to the range of the data |
//!
//! Any other key is an error. Between two points colour is linear *in linear RGB*, whatever the notation, and extinction
//! is linear, also where opacities are given: an opacity is only another way to write the extinction at its point,
//! −ln(1 − opacity) / `unit_distance`. Opacities above 1 − 2⁻¹⁰ count as that.
//!
//! # ParaView's presets
//!
//! An array of objects, of which the first is read, or one object; of its keys these matter, and the others are ignored:
//!
//! | key | meaning |
//! |---|---|
//! | `RGBPoints` | value, red, green, blue of each point, in display colours (sRGB) from 0 to 1 |
//! | `ColorSpace` | how colours are interpolated: `RGB` (if it is missing), `Lab` or `CIELAB`, `Diverging`, `Step` |
//! | `Points` | value, opacity, midpoint, sharpness of each point; if missing, from opacity 0 at the first value to 1 at the last |
//!
//! *Colours* are interpolated as VTK does, and points are inserted so that what isoray makes of them, linear in linear
//! RGB, deviates by at most 1/1024 in display colours. With `Step` all values up to a point, from the one before, have
//! its colour (in isoray the value of a point itself has the next one). Other colour spaces are refused.
//!
//! *Opacities* are per [`TransferOptions::unit_distance`], interpolated with midpoint and sharpness as VTK does, and
//! become extinctions as above, with points inserted so that these are met within 1 % (or 10⁻⁴ of the larger one of the
//! points on either side, where they vanish).
//!
//! # Values
//!
//! Values are in the data's units, with two exceptions. A range given as [`Remap::range`] takes the place of the file's
//! own. Otherwise a *normalized* file, one whose `RGBPoints` span exactly 0 to 1 or −1 to 1, or which says `normalized =
//! true`, is spread over [`TransferOptions::data_range`]. Colours and opacities of a preset are spread each by their own
//! first and last value, as ParaView does. With [`Remap::log`] equal distances become equal ratios, in either case; a
//! file that stays in its units keeps its first and last value then.

mod color;
mod colormap;
mod curve;
mod error;
mod native;
mod opacity;
mod paraview;
mod remap;

use std::fs::File;
use std::io::Read;
use std::ops::RangeInclusive;
use std::path::Path;

use isoray_preint::{LARGEST, TransferFunction};

pub use colormap::{COLORMAPS, Colormap, UnknownColormap, colormap};
use curve::{Curve, finish, join};
use error::Source;
pub use error::TransferFileError;
pub use native::hex_color;
pub use remap::{Remap, RemapError};

/// What a transfer-function file leaves to its user.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferOptions {
    /// World units of length that opacities are for, where the file does not say; between 10⁻²⁰ and 10²⁰.
    pub unit_distance: f64,
    /// The range that normalized files are mapped to; without one their values stay as they are.
    pub data_range: Option<[f32; 2]>,
    /// Another range or spacing of the values.
    pub remap: Remap,
}

impl Default for TransferOptions {
    /// Opacities per world unit, and values as they are.
    fn default() -> Self {
        Self { unit_distance: 1.0, data_range: None, remap: Remap::default() }
    }
}

/// Longest file that is read, in bytes: all 200 presets of ParaView take two million.
const MAX_BYTES: u64 = 8 << 20;
/// Most points in a list; scientific colour maps have 256 to 1024.
const MAX_POINTS: usize = 1 << 14;
/// Lengths for which every extinction is within range.
const UNIT_DISTANCES: RangeInclusive<f64> = 1e-20..=1e20;

/// A file, read but not yet moved to the data's values.
struct Parsed {
    /// Linear RGB.
    colors: Curve<3>,
    extinctions: Curve<1>,
    normalized: bool,
}

/// Reads a transfer function from a TOML file, or from a ParaView preset in JSON; the
/// [module](self) describes both.
///
/// # Errors
///
/// If the file cannot be read or is no transfer function, or the options are wrong or do not fit it.
pub fn read_transfer_function(
    path: &Path,
    options: &TransferOptions,
) -> Result<TransferFunction, TransferFileError> {
    if !UNIT_DISTANCES.contains(&options.unit_distance) {
        return Err(TransferFileError::UnitDistance { path: path.to_owned(), found: options.unit_distance });
    }
    let bytes = read(path)?;
    let text = std::str::from_utf8(&bytes)
        .map_err(|e| TransferFileError::NotText { path: path.to_owned(), at: e.valid_up_to() })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim().is_empty() {
        return Err(TransferFileError::Empty { path: path.to_owned() });
    }
    let source = Source { path, text };
    let parsed = match is_json(path, text) {
        true => paraview::parse(source, options.unit_distance)?,
        false => native::parse(source, options.unit_distance)?,
    };
    place(path, &parsed, options)
}

fn read(path: &Path) -> Result<Vec<u8>, TransferFileError> {
    let error = |action| move |source| TransferFileError::Io { path: path.to_owned(), action, source };
    let file = File::open(path).map_err(error("open"))?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(error("read"))?;
    match bytes.len() as u64 > MAX_BYTES {
        true => Err(TransferFileError::TooLarge { path: path.to_owned(), most: MAX_BYTES }),
        false => Ok(bytes),
    }
}

/// Whether a text looks like JSON: TOML does not begin with `{`, nor has it `[` and then anything but a name or another
/// `[`. Where that does not tell, the extension does.
fn is_json(path: &Path, text: &str) -> bool {
    let text = text.trim_start();
    let inside = text.strip_prefix('[').map(str::trim_start);
    text.starts_with('{')
        || inside.is_some_and(|rest| rest.is_empty() || rest.starts_with(['{', ']']))
        || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

/// Refuses a value that is out of range, less than the one `before`, or the third in a row; tells what was expected
/// and what was found.
fn check_value(value: f64, before: Option<f64>, twice: Option<f64>) -> Result<(), (String, String)> {
    let largest = f64::from(LARGEST);
    if !(-largest..=largest).contains(&value) {
        return Err(("a number between -1e30 and 1e30".to_owned(), value.to_string()));
    }
    match before {
        Some(before) if value < before => {
            Err((format!("a value of at least {before}, that of the point before"), value.to_string()))
        }
        Some(before) if value == before && twice == before.into() => {
            Err(("at most two points of one value".to_owned(), format!("a third of value {value}")))
        }
        _ => Ok(()),
    }
}

/// Puts the values where they belong.
fn place(
    path: &Path,
    parsed: &Parsed,
    options: &TransferOptions,
) -> Result<TransferFunction, TransferFileError> {
    let Parsed { colors, extinctions, normalized } = parsed;
    let Remap { range, log } = options.remap;
    let data_range = options.data_range.filter(|_| *normalized);
    let function = match range.or(data_range) {
        None if !log => join(colors, extinctions),
        target => {
            let own = [colors.span(), extinctions.span()];
            let union = [own[0][0].min(own[1][0]), own[0][1].max(own[1][1])];
            let new = target.unwrap_or(union.map(|v| v as f32));
            remap::check(new, range.is_some(), log)
                .map_err(|reason| TransferFileError::Remap { path: path.to_owned(), reason })?;
            let [for_colors, for_extinctions] = if target.is_some() { own } else { [union; 2] };
            let positions = join(&colors.normalized(for_colors), &extinctions.normalized(for_extinctions));
            remap::spread(&positions, new, log)
        }
    };
    finish(&function).map_err(|reason| TransferFileError::Function { path: path.to_owned(), reason })
}
