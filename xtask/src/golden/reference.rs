//! Stored references: depth and normals of the fixture scenes.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use exr::prelude::{ReadChannels, ReadLayers, read};
use isoray_io::{ExrChannel, write_exr};

use super::report::Tally;
use super::verify::Rendered;

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
pub(crate) fn check(file: &Path, rendered: &Rendered, tally: &Tally, bless: bool) -> Result<Option<String>> {
    if bless {
        save(file, rendered)?;
        return Ok(None);
    }
    let stored = load(file)?;
    let image = &rendered.forward;
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
    let ok =
        sides <= tally.grazing() && depths <= tally.grazing() && normals as f64 <= NORMAL_SHARE * hits as f64;
    if ok {
        return Ok(None);
    }
    let kept = crate::root().join("target/golden").join(file.file_name().unwrap_or_default());
    fs::create_dir_all(kept.parent().unwrap_or(Path::new(".")))?;
    save(&kept, rendered)?;
    Ok(Some(format!(
        "differs from {} in {sides} hits, {depths} depths and {normals} normals; rendered: {}",
        file.display(),
        kept.display()
    )))
}

fn save(file: &Path, rendered: &Rendered) -> Result<()> {
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder)?;
    }
    let image = &rendered.forward;
    let [width, height] = image.size();
    let channels = [
        ("Z", image.channel(|p| p.depth)),
        ("N.X", image.channel(|p| p.normal.x)),
        ("N.Y", image.channel(|p| p.normal.y)),
        ("N.Z", image.channel(|p| p.normal.z)),
    ];
    let channels: Vec<_> = channels.iter().map(|(name, data)| ExrChannel { name, data }).collect();
    Ok(write_exr(file, width, height, &channels)?)
}

/// Depth and the three components of the normal.
fn load(file: &Path) -> Result<[Vec<f32>; 4]> {
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
    Ok([channel("Z")?, channel("N.X")?, channel("N.Y")?, channel("N.Z")?])
}
