//! Where a node or block lies.

use wide::f64x4;

/// Bits of a coordinate in [`Place::packed`]: the largest axis has 2²¹ samples.
const BITS: u32 = 21;
const MASK: u64 = (1 << BITS) - 1;

/// Low corners of the octants of a unit cube: packed, and as numbers.
const OCTANTS: [(u64, [f64; 4]); 8] = {
    let mut octants = [(0, [0.0; 4]); 8];
    let mut n = 0;
    while n < 8 {
        let [x, y, z] = [n as u64 & 1, n as u64 >> 1 & 1, n as u64 >> 2 & 1];
        octants[n] = (x | y << BITS | z << (2 * BITS), [x as f64, y as f64, z as f64, 0.0]);
        n += 1;
    }
    octants
};

/// The low corner of a node or block, in both forms that are needed: whole numbers to look up with, in one word, and floating-point numbers
/// to compute planes with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    packed: u64,
    /// The fourth lane is idle.
    pub(crate) base: f64x4,
}

impl Place {
    /// The low corner of the domain.
    pub(crate) const ORIGIN: Self = Self { packed: 0, base: f64x4::ZERO };

    /// The child `octant`, whose own level is `level`.
    #[inline(always)]
    pub(crate) fn child(self, level: u32, octant: u32) -> Self {
        let (packed, corner) = OCTANTS[octant as usize & 7];
        Self { packed: self.packed | packed << level, base: self.base + f64x4::new(corner) * edge(level) }
    }

    /// Lattice coordinates.
    #[inline(always)]
    pub(crate) fn corner(self) -> [u32; 3] {
        [self.packed & MASK, self.packed >> BITS & MASK, self.packed >> (2 * BITS) & MASK].map(|c| c as u32)
    }

    /// Lattice coordinates of the parent of what lies here on `level`.
    #[inline(always)]
    pub(crate) fn parent(self, level: u32) -> [u32; 3] {
        self.corner().map(|c| c & !(1 << level))
    }

    /// The mid-planes of a node of `level`.
    #[inline(always)]
    pub(crate) fn planes(self, level: u32) -> f64x4 {
        self.base + edge(level - 1)
    }

    /// The mid-planes of its lower and of its upper children.
    #[inline(always)]
    pub(crate) fn child_planes(self, level: u32) -> [f64x4; 2] {
        let quarter = edge(level) * f64x4::splat(0.25);
        [self.base + quarter, self.base + f64x4::splat(3.0) * quarter]
    }
}

/// The edge of a node of `level`, in each lane.
#[inline(always)]
fn edge(level: u32) -> f64x4 {
    f64x4::splat(f64::from(1i32 << level))
}
