//! From camera flags to a view.

use anyhow::Result;
use glam::{DAffine3, DVec3};
use isoray_grid::Dims;
use isoray_render::{Camera, Projection, View, frame_all};

use crate::cli::RenderArgs;
use crate::failure::usage;

/// Where the default camera looks from: somewhat from the side and above, at what is the front in the usual
/// orientation of medical data.
const DEFAULT_DIRECTION: DVec3 = DVec3::new(0.5, 0.8, -0.35);

/// Refuses camera flags and sizes that make no sense for any volume, before one is read.
pub(super) fn check_camera(args: &RenderArgs) -> Result<()> {
    let flags = &args.camera;
    let projection = projection(args);
    let new = |eye, look_at, up| {
        Camera::new(&View { eye, look_at, up, projection }, args.size).map_err(|e| usage(e.to_string()))
    };
    // Size and opening first, from a place where nothing else can be wrong.
    new(-DEFAULT_DIRECTION, DVec3::ZERO, DEFAULT_DIRECTION.any_orthogonal_vector())?;
    match (flags.eye, flags.look_at) {
        (Some(eye), Some(look_at)) => new(eye, look_at, flags.up)?,
        // Which way such an eye looks is up to the volume.
        (Some(_), None) => return Ok(()),
        (None, _) => new(-DEFAULT_DIRECTION, DVec3::ZERO, flags.up)?,
    };
    Ok(())
}

/// The camera that the flags describe; what they leave open is chosen to show the whole volume.
pub(super) fn camera(args: &RenderArgs, dims: Dims, index_to_world: &DAffine3) -> Result<Camera> {
    Camera::new(&view(args, dims, index_to_world), args.size).map_err(|e| usage(e.to_string()))
}

/// The middle of the domain, in the world.
pub(super) fn centre(dims: Dims, index_to_world: &DAffine3) -> DVec3 {
    let last = DVec3::from_array(dims.axes().map(|n| f64::from(n - 1)));
    index_to_world.transform_point3(last / 2.0)
}

fn projection(args: &RenderArgs) -> Projection {
    match args.camera.ortho_height {
        Some(height) => Projection::Orthographic { height },
        None => Projection::Perspective { fov: args.camera.fov },
    }
}

fn view(args: &RenderArgs, dims: Dims, index_to_world: &DAffine3) -> View {
    let flags = &args.camera;
    let projection = projection(args);
    let look_at = flags.look_at.unwrap_or_else(|| centre(dims, index_to_world));
    let default = View { eye: look_at - DEFAULT_DIRECTION, look_at, up: flags.up, projection };
    match flags.eye {
        Some(eye) => View { eye, ..default },
        None => {
            let framed = frame_all(&default, args.size, dims, index_to_world);
            // A look-at point of the user's own is kept: the camera moves along with it.
            View { eye: look_at + (framed.eye - framed.look_at), ..default }
        }
    }
}
