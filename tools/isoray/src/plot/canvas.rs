//! A picture in memory with filled boxes and numbers.

use std::ops::Range;

/// sRGB.
pub(crate) type Color = [u8; 3];

/// Width and height of a character, in dots.
pub(crate) const CHARACTER: [u32; 2] = [5, 7];
/// From one character to the next, in dots.
const ADVANCE: u32 = 6;

/// Rows from the top, the leftmost dot in bit 4, of the characters that numbers are made of.
fn glyph(character: char) -> [u8; 7] {
    match character {
        '0' => [0x0e, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0e],
        '1' => [0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e],
        '2' => [0x0e, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1f],
        '3' => [0x1f, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0e],
        '4' => [0x02, 0x06, 0x0a, 0x12, 0x1f, 0x02, 0x02],
        '5' => [0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e],
        '6' => [0x06, 0x08, 0x10, 0x1e, 0x11, 0x11, 0x0e],
        '7' => [0x1f, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08],
        '8' => [0x0e, 0x11, 0x11, 0x0e, 0x11, 0x11, 0x0e],
        '9' => [0x0e, 0x11, 0x11, 0x0f, 0x01, 0x02, 0x0c],
        'e' => [0x00, 0x00, 0x0e, 0x11, 0x1f, 0x10, 0x0e],
        '-' => [0x00, 0x00, 0x00, 0x1f, 0x00, 0x00, 0x00],
        '.' => [0x00, 0x00, 0x00, 0x00, 0x00, 0x0c, 0x0c],
        _ => [0x00; 7],
    }
}

/// Pixels, row 0 at the top.
pub(crate) struct Canvas {
    size: [u32; 2],
    pixels: Vec<u8>,
}

impl Canvas {
    /// A picture of one colour.
    pub(crate) fn new(size: [u32; 2], [r, g, b]: Color) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self { size, pixels: [r, g, b].repeat(count) }
    }

    /// Three bytes a pixel.
    pub(crate) fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// Mixes a colour into a box of pixels, the part of it that is in the picture; `share` is from 0 to 1.
    pub(crate) fn mix(&mut self, x: Range<i64>, y: Range<i64>, color: Color, share: f64) {
        let [width, height] = self.size.map(i64::from);
        for row in y.start.max(0)..y.end.min(height) {
            for column in x.start.max(0)..x.end.min(width) {
                let at = 3 * (row * width + column) as usize;
                for (old, new) in self.pixels[at..at + 3].iter_mut().zip(color) {
                    *old = (f64::from(*old) * (1.0 - share) + f64::from(new) * share).round() as u8;
                }
            }
        }
    }

    /// Fills a box of pixels.
    pub(crate) fn fill(&mut self, x: Range<i64>, y: Range<i64>, color: Color) {
        self.mix(x, y, color, 1.0);
    }

    /// Writes a number with its upper left corner at (x, y), `scale` pixels a dot.
    pub(crate) fn number(&mut self, [x, y]: [i64; 2], text: &str, scale: u32, color: Color) {
        let dot = i64::from(scale);
        for (n, character) in (0..).zip(text.chars()) {
            let left = x + n * i64::from(ADVANCE) * dot;
            for (row, bits) in (0..).zip(glyph(character)) {
                for column in (0..i64::from(CHARACTER[0])).filter(|c| bits >> (4 - c) & 1 == 1) {
                    let [x, y] = [left + column * dot, y + row * dot];
                    self.fill(x..x + dot, y..y + dot, color);
                }
            }
        }
    }
}

/// Width of a number in pixels.
pub(crate) fn width(text: &str, scale: u32) -> i64 {
    let count = text.chars().count() as i64;
    (count * i64::from(ADVANCE) - 1).max(0) * i64::from(scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_outside_is_cut_off() {
        let mut canvas = Canvas::new([4, 3], [255; 3]);
        canvas.fill(-5..1, 2..9, [0; 3]);
        canvas.number([3, -6], "8", 1, [7, 8, 9]);
        let black = canvas.pixels().chunks(3).filter(|p| *p == [0; 3]).count();
        assert_eq!(black, 1);
        assert!(width("-1.5e-7", 2) == 82 && width("", 1) == 0);
    }
}
