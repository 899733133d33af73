//! Flags that make no sense for any volume: refused before one is read.

use std::path::Path;

use anyhow::Result;

use super::view::check_camera;
use super::write::Format;
use crate::cli::{RenderArgs, SchemeArg, ShadingArg};
use crate::failure::usage;
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
        ("--structure", volume.structure.is_some()),
        ("--terminate", volume.terminate.is_some()),
    ];
    match given(&of_volumes) {
        Some(flag) => {
            Err(usage(format!("{flag}: expected --volume beside it, found an isosurface to render")))
        }
        None => args.isovalue.map_or(Ok(()), |v| checked_isovalue(v).map(drop)),
    }
}

/// Refuses what only isosurfaces have, and what contradicts itself.
fn check_volume(args: &RenderArgs) -> Result<()> {
    let volume = &args.volume;
    let of_surfaces = [("--isovalue", args.isovalue.is_some()), ("--normals", args.normals.is_some())];
    if let Some(flag) = given(&of_surfaces) {
        return Err(usage(format!("{flag}: expected an isosurface to render, found --volume")));
    }
    let of_shading =
        [("--gradient-scale", volume.gradient_scale.is_some()), ("--light", args.light.is_some())];
    if let Some(flag) = given(&of_shading).filter(|_| volume.shading == Some(ShadingArg::None)) {
        return Err(usage(format!("{flag}: expected --shading diffuse or specular, found none")));
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
    let inputs: Vec<&Path> = inputs.iter().copied().chain(args.transfer.tf.as_deref()).collect();
    pictures.iter().try_for_each(|picture| check_output(picture, &inputs))?;
    match &args.stats {
        Some(Some(file)) if pictures.contains(&file.as_path()) => {
            Err(usage(format!("{}: given as the picture and as the --stats file", file.display())))
        }
        Some(Some(file)) => check_output(file, &inputs),
        Some(None) | None => Ok(()),
    }
}
