//! Gradients, per unit of index space.

use crate::lerp;

/// The gradient of the cell's own trilinear interpolant at cell-local `p` (*forward* normals).
#[inline]
pub fn gradient(corners: &[f32; 8], p: [f32; 3]) -> [f32; 3] {
    let c = corners;
    let [x, y, z] = p;
    let dx = |n: usize| c[n + 1] - c[n];
    let gx = lerp(lerp(dx(0), dx(2), y), lerp(dx(4), dx(6), y), z);
    let ex: [f32; 4] = std::array::from_fn(|n| lerp(c[2 * n], c[2 * n + 1], x));
    let gy = lerp(ex[1] - ex[0], ex[3] - ex[2], z);
    let gz = lerp(ex[2], ex[3], y) - lerp(ex[0], ex[1], y);
    [gx, gy, gz]
}

/// The derivative at the middle one of five equidistant samples of unit distance, of which those outside the
/// domain, and those whose value is not finite, are `None`: central where both neighbours exist, else
/// one-sided of second order, else one-sided of first order, else zero. All but the last are exact on
/// linear data; the first two on quadratic data.
#[inline]
pub fn central_difference(line: [Option<f32>; 5]) -> f32 {
    let one_sided = |f0: f32, f1: f32, f2: Option<f32>| match f2 {
        Some(f2) => (f1 - f0) * 2.0 - (f2 - f0) * 0.5,
        None => f1 - f0,
    };
    match line {
        [_, Some(below), _, Some(above), _] => (above - below) * 0.5,
        [_, _, Some(here), Some(above), further] => one_sided(here, above, further),
        [further, Some(below), Some(here), _, _] => -one_sided(here, below, further),
        _ => 0.0,
    }
}

/// Trilinear interpolation of the gradients at the eight corners, at cell-local `p` (*central* normals).
pub fn interpolate_gradients(corners: &[[f32; 3]; 8], p: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| crate::trilinear(&corners.map(|g| g[axis]), p))
}
