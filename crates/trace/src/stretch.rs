//! A ray's exact stretches in the cells of a block.

use isoray_cell::Segment;
use wide::f64x4;

use crate::corner::Corner;
use crate::ray::{ClippedRay, least};

/// Planes across each axis of a block.
const PLANES: usize = 5;

/// From a block's low corner to those of its cells.
const CELL_CORNERS: [[f64; 4]; 64] = {
    let mut corners = [[0.0; 4]; 64];
    let mut n = 0;
    while n < 64 {
        corners[n] = [(n & 3) as f64, (n >> 2 & 3) as f64, (n >> 4) as f64, 0.0];
        n += 1;
    }
    corners
};

/// Where a ray crosses the planes of a block's cells. All of them at once, so that what is left to do for a cell is to look them up.
pub(crate) struct Crossings {
    /// The first across each axis is the one that the ray enters the block by, whichever way it runs.
    at: [[f64; 4]; PLANES],
    low: f64x4,
}

/// A stretch in one cell.
pub(crate) struct Stretch {
    /// Where the ray crosses the cell's planes.
    near: f64x4,
    far: f64x4,
    /// The cell's low corner.
    low: f64x4,
    pub(crate) interval: [f64; 2],
}

impl Crossings {
    #[inline(always)]
    pub(crate) fn new(ray: &ClippedRay, corner: Corner) -> Self {
        let [x, y, z] = corner.coordinates().map(f64::from);
        let low = f64x4::new([x, y, z, 0.0]);
        let first = f64x4::splat((PLANES - 1) as f64).mul_add(ray.behind, low);
        let plane = |n: usize| f64x4::splat(n as f64).mul_add(ray.step, first);
        Self { at: std::array::from_fn(|n| ray.crossings(plane(n)).to_array()), low }
    }

    /// The stretch in the cell of this number in the order of the ray and this offset in that of the lattice; of no length if the ray does not
    /// pass through it, or only touches it.
    ///
    /// Along each axis it is between two planes from the crossing of the one until that of the other, and in the cell as long as that holds for all
    /// three.
    #[inline(always)]
    pub(crate) fn stretch(&self, ray: &ClippedRay, number: u32, offset: u32) -> Stretch {
        let n = number as usize;
        let [i, j, k] = [n & 3, n >> 2 & 3, n >> 4 & 3];
        let (near_x, near_y, near_z) = (self.at[i][0], self.at[j][1], self.at[k][2]);
        let (far_x, far_y, far_z) = (self.at[i + 1][0], self.at[j + 1][1], self.at[k + 1][2]);
        let begin = -least(least(-near_x, -near_y), least(-near_z, -ray.t_begin));
        let end = least(least(far_x, far_y), least(far_z, ray.t_end));
        Stretch {
            near: f64x4::new([near_x, near_y, near_z, f64::NEG_INFINITY]),
            far: f64x4::new([far_x, far_y, far_z, f64::INFINITY]),
            low: self.low + f64x4::new(CELL_CORNERS[offset as usize & 63]),
            interval: [begin, end],
        }
    }
}

impl Stretch {
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.interval[0] >= self.interval[1]
    }

    /// Cell-local.
    #[inline(always)]
    pub(crate) fn segment(&self, ray: &ClippedRay) -> Segment {
        let [begin, end] = self.interval;
        let entered = self.near.simd_eq(f64x4::splat(begin));
        let left = self.far.simd_eq(f64x4::splat(end));
        Segment {
            entry: ray.local(self.low, begin, entered, ray.behind),
            exit: ray.local(self.low, end, left, ray.ahead),
        }
    }
}
