//! Level of detail of adaptive meshes.

use std::path::Path;

use anyhow::{Context, Result};
use isoray_amr::Patches;
use isoray_render::{Camera, mesh_detail};

use super::view;
use crate::cli::RenderArgs;
use crate::load::{Loaded, load_prepared};
use crate::mesh::no_mesh;

/// Opens a volume for this view alone: a mesh has the levels that `--lod` wants. Without a camera it is the one that the flags describe.
pub(super) fn load(path: &Path, args: &RenderArgs, camera: Option<&Camera>) -> Result<Loaded> {
    let ratio = args.surface.lod;
    let prepare = |patches: Patches| {
        let camera = match camera {
            Some(camera) => *camera,
            None => {
                let (dims, index_to_world) = patches.lattice().with_context(|| no_mesh(path))?;
                view::camera(args, dims, &index_to_world)?
            }
        };
        mesh_detail(patches, camera.pixel_width(), ratio).with_context(|| no_mesh(path))
    };
    load_prepared(path, &args.source, if ratio > 0.0 { Some(&prepare) } else { None })
}
