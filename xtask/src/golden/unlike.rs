//! Pictures that must be one, bit for bit.

use anyhow::Result;
use isoray_render::{Image, Pixel};

use super::compared::over_background;
use super::reference::show;
use crate::for_oracle::{apart, colors_apart, is_hit};

/// Where a picture is not the expected one, by how much, and what both look like.
pub(crate) fn unlike(found: &Image, expected: &Image, how: &str, title: &str) -> Result<Option<String>> {
    let Some(told) = differences(found.pixels(), expected.pixels(), expected.size()[0]) else {
        return Ok(None);
    };
    let pictures = [expected, found].map(over_background);
    let shown = show(&format!("{title}, {how}"), &pictures[0], &pictures[1])?;
    Ok(Some(format!("another picture by {how}: {told}; {}", shown.display())))
}

fn differences(found: &[Pixel], expected: &[Pixel], width: u32) -> Option<String> {
    let pairs = || found.iter().zip(expected).enumerate().filter(|(_, (a, b))| bits(a) != bits(b));
    let (first, _) = pairs().next()?;
    let [mut color, mut depth, mut normal] = [0.0f64; 3];
    for (_, (a, b)) in pairs() {
        color = color.max(colors_apart(a.color.to_array(), b.color.to_array()));
        if is_hit(a) || is_hit(b) {
            depth = depth.max(apart(a.depth.into(), b.depth.into()));
        }
        normal = normal.max(colors_apart(a.normal.extend(0.0).to_array(), b.normal.extend(0.0).to_array()));
    }
    let place = [first as u32 % width, first as u32 / width];
    Some(format!(
        "{} pixels, the first {place:?}; colours by up to {color:.2e}, depths by {depth:.2e}, normals by {normal:.2e}",
        pairs().count()
    ))
}

fn bits(p: &Pixel) -> [u32; 8] {
    let [[r, g, b, alpha], [x, y, z, depth]] = [p.color.to_array(), p.normal.extend(p.depth).to_array()];
    [r, g, b, alpha, x, y, z, depth].map(f32::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_counted_and_located() {
        let expected = [Pixel::EMPTY; 6];
        assert_eq!(differences(&expected, &expected, 3), None);
        let mut found = expected;
        found[4].depth = 7.0;
        found[5].color.x = 0.25;
        assert_eq!(
            differences(&found, &expected, 3).unwrap(),
            "2 pixels, the first [1, 1]; colours by up to 2.50e-1, depths by inf, normals by 0.00e0"
        );
        // Zeros of either sign are two things.
        found = expected;
        found[0].color.x = -0.0;
        assert!(differences(&found, &expected, 3).is_some());
    }
}
