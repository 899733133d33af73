//! Coarse samples on the upper faces of scalar leaves.

use isoray_grid::Scalar;

use crate::fidelity::Coarse;
use crate::geometry::{CAP_EDGE, NODE_LEVEL, child_origin, octant_of};
use crate::node::{Node, Range};
use crate::view::OctreeView;

/// What lies beside a leaf.
enum Beside<'a, T: Scalar> {
    Node(&'a Node<T::Stored>, u32),
    Constant(T),
    Cap,
    Nothing,
}

impl<'a, T: Scalar> OctreeView<'a, T> {
    /// Extends `range` by the coarse samples of levels 1 to `level` on the upper faces of the cube of edge `2^level` at `origin`: all there are
    /// in its closed box, if it is uniform. Takes time in proportion to the structure there.
    pub(super) fn include_faces(&self, level: u32, origin: [u32; 3], kind: Coarse, range: &mut Range<T>) {
        for direction in 1..8u32 {
            let corner = std::array::from_fn(|a| origin[a] + ((direction >> a & 1) << level));
            if self.dims().contains(corner) {
                range.include(self.coarse(level, corner, kind));
                let beside = self.region(level, corner);
                self.include_coarse_face(&beside, corner, direction, kind, range);
            }
        }
    }

    /// The region of `level` ≥ [`NODE_LEVEL`] at `p`, which is in the domain.
    fn region(&self, level: u32, p: [u32; 3]) -> Beside<'a, T> {
        let Some(mut node) = self.root() else { return Beside::Nothing };
        let mut above = self.root_level();
        while above > level {
            let octant = octant_of(p, above);
            if !node.is_stored(octant) {
                return Beside::Constant(node.value(octant));
            }
            above -= 1;
            match self.nodes(above).get(node.child(octant)) {
                Some(next) => node = next,
                None => return Beside::Nothing,
            }
        }
        Beside::Node(node, above)
    }

    /// Extends `range` by the coarse samples of a region at its low side along the axes of `direction`.
    fn include_coarse_face(
        &self,
        beside: &Beside<'a, T>,
        origin: [u32; 3],
        direction: u32,
        kind: Coarse,
        range: &mut Range<T>,
    ) {
        match *beside {
            Beside::Nothing => {}
            Beside::Constant(value) => range.include(value),
            Beside::Cap => {
                for octant in (0..8u32).filter(|octant| octant & direction == 0) {
                    let p = std::array::from_fn(|a| origin[a] + CAP_EDGE / 2 * (octant >> a & 1));
                    if self.dims().contains(p) {
                        range.include(self.coarse(1, p, kind));
                    }
                }
            }
            Beside::Node(node, level) => {
                for octant in (0..8u32).filter(|octant| octant & direction == 0) {
                    let corner = child_origin(origin, level, octant);
                    if !self.dims().contains(corner) {
                        continue;
                    }
                    range.include(node.value(octant));
                    let child = match node.is_stored(octant) {
                        false => continue,
                        true if level == NODE_LEVEL => Beside::Cap,
                        true => match self.nodes(level - 1).get(node.child(octant)) {
                            Some(node) => Beside::Node(node, level - 1),
                            None => Beside::Nothing,
                        },
                    };
                    self.include_coarse_face(&child, corner, direction, kind, range);
                }
            }
        }
    }
}
