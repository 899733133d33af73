//! One cell: its corners, their trilinear interpolant and its gradient, from the definition.

use crate::Lattice;

/// Values at a cell's eight corners. Corner `c` lies at `x = c & 1`, `y = c >> 1 & 1`, `z = c >> 2`:
///
/// ```text
///        6 ------- 7
///       /|        /|      z  y
///      4 ------- 5 |      | /
///      | 2 ------|-3      |/
///      |/        |/       +--- x
///      0 ------- 1
/// ```
pub(crate) type Corners = [f64; 8];

/// The corners of a cell whose coordinates are each less than `dims - 1`.
#[inline]
pub(crate) fn corners(l: &impl Lattice, [x, y, z]: [u32; 3]) -> Corners {
    [
        l.sample([x, y, z]),
        l.sample([x + 1, y, z]),
        l.sample([x, y + 1, z]),
        l.sample([x + 1, y + 1, z]),
        l.sample([x, y, z + 1]),
        l.sample([x + 1, y, z + 1]),
        l.sample([x, y + 1, z + 1]),
        l.sample([x + 1, y + 1, z + 1]),
    ]
}

/// Linear interpolation that is exactly `a` at 0, exactly `b` at 1, and zero only between opposite signs.
#[inline]
fn lerp(a: f64, b: f64, x: f64) -> f64 {
    a * (1.0 - x) + b * x
}

/// The trilinear interpolant at a cell-local point of `[0,1]³`.
///
/// On a face it depends on that face's corners only, in an order of operations that is the same seen
/// from both cells: neighbours agree there bit for bit.
#[inline]
pub(crate) fn trilinear(c: &Corners, [x, y, z]: [f64; 3]) -> f64 {
    let low = lerp(lerp(c[0], c[1], x), lerp(c[2], c[3], x), y);
    let high = lerp(lerp(c[4], c[5], x), lerp(c[6], c[7], x), y);
    lerp(low, high, z)
}

/// The gradient of the trilinear interpolant at a cell-local point: differences along each axis,
/// interpolated bilinearly along the other two.
#[inline]
pub(crate) fn gradient(c: &Corners, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let bilinear = |q: [f64; 4], a, b| lerp(lerp(q[0], q[1], a), lerp(q[2], q[3], a), b);
    [
        bilinear([c[1] - c[0], c[3] - c[2], c[5] - c[4], c[7] - c[6]], y, z),
        bilinear([c[2] - c[0], c[3] - c[1], c[6] - c[4], c[7] - c[5]], x, z),
        bilinear([c[4] - c[0], c[5] - c[1], c[6] - c[2], c[7] - c[3]], x, y),
    ]
}
