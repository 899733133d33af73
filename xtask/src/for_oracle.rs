//! The renderer's input as the oracle takes it: the same numbers, exactly.

use isoray_oracle::{OracleRay, OracleShading, TransferPoint, TransferPoints};
use isoray_preint::{ControlPoint, Lighting};
use isoray_trace::Ray;

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
