//! Pictures of isosurfaces and of volumes against the oracle, pixel by pixel.

use std::path::PathBuf;

use anyhow::Result;
use glam::{DVec3, Vec3};
use isoray_oracle::Lattice;
use isoray_render::{Image, encode_srgb};
use rayon::prelude::*;

use super::picture::Picture;
use super::reference::show;
use super::report::{VOXELS, quantile};
use super::truth::{Doubtful, Seen, Truth};
use crate::for_oracle;

/// What a picture is rendered over.
pub(crate) const BACKGROUND: Vec3 = Vec3::splat(0.05);

/// 99 % of the colours of surfaces are within this of the oracle's, linear: behind a transmittance of so much a ray ends. Where none ends before its last surface, 6·10⁻⁷ was the most.
const COLOR_99: f64 = 1.0 / 8192.0;
/// Share of pixels that may be doubtful; at most 3·10⁻⁴ are.
const DOUBTFUL: f64 = 0.01;
/// Share of hits of which it may be doubtful what is in shadow: of lights that come along the surface, and there may be several lights and surfaces.
const UNLIT: f64 = 0.5;

/// How a picture compares with the oracle.
#[derive(Debug, Default)]
pub(crate) struct Compared {
    pub(crate) pixels: usize,
    pub(crate) doubtful: usize,
    /// Pixels of hits that are compared, but not their colours.
    pub(crate) unlit: usize,
    pub(crate) hits: usize,
    /// Pixels where only one of both shows anything.
    pub(crate) wrong: Vec<[u32; 2]>,
    /// By pixel, of those compared.
    depths: Vec<(f64, [u32; 2])>,
    degrees: Vec<f64>,
    colors: Vec<(f64, [u32; 2])>,
    /// Whether the oracle has colours at all.
    has_colors: bool,
    /// Bound of every colour's error, if there is one.
    bound: Option<f64>,
}

impl Compared {
    /// The surfaces of a picture.
    pub(crate) fn surfaces<L: Lattice>(
        truth: &Truth<'_, L>,
        image: &Image,
        scene: &str,
    ) -> Result<(Self, Option<PathBuf>)> {
        let [width, height] = image.size();
        let places: Vec<[u32; 2]> = (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).collect();
        let seen: Vec<_> = places.par_iter().map(|&place| truth.pixel(place)).collect();
        let mut compared = Self { has_colors: truth.has_colors, ..Self::default() };
        for (&place, seen) in places.iter().zip(&seen) {
            compared.add(truth, image, place, seen);
        }
        let shown = match compared.failures().is_empty() {
            true => None,
            false => {
                Some(show(&format!("{scene}, oracle"), &picture(&seen, image), &over_background(image))?)
            }
        };
        Ok((compared, shown))
    }

    fn add<L: Lattice>(
        &mut self,
        truth: &Truth<'_, L>,
        image: &Image,
        place: [u32; 2],
        seen: &Result<Seen, Doubtful>,
    ) {
        self.pixels += 1;
        let Ok(seen) = seen else {
            self.doubtful += 1;
            return;
        };
        let found = image.pixel(place[0], place[1]);
        match (seen.first, found.depth.is_finite()) {
            (None, false) => return,
            (None, true) | (Some(_), false) => return self.wrong.push(place),
            (Some((depth, normal)), true) => {
                self.hits += 1;
                let speed = truth.speed(place);
                self.depths.push(((f64::from(found.depth) - depth).abs() * speed, place));
                self.degrees.push(for_oracle::degrees(found.normal.as_dvec3(), normal));
            }
        }
        let Some([least, most]) = seen.color else {
            self.unlit += 1;
            return;
        };
        let color = found.color.truncate().as_dvec3();
        let beyond = (least - color).max(color - most).max(DVec3::ZERO).max_element();
        self.colors.push((beyond.max((f64::from(found.color.w) - seen.alpha).abs()), place));
    }

    /// A picture of a volume: RGBA of every `step`-th pixel along x and y.
    pub(crate) fn volume(
        image: &Image,
        step: u32,
        bound: Option<f64>,
        truth: impl Fn([u32; 2]) -> Option<[Option<f64>; 4]> + Sync,
    ) -> Self {
        let [width, height] = image.size().map(|n| n / step);
        let one = |n: u32| {
            let place = [n % width * step + step / 2, n / width * step + step / 2];
            let found = image.pixel(place[0], place[1]).color.to_array();
            let apart = |expected: [Option<f64>; 4]| {
                let channels = found.iter().zip(expected);
                channels.filter_map(|(f, e)| Some((f64::from(*f) - e?).abs())).fold(0.0, f64::max)
            };
            truth(place).map(|expected| (apart(expected), place))
        };
        let pixels: Vec<_> = (0..width * height).into_par_iter().map(one).collect();
        let colors: Vec<_> = pixels.iter().flatten().copied().collect();
        let doubtful = pixels.len() - colors.len();
        Self { pixels: pixels.len(), doubtful, hits: colors.len(), colors, bound, ..Self::default() }
    }

    /// The largest error of a depth in voxels, 99 % of the angles of normals in degrees, 99 % of the errors of colours and the largest.
    pub(crate) fn errors(&self) -> [f64; 4] {
        let colors: Vec<f64> = self.colors.iter().map(|c| c.0).collect();
        [
            worst(&self.depths).map_or(0.0, |w| w.0),
            quantile(&self.degrees, 0.99),
            quantile(&colors, 0.99),
            worst(&self.colors).map_or(0.0, |w| w.0),
        ]
    }

    /// The bounds that are broken.
    pub(crate) fn failures(&self) -> Vec<String> {
        let [_, degrees, color, _] = self.errors();
        let mut failures = Vec::new();
        if let Some(first) = self.wrong.first() {
            let n = self.wrong.len();
            failures.push(format!("{n} pixels that hit or miss unlike the oracle, the first at {first:?}"));
        }
        if let Some((voxels, place)) = worst(&self.depths)
            && voxels > VOXELS
        {
            failures
                .push(format!("a depth off by {voxels:.2e} voxels at {place:?}, expected at most {VOXELS}"));
        }
        if degrees > for_oracle::DEGREES_99 {
            failures.push(format!(
                "99 % of the normals within {degrees:.2e} degrees, expected {}",
                for_oracle::DEGREES_99
            ));
        }
        let (worst, place) = worst(&self.colors).unwrap_or_default();
        match self.bound {
            Some(bound) if worst > bound => failures
                .push(format!("a colour off by {worst:.2e} at {place:?}, expected at most {bound:.2e}")),
            None if color > COLOR_99 => failures.push(format!(
                "99 % of the colours within {color:.2e}, expected {COLOR_99}; the worst is off by {worst:.2e} at {place:?}"
            )),
            _ => {}
        }
        let unlit = if self.has_colors { self.unlit } else { 0 };
        let shares = [
            ("pixels are doubtful", self.doubtful, self.pixels, DOUBTFUL),
            ("hits have doubtful lights", unlit, self.hits, UNLIT),
        ];
        for (what, n, of, share) in shares {
            if n as f64 > share * of as f64 {
                failures.push(format!("{n} of {of} {what}: the scene makes a poor test"));
            }
        }
        failures
    }
}

fn worst(errors: &[(f64, [u32; 2])]) -> Option<(f64, [u32; 2])> {
    errors.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0))
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
        let known = seen[n].as_ref().ok().and_then(|seen| Some((seen.color?, seen.alpha)));
        let Some(([least, most], alpha)) = known else { return found.to_array() };
        let color = found.truncate().as_dvec3().clamp(least, most.max(least));
        color.as_vec3().extend(alpha as f32).to_array()
    })
}
