//! Where a node or block lies.

use isoray_octree::MAX_LEVEL;
use wide::f64x4;

/// Bits of a coordinate in [`Place::packed`]: the largest axis has 2²¹ samples.
const BITS: u32 = 21;
const MASK: u64 = (1 << BITS) - 1;

/// The octants of a node: their low corners, packed, in units of their edge; and the directions of their centres.
const OCTANTS: [(u64, [f64; 4]); 8] = {
    let mut octants = [(0, [0.0; 4]); 8];
    let mut n = 0;
    while n < 8 {
        let [x, y, z] = [n as u64 & 1, n as u64 >> 1 & 1, n as u64 >> 2 & 1];
        let corner = x | y << BITS | z << (2 * BITS);
        octants[n] = (corner, [2.0 * x as f64 - 1.0, 2.0 * y as f64 - 1.0, 2.0 * z as f64 - 1.0, 0.0]);
        n += 1;
    }
    octants
};

/// Half the edge of a node or block, by level.
const HALF_EDGE: [f64; 32] = {
    let mut half = [0.5; 32];
    let mut level = 1;
    while level <= MAX_LEVEL as usize {
        half[level] = 2.0 * half[level - 1];
        level += 1;
    }
    half
};

/// Where a node or block lies, in both forms that are needed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// The low corner: whole numbers to look up with, in one word.
    packed: u64,
    /// The centre: floating-point numbers to compute planes with. The fourth lane is idle.
    pub(crate) center: f64x4,
}

impl Place {
    /// The root, of `level`.
    #[inline(always)]
    pub(crate) fn root(level: u32) -> Self {
        Self { packed: 0, center: f64x4::splat(HALF_EDGE[level as usize & 31]) }
    }

    /// The child `octant`, whose own level is `level`.
    #[inline(always)]
    pub(crate) fn child(self, level: u32, octant: u32) -> Self {
        let (corner, direction) = OCTANTS[octant as usize & 7];
        let half = f64x4::splat(HALF_EDGE[level as usize & 31]);
        Self {
            packed: self.packed | corner << level,
            center: f64x4::new(direction).mul_add(half, self.center),
        }
    }

    /// The mid-planes of the lower and of the upper children of the node of `level` that lies here.
    #[inline(always)]
    pub(crate) fn child_planes(self, level: u32) -> [f64x4; 2] {
        let quarter = f64x4::splat(HALF_EDGE[level as usize & 31]) * f64x4::splat(0.5);
        [self.center - quarter, self.center + quarter]
    }

    /// Lattice coordinates of the low corner.
    #[inline(always)]
    pub(crate) fn corner(self) -> [u32; 3] {
        [self.packed & MASK, self.packed >> BITS & MASK, self.packed >> (2 * BITS) & MASK].map(|c| c as u32)
    }
}
