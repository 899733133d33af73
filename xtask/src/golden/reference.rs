//! Stored references: depth and normals of the fixture scenes.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use exr::prelude::{ReadChannels, ReadLayers, read};
use isoray_io::{ExrChannel, write_exr};
use isoray_render::{Image, Pixel};

/// Between instruction sets the arithmetic differs within the documented bound, which for depth is that against the oracle, twice.
const VOXELS: f32 = 2e-2;
/// Component of a unit normal; two of the `f32` pipeline's normals differ by less unless the gradient nearly vanishes.
const NORMAL: f32 = 1e-2;
/// Share of hits that may exceed [`NORMAL`].
const NORMAL_SHARE: f64 = 1e-2;

/// `fixtures/golden/…​.exr` of a scene.
pub(crate) fn file_name(folder: &Path, scene: &str) -> PathBuf {
    let simple: String =
        scene.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect();
    let words: Vec<_> = simple.split('-').filter(|w| !w.is_empty()).collect();
    folder.join(words.join("-")).with_extension("exr")
}

/// Compares a picture with the stored one; what differs beyond the bounds is told, and both are kept under `target/golden`. Grazing
/// rays may change side.
pub(crate) fn check(file: &Path, image: &Image, grazing: u64, bless: bool) -> Result<Option<String>> {
    if bless {
        save(file, image)?;
        return Ok(None);
    }
    let stored = load(file, ["Z", "N.X", "N.Y", "N.Z"])?;
    let mut sides = 0;
    let mut depths = 0;
    let mut normals = 0;
    let mut hits = 0;
    for (n, pixel) in image.pixels().iter().enumerate() {
        let [z, x, y, w] = stored.each_ref().map(|c| c.get(n).copied().unwrap_or(f32::NAN));
        if z.is_finite() != pixel.depth.is_finite() {
            sides += 1;
        } else if z.is_finite() {
            hits += 1;
            depths += u64::from((z - pixel.depth).abs() > VOXELS);
            let difference = (glam::Vec3::new(x, y, w) - pixel.normal).abs().max_element();
            normals += u64::from(difference > NORMAL || difference.is_nan());
        }
    }
    let ok = sides <= grazing && depths <= grazing && normals as f64 <= NORMAL_SHARE * hits as f64;
    if ok {
        return Ok(None);
    }
    let kept = kept(file);
    save(&kept, image)?;
    Ok(Some(format!(
        "differs from {} in {sides} hits, {depths} depths and {normals} normals; rendered: {}",
        file.display(),
        kept.display()
    )))
}

/// As [`check`], of the colours of a volume: two pictures within `epsilon` of the truth are within twice that of each other.
pub(crate) fn check_colors(file: &Path, image: &Image, epsilon: f64, bless: bool) -> Result<Option<String>> {
    if bless {
        save_colors(file, image)?;
        return Ok(None);
    }
    let stored = load(file, ["R", "G", "B", "A"])?;
    let is_off = |(n, pixel): (usize, &Pixel)| {
        let expected = stored.each_ref().map(|c| c.get(n).copied().unwrap_or(f32::NAN));
        let within = |(found, stored): (f32, f32)| f64::from((found - stored).abs()) <= 2.0 * epsilon;
        !pixel.color.to_array().into_iter().zip(expected).all(within)
    };
    let off = image.pixels().iter().enumerate().filter(|&pixel| is_off(pixel)).count();
    if off == 0 {
        return Ok(None);
    }
    let kept = kept(file);
    save_colors(&kept, image)?;
    Ok(Some(format!(
        "differs from {} in {off} pixels by more than {}; rendered: {}",
        file.display(),
        2.0 * epsilon,
        kept.display()
    )))
}

/// Where a picture is kept that differs from the stored one.
fn kept(file: &Path) -> PathBuf {
    crate::root().join("target/golden").join(file.file_name().unwrap_or_default())
}

fn save(file: &Path, image: &Image) -> Result<()> {
    let channels = [
        ("Z", image.channel(|p| p.depth)),
        ("N.X", image.channel(|p| p.normal.x)),
        ("N.Y", image.channel(|p| p.normal.y)),
        ("N.Z", image.channel(|p| p.normal.z)),
    ];
    write(file, image, &channels)
}

fn save_colors(file: &Path, image: &Image) -> Result<()> {
    let channels = [
        ("R", image.channel(|p| p.color.x)),
        ("G", image.channel(|p| p.color.y)),
        ("B", image.channel(|p| p.color.z)),
        ("A", image.channel(|p| p.color.w)),
    ];
    write(file, image, &channels)
}

fn write(file: &Path, image: &Image, channels: &[(&str, Vec<f32>)]) -> Result<()> {
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder)?;
    }
    let [width, height] = image.size();
    let channels: Vec<_> = channels.iter().map(|(name, data)| ExrChannel { name, data }).collect();
    Ok(write_exr(file, width, height, &channels)?)
}

/// Four channels.
fn load(file: &Path, names: [&str; 4]) -> Result<[Vec<f32>; 4]> {
    let missing = || format!("{}: cannot be read; make it with `cargo xtask golden --bless`", file.display());
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(file)
        .with_context(missing)?;
    let channel = |name: &str| {
        let found = image.layer_data.channel_data.list.iter().find(|c| c.name.eq_case_insensitive(name));
        let channel = found.with_context(|| format!("{}: no channel {name}", file.display()))?;
        Ok::<_, anyhow::Error>(channel.sample_data.values_as_f32().collect())
    };
    let [a, b, c, d] = names;
    Ok([channel(a)?, channel(b)?, channel(c)?, channel(d)?])
}
