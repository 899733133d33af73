//! Counting the work of a ray.

/// What a traversal reports as it goes; `()` counts nothing and costs nothing.
pub trait Counters {
    /// A node, a cube of 4³ parts or a block was entered.
    fn node(&mut self);
    /// `n` samples were fetched.
    fn lookups(&mut self, n: u32);
    /// A cell that holds the isovalue was intersected.
    fn cell(&mut self);
    /// A cell that holds the isovalue may be met by rays of a packet, which are now intersected with it.
    fn packet_cell(&mut self);
    /// Rays went together; `is_background`: to no block with surface.
    fn packet(&mut self, is_background: bool);
    /// So many primary rays went one by one.
    fn alone(&mut self, rays: usize);
    /// It was asked whether a light reaches a point; `is_traced`: a ray had to tell.
    fn shadow(&mut self, is_traced: bool);
}

impl Counters for () {
    #[inline(always)]
    fn node(&mut self) {}
    #[inline(always)]
    fn lookups(&mut self, _: u32) {}
    #[inline(always)]
    fn cell(&mut self) {}
    #[inline(always)]
    fn packet_cell(&mut self) {}
    #[inline(always)]
    fn packet(&mut self, _: bool) {}
    #[inline(always)]
    fn alone(&mut self, _: usize) {}
    #[inline(always)]
    fn shadow(&mut self, _: bool) {}
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
    /// Cells intersected with a packet, whatever the number of its rays that may meet them.
    pub packet_cells: u64,
    /// Packets of primary rays; and those of them that were led to no block with surface, so that no ray was looked at there.
    pub packets: u64,
    /// See [`packets`](Self::packets).
    pub background_packets: u64,
    /// Primary rays that were not of a packet.
    pub alone: u64,
    /// Rays to lights.
    pub shadow_rays: u64,
    /// Lights, at points, of which it was known without a ray that they are hidden: behind the surface itself.
    pub spared_shadow_rays: u64,
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
    fn packet_cell(&mut self) {
        self.packet_cells += 1;
    }
    fn packet(&mut self, is_background: bool) {
        self.packets += 1;
        self.background_packets += u64::from(is_background);
    }
    fn alone(&mut self, rays: usize) {
        self.alone += rays as u64;
    }
    fn shadow(&mut self, is_traced: bool) {
        *(if is_traced { &mut self.shadow_rays } else { &mut self.spared_shadow_rays }) += 1;
    }
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.lookups += other.lookups;
        self.cells += other.cells;
        self.packet_cells += other.packet_cells;
        self.packets += other.packets;
        self.background_packets += other.background_packets;
        self.alone += other.alone;
        self.shadow_rays += other.shadow_rays;
        self.spared_shadow_rays += other.spared_shadow_rays;
    }
}
