//! Verifying a structure node by node.

use isoray_grid::Scalar;

use crate::geometry::{CAP_LEVEL, CAP_UNIT, MAX_LEVEL, NODE_LEVEL, child_origin, extent, product};
use crate::node::{Node, Range};
use crate::view::OctreeView;

/// A node that breaks the structure's rules.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("level {level}, element {index}: {what}")]
pub struct Malformed {
    /// Level of the node; 2 is the caps'.
    pub level: u32,
    /// Its index.
    pub index: usize,
    /// The rule it breaks.
    pub what: &'static str,
}

/// Verifies every node: each stored element is linked to exactly once, ranges bound the samples of the
/// cells and are tight, values are those of the low corners.
///
/// # Errors
/// A node that breaks a rule.
pub fn check_well_formed<T: Scalar>(view: &OctreeView<'_, T>) -> Result<(), Malformed> {
    let root_level = view.root_level();
    let root = view.root().ok_or(Malformed { level: root_level, index: 0, what: "the root is missing" })?;
    let mut checker = Checker { view, claimed: claims(view) };
    let claimed = checker.claim(root_level, 0, 1);
    debug_assert!(claimed, "the first claim of all cannot collide");
    checker.node(root, root_level, 0, [0; 3])?;
    for (level, claims) in (0..).zip(&checker.claimed) {
        if let Some(index) = claims.iter().position(|&c| !c) {
            return Err(Malformed { level, index, what: "nothing links to it" });
        }
    }
    Ok(())
}

/// By level, one flag for every node; at the caps' level one for every [`CAP_UNIT`] samples.
fn claims<T: Scalar>(view: &OctreeView<'_, T>) -> Vec<Vec<bool>> {
    let count = |level| match level {
        CAP_LEVEL => view.caps().len().div_ceil(CAP_UNIT),
        _ => view.nodes(level).len(),
    };
    (0..=MAX_LEVEL).map(|level| vec![false; count(level)]).collect()
}

/// Depth-first verification.
struct Checker<'v, 'a, T: Scalar> {
    view: &'v OctreeView<'a, T>,
    /// Which elements have been linked to, by level.
    claimed: Vec<Vec<bool>>,
}

impl<T: Scalar> Checker<'_, '_, T> {
    fn node(
        &mut self,
        node: &Node<T::Stored>,
        level: u32,
        index: usize,
        origin: [u32; 3],
    ) -> Result<(), Malformed> {
        let error = |what| Err(Malformed { level, index, what });
        if node.mask != 0 && !self.claim_children(node, level, origin) {
            return error("a link leads outside its array or to what another node links to");
        }
        for octant in 0..8 {
            let corner = child_origin(origin, level, octant);
            let inside = self.view.dims().contains(corner);
            if node.is_stored(octant) && !inside {
                return error("a child outside the domain is stored");
            }
            if inside && !self.view.sample(corner).same_bits(node.values[octant as usize].into()) {
                return error("a child's value is not that of its low corner");
            }
            let expected = if node.is_stored(octant) && level > NODE_LEVEL {
                let child_index = node.child(octant);
                let Some(child) = self.view.nodes(level - 1).get(child_index) else {
                    return error("a link leads outside its array");
                };
                self.node(child, level - 1, child_index, corner)?;
                (0..8).map(|n| child.range(n)).fold(Range::EMPTY, Range::union)
            } else {
                self.leaf_range(corner, level - 1, node.is_stored(octant))
            };
            if expected != node.range(octant as usize) {
                return error("a child's range is not that of its samples");
            }
        }
        Ok(())
    }

    /// Claims the stored children of `node`; false if one is outside its array or claimed already.
    fn claim_children(&mut self, node: &Node<T::Stored>, level: u32, origin: [u32; 3]) -> bool {
        let first = node.first.get() as usize;
        if level > NODE_LEVEL {
            return self.claim(level - 1, first, node.mask.count_ones() as usize);
        }
        let size = |n| product(extent(self.view.dims(), child_origin(origin, level, n), CAP_LEVEL));
        let samples: usize = (0..8).filter(|&n| node.is_stored(n)).map(size).sum();
        first * CAP_UNIT + samples <= self.view.caps().len()
            && self.claim(CAP_LEVEL, first, samples.div_ceil(CAP_UNIT))
    }

    fn claim(&mut self, level: u32, first: usize, count: usize) -> bool {
        let claimed = &mut self.claimed[level as usize];
        let Some(range) = claimed.get_mut(first..).and_then(|rest| rest.get_mut(..count)) else {
            return false;
        };
        range.iter_mut().all(|c| !std::mem::replace(c, true))
    }

    /// The range of the cells of a leaf: its samples and their forward neighbours, inside the domain.
    fn leaf_range(&self, corner: [u32; 3], level: u32, is_cap: bool) -> Range<T> {
        let n = self.view.dims().axes();
        let mut range = Range::EMPTY;
        if (0..3).any(|a| corner[a] + 1 >= n[a]) {
            return range;
        }
        let beyond = corner.map(|c| c + (1 << level));
        let last: [u32; 3] = std::array::from_fn(|a| beyond[a].min(n[a] - 1));
        range.include(self.view.sample(corner));
        for z in corner[2]..=last[2] {
            for y in corner[1]..=last[1] {
                // Inside a scalar leaf all samples are that of the corner.
                let from = if is_cap || z == beyond[2] || y == beyond[1] { corner[0] } else { beyond[0] };
                for x in from..=last[0] {
                    range.include(self.view.sample([x, y, z]));
                }
            }
        }
        range
    }
}
