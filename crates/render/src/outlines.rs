//! Straight lines over a finished picture, as outlines of boxes.

use glam::{DVec2, DVec3, DVec4, Vec3};

use crate::camera::Camera;
use crate::clip::Clip;
use crate::image::{Image, Pixel};

/// A straight line in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Where it begins and ends.
    pub ends: [DVec3; 2],
    /// Linear RGB.
    pub color: Vec3,
}

impl Line {
    /// The edges of a box, whose `corners` are numbered x fastest.
    pub fn edges(corners: &[DVec3; 8], color: Vec3) -> [Self; 12] {
        std::array::from_fn(|n| {
            let axis = n / 4;
            // The other two axes of the first corner.
            let at = [(n & 1) << ((axis + 1) % 3), (n >> 1 & 1) << ((axis + 2) % 3)];
            let first = at[0] | at[1];
            Self { ends: [corners[first], corners[first | 1 << axis]], color }
        })
    }
}

/// Half the width of a line in pixels: the thinnest that shows no steps.
const HALF_WIDTH: f64 = 0.6;

/// How far from a line pixels still have some of it: half of their own width more.
const REACH: f64 = HALF_WIDTH + 0.5;

/// Of several lines in a pixel the first is drawn that no other covers the pixel more than by this: along the same edge they differ by roundings.
const ALIKE: f32 = 1.0 / 256.0;

/// What is nearer to the plane through the eye than this share of the farther end's distance is not drawn: there is no place for it in the picture.
const NEAR: f64 = 1e-6;

/// Draws lines over a picture by `camera`, each about a pixel wide, with an `opacity` from 0 to 1; depths and normals stay.
///
/// Of a line, what `clip` does not keep is not drawn, nor what is behind the eye. What is farther away than a pixel's depth comes through as far as the pixel is not
/// opaque, and all else lies over it: a picture of a volume has no depth, so that all lines lie over it. Where several lines meet in a pixel it has that which covers
/// most of it; the first, if they are alike.
pub fn draw_lines(
    image: &mut Image,
    camera: &Camera,
    lines: impl IntoIterator<Item = Line>,
    clip: &Clip,
    opacity: f32,
) {
    let mut marks = vec![Mark::NONE; image.pixels().len()];
    for line in lines {
        let Some(drawn) = Drawn::new(camera, &line, clip) else { continue };
        drawn.cover(camera.size(), |[x, y], coverage, ahead| {
            let at = y as usize * camera.size()[0] as usize + x as usize;
            let (Some(pixel), Some(mark)) = (image.pixels().get(at), marks.get_mut(at)) else { return };
            let is_hidden =
                camera.distance([x, y], ahead) - camera.width_of_pixel(ahead) > pixel.depth.into();
            let through = if is_hidden { 1.0 - pixel.color.w } else { 1.0 };
            let weight = coverage * opacity;
            if weight * through > mark.weight * mark.through + ALIKE {
                *mark = Mark { color: line.color, weight, through, is_hidden };
            }
        });
    }
    for (pixel, mark) in image.pixels_mut().iter_mut().zip(&marks) {
        mark.draw(pixel);
    }
}

/// What a pixel has of a line.
#[derive(Clone, Copy)]
struct Mark {
    color: Vec3,
    /// Its opacity, times what it covers of the pixel.
    weight: f32,
    /// What of it is not hidden.
    through: f32,
    is_hidden: bool,
}

impl Mark {
    const NONE: Self = Self { color: Vec3::ZERO, weight: 0.0, through: 1.0, is_hidden: false };

    fn draw(&self, pixel: &mut Pixel) {
        let line = (self.color * self.weight).extend(self.weight);
        if self.is_hidden {
            pixel.color += self.through * line;
        } else if self.weight > 0.0 {
            pixel.color = line + (1.0 - self.weight) * pixel.color;
        }
    }
}

/// A line in the picture.
struct Drawn {
    /// In pixels from the upper left corner.
    ends: [DVec2; 2],
    /// At each end, one over the weight that places in the picture are divided by, and how far ahead it is, divided by that: linear in between.
    depths: [DVec2; 2],
}

impl Drawn {
    /// What is seen of a line, if anything.
    fn new(camera: &Camera, line: &Line, clip: &Clip) -> Option<Self> {
        let [begin, end] = line.ends;
        let kept = clip.kept(begin, end - begin)?;
        let ends = line.ends.map(|p| camera.projected(p));
        let [width, height] = camera.size().map(f64::from);
        // Lines reach into the picture from this far outside of it.
        let beyond = DVec2::ONE + 4.0 * REACH / DVec2::new(width, height);
        let near = NEAR * ends[0].w.max(ends[1].w);
        let inside = |p: DVec4| {
            let [x, y] = [beyond.x * p.z, beyond.y * p.z];
            [p.w - near, x - p.x, x + p.x, y - p.y, y + p.y]
        };
        let [from, to] = stretch(ends.map(inside), [kept.begin.max(0.0), kept.end.min(1.0)])?;
        let ends = [from, to].map(|s| ends[0].lerp(ends[1], s));
        let place = |p: DVec4| {
            let [x, y] = [1.0 + p.x / p.z, 1.0 - p.y / p.z];
            DVec2::new(x * width, y * height) / 2.0
        };
        Some(Self { ends: ends.map(place), depths: ends.map(|p| DVec2::new(1.0, p.w) / p.z) })
    }

    /// Calls `each` with the pixels that it covers, how much of them, and how far ahead of the eye the line is there.
    fn cover(&self, size: [u32; 2], mut each: impl FnMut([u32; 2], f32, f64)) {
        let [begin, end] = self.ends;
        let along = end - begin;
        let is_steep = along.y.abs() > along.x.abs();
        // The axis along which it goes from pixel to pixel, and the other one.
        let [major, minor] = if is_steep { [1, 0] } else { [0, 1] };
        let slope = if along[major] == 0.0 { 0.0 } else { along[minor] / along[major] };
        let [low, high] = [begin[major].min(end[major]), begin[major].max(end[major])];
        for m in pixels(low - REACH, high + REACH, size[major]) {
            let middle = begin[minor] + slope * ((f64::from(m) + 0.5).clamp(low, high) - begin[major]);
            // Pixels as far from a line at 45° as it reaches are √2 times as far along an axis.
            let band = REACH * std::f64::consts::SQRT_2;
            for n in pixels(middle - band, middle + band, size[minor]) {
                let pixel = if is_steep { [n, m] } else { [m, n] };
                let from_begin = DVec2::from_array(pixel.map(|c| f64::from(c) + 0.5)) - begin;
                let share = from_begin.dot(along) / along.length_squared();
                // Not a number if the line is a point.
                let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
                let coverage = REACH - from_begin.distance(along * share);
                if coverage > 0.0 {
                    let depth = self.depths[0].lerp(self.depths[1], share);
                    each(pixel, coverage.min(1.0) as f32, depth.y / depth.x);
                }
            }
        }
    }
}

/// The pixels that have some of what is between two coordinates, of as many as there are.
fn pixels(low: f64, high: f64, count: u32) -> std::ops::Range<u32> {
    // What is negative becomes 0.
    low.floor() as u32..(high.floor() as u32).saturating_add(u32::from(high >= 0.0)).min(count)
}

/// Where between `from` and `to` all of some linear functions, given at 0 and 1, are not negative.
fn stretch<const N: usize>(functions: [[f64; N]; 2], [mut from, mut to]: [f64; 2]) -> Option<[f64; 2]> {
    for (at_0, at_1) in functions[0].into_iter().zip(functions[1]) {
        if at_0 < 0.0 && at_1 < 0.0 {
            return None;
        }
        let zero = at_0 / (at_0 - at_1);
        if at_0 < 0.0 {
            from = from.max(zero);
        } else if at_1 < 0.0 {
            to = to.min(zero);
        }
    }
    (from <= to).then_some([from, to])
}

#[cfg(test)]
mod tests;
