//! Which cells of adaptive meshes a camera resolves.

use glam::{DAffine3, DVec3};
use isoray_amr::{MeshError, Patches};
use isoray_octree::lod::PixelWidth;

/// Coarser patches wherever cells of a coarser level are at most `ratio` pixels wide, so that a mesh of them is for this view alone; zero: as they are.
///
/// A cell is as wide as its longest edge in the world, and a pixel in a box of cells as it is at the point of the box's hull along the world's axes that is nearest to the eye. So levels
/// are those that a structured volume of the finest cells has at this ratio ([`Detail`](isoray_octree::lod::Detail)), down to level 0 of the mesh, but for the boxes, which are others.
///
/// # Errors
/// As [`Patches::coarsened`].
pub fn mesh_detail(patches: Patches, pixel: PixelWidth, ratio: f64) -> Result<Patches, MeshError> {
    if ratio <= 0.0 {
        return Ok(patches);
    }
    let to_world = patches.index_to_world;
    let axes = to_world.matrix3;
    let longest = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length).into_iter().fold(0.0, f64::max);
    let mut edges = vec![longest];
    for &ratio in &patches.ratios {
        edges.push(edges[edges.len() - 1] / f64::from(ratio));
    }
    patches.coarsened(|level, place| {
        let width = match pixel {
            PixelWidth::PerDistance(width, eye) => width * distance(&to_world, place, eye),
            PixelWidth::Constant(width) => width,
        };
        edges[level as usize] <= ratio * width
    })
}

/// From a point of the world to the hull, along its axes, of a box.
fn distance(to_world: &DAffine3, corners: [[f64; 3]; 2], from: DVec3) -> f64 {
    let corner = |n: usize| DVec3::from_array(std::array::from_fn(|a| corners[n >> a & 1][a]));
    let corners: [DVec3; 8] = std::array::from_fn(|n| to_world.transform_point3(corner(n)));
    let low = corners.into_iter().fold(DVec3::INFINITY, DVec3::min);
    let high = corners.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max);
    from.distance(from.clamp(low, high))
}

#[cfg(test)]
mod tests {
    use isoray_amr::{Centering, Patch};

    use super::*;

    /// Columns of eight boxes along x, of level 1 in level 0, in a world whose axes are stretched and turned.
    fn patches() -> Patches {
        let patch = |level, x: u32, cells: [u32; 3]| {
            let low = [x as i32, 0, 0];
            Patch { level, low, cells, values: vec![x as f32; cells.iter().product::<u32>() as usize].into() }
        };
        let coarse = patch(0, 0, [16, 2, 2]);
        let turned = DAffine3::from_rotation_z(std::f64::consts::FRAC_PI_2);
        Patches {
            centering: Centering::Cells,
            ratios: vec![2],
            index_to_world: turned * DAffine3::from_scale(DVec3::new(0.5, 1.0, 0.25)),
            domain: ([0; 3], [16, 2, 2]),
            patches: std::iter::once(coarse).chain((0..8).map(|n| patch(1, 4 * n, [4; 3]))).collect(),
        }
    }

    fn fine(pixel: PixelWidth, ratio: f64) -> Vec<i32> {
        let left = mesh_detail(patches(), pixel, ratio).unwrap();
        left.patches.iter().filter(|patch| patch.level == 1).map(|patch| patch.low[0]).collect()
    }

    #[test]
    fn boxes_go_where_coarser_cells_are_small_enough() {
        // Boxes begin at 0, 1, … along y, where a cell of level 0 is 1 wide; in the world the domain is from −2 to 0 along x.
        let eye = DVec3::new(-1.0, -1.0, 0.25);
        let pixel = PixelWidth::PerDistance(0.25, eye);
        assert_eq!(fine(pixel, 0.0).len(), 8);
        // At a distance of 4 a pixel is 1 wide, as the cells are.
        assert_eq!(fine(pixel, 1.0), [0, 4, 8]);
        assert_eq!(fine(pixel, 2.0), [0]);
        assert_eq!(fine(pixel, 4.0), [0i32; 0]);
        assert_eq!(fine(PixelWidth::Constant(0.5), 1.9).len(), 8);
        assert!(fine(PixelWidth::Constant(0.5), 2.0).is_empty());
        // From inside of a box.
        let inside = PixelWidth::PerDistance(0.25, DVec3::new(-1.0, 3.5, 0.25));
        assert_eq!(fine(inside, 1e6), [12]);
    }
}
