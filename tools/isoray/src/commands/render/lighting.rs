//! How volumes are lit.

use anyhow::Result;
use glam::{DAffine3, DVec3};
use isoray_grid::{Dims, Scalar};
use isoray_octree::OctreeVolume;
use isoray_render::{VolumeShading, gradient_scale};

use super::view::centre;
use crate::cli::{LightArg, RenderArgs, ShadingArg};
use crate::output::to_stdout;

/// What a region without a gradient keeps of its colour: more than half, so that the inside of things is not lost.
const AMBIENT: f32 = 0.6;
/// What a gradient of one scale toward the light adds: borders stand out, being brighter than the colour itself.
const DIFFUSE: f32 = 0.9;
/// What a highlight adds at most.
const SPECULAR: f32 = 0.4;
/// Of the highlight: wide enough to be seen on a noisy scan.
const EXPONENT: f32 = 24.0;

/// The shading that the flags describe, if there is any; says which gradient scale was measured.
pub(super) fn shading<T: Scalar>(
    args: &RenderArgs,
    volume: &OctreeVolume<T>,
) -> Result<Option<VolumeShading>> {
    let specular = match args.volume.shading {
        Some(ShadingArg::None) => return Ok(None),
        None | Some(ShadingArg::Diffuse) => 0.0,
        Some(ShadingArg::Specular) => SPECULAR,
    };
    let meta = volume.meta();
    let gradient_scale = match args.volume.gradient_scale {
        Some(scale) => scale,
        None => {
            let scale = gradient_scale(&volume.view(), meta.index_to_world);
            to_stdout(|out| {
                writeln!(
                    out,
                    "gradient scale {scale:.4}, the change of value per world unit that all but 1 % of the volume is below (choose with --gradient-scale)"
                )
            })?;
            scale
        }
    };
    let light = light(args.light, meta.dims, &meta.index_to_world);
    Ok(Some(VolumeShading {
        ambient: AMBIENT,
        diffuse: DIFFUSE,
        specular,
        exponent: EXPONENT,
        gradient_scale,
        light,
    }))
}

/// From the volume's centre toward the position; from the eye if that is the centre itself.
fn light(light: Option<LightArg>, dims: Dims, index_to_world: &DAffine3) -> Option<DVec3> {
    match light {
        Some(LightArg::Point(at)) => (at - centre(dims, index_to_world)).try_normalize(),
        None | Some(LightArg::Headlight) => None,
    }
}
