//! Outlines of patches.

use glam::DVec3;
use isoray_amr::LevelBox;
use isoray_render::{Camera, Image, LEVEL_COLORS, Line, draw_lines};

use super::clipping::kept;
use crate::cli::RenderArgs;
use crate::mesh::MeshVolume;

/// Of lines over a volume, which has no depth: so that what is behind them is seen.
const OVER_VOLUME: f32 = 0.5;

/// Draws the outlines of the patches over the picture of a mesh.
pub(super) fn draw(args: &RenderArgs, mesh: &MeshVolume, camera: &Camera, image: &mut Image) {
    let mut boxes = mesh.mesh.outlines().to_vec();
    // Where edges of several levels lie on each other, that of the finest is drawn.
    boxes.sort_by_key(|of| of.exponent);
    let lines = boxes.iter().flat_map(|LevelBox { low, high, exponent }| {
        let corners = std::array::from_fn(|n| {
            let corner = std::array::from_fn(|a| f64::from([low, high][n >> a & 1][a]));
            mesh.meta.index_to_world.transform_point3(DVec3::from_array(corner))
        });
        Line::edges(&corners, LEVEL_COLORS[*exponent as usize % LEVEL_COLORS.len()])
    });
    let opacity = if args.volume.volume { OVER_VOLUME } else { 1.0 };
    draw_lines(image, camera, lines, &kept(&args.clip), opacity);
}
