//! Octree hashing (section 4.2, appendix B).

use isoray_grid::Scalar;

use super::{LEAF, MAX_DEPTH, PaperOctree, octant};

impl<T: Scalar> PaperOctree<T> {
    /// The sample at `dest`, from node `index` of `depth`, which holds it, down (B.1).
    #[inline(always)]
    fn point_locate(&self, dest: [i32; 3], mut depth: usize, mut index: usize) -> T {
        loop {
            let node = &self.nodes[depth][index];
            let child = octant(dest, self.child_bit_depth[depth]);
            let offset = node.child_offset[child];
            if offset == LEAF {
                return node.child_scalars[child];
            }
            index = node.child_start as usize + offset as usize;
            depth += 1;
            if depth == self.nodes.len() {
                return self.caps[index][octant(dest, 1)];
            }
        }
    }

    /// The sample at `dest`, by way of the deepest node on the way down to `start` that holds both;
    /// `parent_trace` has that way as far as `depth` (B.2).
    #[inline]
    pub(super) fn neighbor_find(
        &self,
        start: [i32; 3],
        dest: [i32; 3],
        depth: usize,
        parent_trace: &[u32; MAX_DEPTH],
    ) -> T {
        let differing = (start[0] ^ dest[0]) | (start[1] ^ dest[1]) | (start[2] ^ dest[2]);
        let mut up = depth;
        // A node holds both if they differ in no bit above the one that chooses among its children.
        while differing >= 2 * self.child_bit_depth[up] {
            up -= 1;
        }
        self.point_locate(dest, up, parent_trace[up] as usize)
    }

    /// The sample at lattice point `p`, which must be inside.
    pub fn sample(&self, p: [u32; 3]) -> T {
        self.point_locate(p.map(|c| c as i32), 0, 0)
    }
}
