//! Frames of a volume.

use anyhow::Result;
use isoray_grid::{DenseVolume, GridVolume, Scalar};
use isoray_octree::{Meta, OctreeVolume, VolumeVisitor};
use isoray_preint::{Bounded, Cuts, Integrate, LinearPieces, Linearised, TransferFunction, Visibility};
use isoray_render::{
    ByLevel, Camera, VolumeScene, VolumeShading, VolumeSource, VolumeStatistics, render_volume,
    render_volume_counted,
};

use super::clipping::clip;
use super::frames::{Bytes, Rendered};
use super::lighting::shading;
use super::look::VolumeLook;
use super::stats::{VolumeStats, What};
use super::structure;
use crate::cli::{RenderArgs, SchemeArg};
use crate::failure::warn;
use crate::load::Data;
use crate::output::to_stdout;
use crate::transfer::{summary, transfer_function};

/// Transmittance at which a ray ends: what is behind could change no pixel by more than a quarter of a step of eight bits.
const TERMINATE: f64 = 0.001;

/// The transfer function; says what was proposed, if none was given.
pub(super) fn transfer(args: &RenderArgs, meta: &Meta) -> Result<TransferFunction> {
    let transfer = transfer_function(&args.transfer, meta)?;
    if args.transfer.tf.is_none() {
        to_stdout(|out| writeln!(out, "{}", summary(&args.transfer, &transfer)))?;
    }
    Ok(transfer)
}

/// Renders the volume.
pub(super) fn render(
    args: &RenderArgs,
    look: &VolumeLook,
    volume: &Data,
    camera: &Camera,
) -> Result<(Rendered, What)> {
    warn_invisible(volume.meta(), &look.visible);
    let (rendered, statistics) = match volume {
        Data::Octree(volume) => volume.visit(Frames { camera, look, args })?,
        Data::Mesh(mesh) => {
            let (bytes, frames) = ((&mesh.mesh).into(), Frames { camera, look, args });
            frames.with_scheme(&mesh.meta, |scene| match args.mesh.show_levels {
                true => frames.of(&ByLevel(&mesh.mesh), bytes, &mesh.meta, scene),
                false => frames.of(&mesh.mesh, bytes, &mesh.meta, scene),
            })
        }
    };
    let stats = VolumeStats::new(args.volume.scheme.unwrap_or_default(), &statistics);
    Ok((rendered, What::Volume(stats)))
}

fn warn_invisible(meta: &Meta, visible: &Visibility) {
    match meta.range {
        Some([low, high]) if !visible.is_visible(low as f32, high as f32) => {
            warn(format!("nothing to see: no value from {low} to {high} has an extinction"));
        }
        Some(_) => {}
        None => warn("nothing to see: no sample is finite"),
    }
}

struct Frames<'a> {
    camera: &'a Camera,
    look: &'a VolumeLook,
    args: &'a RenderArgs,
}

impl VolumeVisitor for Frames<'_> {
    type Output = Result<(Rendered, VolumeStatistics)>;

    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Self::Output {
        self.with_scheme(volume.meta(), |scene| self.frames(volume, scene))
    }
}

impl Frames<'_> {
    /// What `render` makes of the scene.
    fn with_scheme<R>(
        &self,
        meta: &Meta,
        render: impl FnOnce(&VolumeScene<'_, Box<dyn Integrate>>) -> R,
    ) -> R {
        let shading = shading(self.args, self.look.gradient_scale, meta);
        // Levels colour what is white.
        let white = self.args.mesh.show_levels.then(|| self.look.transfer.in_white());
        let transfer = white.as_ref().unwrap_or(&self.look.transfer);
        let linearised = |cuts| Linearised {
            cuts,
            pieces: LinearPieces::new(transfer),
            terminate: self.args.volume.terminate.unwrap_or(TERMINATE),
        };
        let scheme: Box<dyn Integrate> = match self.args.volume.scheme.unwrap_or_default() {
            SchemeArg::Bounded(epsilon) => {
                let lit = shading.map_or(1.0, |s| brightest(&s, meta));
                Box::new(Bounded::new(transfer, epsilon, lit))
            }
            SchemeArg::Adaptive => {
                let cuts = Cuts::Adaptive { inflection: true, shading: shading.is_some() };
                Box::new(linearised(cuts))
            }
            SchemeArg::Fixed(pieces) => Box::new(linearised(Cuts::Fixed(pieces))),
        };
        let clip = self.args.clip.is_given().then(|| clip(&self.args.clip, meta));
        let scene =
            VolumeScene { visible: &self.look.visible, scheme: &scheme, shading, clip: clip.as_ref() };
        render(&scene)
    }

    fn frames<T: Scalar>(
        &self,
        volume: &OctreeVolume<T>,
        scene: &VolumeScene<'_, Box<dyn Integrate>>,
    ) -> Result<(Rendered, VolumeStatistics)> {
        let octree = volume.view();
        if !structure::is_grid(self.args.structure, volume) {
            return Ok(self.of(&octree, volume.into(), volume.meta(), scene));
        }
        let samples = octree.to_dense();
        let dense = GridVolume::new(DenseVolume::new(octree.dims(), &samples)?);
        let structure_bytes = structure::grid_bytes(&dense);
        let (rendered, statistics) = self.of(&dense, volume.into(), volume.meta(), scene);
        Ok((Rendered { structure_bytes, ..rendered }, statistics))
    }

    fn of(
        &self,
        source: &impl VolumeSource,
        bytes: Bytes,
        meta: &Meta,
        scene: &VolumeScene<'_, Box<dyn Integrate>>,
    ) -> (Rendered, VolumeStatistics) {
        let placement = meta.index_to_world;
        let rendered = Rendered::new(bytes, self.args.repeat, |progress| {
            render_volume(source, placement, self.camera, scene, progress)
        });
        // Counting costs time, so it is a frame of its own, and only where somebody asks.
        let statistics = match self.args.stats {
            Some(_) => render_volume_counted(source, placement, self.camera, scene).1,
            None => VolumeStatistics::default(),
        };
        (Rendered { work: statistics.work, ..rendered }, statistics)
    }
}

/// A bound of the factor of colours.
fn brightest(shading: &VolumeShading, meta: &Meta) -> f32 {
    let range = meta.range.map_or(0.0, |[low, high]| high - low);
    shading.brightest(&meta.index_to_world, range)
}
