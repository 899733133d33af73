//! Flags that make no sense for any volume: refused before one is read.

use std::path::Path;

use anyhow::Result;
use isoray_io::transfer::colormap;

use super::view::check_camera;
use super::write::Format;
use crate::cli::{LightArg, RenderArgs, SchemeArg, ShadingArg, StructureArg, TraversalArg};
use crate::failure::usage;
use crate::mesh::is_mesh;
use crate::output::check_output;
use crate::transfer;

pub(super) fn check(args: &RenderArgs) -> Result<()> {
    Format::of(&args.output)?;
    if args.volume.volume {
        check_volume(args)?;
    } else {
        check_surface(args)?;
    }
    check_camera(args)
}

/// The first flag that was given.
fn given<'a>(flags: &[(&'a str, bool)]) -> Option<&'a str> {
    flags.iter().find(|f| f.1).map(|f| f.0)
}

/// Refuses what only volumes have.
fn check_surface(args: &RenderArgs) -> Result<()> {
    let (volume, transfer) = (&args.volume, &args.transfer);
    let of_volumes = [
        ("--tf", transfer.tf.is_some()),
        ("--colormap", transfer.colormap.is_some()),
        ("--tf-range", transfer.tf_range.is_some()),
        ("--log", transfer.log),
        ("--extinction-scale", transfer.extinction_scale.is_some()),
        ("--shading", volume.shading.is_some()),
        ("--gradient-scale", volume.gradient_scale.is_some()),
        ("--scheme", volume.scheme.is_some()),
        ("--terminate", volume.terminate.is_some()),
    ];
    match given(&of_volumes) {
        Some(flag) => {
            Err(usage(format!("{flag}: expected --volume beside it, found an isosurface to render")))
        }
        None => {
            args.surface.isovalue.iter().try_for_each(|surface| checked_isovalue(surface.value).map(drop))?;
            check_looks(args)
        }
    }
}

/// Refuses looks of surfaces that come to nothing.
fn check_looks(args: &RenderArgs) -> Result<()> {
    let surface = &args.surface;
    let of_colors =
        [("--color-map", surface.color_map.is_some()), ("--color-range", surface.color_range.is_some())];
    if let Some(flag) = given(&of_colors).filter(|_| surface.color_by.is_none()) {
        return Err(usage(format!("{flag}: expected --color-by FILE beside it")));
    }
    if let Some(name) = &surface.color_map {
        colormap(name).map_err(|e| usage(format!("--color-map: {e}")))?;
    }
    if args.clip.cap && !args.clip.is_given() {
        return Err(usage("--cap: expected --clip-box or --clip-plane beside it".to_owned()));
    }
    let is_single = surface.traversal == Some(TraversalArg::Single);
    if surface.packet.is_some() && is_single {
        return Err(usage(
            "--packet: expected --traversal auto, masked or coherent beside it, found single".to_owned(),
        ));
    }
    let is_grid = args.structure == Some(StructureArg::Grid);
    let of_octrees = match surface.traversal {
        Some(TraversalArg::Masked) => Some("masked"),
        Some(TraversalArg::Coherent) => Some("coherent"),
        None | Some(TraversalArg::Auto | TraversalArg::Single) => None,
    };
    if let Some(name) = of_octrees.filter(|_| is_grid) {
        return Err(usage(format!("--traversal {name}: expected --structure octree or auto, found grid")));
    }
    let of_detail = [
        ("--lod-blend", surface.lod_blend.is_some()),
        ("--lod-distance", surface.lod_distance.is_some()),
        ("--lod-colors", surface.lod_colors),
    ];
    if let Some(flag) = given(&of_detail).filter(|_| surface.lod == 0.0) {
        return Err(usage(format!("{flag}: expected --lod RATIO beside it, with a ratio above 0")));
    }
    if surface.lod > 0.0 && is_grid {
        return Err(usage("--lod: expected --structure octree or auto, found grid".to_owned()));
    }
    if let Some(ratio) = surface.shadow_lod {
        if !surface.shadows && surface.ao.is_none() {
            return Err(usage("--shadow-lod: expected --shadows or --ao beside it".to_owned()));
        }
        if surface.isovalue.len() > 1 || surface.isovalue.iter().any(|given| given.opacity < 1.0) {
            return Err(usage("--shadow-lod: expected one opaque surface".to_owned()));
        }
        if is_grid {
            return Err(usage("--shadow-lod: expected --structure octree or auto, found grid".to_owned()));
        }
        if ratio != 0.0 && ratio <= surface.lod {
            let lod = surface.lod;
            return Err(usage(format!(
                "--shadow-lod: expected 0 or more than the ratio of --lod, {lod}, found {ratio}"
            )));
        }
    }
    if args.mesh.show_levels && surface.color_by.is_some() {
        return Err(usage("--show-levels: expected no --color-by beside it".to_owned()));
    }
    if surface.lod_colors && surface.color_by.is_some() {
        return Err(usage("--lod-colors: expected no --color-by beside it".to_owned()));
    }
    let has_lamp = args.light.iter().any(|light| *light != LightArg::Headlight);
    if surface.shadows && !has_lamp {
        return Err(usage(
            "--shadows: expected a --light that is not the headlight, whose shadows nobody sees".to_owned(),
        ));
    }
    Ok(())
}

/// Refuses what only structured volumes have.
pub(super) fn check_mesh(args: &RenderArgs) -> Result<()> {
    let surface = &args.surface;
    let of_structured = [
        ("--structure", args.structure.is_some_and(|structure| structure != StructureArg::Auto)),
        ("--traversal", matches!(surface.traversal, Some(TraversalArg::Masked | TraversalArg::Coherent))),
        ("--packet", surface.packet.is_some()),
        ("--lod-blend", surface.lod_blend.is_some()),
        ("--lod-distance", surface.lod_distance.is_some()),
        ("--lod-colors", surface.lod_colors),
        ("--shadow-lod", surface.shadow_lod.is_some()),
        ("--color-by", surface.color_by.is_some()),
    ];
    match given(&of_structured) {
        Some(flag) => {
            let file = args.file.display();
            Err(usage(format!("{flag}: expected a structured volume, found an adaptive mesh, {file}")))
        }
        None => Ok(()),
    }
}

/// Refuses what only adaptive meshes have.
pub(super) fn check_structured(args: &RenderArgs) -> Result<()> {
    let of_meshes = [("--show-levels", args.mesh.show_levels), ("--show-patches", args.mesh.show_patches)];
    match given(&of_meshes) {
        Some(flag) => {
            let file = args.file.display();
            Err(usage(format!("{flag}: expected an adaptive mesh, found a structured volume, {file}")))
        }
        None => Ok(()),
    }
}

/// Refuses what only isosurfaces have, and what contradicts itself.
fn check_volume(args: &RenderArgs) -> Result<()> {
    let volume = &args.volume;
    let surface = &args.surface;
    let of_surfaces = [
        ("--isovalue", !surface.isovalue.is_empty()),
        ("--normals", surface.normals.is_some()),
        ("--traversal", surface.traversal.is_some()),
        ("--packet", surface.packet.is_some()),
        ("--shadows", surface.shadows),
        ("--ao", surface.ao.is_some()),
        ("--specular", surface.specular.is_some()),
        // Those of meshes have levels.
        ("--lod", surface.lod > 0.0 && !is_mesh(&args.file)),
        ("--lod-blend", surface.lod_blend.is_some()),
        ("--lod-distance", surface.lod_distance.is_some()),
        ("--lod-colors", surface.lod_colors),
        ("--shadow-lod", surface.shadow_lod.is_some()),
        ("--color-by", surface.color_by.is_some()),
        ("--color-map", surface.color_map.is_some()),
        ("--color-range", surface.color_range.is_some()),
        ("--cap", args.clip.cap),
    ];
    if let Some(flag) = given(&of_surfaces) {
        return Err(usage(format!("{flag}: expected an isosurface to render, found --volume")));
    }
    let of_shading =
        [("--gradient-scale", volume.gradient_scale.is_some()), ("--light", !args.light.is_empty())];
    if let Some(flag) = given(&of_shading).filter(|_| volume.shading == Some(ShadingArg::None)) {
        return Err(usage(format!("{flag}: expected --shading diffuse or specular, found none")));
    }
    if args.mesh.show_levels && args.transfer.colormap.is_some() {
        return Err(usage("--show-levels: expected no --colormap beside it".to_owned()));
    }
    if args.light.len() > 1 {
        let found = args.light.len();
        return Err(usage(format!("--light: expected one light beside --volume, found {found}")));
    }
    if let (Some(_), scheme @ SchemeArg::Bounded(_)) = (volume.terminate, volume.scheme.unwrap_or_default()) {
        return Err(usage(format!(
            "--terminate: expected --scheme adaptive or fixed:N, found {scheme}, where the bound decides where rays end"
        )));
    }
    transfer::check(&args.transfer)
}

/// The isovalue in the precision of all comparisons.
pub(super) fn checked_isovalue(v: f64) -> Result<f32> {
    let rounded = v as f32;
    if rounded.is_finite() {
        Ok(rounded)
    } else {
        Err(usage(format!("--isovalue {v}: expected a finite number, of at most {:e}", f32::MAX)))
    }
}

/// Refuses pictures or statistics that could not be written, or would replace one of `inputs` or a transfer function.
pub(super) fn check_outputs(args: &RenderArgs, inputs: &[&Path], pictures: &[&Path]) -> Result<()> {
    let beside = [&args.transfer.tf, &args.surface.color_by];
    let beside = beside.into_iter().filter_map(|path| path.as_deref());
    let inputs: Vec<&Path> = inputs.iter().copied().chain(beside).collect();
    pictures.iter().try_for_each(|picture| check_output(picture, &inputs))?;
    match &args.stats {
        Some(Some(file)) if pictures.contains(&file.as_path()) => {
            Err(usage(format!("{}: given as the picture and as the --stats file", file.display())))
        }
        Some(Some(file)) => check_output(file, &inputs),
        Some(None) | None => Ok(()),
    }
}
