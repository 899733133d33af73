//! Flags of isosurfaces, and of what is cut away.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::DVec3;
use isoray_io::transfer::hex_color;

use super::{parse_color, parse_numbers, parse_triple};

/// What `isoray render` can be told about isosurfaces.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Isosurfaces")]
pub(crate) struct SurfaceArgs {
    /// Value at which a surface lies, in the data's own units, with its colour (#rrggbb, or linear R,G,B from 0 to 1) and
    /// opacity, from 0 to 1; may be given several times [default: proposed from the histogram]
    #[arg(long, value_name = "V[:COLOR[:OPACITY]]", value_parser = parse_isovalue, allow_hyphen_values = true)]
    pub(crate) isovalue: Vec<IsovalueArg>,
    /// Where normals for shading come from [default: forward]
    #[arg(long, value_enum)]
    pub(crate) normals: Option<NormalsArg>,
    /// Let surfaces cast shadows
    #[arg(long)]
    pub(crate) shadows: bool,
    /// Darken what sees little of the sky, by N rays from each point
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub(crate) ao: Option<u32>,
    /// Highlights of brightness K, from 0 to 1, the smaller the larger EXPONENT is [default exponent: 32]
    #[arg(long, value_name = "K[:EXPONENT]", value_parser = parse_specular, allow_hyphen_values = true)]
    pub(crate) specular: Option<SpecularArg>,
    /// How rays to a single opaque surface go through the octree; the picture is the same, bit for bit [default: auto]
    #[arg(long, value_enum)]
    pub(crate) traversal: Option<TraversalArg>,
    /// Pixels along the edge of a packet of rays [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=16))]
    pub(crate) packet: Option<u32>,
    /// Draw cells up to RATIO pixels wide in place of finer ones, by distance; of adaptive meshes, volumes too; 0 is exact
    #[arg(long, value_name = "RATIO", value_parser = parse_ratio, default_value = "0", allow_hyphen_values = true)]
    pub(crate) lod: f64,
    /// Over which last share of the stretch at a level, from 0 to 1, its values go over into the next one's [default: 0]
    #[arg(long, value_name = "SHARE", value_parser = parse_share, allow_hyphen_values = true)]
    pub(crate) lod_blend: Option<f64>,
    /// What the level depends on [default: true]
    #[arg(long, value_enum)]
    pub(crate) lod_distance: Option<DistanceArg>,
    /// Colour surfaces by the level that is drawn
    #[arg(long)]
    pub(crate) lod_colors: bool,
    /// Look for what hides a light or the sky in cells up to RATIO pixels wide, from the next one on; 0 is exact
    #[arg(long, value_name = "RATIO", value_parser = parse_ratio, allow_hyphen_values = true)]
    pub(crate) shadow_lod: Option<f64>,
    /// Colour surfaces by a second volume on the same lattice; three components of u8 are red, green and blue
    #[arg(long, value_name = "FILE")]
    pub(crate) color_by: Option<PathBuf>,
    /// Colours of its values, one of those that `isoray tf list` names [default: viridis]
    #[arg(long, value_name = "NAME")]
    pub(crate) color_map: Option<String>,
    /// Values that get the first and the last of them [default: the least and the greatest there is]
    #[arg(long, value_name = "A:B", value_parser = parse_range, allow_hyphen_values = true)]
    pub(crate) color_range: Option<[f32; 2]>,
}

/// What is cut away, of surfaces and volumes.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Clipping (world space)")]
pub(crate) struct ClipArgs {
    /// Keep what is in a box
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = parse_box, allow_hyphen_values = true)]
    pub(crate) clip_box: Option<[DVec3; 2]>,
    /// Keep the points with N·p >= D; may be given several times
    #[arg(long, value_name = "NX,NY,NZ,D", value_parser = parse_plane, allow_hyphen_values = true)]
    pub(crate) clip_plane: Vec<PlaneArg>,
    /// Isosurfaces: close the cut where it goes through the inside of one
    #[arg(long)]
    pub(crate) cap: bool,
}

impl ClipArgs {
    /// Whether anything may be cut away.
    pub(crate) fn is_given(&self) -> bool {
        self.clip_box.is_some() || !self.clip_plane.is_empty()
    }
}

/// A surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct IsovalueArg {
    pub(crate) value: f64,
    /// Linear RGB.
    pub(crate) color: Option<DVec3>,
    pub(crate) opacity: f32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum NormalsArg {
    /// Gradient of the interpolated field itself: exact, with creases at cell faces
    Forward,
    /// Interpolated central differences: smooth
    Central,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TraversalArg {
    /// As packets, unless rays are too far apart
    Auto,
    /// One ray after the other
    Single,
    /// Packets as one down the octree, and in SIMD lanes at its cells
    Masked,
    /// Packets slab by slab through the octree, and in SIMD lanes at its cells
    Coherent,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum DistanceArg {
    /// The distance from the eye
    True,
    /// That of the slice across the axis of the volume along which the view mostly runs
    Slices,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpecularArg {
    pub(crate) brightness: f32,
    pub(crate) exponent: f32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlaneArg {
    pub(crate) normal: DVec3,
    pub(crate) offset: f64,
}

fn parse_isovalue(text: &str) -> Result<IsovalueArg, String> {
    let mut parts = text.split(':');
    let value = parts.next().unwrap_or_default();
    let value = value.trim().parse().map_err(|_| format!("expected a number, like 42, found '{value}'"))?;
    let color = match parts.next() {
        None | Some("") => None,
        Some(color) => Some(parse_any_color(color)?),
    };
    let opacity = match parts.next() {
        None => 1.0,
        Some(opacity) => match opacity.parse() {
            Ok(o) if o > 0.0 && o <= 1.0 => o,
            _ => return Err(format!("expected an opacity above 0 and up to 1, found '{opacity}'")),
        },
    };
    match parts.next() {
        None => Ok(IsovalueArg { value, color, opacity }),
        Some(_) => Err(format!("expected V:COLOR:OPACITY, like 42:#c08040:0.5, found '{text}'")),
    }
}

fn parse_any_color(text: &str) -> Result<DVec3, String> {
    match hex_color(text) {
        Some(color) => Ok(DVec3::from_array(color.map(f64::from))),
        None => parse_color(text).map_err(|_| {
            format!("expected a colour like #c08040 or three numbers from 0 to 1, found '{text}'")
        }),
    }
}

fn parse_specular(text: &str) -> Result<SpecularArg, String> {
    let (brightness, exponent) = text.split_once(':').unwrap_or((text, "32"));
    let brightness = match brightness.parse() {
        Ok(k) if (0.0..=1.0).contains(&k) => k,
        _ => return Err(format!("expected a brightness from 0 to 1, found '{brightness}'")),
    };
    match exponent.parse() {
        Ok(exponent) if (1.0..=10_000.0).contains(&exponent) => Ok(SpecularArg { brightness, exponent }),
        _ => Err(format!("expected an exponent from 1 to 10000, found '{exponent}'")),
    }
}

fn parse_ratio(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(ratio) if (0.0..=1e6).contains(&ratio) => Ok(ratio),
        _ => Err(format!("expected a number of pixels from 0 to 1000000, found '{text}'")),
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err(format!("expected a number from 0 to 1, found '{text}'")),
    }
}

fn parse_range(text: &str) -> Result<[f32; 2], String> {
    let wrong = || format!("expected two different numbers, like 0:255, found '{text}'");
    match parse_numbers::<f32>(text, ':', "two numbers")?[..] {
        [a, b] if a.is_finite() && b.is_finite() && a != b => Ok([a, b]),
        _ => Err(wrong()),
    }
}

fn parse_box(text: &str) -> Result<[DVec3; 2], String> {
    const WHAT: &str = "six numbers, the lowest corner and the highest, like 0,0,0,10,10,10";
    match parse_numbers::<f64>(text, ',', WHAT)?[..] {
        [a, b, c, d, e, f] if [a, b, c, d, e, f].iter().all(|c| c.is_finite()) && a < d && b < e && c < f => {
            Ok([DVec3::new(a, b, c), DVec3::new(d, e, f)])
        }
        _ => Err(format!("expected {WHAT}, found '{text}'")),
    }
}

fn parse_plane(text: &str) -> Result<PlaneArg, String> {
    const WHAT: &str = "four numbers, a normal that is not zero and a distance, like 0,0,1,20";
    let (normal, offset) = text.rsplit_once(',').ok_or(format!("expected {WHAT}, found '{text}'"))?;
    match (parse_triple(normal), offset.trim().parse()) {
        (Ok(normal), Ok(offset)) if normal != DVec3::ZERO && f64::is_finite(offset) => {
            Ok(PlaneArg { normal, offset })
        }
        _ => Err(format!("expected {WHAT}, found '{text}'")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn isovalues_with_looks() {
        let of = |text| parse_isovalue(text).unwrap();
        assert_eq!(of("-300"), IsovalueArg { value: -300.0, color: None, opacity: 1.0 });
        assert_eq!(of("42::0.25"), IsovalueArg { value: 42.0, color: None, opacity: 0.25 });
        assert_eq!(of("1.5:1,0.5,0").color, Some(DVec3::new(1.0, 0.5, 0.0)));
        assert_eq!(of("7:#ff0000:0.5").color, Some(DVec3::X));
        for (text, part) in [
            ("x", "expected a number"),
            ("1:red", "like #c08040"),
            ("1:#ff00", "like #c08040"),
            ("1:2,0,0", "from 0 to 1"),
            ("1::0", "above 0 and up to 1"),
            ("1::1.5", "above 0 and up to 1"),
            ("1::nan", "above 0 and up to 1"),
            ("1::1:2", "V:COLOR:OPACITY"),
        ] {
            let error = parse_isovalue(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn ratios_and_shares() {
        assert_eq!((parse_ratio("1.5"), parse_share("0.25")), (Ok(1.5), Ok(0.25)));
        for text in ["-1", "nan", "inf", "x"] {
            assert!(parse_ratio(text).unwrap_err().contains("pixels from 0"), "{text}");
            assert!(parse_share(text).unwrap_err().contains("from 0 to 1"), "{text}");
        }
        assert!(parse_share("1.01").is_err());
    }

    #[test]
    fn planes_boxes_ranges_and_highlights() {
        assert_eq!(
            parse_plane("0,-1,2,-5"),
            Ok(PlaneArg { normal: DVec3::new(0.0, -1.0, 2.0), offset: -5.0 })
        );
        assert_eq!(parse_box("0,0,-1,2,3,4"), Ok([DVec3::new(0.0, 0.0, -1.0), DVec3::new(2.0, 3.0, 4.0)]));
        assert_eq!(parse_range("-5:10"), Ok([-5.0, 10.0]));
        assert_eq!(parse_specular("0.5"), Ok(SpecularArg { brightness: 0.5, exponent: 32.0 }));
        assert_eq!(parse_specular("1:8"), Ok(SpecularArg { brightness: 1.0, exponent: 8.0 }));
        assert!(
            parse_plane("0,0,0,1").is_err() && parse_plane("1,2,3").is_err() && parse_plane("1").is_err()
        );
        assert!(parse_box("0,0,0,1,1,0").is_err() && parse_box("0,0,0").is_err());
        assert!(parse_range("3:3").is_err() && parse_range("3").is_err() && parse_range("nan:1").is_err());
        assert!(parse_specular("2").is_err() && parse_specular("0.5:0").is_err());
    }
}
