//! Pictures of 8-bit sRGB, and what shows how two of them differ.

use std::fmt;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use isoray_io::{PixelData, write_png};

use super::flip::flip;

/// Three bytes a pixel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Picture {
    pub(crate) size: [u32; 2],
    pub(crate) rgb: Vec<u8>,
}

/// How much two pictures differ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Difference {
    /// Mean and largest ꟻLIP.
    pub(crate) mean: f64,
    pub(crate) max: f64,
    /// The first pixel that differs at all, and the one whose ꟻLIP is largest.
    pub(crate) first: [u32; 2],
    pub(crate) worst: [u32; 2],
    /// Pixels that differ at all, and the largest difference of a channel, in steps of 8 bits.
    pub(crate) pixels: usize,
    pub(crate) steps: u8,
    /// Of those that are not doubtful, the share of all pixels that differ, and how many do by more than a step.
    pub(crate) certain: f64,
    pub(crate) large: usize,
}

/// Of a picture that is as it was. Builds for plain x86-64, x86-64-v3 and the machine's own instructions give the stored pictures, to the byte. What may differ elsewhere is a colour next to
/// the border of two steps of 8 bits, in one pixel of a hundred, and what the oracle calls doubtful. A step of 8 bits is a ꟻLIP of 5·10⁻² at most, and 5·10⁻⁴ in the
/// mean of a picture with one such pixel in a hundred; a doubtful one that changes side is 0.3 at most.
const SHARE: f64 = 1e-2;
const FLIP_MEAN: f64 = 1e-3;
const FLIP_MAX: f64 = 0.3;

impl Difference {
    /// Whether the picture may be called the same.
    pub(crate) fn is_allowed(&self) -> bool {
        self.large == 0 && self.certain <= SHARE && self.mean <= FLIP_MEAN && self.max <= FLIP_MAX
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} pixels differ, the first at {:?}, the worst at {:?}; {:.2} % of the pixels that are not doubtful, expected {}, and {} of them by more than a step; ꟻLIP is {:.2e} in the mean, expected {FLIP_MEAN}, and {:.2e} at most, expected {FLIP_MAX}",
            self.pixels,
            self.first,
            self.worst,
            100.0 * self.certain,
            100.0 * SHARE,
            self.large,
            self.mean,
            self.max
        )
    }
}

/// Differences are shown so many times as large as they are.
const AMPLIFICATION: i32 = 8;
/// Each pixel of pictures beside each other is a square of so many, with so many between pictures.
const ZOOM: u32 = 3;
const GAP: u32 = 2;

impl Picture {
    /// A PNG.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let image = image::open(path).with_context(|| format!("{}: cannot be read", path.display()))?;
        let image = image.into_rgb8();
        Ok(Self { size: [image.width(), image.height()], rgb: image.into_raw() })
    }

    /// Writes a PNG.
    pub(crate) fn write(&self, path: &Path) -> Result<()> {
        Ok(write_png(path, self.size[0], self.size[1], PixelData::Rgb8(&self.rgb))?)
    }

    /// Compares it with its reference, of the same size; `None` if they are equal. Of some pixels it may be doubtful what they are.
    pub(crate) fn difference(
        &self,
        reference: &Self,
        is_doubtful: impl Fn(usize) -> bool,
    ) -> Result<Option<Difference>> {
        ensure!(
            self.size == reference.size,
            "the reference has {:?} pixels, the picture {:?}",
            reference.size,
            self.size
        );
        let place = |n: usize| [n as u32 % self.size[0], n as u32 / self.size[0]];
        let pairs = self.rgb.chunks_exact(3).zip(reference.rgb.chunks_exact(3));
        let differing: Vec<usize> = pairs.enumerate().filter(|(_, (a, b))| a != b).map(|(n, _)| n).collect();
        let Some(&first) = differing.first() else { return Ok(None) };
        let values = flip(self.size, &reference.rgb, &self.rgb);
        let worst = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
        let steps_of = |n: usize| {
            let channels = self.rgb[3 * n..3 * n + 3].iter().zip(&reference.rgb[3 * n..]);
            channels.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
        };
        let certain = || differing.iter().copied().filter(|&n| !is_doubtful(n));
        Ok(Some(Difference {
            mean: values.iter().sum::<f64>() / values.len() as f64,
            max: values[worst],
            first: place(first),
            worst: place(worst),
            pixels: differing.len(),
            steps: differing.iter().map(|&n| steps_of(n)).max().unwrap_or(0),
            certain: certain().count() as f64 / values.len() as f64,
            large: certain().filter(|&n| steps_of(n) > 1).count(),
        }))
    }

    /// The share of pixels that differ from another picture's by more than a step of 8 bits.
    pub(crate) fn share_of_steps(&self, other: &Self) -> Result<f64> {
        ensure!(self.size == other.size, "{:?} and {:?} pixels", self.size, other.size);
        let pairs = self.rgb.chunks_exact(3).zip(other.rgb.chunks_exact(3));
        let is_large = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1);
        Ok(pairs.filter(is_large).count() as f64 / (self.rgb.len() / 3) as f64)
    }

    /// The differences of two pictures of one size, amplified.
    pub(crate) fn amplified(&self, other: &Self) -> Self {
        let amplified = |(a, b): (&u8, &u8)| (i32::from(a.abs_diff(*b)) * AMPLIFICATION).min(255) as u8;
        Self { size: self.size, rgb: self.rgb.iter().zip(&other.rgb).map(amplified).collect() }
    }

    /// Pictures of one size beside each other, enlarged, on grey.
    pub(crate) fn beside_each_other(pictures: &[&Self]) -> Self {
        let [width, height] = pictures[0].size.map(|n| n * ZOOM);
        let across = (width + GAP) * pictures.len() as u32 - GAP;
        let pixel = |[x, y]: [u32; 2]| {
            let [of, x] = [x / (width + GAP), x % (width + GAP)];
            if x >= width {
                return [128; 3];
            }
            let picture = pictures[of as usize];
            let at = 3 * (y / ZOOM * picture.size[0] + x / ZOOM) as usize;
            [0, 1, 2].map(|n| picture.rgb[at + n])
        };
        let places = (0..height).flat_map(|y| (0..across).map(move |x| [x, y]));
        Self { size: [across, height], rgb: places.flat_map(pixel).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(grey: u8) -> Picture {
        Picture { size: [4, 3], rgb: vec![grey; 36] }
    }

    #[test]
    fn a_difference_is_located_and_shown() {
        let reference = plain(100);
        assert!(reference.difference(&plain(100), |_| false).unwrap().is_none());
        let mut other = reference.clone();
        other.rgb[3 * 6 + 1] = 140;
        other.rgb[3 * 9] = 101;
        let difference = other.difference(&reference, |n| n == 9).unwrap().unwrap();
        assert_eq!([difference.first, difference.worst], [[2, 1]; 2]);
        assert_eq!((difference.pixels, difference.steps, difference.large), (2, 40, 1));
        assert_eq!(difference.certain, 1.0 / 12.0);
        assert!(difference.max > difference.mean && difference.mean > 0.0);
        let amplified = other.amplified(&reference);
        assert_eq!([amplified.rgb[0], amplified.rgb[3 * 6 + 1], amplified.rgb[3 * 9]], [0, 255, 8]);
        assert!(Picture { size: [3, 4], ..plain(0) }.difference(&reference, |_| false).is_err());
    }

    #[test]
    fn few_pixels_may_differ_by_a_step_and_doubtful_ones_by_more() {
        let reference = Picture { size: [40, 40], rgb: vec![100; 4800] };
        let with = |pixels: std::ops::Range<usize>, value: u8| {
            let mut other = reference.clone();
            pixels.for_each(|n| other.rgb[3 * n] = value);
            other.difference(&reference, |n| n < 2).unwrap().unwrap().is_allowed()
        };
        assert!(with(100..116, 101) && !with(100..117, 101));
        assert!(!with(100..101, 102) && with(0..1, 120));
        // Not by anything.
        assert!(!with(0..1, 255));
    }

    #[test]
    fn pictures_lie_beside_each_other() {
        let [a, b] = [plain(0), plain(255)];
        let both = Picture::beside_each_other(&[&a, &b, &a]);
        assert_eq!(both.size, [3 * 12 + 4, 9]);
        let row: Vec<u8> = both.rgb[..3 * 40].chunks(3).map(|p| p[0]).collect();
        assert_eq!(row, [vec![0; 12], vec![128; 2], vec![255; 12], vec![128; 2], vec![0; 12]].concat());
    }
}
