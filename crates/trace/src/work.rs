//! Counting the work of a ray.

/// What a traversal reports as it goes; `()` counts nothing and costs nothing.
pub trait Counters {
    /// A node, a cube of 4³ parts or a block was entered.
    fn node(&mut self);
    /// `n` samples were fetched.
    fn lookups(&mut self, n: u32);
    /// A cell that holds the isovalue was intersected.
    fn cell(&mut self);
}

impl Counters for () {
    #[inline(always)]
    fn node(&mut self) {}
    #[inline(always)]
    fn lookups(&mut self, _: u32) {}
    #[inline(always)]
    fn cell(&mut self) {}
}

/// Counts of the work done (Knoll 2009, Table 2: look-ups and intersections per ray).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Nodes, cubes and blocks entered.
    pub nodes: u64,
    /// Samples fetched.
    pub lookups: u64,
    /// Cells intersected.
    pub cells: u64,
}

impl Counters for Work {
    fn node(&mut self) {
        self.nodes += 1;
    }
    fn lookups(&mut self, n: u32) {
        self.lookups += u64::from(n);
    }
    fn cell(&mut self) {
        self.cells += 1;
    }
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.lookups += other.lookups;
        self.cells += other.cells;
    }
}
