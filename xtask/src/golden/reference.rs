//! Stored references: depth and normals, colours of volumes, and pictures.

mod replace;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use exr::prelude::{ReadChannels, ReadLayers, read};
use glam::Vec3;
use isoray_io::{ExrChannel, write_exr};
use isoray_render::{Image, Pixel};

use super::compared::{colors_picture, over_background};
use super::picture::{Difference, Picture};
use crate::for_oracle::{apart, colors_apart, is_hit};
use crate::root;

/// Between instruction sets the arithmetic differs within the documented bound, which for depth is that against the oracle, twice.
const VOXELS: f32 = 2e-2;
/// Component of a unit normal; two of the `f32` pipeline's normals differ by less unless the gradient nearly vanishes.
const NORMAL: f32 = 1e-2;
/// Share of hits that may exceed [`NORMAL`].
const NORMAL_SHARE: f64 = 1e-2;

/// The stored references, and those that are to replace them.
pub(crate) struct References {
    folder: PathBuf,
    /// Where files are while they are replaced: on the same file system, if it can be.
    scratch: PathBuf,
    is_update: bool,
    new: Vec<(String, Contents)>,
    /// Names of files that scenes have.
    used: BTreeSet<String>,
}

/// What a file holds.
enum Contents {
    Channels { size: [u32; 2], channels: Vec<(&'static str, Vec<f32>)> },
    Picture(Picture),
}

impl References {
    /// Those of the fixtures; `is_update`: nothing is compared with them, they are to be replaced.
    pub(crate) fn new(is_update: bool) -> Self {
        Self::of(root().join("fixtures/golden"), root().join("target/golden"), is_update)
    }

    /// Whether they are to be replaced.
    pub(crate) fn is_update(&self) -> bool {
        self.is_update
    }

    fn of(folder: PathBuf, scratch: PathBuf, is_update: bool) -> Self {
        Self { folder, scratch, is_update, new: Vec::new(), used: BTreeSet::new() }
    }

    /// The file of a scene.
    fn file_of(&mut self, scene: &str, extension: &str) -> String {
        let name = file_name(scene, extension);
        self.used.insert(name.clone());
        name
    }

    /// Files in the folder that no scene asked for, after all did.
    pub(crate) fn orphans(&self) -> Result<Vec<String>> {
        let mut orphans = Vec::new();
        if !self.folder.is_dir() {
            return Ok(orphans);
        }
        for entry in fs::read_dir(&self.folder)? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            if !self.used.contains(&name) {
                orphans.push(name);
            }
        }
        orphans.sort();
        Ok(orphans)
    }

    /// Compares depth and normals with the stored ones; what differs beyond the bounds is told, and shown under `target/golden`. Pixels whose rays
    /// graze may differ: rounding decides what they show.
    pub(crate) fn surface(
        &mut self,
        scene: &str,
        image: &Image,
        is_grazing: impl Fn(usize) -> bool,
    ) -> Result<Option<String>> {
        let name = self.file_of(scene, "exr");
        if self.is_update {
            self.new.push((name, surface_channels(image)));
            return Ok(None);
        }
        let stored = match load(&self.folder.join(&name), ["Z", "N.X", "N.Y", "N.Z"], image) {
            Ok(stored) => stored,
            Err(error) => return self.without(&error, scene, surface_channels(image)).map(Some),
        };
        let differences = Differences::of(&stored, image.pixels(), is_grazing);
        if differences.are_allowed() {
            return Ok(None);
        }
        let Differences { sides, depths, normals, .. } = &differences;
        let kept = self.keep(scene, surface_channels(image))?;
        let reference = normals_picture(image.size(), |n| {
            let [z, x, y, w] = stored.each_ref().map(|c| c[n]);
            z.is_finite().then_some(Vec3::new(x, y, w))
        });
        let found = normals_picture(image.size(), |n| {
            let pixel = image.pixels()[n];
            is_hit(&pixel).then_some(pixel.normal)
        });
        let shown = show(scene, &reference, &found)?;
        let width = image.size()[0];
        Ok(Some(format!(
            "differs from {name}: hits in {}, depths in {}, normals in {}; rendered: {}, as a picture: {}",
            sides.told(width),
            depths.told(width),
            normals.told(width),
            kept.display(),
            shown.display()
        )))
    }

    /// Compares the colours of a volume: two pictures within `epsilon` of the truth are within twice that of each other.
    pub(crate) fn volume(&mut self, scene: &str, image: &Image, epsilon: f64) -> Result<Option<String>> {
        let name = self.file_of(scene, "exr");
        if self.is_update {
            self.new.push((name, color_channels(image)));
            return Ok(None);
        }
        let stored = match load(&self.folder.join(&name), ["R", "G", "B", "A"], image) {
            Ok(stored) => stored,
            Err(error) => return self.without(&error, scene, color_channels(image)).map(Some),
        };
        let mut colors = Beyond::default();
        for (n, pixel) in image.pixels().iter().enumerate() {
            let expected = stored.each_ref().map(|c| c[n]);
            colors.add(n, colors_apart(pixel.color.to_array(), expected), 2.0 * epsilon);
        }
        if colors.count == 0 {
            return Ok(None);
        }
        let kept = self.keep(scene, color_channels(image))?;
        let reference = colors_picture(image.size(), |n| stored.each_ref().map(|c| c[n]));
        let found = over_background(image);
        let shown = show(scene, &reference, &found)?;
        Ok(Some(format!(
            "differs from {name} by more than {}: {}; rendered: {}, as a picture: {}",
            2.0 * epsilon,
            colors.told(image.size()[0]),
            kept.display(),
            shown.display()
        )))
    }

    /// Compares a picture of a scene with the one that is stored under a name; scenes that ought to look alike have one. How it differs, if it is not that one, and what is wrong if
    /// that is too much.
    pub(crate) fn picture(
        &mut self,
        (stored, scene): (&str, &str),
        picture: &Picture,
        is_doubtful: impl Fn(usize) -> bool,
    ) -> Result<(Option<Difference>, Option<String>)> {
        let name = self.file_of(stored, "png");
        if !self.is_update {
            let reference = Picture::read(&self.folder.join(&name)).with_context(make_it);
            let compared = reference.and_then(|of| Ok((picture.difference(&of, is_doubtful)?, of)));
            return match compared {
                Ok((difference, reference)) => told(difference, &name, scene, &reference, picture),
                Err(error) => {
                    let error = error.context(name);
                    Ok((None, Some(self.without(&error, scene, Contents::Picture(picture.clone()))?)))
                }
            };
        }
        let known = self.new.iter().find(|(known, _)| *known == name);
        if let Some((_, Contents::Picture(first))) = known {
            return told(picture.difference(first, is_doubtful)?, &name, scene, first, picture);
        }
        self.new.push((name, Contents::Picture(picture.clone())));
        Ok((None, None))
    }

    /// Replaces the stored references by the new ones, and removes those given: all that is new is written before the first is replaced, and if one cannot be, those before it are put back.
    /// How many are new.
    ///
    /// # Errors
    /// If one cannot be written or replaced; then none is, unless putting back fails too, of which the error tells.
    pub(crate) fn store(&self, orphans: &[String]) -> Result<usize> {
        self.store_by(orphans, &mut |from: &Path, to: &Path| replace::moved(from, to))
    }

    fn store_by(&self, orphans: &[String], by: replace::Move<'_>) -> Result<usize> {
        if self.new.is_empty() && orphans.is_empty() {
            return Ok(0);
        }
        fs::create_dir_all(&self.folder)?;
        fs::create_dir_all(&self.scratch)?;
        let new = tempfile::tempdir_in(&self.scratch)?;
        for (name, contents) in &self.new {
            contents.write(&new.path().join(name))?;
        }
        let old = tempfile::tempdir_in(&self.scratch)?;
        let names: Vec<&str> = self.new.iter().map(|(name, _)| name.as_str()).collect();
        replace::all(&self.folder, [new.path(), old.path()], &names, orphans, by)?;
        Ok(names.len())
    }

    /// What is wrong with a scene of which there is no reference that it can be compared with.
    fn without(&self, error: &anyhow::Error, scene: &str, contents: Contents) -> Result<String> {
        let kept = self.keep(scene, contents)?;
        Ok(format!("{error:#}; rendered: {}", kept.display()))
    }

    /// Keeps what differs from the stored one, as it would be stored.
    fn keep(&self, scene: &str, contents: Contents) -> Result<PathBuf> {
        let extension = if matches!(contents, Contents::Picture(_)) { "png" } else { "exr" };
        let kept = kept(scene, extension)?;
        contents.write(&kept)?;
        Ok(kept)
    }
}

/// Pixels beyond a bound.
#[derive(Default)]
struct Beyond {
    count: u64,
    first: usize,
    worst: (usize, f64),
}

/// Of pixels that do not graze.
#[derive(Default)]
struct Differences {
    sides: Beyond,
    depths: Beyond,
    normals: Beyond,
    /// Pixels that hit in both.
    hits: u64,
}

impl Differences {
    /// From stored depths and normals.
    fn of(stored: &[Vec<f32>; 4], pixels: &[Pixel], is_grazing: impl Fn(usize) -> bool) -> Self {
        let mut differences = Self::default();
        for (n, pixel) in pixels.iter().enumerate().filter(|(n, _)| !is_grazing(*n)) {
            let [z, x, y, w] = stored.each_ref().map(|c| c[n]);
            if z.is_finite() != is_hit(pixel) {
                differences.sides.add(n, f64::INFINITY, 0.0);
            } else if z.is_finite() {
                differences.hits += 1;
                differences.depths.add(n, apart(z.into(), pixel.depth.into()), VOXELS.into());
                let normal = colors_apart([x, y, w, 0.0], pixel.normal.extend(0.0).to_array());
                differences.normals.add(n, normal, NORMAL.into());
            }
        }
        differences
    }

    /// Side and depth are the oracle's in both pictures, within half of the bound.
    fn are_allowed(&self) -> bool {
        let normals_ok = self.normals.count as f64 <= NORMAL_SHARE * self.hits as f64;
        self.sides.count == 0 && self.depths.count == 0 && normals_ok
    }
}

impl Beyond {
    /// Adds pixel `n`, off by `by`, if that is more than `bound` or no number.
    fn add(&mut self, n: usize, by: f64, bound: f64) {
        if by <= bound {
            return;
        }
        if self.count == 0 {
            self.first = n;
        }
        if self.count == 0 || by > self.worst.1 {
            self.worst = (n, by);
        }
        self.count += 1;
    }

    fn told(&self, width: u32) -> String {
        let at = |n: usize| format!("({}, {})", n as u32 % width, n as u32 / width);
        match (self.count, self.worst) {
            (0, _) => "no pixel".to_owned(),
            (n, (_, f64::INFINITY)) => format!("{n} pixels, the first at {}", at(self.first)),
            (n, (worst, by)) => {
                format!("{n} pixels, the first at {}, the worst at {} by {by:.3e}", at(self.first), at(worst))
            }
        }
    }
}

impl Contents {
    fn write(&self, path: &Path) -> Result<()> {
        match self {
            Self::Picture(picture) => picture.write(path),
            Self::Channels { size: [width, height], channels } => {
                let channels: Vec<_> =
                    channels.iter().map(|(name, data)| ExrChannel { name, data }).collect();
                Ok(write_exr(path, *width, *height, &channels)?)
            }
        }
    }
}

/// How a picture differs from its reference, and what is wrong if that is too much.
fn told(
    difference: Option<Difference>,
    name: &str,
    scene: &str,
    reference: &Picture,
    found: &Picture,
) -> Result<(Option<Difference>, Option<String>)> {
    let Some(d) = difference.filter(|d| !d.is_allowed()) else { return Ok((difference, None)) };
    let shown = show(scene, reference, found)?;
    Ok((difference, Some(format!("unlike {name}: {d}; {}", shown.display()))))
}

/// Writes reference, result and amplified difference beside each other; where.
pub(crate) fn show(scene: &str, reference: &Picture, found: &Picture) -> Result<PathBuf> {
    let shown = kept(scene, "png")?;
    Picture::beside_each_other(&[reference, found, &found.amplified(reference)]).write(&shown)?;
    Ok(shown)
}

/// Where that is kept which differs: `target/golden`.
fn kept(scene: &str, extension: &str) -> Result<PathBuf> {
    let folder = root().join("target/golden");
    fs::create_dir_all(&folder)?;
    Ok(folder.join(file_name(scene, extension)))
}

/// The name of a scene as that of a file.
fn file_name(scene: &str, extension: &str) -> String {
    let simple: String =
        scene.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect();
    let words: Vec<_> = simple.split('-').filter(|w| !w.is_empty()).collect();
    format!("{}.{extension}", words.join("-"))
}

/// Normals as colours, white where there is none.
pub(crate) fn normals_picture(size: [u32; 2], normal: impl Fn(usize) -> Option<Vec3>) -> Picture {
    let byte = |c: f32| (127.5 * (c + 1.0)).round() as u8;
    let pixel = |n: usize| normal(n).map_or([255; 3], |normal| normal.to_array().map(byte));
    Picture { size, rgb: (0..(size[0] * size[1]) as usize).flat_map(pixel).collect() }
}

fn surface_channels(image: &Image) -> Contents {
    let channel = |f: fn(&Pixel) -> f32| image.channel(f);
    let channels = vec![
        ("Z", channel(|p| p.depth)),
        ("N.X", channel(|p| p.normal.x)),
        ("N.Y", channel(|p| p.normal.y)),
        ("N.Z", channel(|p| p.normal.z)),
    ];
    Contents::Channels { size: image.size(), channels }
}

fn color_channels(image: &Image) -> Contents {
    let channel = |f: fn(&Pixel) -> f32| image.channel(f);
    let channels = vec![
        ("R", channel(|p| p.color.x)),
        ("G", channel(|p| p.color.y)),
        ("B", channel(|p| p.color.z)),
        ("A", channel(|p| p.color.w)),
    ];
    Contents::Channels { size: image.size(), channels }
}

fn make_it() -> &'static str {
    "a reference that is not there is made by `cargo xtask golden --update`"
}

/// Four channels, of as many pixels as the picture has.
fn load(file: &Path, names: [&str; 4], of: &Image) -> Result<[Vec<f32>; 4]> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(file)
        .with_context(|| format!("{}: cannot be read", file.display()))
        .with_context(make_it)?;
    let channel = |name: &str| {
        let found = image.layer_data.channel_data.list.iter().find(|c| c.name.eq_case_insensitive(name));
        let channel = found.with_context(|| format!("{}: no channel {name}", file.display()))?;
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        let [found, expected] = [values.len(), of.pixels().len()];
        ensure!(found == expected, "{}: {found} pixels, expected {expected}", file.display());
        Ok(values)
    };
    let [a, b, c, d] = names;
    Ok([channel(a)?, channel(b)?, channel(c)?, channel(d)?])
}

#[cfg(test)]
mod tests;
