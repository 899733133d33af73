//! Boxes of the finest lattice.

/// A box, from its low to its high corner, in edges of the finest cells from the domain's low corner. It has a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Cuboid {
    pub(crate) low: [u32; 3],
    pub(crate) high: [u32; 3],
}

impl Cuboid {
    /// What both have in common, if that has a volume.
    pub(crate) fn common(&self, other: &Self) -> Option<Self> {
        let low: [u32; 3] = std::array::from_fn(|a| self.low[a].max(other.low[a]));
        let high: [u32; 3] = std::array::from_fn(|a| self.high[a].min(other.high[a]));
        (0..3).all(|a| low[a] < high[a]).then_some(Self { low, high })
    }

    /// Whether both have a point in common, be it of their surfaces.
    #[inline]
    pub(crate) fn touches(&self, other: &Self) -> bool {
        (0..3).all(|a| self.low[a] <= other.high[a] && other.low[a] <= self.high[a])
    }

    pub(crate) fn edges(&self) -> [u32; 3] {
        std::array::from_fn(|a| self.high[a] - self.low[a])
    }

    pub(crate) fn volume(&self) -> u64 {
        self.edges().iter().map(|&n| u64::from(n)).product()
    }

    /// Half of its surface.
    pub(crate) fn half_surface(&self) -> f64 {
        let [x, y, z] = self.edges().map(f64::from);
        x * y + y * z + z * x
    }

    /// The parts on both sides of a plane that cuts it.
    pub(crate) fn split(&self, axis: usize, plane: u32) -> [Self; 2] {
        let (mut below, mut above) = (*self, *self);
        (below.high[axis], above.low[axis]) = (plane, plane);
        [below, above]
    }
}
