//! Frames of an isosurface.

use anyhow::Result;
use isoray_grid::Scalar;
use isoray_octree::{AnyVolume, Meta, OctreeVolume, VolumeVisitor};
use isoray_render::{
    Camera, FrameStatistics, Light, Normals, Scene, render_counted, render_with_progress as frame,
};

use super::flags::checked_isovalue;
use super::frames::Rendered;
use super::stats::{SurfaceStats, What};
use crate::cli::{LightArg, NormalsArg, RenderArgs};
use crate::failure::warn;
use crate::isovalue::propose;
use crate::output::to_stdout;

/// The isovalue; says which was proposed, if none was given.
pub(super) fn isovalue(args: &RenderArgs, meta: &Meta) -> Result<f32> {
    match args.isovalue {
        Some(v) => checked_isovalue(v),
        None => proposed_isovalue(meta),
    }
}

/// Renders the surface.
pub(super) fn render(
    args: &RenderArgs,
    isovalue: f32,
    volume: &AnyVolume,
    camera: &Camera,
) -> (Rendered, What) {
    warn_out_of_range(volume.meta(), isovalue);
    let scene = scene(args, isovalue);
    let (rendered, statistics) = volume.visit(Frames { camera, scene: &scene, args });
    let FrameStatistics { hits, flat, .. } = statistics;
    (rendered, What::Surface(SurfaceStats { isovalue, hits, flat_hits: flat }))
}

fn proposed_isovalue(meta: &Meta) -> Result<f32> {
    let proposed = meta.range.and_then(|range| propose(&*meta.histogram, range).map(|v| (v, range)));
    // One value, or none: no isovalue has a surface, and the warning about the range will say so.
    let Some((v, [low, high])) = proposed else { return Ok(0.0) };
    to_stdout(|out| {
        writeln!(
            out,
            "isovalue {v}, proposed by Otsu's method: it best parts the values {low} to {high} in two (choose with --isovalue)"
        )
    })?;
    Ok(v)
}

fn warn_out_of_range(meta: &Meta, isovalue: f32) {
    match meta.range {
        Some([low, high]) if f64::from(isovalue) <= low || f64::from(isovalue) > high => {
            warn(format!("no surface at isovalue {isovalue}: the values range from {low} to {high}"));
        }
        Some(_) => {}
        None => warn("no surface: no sample is finite"),
    }
}

fn scene(args: &RenderArgs, isovalue: f32) -> Scene {
    Scene {
        isovalue,
        normals: match args.normals {
            None | Some(NormalsArg::Forward) => Normals::Forward,
            Some(NormalsArg::Central) => Normals::Central,
        },
        light: match args.light {
            None | Some(LightArg::Headlight) => Light::Headlight,
            Some(LightArg::Point(at)) => Light::Point(at),
        },
        ..Scene::default()
    }
}

struct Frames<'a> {
    camera: &'a Camera,
    scene: &'a Scene,
    args: &'a RenderArgs,
}

impl VolumeVisitor for Frames<'_> {
    type Output = (Rendered, FrameStatistics);

    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Self::Output {
        let octree = volume.view();
        let placement = volume.meta().index_to_world;
        let rendered = Rendered::new(volume, self.args.repeat, |progress| {
            frame(&octree, placement, self.camera, self.scene, progress)
        });
        // Counting costs time, so it is a frame of its own, and only where somebody asks.
        let statistics = match self.args.stats {
            Some(_) => render_counted(&octree, placement, self.camera, self.scene).1,
            None => FrameStatistics::default(),
        };
        (Rendered { work: statistics.work, ..rendered }, statistics)
    }
}
