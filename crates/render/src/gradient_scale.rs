//! The scale of gradients of a volume.

use glam::{DAffine3, DVec3};
use isoray_cell::gradient;
use rayon::prelude::*;

use crate::source::VolumeSource;

/// Cells that are looked at, at most, but for rounding along each axis.
const CELLS: f64 = 262_144.0;

/// Share of the cells that are less steep.
const PERCENTILE: f64 = 0.99;

/// The 99th percentile of `|∇s|` per world unit, at the centres of cells spread evenly over the volume, among those where it is not zero (in
/// a volume that is mostly empty it would be zero itself). 1 if there is none.
pub fn gradient_scale(volume: &impl VolumeSource, index_to_world: DAffine3) -> f64 {
    let to_world = index_to_world.matrix3.inverse().transpose();
    let cells = volume.dims().axes().map(|n| n.saturating_sub(1));
    let all: f64 = cells.iter().map(|&n| f64::from(n)).product();
    let stride = (all / CELLS).cbrt().ceil().max(1.0) as u32;
    let along = |a: usize| (stride / 2..cells[a].max(1)).step_by(stride as usize);
    let row = |z: u32| {
        let mut steep = Vec::new();
        for y in along(1) {
            for x in along(0) {
                let slope = gradient(&volume.corners([x, y, z]).map(f64::from), [0.5; 3]);
                let steepness = (to_world * DVec3::from_array(slope)).length();
                if steepness.is_finite() && steepness > 0.0 {
                    steep.push(steepness);
                }
            }
        }
        steep
    };
    if cells.contains(&0) {
        return 1.0;
    }
    let mut steep: Vec<f64> = along(2).collect::<Vec<_>>().into_par_iter().flat_map_iter(row).collect();
    steep.sort_unstable_by(f64::total_cmp);
    let at = (steep.len() as f64 * PERCENTILE) as usize;
    steep.get(at).copied().unwrap_or(1.0)
}
