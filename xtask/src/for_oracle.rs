//! The renderer's input as the oracle takes it: the same numbers, exactly; and how far normals are from the oracle's.

use glam::DVec3;
use isoray_grid::Scalar;
use isoray_oracle::{DenseLattice, OracleRay, OracleShading, TransferPoint, TransferPoints};
use isoray_preint::{ControlPoint, Lighting};
use isoray_trace::Ray;

use crate::catalog::Dense;

/// 99 % of the normals are within this of the oracle's, in degrees. The rest lie where the gradient nearly vanishes, or
/// changes within the rounding of the depth.
pub(crate) const DEGREES_99: f64 = 0.1;

/// The angle between unit vectors, in degrees, of the chord: accurate for small angles, where the cosine is not.
pub(crate) fn degrees(a: DVec3, b: DVec3) -> f64 {
    2.0 * (0.5 * (a - b).length()).min(1.0).asin().to_degrees()
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
