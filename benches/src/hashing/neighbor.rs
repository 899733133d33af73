//! From one lattice point to the next: up to a node that holds both, and down.

use isoray_grid::Scalar;
use isoray_octree::{Block, NODE_LEVEL};

use super::{Trail, Tree, Visits};

impl<'a, T: Scalar> Tree<'a, T> {
    /// Up as long as a bit of the codes differs, axis by axis: the codes of neighbours differ in a run of bits.
    #[inline(always)]
    pub(super) fn step_by_codes(
        &self,
        trail: &Trail<T>,
        [from, to]: [[u32; 3]; 2],
        visits: &mut impl Visits,
    ) -> Block<'a, T> {
        let mut level = trail.level;
        for a in 0..3 {
            let differing = from[a] ^ to[a];
            visits.up();
            while differing & 1 << level != 0 {
                visits.up();
                level += 1;
            }
        }
        if level == trail.level && level >= NODE_LEVEL {
            return Block::constant(trail.value);
        }
        let level = level.max(NODE_LEVEL);
        self.by_codes(self.node_on(trail, self.depth(level)), level, to, visits)
    }

    /// Up from the last node of the trail until the coordinates agree (2006, B.2) above the bit that chooses among a node's children: the listing compares that bit
    /// alone, and so goes a level too far, and is right only if all higher bits agree.
    #[inline(always)]
    pub(super) fn step_by_masks(
        &self,
        trail: &Trail<T>,
        [from, to]: [[u32; 3]; 2],
        visits: &mut impl Visits,
    ) -> Block<'a, T> {
        let mut depth = trail.depth;
        loop {
            visits.up();
            let above = !(2 * self.child_bit_depth[depth] - 1);
            let agrees = |a: usize| from[a] & above == to[a] & above;
            if depth == 0 || (agrees(0) && agrees(1) && agrees(2)) {
                return self.by_masks(self.node_on(trail, depth), depth, to, visits);
            }
            depth -= 1;
        }
    }

    /// Up to the level of the highest bit that differs.
    #[inline(always)]
    pub(super) fn step_by_jump(
        &self,
        trail: &Trail<T>,
        [from, to]: [[u32; 3]; 2],
        visits: &mut impl Visits,
    ) -> Block<'a, T> {
        let differing = (from[0] ^ to[0]) | (from[1] ^ to[1]) | (from[2] ^ to[2]);
        let level = (u32::BITS - differing.leading_zeros()).max(NODE_LEVEL);
        visits.up();
        if level <= trail.level {
            return Block::constant(trail.value);
        }
        self.by_codes(self.node_on(trail, self.depth(level)), level, to, visits)
    }
}
