//! Gradients, per unit of index space.

use crate::{Mask, Real, lerp};

/// The gradient of the cell's own trilinear interpolant at cell-local `p` (*forward* normals).
#[inline]
pub fn gradient<R: Real>(corners: &[R; 8], p: [R; 3]) -> [R; 3] {
    let c = corners;
    let [x, y, z] = p;
    let dx = |n: usize| c[n + 1] - c[n];
    let gx = lerp(lerp(dx(0), dx(2), y), lerp(dx(4), dx(6), y), z);
    let ex: [R; 4] = std::array::from_fn(|n| lerp(c[2 * n], c[2 * n + 1], x));
    let gy = lerp(ex[1] - ex[0], ex[3] - ex[2], z);
    let gz = lerp(ex[2], ex[3], y) - lerp(ex[0], ex[1], y);
    [gx, gy, gz]
}

/// The derivative at the middle one of five equidistant samples of unit distance, of which those outside the
/// domain, and those whose value is not finite, do not exist: central where both neighbours do, else
/// one-sided of second order, else one-sided of first order, else zero. All but the last are exact on
/// linear data; the first two on quadratic data.
#[inline]
pub fn central_differences<R: Real>(line: [R; 5], exists: [R::Mask; 5]) -> R {
    let [below2, below, here, above, above2] = line;
    let [has_below2, has_below, has_here, has_above, has_above2] = exists;
    let half = R::splat(0.5);
    let central = (above - below) * half;
    let one_sided = |f1: R, f2: R, has_f2: R::Mask| {
        let first = f1 - here;
        R::select(has_f2, (first + first) - (f2 - here) * half, first)
    };
    let forward = one_sided(above, above2, has_above2);
    let backward = -one_sided(below, below2, has_below2);
    let has_backward = has_below & has_here;
    let has_forward = has_above & has_here;
    let slope = R::select(has_forward, forward, R::select(has_backward, backward, R::splat(0.0)));
    R::select(has_below & has_above, central, slope)
}

/// Samples along each axis around a cell: its two and one more on either side.
pub const STENCIL: usize = 4;

/// The gradient at cell-local `p` from the 4³ samples around a cell, x fastest, and where each of them exists: interpolated between the
/// [`central_differences`] at the cell's corners (*central* normals), continuous across cells, where the forward gradient jumps.
///
/// The cell's corners, samples 1 and 2 along each axis, must exist. Per unit of index space; a world normal is its product with the inverse
/// transpose of the map from index to world space, normalised.
pub fn stencil_gradient<R: Real>(samples: &[R; 64], exists: &[R::Mask; 64], p: [R; 3]) -> [R; 3] {
    interpolate_gradients(&corner_gradients(samples, exists), p)
}

/// The [`central_differences`] at the corners of a cell, from the samples around it; see [`stencil_gradient`]. They are the same for all points of the cell. Samples that are
/// not in line with two corners are not needed.
pub fn corner_gradients<R: Real>(samples: &[R; 64], exists: &[R::Mask; 64]) -> [[R; 3]; 8] {
    std::array::from_fn(|n| {
        let corner: [usize; 3] = std::array::from_fn(|a| 1 + (n >> a & 1));
        std::array::from_fn(|axis| {
            let stride = STENCIL.pow(axis as u32);
            let base = corner[0] + STENCIL * (corner[1] + STENCIL * corner[2]) - corner[axis] * stride;
            let at = |k: usize| {
                let along = (corner[axis] + k).checked_sub(2).filter(|&c| c < STENCIL)?;
                Some(base + along * stride)
            };
            let line = std::array::from_fn(|k| at(k).map_or(R::splat(0.0), |n| samples[n]));
            central_differences(line, std::array::from_fn(|k| at(k).map_or(R::Mask::never(), |n| exists[n])))
        })
    })
}

/// [`corner_gradients`] where all samples exist: the same.
pub fn central_gradients<R: Real>(samples: &[R; 64]) -> [[R; 3]; 8] {
    std::array::from_fn(|n| {
        let at = 21 + (n & 1) + STENCIL * ((n >> 1 & 1) + STENCIL * (n >> 2));
        [1, STENCIL, STENCIL * STENCIL]
            .map(|stride| (samples[(at + stride) % 64] - samples[(at - stride) % 64]) * R::splat(0.5))
    })
}

/// Trilinear interpolation of the gradients at the eight corners, at cell-local `p` (*central* normals).
pub fn interpolate_gradients<R: Real>(corners: &[[R; 3]; 8], p: [R; 3]) -> [R; 3] {
    std::array::from_fn(|axis| crate::trilinear(&corners.map(|g| g[axis]), p))
}

/// A unit vector, in lanes where there is one.
#[derive(Clone, Copy, Debug)]
pub struct Normal<R: Real> {
    /// Of length 1, toward larger values; zero where there is none.
    pub direction: [R; 3],
    /// Where the gradient is neither zero nor beyond numbers.
    pub exists: R::Mask,
}

/// The unit normal in world space of an index-space `gradient`. The rows of `matrix` are those of the inverse transpose of the
/// index-to-world map's linear part, so that the normal is perpendicular to the surface on oblique grids too.
///
/// A gradient that is exactly zero, or not finite, has no normal. With `κ` the magnitudes of the nine products over the length
/// of their sums, the result is within `(3κ + 6)·u` of exact, `u` the unit roundoff (`2⁻²⁴` in `f32`), provided that no product is denormal.
/// An orthogonal grid has `κ = 1`.
// Three roundings of each component's products and sums; then one by the scale, four of the length, two of the reciprocal's product, halved
// where they stand under the root.
#[inline]
pub fn unit_normal<R: Real>(gradient: [R; 3], matrix: &[[R; 3]; 3]) -> Normal<R> {
    let [x, y, z] = gradient;
    let normal = matrix.map(|[mx, my, mz]| mx.fma(x, my.fma(y, mz * z)));
    // Scaled, so that no square overflows or vanishes.
    let [ax, ay, az] = normal.map(R::abs);
    let largest = ax.max(ay).max(az);
    let [x, y, z] = normal.map(|c| c / largest);
    let square = x.fma(x, y.fma(y, z * z));
    let exists = square.ge(R::splat(1.0));
    let inverse = R::splat(1.0) / square.sqrt();
    Normal { direction: [x, y, z].map(|c| R::select(exists, c * inverse, R::splat(0.0))), exists }
}
