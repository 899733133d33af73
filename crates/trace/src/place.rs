//! Where a node or block lies.

use isoray_grid::MAX_AXIS;
use isoray_octree::{CAP_EDGE, MAX_LEVEL};
use wide::f64x4;

use crate::corner::Corner;

/// A quarter of the edge of a node, by its level.
const QUARTER_EDGE: [f64; 32] = {
    let mut quarter = [0.25; 32];
    let mut level = 1;
    while level <= MAX_LEVEL as usize {
        quarter[level] = 2.0 * quarter[level - 1];
        level += 1;
    }
    quarter
};

/// The centre of the root, of `level`.
#[inline(always)]
pub(crate) fn root_center(level: u32) -> f64x4 {
    f64x4::splat(2.0 * QUARTER_EDGE[level as usize & 31])
}

/// The coordinates of the centres of the children of the node of `level` around `center`: on this side and on the far side, along
/// `step`, of its mid-planes.
#[inline(always)]
pub(crate) fn child_centers(center: f64x4, level: u32, step: f64x4) -> [f64x4; 2] {
    let quarter = step * f64x4::splat(QUARTER_EDGE[level as usize & 31]);
    [center - quarter, center + quarter]
}

/// Where a block lies, in both forms that are needed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// The low corner: whole numbers to look up with.
    corner: Corner,
    /// The centre: floating-point numbers to compute planes with. The fourth lane is idle.
    pub(crate) center: f64x4,
}

impl Place {
    /// The block around `center`.
    #[inline(always)]
    pub(crate) fn around(center: f64x4) -> Self {
        /// In a number from here to twice that the lowest bits count units.
        const UNITS: f64 = (1u64 << (f64::MANTISSA_DIGITS - 1)) as f64;
        let low = center + f64x4::splat(UNITS - f64::from(CAP_EDGE / 2));
        let [x, y, z, _] = low.to_array().map(|c| c.to_bits() as u32);
        Self { corner: Corner::new([x, y, z].map(|c| c & (MAX_AXIS - 1))), center }
    }

    /// Not zero, and different for different places.
    #[inline(always)]
    pub(crate) fn key(self) -> u64 {
        self.corner.0 | 1
    }

    /// Lattice coordinates of the low corner.
    #[inline(always)]
    pub(crate) fn corner(self) -> [u32; 3] {
        self.corner.coordinates()
    }
}
