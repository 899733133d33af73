//! Pictures of isosurfaces and of volumes against the oracle, pixel by pixel.

use std::path::PathBuf;

use anyhow::Result;
use glam::Vec3;
use isoray_oracle::Lattice;
use isoray_render::{Image, Pixel, Scene, encode_srgb};
use rayon::prelude::*;

use super::picture::Picture;
use super::reference::{normals_picture, show};
use super::report::VOXELS;
use super::truth::{Doubtful, Seen, Truth};
use crate::for_oracle::{self, apart, breaks, is_hit};

/// What a picture is rendered over.
pub(crate) const BACKGROUND: Vec3 = Vec3::splat(0.05);

/// Of surfaces, what rounding takes of a colour or an opacity, linear: 2.1·10⁻⁶ is the most in these scenes, where a highlight is raised to the 32nd power. A step of 8 bits
/// is 3·10⁻⁴ at least.
const ROUNDING: f64 = 1e-5;
/// Behind a transmittance of so much a ray ends: what is not gathered there is at most that, of light and of opacity.
const INVISIBLE: f64 = 1.0 / 8192.0;
/// Of surfaces, degrees between a normal and the oracle's: 1.6·10⁻⁴ is the most in these scenes, where the gradient does not nearly vanish.
const DEGREES: f64 = 1e-3;
/// Share of pixels that may be doubtful; at most 3·10⁻⁴ are.
const DOUBTFUL: f64 = 1e-3;
/// Share of hits of which it may be doubtful what is in shadow, those of light that comes along the surface: at most 0.22 of one surface in these scenes, and 0.4 of two. Of these
/// opacities are compared, and colours with what is seen by none and by all of the light.
const UNLIT: f64 = 0.45;
/// Share of hits whose gradient may nearly vanish; in these scenes none does. Of these opacities are compared alone.
const UNSTEADY: f64 = 1e-3;
/// Share of pixels that are to show something, lest a scene be of little else than background.
const LIT: f64 = 0.1;
/// An opacity that shows: half a step of 8 bits.
const SHOWS: f32 = 1.0 / 510.0;

/// How a picture compares with the oracle.
#[derive(Debug, Default)]
pub(crate) struct Compared {
    /// Those of the oracle, and all of the picture.
    pub(crate) pixels: usize,
    all: usize,
    pub(crate) doubtful: usize,
    /// Pixels of hits of whose lights not all is known.
    pub(crate) unlit: usize,
    /// Pixels of hits of whose normals little is known.
    pub(crate) unsteady: usize,
    pub(crate) hits: usize,
    /// Pixels of the whole picture that show anything.
    pub(crate) lit: usize,
    /// Pixels where only one of both shows anything.
    pub(crate) wrong: Vec<[u32; 2]>,
    /// By pixel, of those compared.
    depths: Worst,
    degrees: Worst,
    colors: Worst,
    /// Bounds of errors of colours and of opacities.
    bound: f64,
    /// Whether lights are to be told.
    /// By pixel of the picture: whether rounding may change it by more than itself.
    is_doubtful: Vec<bool>,
}

/// The largest of errors, and where.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    by: f64,
    place: [u32; 2],
}

impl Worst {
    /// What is no number is the largest.
    fn add(&mut self, by: f64, place: [u32; 2]) {
        if breaks(by, self.by) {
            *self = Self { by: if by.is_nan() { f64::INFINITY } else { by }, place };
        }
    }
}

/// Channels of a pixel of a volume, each the least and the most that it can be.
pub(crate) type Channels = [[f64; 2]; 4];

/// What the oracle says of every [`STEP`]-th pixel along x and y of a picture of a volume; nothing of those that are doubtful.
pub(crate) struct Truths {
    size: [u32; 2],
    channels: Vec<Option<Channels>>,
}

const STEP: u32 = 2;

impl Truths {
    pub(crate) fn new(size: [u32; 2], truth: impl Fn([u32; 2]) -> Option<Channels> + Sync) -> Self {
        let size = size.map(|n| n / STEP);
        let channels = (0..size[0] * size[1]).into_par_iter().map(|n| truth(Self::place(size, n)));
        Self { size, channels: channels.collect() }
    }

    fn place([width, _]: [u32; 2], n: u32) -> [u32; 2] {
        [n % width, n / width].map(|c| c * STEP + STEP / 2)
    }
}

/// A colour that is known.
pub(crate) fn exactly(color: [f64; 4]) -> Channels {
    color.map(|c| [c; 2])
}

impl Compared {
    /// The surfaces of a picture. Where what the oracle says breaks a bound, it is shown: the colours, or the normals if it is a bound of the surface's place.
    pub(crate) fn surfaces<L: Lattice>(
        truth: &Truth<'_, L>,
        image: &Image,
        title: &str,
    ) -> Result<(Self, Vec<PathBuf>)> {
        let seen = Self::seen(truth, image.size());
        let compared = Self::of_seen(truth, &seen, image.pixels());
        let mut shown = Vec::new();
        if !compared.failures().is_empty() {
            let expected = picture(&seen, image);
            shown.push(show(&format!("{title}, oracle"), &expected, &over_background(image))?);
        }
        let [voxels, degrees, _] = compared.errors();
        if breaks(voxels, VOXELS) || breaks(degrees, DEGREES) || !compared.wrong.is_empty() {
            let [expected, found] = normals(&seen, image);
            shown.push(show(&format!("{title}, normals, oracle"), &expected, &found)?);
        }
        Ok((compared, shown))
    }

    /// What the oracle sees in each pixel.
    fn seen<L: Lattice>(truth: &Truth<'_, L>, [width, height]: [u32; 2]) -> Vec<Result<Seen, Doubtful>> {
        (0..width * height).into_par_iter().map(|n| truth.pixel([n % width, n / width])).collect()
    }

    fn of_seen<L: Lattice>(truth: &Truth<'_, L>, seen: &[Result<Seen, Doubtful>], pixels: &[Pixel]) -> Self {
        let width = truth.eye.camera.size()[0];
        let mut compared = Self {
            bound: bound(truth.scene),
            all: pixels.len(),
            is_doubtful: vec![false; pixels.len()],
            ..Self::default()
        };
        for (n, (seen, pixel)) in seen.iter().zip(pixels).enumerate() {
            let place = [n as u32 % width, n as u32 / width];
            compared.is_doubtful[n] = !compared.add(seen, pixel, place, truth.speed(place));
        }
        compared
    }

    /// Adds a pixel; whether all of it is known.
    fn add(&mut self, seen: &Result<Seen, Doubtful>, found: &Pixel, place: [u32; 2], speed: f64) -> bool {
        self.pixels += 1;
        self.lit += usize::from(is_hit(found));
        let Ok(seen) = seen else {
            self.doubtful += 1;
            return false;
        };
        match (seen.first, is_hit(found)) {
            (None, false) => {}
            (None, true) | (Some(_), false) => self.wrong.push(place),
            (Some((depth, normal)), true) => {
                self.hits += 1;
                self.depths.add(apart(found.depth.into(), depth) * speed, place);
                if seen.is_steady {
                    self.degrees.add(for_oracle::degrees(found.normal.as_dvec3(), normal), place);
                }
            }
        }
        self.colors.add(apart(found.color.w.into(), seen.alpha), place);
        self.unlit += usize::from(!seen.is_told);
        self.unsteady += usize::from(!seen.is_steady);
        if seen.is_steady {
            let [least, most] = seen.color.map(|c| c.to_array());
            let channels = found.color.truncate().to_array().into_iter().zip(least.into_iter().zip(most));
            channels.for_each(|(c, (least, most))| self.colors.add(beyond(c, [least, most]), place));
        }
        seen.is_told && seen.is_steady
    }

    /// A picture of a volume. Where what the oracle says breaks the bound, it is shown.
    pub(crate) fn volume(
        image: &Image,
        truths: &Truths,
        bound: f64,
        title: &str,
    ) -> Result<(Self, Option<PathBuf>)> {
        let Truths { size, channels } = truths;
        let place = |n: u32| Truths::place(*size, n);
        let pixel = |n: u32| image.pixel(place(n)[0], place(n)[1]);
        let found: Vec<Pixel> = (0..size[0] * size[1]).map(pixel).collect();
        let mut compared = Self::of_channels(channels, &found, place, bound);
        compared.all = image.pixels().len();
        compared.lit = image.pixels().iter().filter(|p| shows(p)).count();
        if compared.failures().is_empty() {
            return Ok((compared, None));
        }
        let expected = colors_picture(*size, |n| {
            let found = found[n].color.to_array();
            let Some(truth) = channels[n] else { return found };
            [0, 1, 2, 3].map(|c| f64::from(found[c]).max(truth[c][0]).min(truth[c][1]) as f32)
        });
        let found = colors_picture(*size, |n| found[n].color.to_array());
        let shown = show(&format!("{title}, oracle"), &expected, &found)?;
        Ok((compared, Some(shown)))
    }

    fn of_channels(
        truths: &[Option<Channels>],
        found: &[Pixel],
        place: impl Fn(u32) -> [u32; 2],
        bound: f64,
    ) -> Self {
        let mut compared = Self { pixels: found.len(), all: found.len(), bound, ..Self::default() };
        for (n, (truth, found)) in truths.iter().zip(found).enumerate() {
            compared.lit += usize::from(shows(found));
            let Some(truth) = truth else {
                compared.doubtful += 1;
                continue;
            };
            compared.hits += 1;
            let channels = found.color.to_array().into_iter().zip(truth);
            channels.for_each(|(c, range)| compared.colors.add(beyond(c, *range), place(n as u32)));
        }
        compared
    }

    /// The largest error of a depth in voxels, of a normal in degrees, and of a colour.
    pub(crate) fn errors(&self) -> [f64; 3] {
        [self.depths.by, self.degrees.by, self.colors.by]
    }

    /// Whether rounding may change a pixel by more than itself.
    pub(crate) fn is_doubtful(&self, n: usize) -> bool {
        self.is_doubtful.get(n).copied().unwrap_or(false)
    }

    /// Shares of pixels that are doubtful, of hits whose lights are, and of pixels that show anything.
    pub(crate) fn shares(&self) -> [f64; 3] {
        let share = |n: usize, of: usize| n as f64 / of.max(1) as f64;
        [share(self.doubtful, self.pixels), share(self.unlit, self.hits), share(self.lit, self.all)]
    }

    /// The bounds that are broken.
    pub(crate) fn failures(&self) -> Vec<String> {
        let mut failures = Vec::new();
        if let Some(first) = self.wrong.first() {
            let n = self.wrong.len();
            failures.push(format!("{n} pixels that hit or miss unlike the oracle, the first at {first:?}"));
        }
        let bounds = [
            ("a depth, in voxels,", self.depths, VOXELS),
            ("a normal, in degrees,", self.degrees, DEGREES),
            ("a colour or an opacity", self.colors, self.bound),
        ];
        for (what, Worst { by, place }, bound) in bounds {
            if breaks(by, bound) {
                failures.push(format!("{what} off by {by:.2e} at {place:?}, expected at most {bound:.2e}"));
            }
        }
        let most = [
            ("pixels are doubtful", self.doubtful, self.pixels, DOUBTFUL),
            ("hits have doubtful lights", self.unlit, self.hits, UNLIT),
            ("hits have doubtful normals", self.unsteady, self.hits, UNSTEADY),
        ];
        for (what, n, of, share) in most {
            if n as f64 > share * of as f64 {
                failures.push(format!("{n} of {of} {what}: the scene makes a poor test"));
            }
        }
        if (self.lit as f64) < LIT * self.all as f64 {
            let [lit, all] = [self.lit, self.all];
            failures.push(format!("{lit} of {all} pixels show anything: the scene makes a poor test"));
        }
        failures
    }
}

/// Whether a pixel of a volume shows anything.
fn shows(pixel: &Pixel) -> bool {
    pixel.color.w > SHOWS || pixel.color.w.is_nan()
}

/// How far a number is out of a range.
fn beyond(found: f32, [least, most]: [f64; 2]) -> f64 {
    let found = f64::from(found);
    match found >= least && found <= most {
        true => 0.0,
        false => apart(found, least).min(apart(found, most)),
    }
}

/// Of errors of colours.
fn bound(scene: &Scene<'_>) -> f64 {
    let is_opaque = scene.surfaces.iter().all(|surface| surface.opacity >= 1.0);
    ROUNDING + if is_opaque { 0.0 } else { INVISIBLE * f64::from(1.0 + scene.specular) }
}

/// 8-bit sRGB, over the background.
pub(crate) fn over_background(image: &Image) -> Picture {
    Picture { size: image.size(), rgb: image.to_rgb8(BACKGROUND) }
}

/// Premultiplied linear colours over the background.
pub(crate) fn colors_picture(size: [u32; 2], color: impl Fn(usize) -> [f32; 4]) -> Picture {
    let pixel = |n: usize| {
        let [r, g, b, alpha] = color(n);
        encode_srgb(Vec3::new(r, g, b) + BACKGROUND * (1.0 - alpha))
    };
    Picture { size, rgb: (0..(size[0] * size[1]) as usize).flat_map(pixel).collect() }
}

/// What the oracle sees, and where that is doubtful, what was rendered.
fn picture(seen: &[Result<Seen, Doubtful>], found: &Image) -> Picture {
    colors_picture(found.size(), |n| {
        let found = found.pixels()[n].color;
        let Ok(Seen { color: [least, most], alpha, .. }) = seen[n] else { return found.to_array() };
        let color = found.truncate().as_dvec3().max(least).min(most.max(least));
        color.as_vec3().extend(alpha as f32).to_array()
    })
}

/// The oracle's normals, and where these are doubtful, what was rendered; and what was.
fn normals(seen: &[Result<Seen, Doubtful>], found: &Image) -> [Picture; 2] {
    let of_found = |n: usize| is_hit(&found.pixels()[n]).then_some(found.pixels()[n].normal);
    let of_seen = |n: usize| match &seen[n] {
        Ok(seen) => seen.first.map(|(_, normal)| normal.as_vec3()),
        Err(Doubtful) => of_found(n),
    };
    [normals_picture(found.size(), of_seen), normals_picture(found.size(), of_found)]
}

#[cfg(test)]
mod tests;
