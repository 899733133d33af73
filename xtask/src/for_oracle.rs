//! The renderer's input as the oracle takes it: the same numbers, exactly; and how far normals are from the oracle's.

use glam::{DAffine3, DVec3};
use isoray_grid::Scalar;
use isoray_oracle::{DenseLattice, OracleRay, OracleShading, TransferPoint, TransferPoints};
use isoray_preint::{ControlPoint, Lighting};
use isoray_render::{Pixel, VolumeShading};
use isoray_trace::Ray;

use crate::catalog::Dense;

/// 99 % of the normals are within this of the oracle's, in degrees. The rest lie where the gradient nearly vanishes, or
/// changes within the rounding of the depth.
pub(crate) const DEGREES_99: f64 = 0.1;

/// The angle between unit vectors, in degrees, of the chord: accurate for small angles, where the cosine is not. Infinite if there is none, of what is no number.
pub(crate) fn degrees(a: DVec3, b: DVec3) -> f64 {
    match (a - b).length() {
        chord if chord.is_nan() => f64::INFINITY,
        chord => 2.0 * (0.5 * chord).min(1.0).asin().to_degrees(),
    }
}

/// How far two numbers are from each other: infinitely, if either is none, so that no bound holds.
pub(crate) fn apart(a: f64, b: f64) -> f64 {
    match (a - b).abs() {
        by if by.is_nan() => f64::INFINITY,
        by => by,
    }
}

/// Whether an error breaks a bound: one that is no number does.
pub(crate) fn breaks(error: f64, bound: f64) -> bool {
    error > bound || error.is_nan()
}

/// The largest difference of two colours' channels.
pub(crate) fn colors_apart<A: Copy + Into<f64>, B: Copy + Into<f64>>(a: [A; 4], b: [B; 4]) -> f64 {
    a.into_iter().zip(b).fold(0.0, |most, (a, b)| f64::max(most, apart(a.into(), b.into())))
}

/// Whether a pixel shows a surface. Those that show none are infinitely far away; what is no number, or negative, is no such distance.
pub(crate) fn is_hit(pixel: &Pixel) -> bool {
    pixel.depth != f32::INFINITY
}

pub(crate) fn lattice<T: Scalar + Into<f64>>(volume: &Dense<T>) -> DenseLattice<T> {
    let samples = volume.samples.clone();
    DenseLattice::from_vec(volume.dims.axes(), samples)
        .expect("a dense volume holds the samples of its lattice")
}

pub(crate) fn ray(ray: &Ray) -> OracleRay {
    OracleRay { origin: ray.origin, direction: ray.direction, t_min: ray.t_min, t_max: ray.t_max }
}

pub(crate) fn transfer(points: &[ControlPoint]) -> TransferPoints {
    let point = |p: &ControlPoint| TransferPoint {
        value: p.value.into(),
        color: p.color.map(f64::from),
        extinction: p.extinction.into(),
    };
    TransferPoints(points.iter().map(point).collect())
}

pub(crate) fn shading(lighting: &Lighting) -> OracleShading {
    OracleShading {
        ambient: lighting.ambient.into(),
        diffuse: lighting.diffuse.into(),
        specular: lighting.specular.into(),
        exponent: lighting.exponent.into(),
        light: lighting.light.map(f64::from),
        half: lighting.half.map(f64::from),
    }
}

/// What a ray of unit world `direction` is lit by, in index space: [`VolumeShading`] as its fields are described, in double precision throughout.
pub(crate) fn lit_by(shading: &VolumeShading, index_to_world: &DAffine3, direction: DVec3) -> OracleShading {
    let to_viewer = -direction.normalize();
    let to_light = shading.light.map_or(to_viewer, DVec3::normalize);
    let half = (to_light + to_viewer).normalize_or(to_viewer);
    // The world's gradient times v is the index space's times the inverse of the placement applied to v.
    let to_index = index_to_world.matrix3.inverse();
    let over_scale = |v: DVec3| (to_index * v).to_array().map(|c| c / shading.gradient_scale);
    OracleShading {
        ambient: shading.ambient.into(),
        diffuse: shading.diffuse.into(),
        specular: shading.specular.into(),
        exponent: shading.exponent.into(),
        light: over_scale(to_light),
        half: over_scale(half),
    }
}
