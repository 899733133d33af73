//! Reference gradients for smooth normals.

use crate::Lattice;
use crate::cell::trilinear;

/// The *central* gradient at a point of a cell, in index space: central differences of the samples at
/// the cell's eight corners, interpolated trilinearly.
///
/// `position` is in lattice coordinates and is clamped to the closed cell. Where a neighbour is missing
/// or not finite, the difference is second-order one-sided, `(-3f₀ + 4f₁ - f₂)/2`, or first-order if
/// there is no `f₂` either, or zero if nothing is left. Zero too for a cell outside the lattice.
pub fn central_gradient(l: &impl Lattice, position: [f64; 3], cell: [u32; 3]) -> [f64; 3] {
    let dims = l.dims();
    if (0..3).any(|axis| cell[axis] >= dims[axis].saturating_sub(1)) {
        return [0.0; 3];
    }
    let local = std::array::from_fn(|axis| (position[axis] - f64::from(cell[axis])).clamp(0.0, 1.0));
    std::array::from_fn(|axis| {
        let differences: [f64; 8] = std::array::from_fn(|corner| {
            let bits = corner as u32;
            difference(l, [cell[0] + (bits & 1), cell[1] + (bits >> 1 & 1), cell[2] + (bits >> 2)], axis)
        });
        trilinear(&differences, local)
    })
}

/// The derivative along an axis at a lattice point, by differences of the finite samples around it.
fn difference(l: &impl Lattice, p: [u32; 3], axis: usize) -> f64 {
    let n = l.dims()[axis];
    let at = |offset: i32| {
        let coordinate = p[axis].checked_add_signed(offset).filter(|&c| c < n)?;
        let mut q = p;
        q[axis] = coordinate;
        Some(l.sample(q)).filter(|s| s.is_finite())
    };
    if let (Some(before), Some(after)) = (at(-1), at(1)) {
        return 0.5 * (after - before);
    }
    let one_sided = |step: i32| {
        let (f0, f1) = (at(0)?, at(step)?);
        let slope = match at(2 * step) {
            Some(f2) => 0.5 * (-3.0 * f0 + 4.0 * f1 - f2),
            None => f1 - f0,
        };
        Some(slope * f64::from(step))
    };
    one_sided(1).or_else(|| one_sided(-1)).unwrap_or(0.0)
}
