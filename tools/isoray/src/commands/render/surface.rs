//! Frames of isosurfaces.

use anyhow::{Result, bail};
use glam::Vec3;
use isoray_grid::{DenseVolume, GridVolume, Scalar};
use isoray_octree::lod::{Detail, DetailRequest, DetailView, DistanceMeasure};
use isoray_octree::{Coarse, Meta, OctreeVolume, VolumeVisitor};
use isoray_render::{
    Camera, ColorField, FarShadowed, FrameStatistics, Light, Normals, SURFACE_COLOR, Scene, Slicing, Surface,
    SurfaceSource, Traversal, render_counted, render_with_progress as frame,
};

use super::clipping::clip;
use super::flags::checked_isovalue;
use super::frames::{Bytes, Rendered};
use super::look::SurfaceLook;
use super::stats::{SurfaceStats, What};
use super::structure;
use crate::cli::{DistanceArg, IsovalueArg, LightArg, NormalsArg, RenderArgs, TraversalArg};
use crate::failure::warn;
use crate::isovalue::propose;
use crate::load::Data;
use crate::output::to_stdout;

/// The surfaces; says which isovalue was proposed, if none was given.
pub(super) fn surfaces(args: &RenderArgs, meta: &Meta) -> Result<Vec<Surface>> {
    if args.surface.isovalue.is_empty() {
        let isovalue = proposed_isovalue(meta)?;
        return Ok(vec![Surface { isovalue, color: SURFACE_COLOR, opacity: 1.0 }]);
    }
    let surface = |(n, given): (usize, &IsovalueArg)| {
        Ok(Surface {
            isovalue: checked_isovalue(given.value)?,
            color: given.color.map_or(PALETTE[n % PALETTE.len()], |color| color.as_vec3()),
            opacity: given.opacity,
        })
    };
    args.surface.isovalue.iter().enumerate().map(surface).collect()
}

/// Colours of surfaces that are given none, in their order.
const PALETTE: [Vec3; 5] = [
    SURFACE_COLOR,
    Vec3::new(0.55, 0.13, 0.08),
    Vec3::new(0.10, 0.30, 0.55),
    Vec3::new(0.20, 0.45, 0.15),
    Vec3::new(0.60, 0.40, 0.05),
];

/// Renders the surfaces.
pub(super) fn render(
    args: &RenderArgs,
    look: &SurfaceLook,
    volume: &Data,
    camera: &Camera,
) -> Result<(Rendered, What)> {
    let isovalues: Vec<f32> = look.surfaces.iter().map(|surface| surface.isovalue).collect();
    isovalues.iter().for_each(|&isovalue| warn_out_of_range(volume.meta(), isovalue));
    let scene = scene(args, look, volume.meta());
    let (rendered, statistics) = match volume {
        Data::Octree(volume) => volume.visit(Frames { camera, scene: &scene, args })?,
        Data::Mesh(mesh) => {
            Frames { camera, scene: &scene, args }.of(&mesh.mesh, (&mesh.mesh).into(), &mesh.meta)
        }
    };
    let FrameStatistics { hits, flat, work, .. } = statistics;
    let counted = SurfaceStats {
        isovalues,
        hits,
        flat_hits: flat,
        packets: work.packets,
        background_packets: work.background_packets,
        rays_alone: work.alone,
        shadow_rays: work.shadow_rays,
        spared_shadow_rays: work.spared_shadow_rays,
    };
    Ok((rendered, What::Surface(counted)))
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

/// Share of a surface's colour that needs no light: little, or, where it is seen how much of the sky reaches a point, much.
const AMBIENT: [f32; 2] = [0.1, 0.4];

fn scene<'l>(args: &RenderArgs, look: &'l SurfaceLook, meta: &Meta) -> Scene<'l> {
    let surface = &args.surface;
    let light = |light: &LightArg| match *light {
        LightArg::Headlight => Light::Headlight,
        LightArg::Point(at) => Light::Point(at),
        LightArg::Direction(direction) => Light::Direction(direction),
    };
    let lights = match args.light[..] {
        [] => vec![Light::Headlight],
        _ => args.light.iter().map(light).collect(),
    };
    let (specular, exponent) = surface.specular.map_or((0.0, 1.0), |s| (s.brightness, s.exponent));
    Scene {
        surfaces: look.surfaces.clone(),
        normals: match surface.normals {
            None | Some(NormalsArg::Forward) => Normals::Forward,
            Some(NormalsArg::Central) => Normals::Central,
        },
        lights,
        ambient: AMBIENT[usize::from(surface.ao.is_some())],
        specular,
        exponent,
        shadows: surface.shadows,
        sky_samples: surface.ao.unwrap_or(0),
        clip: clip(&args.clip, meta),
        cap: args.clip.cap,
        level_colors: surface.lod_colors || args.mesh.show_levels,
        colors: look.colors.as_ref().map(|colors| colors as &dyn ColorField),
        traversal: match surface.traversal {
            None | Some(TraversalArg::Auto) => Traversal::Auto,
            Some(TraversalArg::Single) => Traversal::Single,
            Some(TraversalArg::Masked) => Traversal::Masked,
            Some(TraversalArg::Coherent) => Traversal::Coherent(Slicing::default()),
        },
        packet_edge: surface.packet.unwrap_or(8),
    }
}

struct Frames<'a> {
    camera: &'a Camera,
    scene: &'a Scene<'a>,
    args: &'a RenderArgs,
}

impl VolumeVisitor for Frames<'_> {
    type Output = Result<(Rendered, FrameStatistics)>;

    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Self::Output {
        let octree = volume.view();
        let surface = &self.args.surface;
        let view = |flag, ratio| -> Result<_> {
            let detail = self.detail(volume, flag, ratio)?;
            Ok(detail.map(|detail| DetailView::new(&octree, volume.meta().coarse, detail)))
        };
        let far = view("--shadow-lod", surface.shadow_lod.unwrap_or_default())?;
        if let Some(picture) = view("--lod", surface.lod)? {
            return Ok(self.with(&picture, far.as_ref(), volume));
        }
        if far.is_some() || !structure::is_grid(self.args.structure, volume) {
            return Ok(self.with(&octree, far.as_ref(), volume));
        }
        let samples = octree.to_dense();
        let grid = GridVolume::new(DenseVolume::new(octree.dims(), &samples)?);
        let structure_bytes = structure::grid_bytes(&grid);
        let (rendered, statistics) = self.of(&grid, volume.into(), volume.meta());
        Ok((Rendered { structure_bytes, ..rendered }, statistics))
    }
}

impl Frames<'_> {
    /// Which levels of detail there are by the ratio that `flag` gives, if not everything is at the finest.
    fn detail<T: Scalar>(&self, volume: &OctreeVolume<T>, flag: &str, ratio: f64) -> Result<Option<Detail>> {
        let (surface, meta) = (&self.args.surface, volume.meta());
        if ratio == 0.0 {
            return Ok(None);
        }
        if meta.coarse == Coarse::None {
            let file = self.args.file.display();
            bail!("{file}: expected coarse samples for {flag}, found a volume that was built without");
        }
        let measure = match surface.lod_distance {
            None | Some(DistanceArg::True) => DistanceMeasure::True,
            Some(DistanceArg::Slices) => DistanceMeasure::Slices(self.camera.forward()),
        };
        let blend = surface.lod_blend.unwrap_or(0.0);
        let request = DetailRequest { pixel: self.camera.pixel_width(), ratio, measure, blend };
        let detail = Detail::new(meta.dims, &meta.index_to_world, &request);
        Ok((*detail.levels().end() > 0).then_some(detail))
    }

    /// With shadows from afar, if those are others.
    fn with<T: Scalar>(
        &self,
        picture: &impl SurfaceSource,
        far: Option<&DetailView<'_, T>>,
        volume: &OctreeVolume<T>,
    ) -> (Rendered, FrameStatistics) {
        match far {
            Some(far) => self.of(&FarShadowed { picture, far }, volume.into(), volume.meta()),
            None => self.of(picture, volume.into(), volume.meta()),
        }
    }

    fn of(&self, source: &impl SurfaceSource, bytes: Bytes, meta: &Meta) -> (Rendered, FrameStatistics) {
        let placement = meta.index_to_world;
        let rendered = Rendered::new(bytes, self.args.repeat, |progress| {
            frame(source, placement, self.camera, self.scene, progress)
        });
        // Counting costs time, so it is a frame of its own, and only where somebody asks.
        let statistics = match self.args.stats {
            Some(_) => render_counted(source, placement, self.camera, self.scene).1,
            None => FrameStatistics::default(),
        };
        (Rendered { work: statistics.work, ..rendered }, statistics)
    }
}
