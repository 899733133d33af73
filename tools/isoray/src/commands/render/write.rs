//! From a frame to a file.

use std::path::Path;

use anyhow::Result;
use isoray_io::{ExrChannel, PixelData, write_exr, write_png};
use isoray_render::{Image, Pixel};

use crate::cli::RenderArgs;
use crate::failure::usage;

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Png,
    Exr,
}

impl Format {
    pub(super) fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => {
                Err(usage(format!("--output {}: expected a name that ends in .png or .exr", path.display())))
            }
        }
    }
}

pub(super) fn write(path: &Path, format: Format, image: &Image, args: &RenderArgs) -> Result<()> {
    let [width, height] = image.size();
    match format {
        Format::Png if args.transparent => {
            write_png(path, width, height, PixelData::Rgba8(&image.to_rgba8()))?;
        }
        Format::Png => {
            let background = args.background.as_vec3();
            write_png(path, width, height, PixelData::Rgb8(&image.to_rgb8(background)))?;
        }
        Format::Exr => {
            let channels: Vec<_> = channels(args.volume.volume)
                .iter()
                .map(|&(name, value)| (name, image.channel(value)))
                .collect();
            let channels: Vec<_> = channels.iter().map(|(name, data)| ExrChannel { name, data }).collect();
            write_exr(path, width, height, &channels)?;
        }
    }
    Ok(())
}

/// A channel's name, and where its values are.
type Channel = (&'static str, fn(&Pixel) -> f32);

/// A volume has neither depth nor normals.
fn channels(is_volume: bool) -> &'static [Channel] {
    const ALL: [Channel; 8] = [
        ("R", |p| p.color.x),
        ("G", |p| p.color.y),
        ("B", |p| p.color.z),
        ("A", |p| p.color.w),
        ("Z", |p| p.depth),
        ("N.X", |p| p.normal.x),
        ("N.Y", |p| p.normal.y),
        ("N.Z", |p| p.normal.z),
    ];
    if is_volume { &ALL[..4] } else { &ALL }
}
