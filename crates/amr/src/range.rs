//! Ranges of values.

use wide::f32x8;

/// The range of values, if all of them are finite.
pub(crate) fn range(values: &[f32]) -> Option<[f32; 2]> {
    let fold = |of: fn(f32, f32) -> f32| values.iter().copied().reduce(of);
    let [low, high] = [fold(f32::min)?, fold(f32::max)?];
    // What is not a number is passed over by both.
    values.iter().all(|value| value.is_finite()).then_some([low, high])
}

/// That of a cube's corners.
#[inline(always)]
pub(crate) fn range_of_corners(corners: &[f32; 8]) -> Option<[f32; 2]> {
    let lanes = f32x8::new(*corners);
    let is_finite = lanes.is_finite().all();
    let [a, b, c, d, e, f, g, h] = *corners;
    let of = |pick: fn(f32, f32) -> f32| pick(pick(pick(a, b), pick(c, d)), pick(pick(e, f), pick(g, h)));
    let least = of(|a, b| if a < b { a } else { b });
    let largest = of(|a, b| if a > b { a } else { b });
    is_finite.then_some([least, largest])
}
