//! How volumes are lit.

use anyhow::Result;
use glam::{DAffine3, DVec3};
use isoray_grid::{Dims, Scalar};
use isoray_octree::{Meta, OctreeVolume, VolumeVisitor};
use isoray_render::{VolumeShading, gradient_scale};

use super::view::centre;
use crate::cli::{LightArg, RenderArgs, ShadingArg};
use crate::load::Data;
use crate::output::to_stdout;

/// What a region without a gradient keeps of its colour: more than half, so that the inside of things is not lost.
const AMBIENT: f32 = 0.6;
/// What a gradient of one scale toward the light adds: borders stand out, being brighter than the colour itself.
const DIFFUSE: f32 = 0.9;
/// What a highlight adds at most.
const SPECULAR: f32 = 0.4;
/// Of the highlight: wide enough to be seen on a noisy scan.
const EXPONENT: f32 = 24.0;

/// The gradient scale, if there is shading; says which was measured, if none was given.
pub(super) fn scale(args: &RenderArgs, volume: &Data) -> Result<Option<f64>> {
    match (args.volume.shading, args.volume.gradient_scale) {
        (Some(ShadingArg::None), _) => Ok(None),
        (_, Some(scale)) => Ok(Some(scale)),
        (_, None) => {
            let scale = match volume {
                Data::Octree(volume) => volume.visit(Measured),
                Data::Mesh(mesh) => gradient_scale(&mesh.mesh, mesh.meta.index_to_world),
            };
            to_stdout(|out| {
                writeln!(
                    out,
                    "gradient scale {scale:.4}, the change of value per world unit that all but 1 % of the volume is below (choose with --gradient-scale)"
                )
            })?;
            Ok(Some(scale))
        }
    }
}

struct Measured;

impl VolumeVisitor for Measured {
    type Output = f64;
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> f64 {
        gradient_scale(&volume.view(), volume.meta().index_to_world)
    }
}

/// The shading that the flags describe; none without a gradient scale.
pub(super) fn shading(args: &RenderArgs, gradient_scale: Option<f64>, meta: &Meta) -> Option<VolumeShading> {
    Some(VolumeShading {
        ambient: AMBIENT,
        diffuse: DIFFUSE,
        specular: if args.volume.shading == Some(ShadingArg::Specular) { SPECULAR } else { 0.0 },
        exponent: EXPONENT,
        gradient_scale: gradient_scale?,
        light: light(args.light.first().copied(), meta.dims, &meta.index_to_world),
    })
}

/// From the volume's centre toward the position; from the eye if that is the centre itself.
fn light(light: Option<LightArg>, dims: Dims, index_to_world: &DAffine3) -> Option<DVec3> {
    match light {
        Some(LightArg::Point(at)) => (at - centre(dims, index_to_world)).try_normalize(),
        Some(LightArg::Direction(direction)) => direction.try_normalize(),
        None | Some(LightArg::Headlight) => None,
    }
}
