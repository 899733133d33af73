//! The finished picture.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// What one pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Linear RGB, premultiplied, and alpha.
    pub color: Vec4,
    /// World distance to the surface; `+inf` where there is none.
    pub depth: f32,
    /// Unit world-space normal toward larger values; zero where there is none.
    pub normal: Vec3,
}

impl Pixel {
    /// Nothing there.
    pub const EMPTY: Self = Self { color: Vec4::ZERO, depth: f32::INFINITY, normal: Vec3::ZERO };
}

/// Pixels in rows, the top one first.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    size: [u32; 2],
    pixels: Vec<Pixel>,
}

impl Image {
    pub(crate) fn empty(size: [u32; 2]) -> Self {
        // On all threads: to be given the memory takes longer than to fill it.
        let count = size[0] as usize * size[1] as usize;
        Self { size, pixels: rayon::iter::repeat_n(Pixel::EMPTY, count).with_min_len(1 << 12).collect() }
    }

    pub(crate) fn pixels_mut(&mut self) -> &mut [Pixel] {
        &mut self.pixels
    }

    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// The pixel at column `x`, row `y`; nothing outside the image.
    pub fn pixel(&self, x: u32, y: u32) -> Pixel {
        let at = y as usize * self.size[0] as usize + x as usize;
        if x < self.size[0] { self.pixels.get(at).copied().unwrap_or(Pixel::EMPTY) } else { Pixel::EMPTY }
    }

    /// 8-bit sRGB over a linear background colour, three bytes a pixel.
    pub fn to_rgb8(&self, background: Vec3) -> Vec<u8> {
        let over = |p: &Pixel| encode_srgb(p.color.truncate() + background * (1.0 - p.color.w));
        self.pixels.iter().flat_map(over).collect()
    }

    /// 8-bit sRGB with straight alpha, four bytes a pixel.
    pub fn to_rgba8(&self) -> Vec<u8> {
        let straight = |p: &Pixel| {
            let [r, g, b] = encode_srgb(p.color.truncate() / p.color.w.max(f32::MIN_POSITIVE));
            [r, g, b, (p.color.w.clamp(0.0, 1.0) * 255.0).round() as u8]
        };
        self.pixels.iter().flat_map(straight).collect()
    }

    /// One channel of all pixels.
    pub fn channel(&self, f: impl Fn(&Pixel) -> f32) -> Vec<f32> {
        self.pixels.iter().map(f).collect()
    }
}

/// Linear to 8-bit sRGB (IEC 61966-2-1), clamped and rounded.
pub fn encode_srgb(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|c| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    })
}
