//! What the pictures of a series have in common.

use anyhow::Result;
use isoray_preint::{TransferFunction, Visibility};
use isoray_render::{Camera, Surface};

use super::colors::Colors;
use super::{lighting, surface, view, volume};
use crate::cli::RenderArgs;
use crate::load::Data;

/// All that is chosen for a volume where flags leave it open; one look shows several volumes alike.
pub(super) struct Look {
    pub(super) camera: Camera,
    pub(super) shown: Shown,
}

/// What is shown of a volume.
pub(super) enum Shown {
    Surface(SurfaceLook),
    Volume(Box<VolumeLook>),
}

pub(super) struct SurfaceLook {
    pub(super) surfaces: Vec<Surface>,
    pub(super) colors: Option<Colors>,
}

pub(super) struct VolumeLook {
    pub(super) transfer: TransferFunction,
    pub(super) visible: Visibility,
    /// `None` where nothing is shaded.
    pub(super) gradient_scale: Option<f64>,
}

impl Look {
    /// Chooses it for this volume; says what was proposed of what was not given.
    pub(super) fn new(args: &RenderArgs, volume: &Data) -> Result<Self> {
        let meta = volume.meta();
        let camera = view::camera(args, meta.dims, &meta.index_to_world)?;
        let shown = match args.volume.volume {
            false => Shown::Surface(SurfaceLook {
                surfaces: surface::surfaces(args, meta)?,
                colors: Colors::open(args, meta)?,
            }),
            true => {
                let transfer = volume::transfer(args, meta)?;
                let visible = Visibility::new(&transfer);
                let gradient_scale = lighting::scale(args, volume)?;
                Shown::Volume(Box::new(VolumeLook { transfer, visible, gradient_scale }))
            }
        };
        Ok(Self { camera, shown })
    }
}
