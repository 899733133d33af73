//! What the oracle says of a volume that is an adaptive mesh.

use glam::DAffine3;
use isoray_oracle::{OracleShading, integrate_ray};
use isoray_preint::ControlPoint;
use isoray_render::{Clip, VolumeShading};

use super::eye::Eye;
use super::glow::clipped;
use crate::finest::{Field, Finest};
use crate::for_oracle::{self, colors_apart};

/// Share of a bound that the rounding of values may move the truth by, of a pixel that is held against that bound: little of what is found, and in none of these scenes is it exceeded.
const DOUBTFUL: f64 = 1.0 / 16.0;

/// What is seen of a mesh, and from where.
pub(crate) struct MeshVolume<'a> {
    pub(crate) finest: &'a Finest,
    pub(crate) field: &'a Field<'a>,
    pub(crate) eye: &'a Eye,
    pub(crate) to_world: DAffine3,
    pub(crate) points: &'a [ControlPoint],
    pub(crate) shading: Option<VolumeShading>,
    pub(crate) clip: &'a Clip,
}

impl MeshVolume<'_> {
    /// RGBA of a pixel; `None` where the rounding of values counts.
    pub(crate) fn pixel(&self, pixel: [u32; 2], bound: f64) -> Option<[f64; 4]> {
        let rounding = self.finest.rounding();
        let [truth, above, below] = [0.0, rounding, -rounding].map(|by| self.moved(pixel, by));
        let moved = colors_apart(truth, above).max(colors_apart(truth, below));
        (moved <= DOUBTFUL * bound).then_some(truth)
    }

    /// With all values moved by so much.
    fn moved(&self, [x, y]: [u32; 2], by: f64) -> [f64; 4] {
        let ray = self.finest.ray(&self.eye.camera.index_ray(&self.to_world.inverse(), x, y));
        let Some(ray) = clipped(self.eye, self.clip, ray, [x, y]) else { return [0.0; 4] };
        let mut points = for_oracle::transfer(self.points);
        points.0.iter_mut().for_each(|point| point.value -= by);
        let shading = self.shading.map(|shading| {
            let of = for_oracle::lit_by(&shading, &self.to_world, self.eye.ray([x, y]).1);
            // The gradient is that in units of the lattice.
            let scaled = |v: [f64; 3]| v.map(|c| c * f64::from(self.finest.scale()));
            OracleShading { light: scaled(of.light), half: scaled(of.half), ..of }
        });
        let radiance = integrate_ray(self.field, &ray, 1.0, &points, shading.as_ref());
        let [r, g, b] = radiance.color;
        [r, g, b, radiance.alpha()]
    }
}
