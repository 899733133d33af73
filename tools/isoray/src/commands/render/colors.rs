//! Surfaces coloured by a second volume.

use std::path::Path;

use anyhow::Result;
use glam::Vec3;
use isoray_cell::trilinear;
use isoray_grid::{Scalar, ScalarType};
use isoray_io::transfer::{Colormap, colormap};
use isoray_io::{Dataset, OpenOptions};
use isoray_octree::{AnyVolume, Meta, OctreeVolume, VolumeVisitor};
use isoray_render::ColorField;

use crate::cli::{InputArgs, RenderArgs};
use crate::failure::usage;
use crate::load::{is_octree_volume, load};
use crate::output::to_stdout;
use crate::transfer::DEFAULT_COLORMAP;

/// What colours surfaces.
pub(super) enum Colors {
    /// One value a sample, by a map from a range of values.
    Mapped { volume: Box<AnyVolume>, map: Colormap, range: [f32; 2] },
    /// Red, green and blue, each a volume of bytes.
    Rgb(Box<[AnyVolume; 3]>),
}

/// The colour where a value is not finite.
const NO_VALUE: Vec3 = Vec3::splat(0.2);

impl Colors {
    /// Opens what the flags name, if they name anything; it must lie on the lattice of the volume that is rendered.
    pub(super) fn open(args: &RenderArgs, meta: &Meta) -> Result<Option<Self>> {
        let Some(path) = &args.surface.color_by else { return Ok(None) };
        let colors = match components(path)? {
            3 => Self::rgb(args, path)?,
            _ => Self::mapped(args, path)?,
        };
        let found = match &colors {
            Self::Mapped { volume, .. } => volume.meta().dims,
            Self::Rgb(volumes) => volumes[0].meta().dims,
        };
        if found != meta.dims {
            return Err(usage(format!(
                "--color-by {}: expected {} samples, as in {}, found {found}",
                path.display(),
                meta.dims,
                args.file.display()
            )));
        }
        Ok(Some(colors))
    }

    fn mapped(args: &RenderArgs, path: &Path) -> Result<Self> {
        let map = colormap(args.surface.color_map.as_deref().unwrap_or(DEFAULT_COLORMAP))?;
        let volume = Box::new(load(path, &InputArgs::default())?.volume.octree(path)?);
        let range = match args.surface.color_range {
            Some(range) => range,
            None => {
                let range = volume.meta().range.map_or([0.0, 1.0], |range| range.map(|v| v as f32));
                let [low, high] = range;
                to_stdout(|out| {
                    writeln!(
                        out,
                        "colours from {low} to {high}, all values of {} (choose with --color-range)",
                        path.display()
                    )
                })?;
                range
            }
        };
        Ok(Self::Mapped { volume, map, range })
    }

    fn rgb(args: &RenderArgs, path: &Path) -> Result<Self> {
        for (flag, is_given) in [
            ("--color-map", args.surface.color_map.is_some()),
            ("--color-range", args.surface.color_range.is_some()),
        ] {
            if is_given {
                let path = path.display();
                return Err(usage(format!(
                    "{flag}: expected one value a sample in {path}, found red, green and blue"
                )));
            }
        }
        let component = |n: usize| {
            load(path, &InputArgs { component: Some(n), ..InputArgs::default() })?.volume.octree(path)
        };
        let volumes = [component(0)?, component(1)?, component(2)?];
        if volumes[0].scalar() != ScalarType::U8 {
            return Err(usage(format!(
                "--color-by {}: expected one value a sample, or three of u8, found three of {}",
                path.display(),
                volumes[0].scalar().name()
            )));
        }
        Ok(Self::Rgb(Box::new(volumes)))
    }
}

/// Values per sample of a file.
fn components(path: &Path) -> Result<u64> {
    if is_octree_volume(path, &InputArgs::default())? {
        return Ok(1);
    }
    let count =
        Dataset::open(path, &OpenOptions { component: Some(0), ..OpenOptions::default() })?.components();
    match count {
        1 | 3 => Ok(count),
        _ => Err(usage(format!(
            "--color-by {}: expected one value a sample, or three of u8, found {count}",
            path.display()
        ))),
    }
}

/// Samples at the corners of a cell.
struct Corners([u32; 3]);

impl VolumeVisitor for Corners {
    type Output = [f32; 8];

    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> [f32; 8] {
        volume.view().corners(self.0).map(T::to_f32)
    }
}

impl ColorField for Colors {
    fn color(&self, cell: [u32; 3], local: [f32; 3]) -> Vec3 {
        match self {
            Self::Mapped { volume, map, range: [low, high] } => {
                let corners = volume.visit(Corners(cell));
                if !corners.iter().all(|c| c.is_finite()) {
                    return NO_VALUE;
                }
                Vec3::from_array(map.at((trilinear(&corners, local) - low) / (high - low)))
            }
            Self::Rgb(volumes) => {
                let channel = |n: usize| {
                    let corners = volumes[n].visit(Corners(cell));
                    trilinear(&corners.map(|byte| decoded(byte / 255.0)), local)
                };
                Vec3::new(channel(0), channel(1), channel(2))
            }
        }
    }
}

/// Linear light of an sRGB component from 0 to 1 (IEC 61966-2-1).
fn decoded(display: f32) -> f32 {
    if display <= 0.04045 { display / 12.92 } else { ((display + 0.055) / 1.055).powf(2.4) }
}
