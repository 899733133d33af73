//! Central-difference gradients.

use isoray_cell::stencil_gradient;
use isoray_grid::{Samples, Scalar};

use crate::hit::Hit;

/// The gradient at a hit, interpolated between central differences at the cell's corners, per unit of index space
/// (*central* normals): continuous across cells, where the forward gradient jumps.
///
/// At the border of the domain, and beside samples that are not finite, differences are one-sided of second order.
pub fn central_gradient(samples: &impl Samples, hit: &Hit) -> [f32; 3] {
    let stencil = samples.stencil(hit.cell).map(|s| s.filter(|s| s.is_finite()).map(Scalar::to_f32));
    stencil_gradient(&stencil.map(Option::unwrap_or_default), &stencil.map(|s| s.is_some()), hit.local)
}
