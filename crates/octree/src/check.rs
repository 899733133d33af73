//! Verifying a structure node by node.

use isoray_grid::Scalar;

use crate::cap::{Block, bytes_of, cap_reach, cap_unit, width};
use crate::geometry::{CAP_LEVEL, MAX_LEVEL, NODE_LEVEL, child_origin, extent, product};
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
/// Safe on any bytes: it takes time in proportion to the structure, whatever the dimensions say.
///
/// # Errors
/// A node that breaks a rule.
pub fn check_well_formed<T: Scalar>(view: &OctreeView<'_, T>) -> Result<(), Malformed> {
    check_with_progress(view, &mut |_| {})
}

/// As [`check_well_formed`], and calls `progress` with the share that is done, up to 1, now and then.
pub(crate) fn check_with_progress<T: Scalar>(
    view: &OctreeView<'_, T>,
    progress: &mut dyn FnMut(f64),
) -> Result<(), Malformed> {
    let root_level = view.root_level();
    let root = view.root().ok_or(Malformed { level: root_level, index: 0, what: "the root is missing" })?;
    // Links first: once every element is known to have one parent, the passes over it are bounded, where
    // damaged links could make one subtree appear under any number of nodes.
    check_links(view, root)?;
    Contents { view, done: 0, progress }.check(root, root_level, 0, [0; 3])
}

/// Verifies that the structure is a tree which holds every stored element.
fn check_links<T: Scalar>(view: &OctreeView<'_, T>, root: &Node<T::Stored>) -> Result<(), Malformed> {
    let mut links = Links { view, claimed: claims(view) };
    let claimed = links.claim(view.root_level(), 0, 1);
    debug_assert!(claimed, "the first claim of all cannot collide");
    links.check(root, view.root_level(), 0, [0; 3])?;
    for (level, claims) in (0..).zip(&links.claimed) {
        if let Some(index) = claims.iter().position(|&c| !c) {
            return Err(Malformed { level, index, what: "nothing links to it" });
        }
    }
    Ok(())
}

/// By level, one flag for every node; at the caps' level one for every unit of links to them.
fn claims<T: Scalar>(view: &OctreeView<'_, T>) -> Vec<Vec<bool>> {
    let count = |level| match level {
        CAP_LEVEL => view.caps().len().saturating_sub(cap_reach::<T>()).div_ceil(cap_unit::<T>()),
        _ => view.nodes(level).len(),
    };
    (0..=MAX_LEVEL).map(|level| vec![false; count(level)]).collect()
}

/// Depth-first verification of the links.
struct Links<'v, 'a, T: Scalar> {
    view: &'v OctreeView<'a, T>,
    /// Which elements have been linked to, by level.
    claimed: Vec<Vec<bool>>,
}

impl<T: Scalar> Links<'_, '_, T> {
    fn check(
        &mut self,
        node: &Node<T::Stored>,
        level: u32,
        index: usize,
        origin: [u32; 3],
    ) -> Result<(), Malformed> {
        let error = |what| Err(Malformed { level, index, what });
        let stored = || (0..8).filter(|&octant| node.is_stored(octant));
        if stored().any(|n| !self.view.dims().contains(child_origin(origin, level, n))) {
            return error("a child outside the domain is stored");
        }
        if node.mask != 0 && !self.claim_children(node, level, origin) {
            return error("a link leads outside its array or to what another node links to");
        }
        if level == NODE_LEVEL {
            return Ok(());
        }
        for octant in stored() {
            let child_index = node.child(octant);
            let Some(child) = self.view.nodes(level - 1).get(child_index) else {
                return error("a link leads outside its array");
            };
            self.check(child, level - 1, child_index, child_origin(origin, level, octant))?;
        }
        Ok(())
    }

    /// Claims the stored children of `node`; false if one is outside its array or claimed already.
    fn claim_children(&mut self, node: &Node<T::Stored>, level: u32, origin: [u32; 3]) -> bool {
        let first = node.first.get() as usize;
        if level > NODE_LEVEL {
            return self.claim(level - 1, first, node.mask.count_ones() as usize);
        }
        let bytes: usize = node.stored_before(8).map(|octant| self.cap_bytes(node, origin, octant)).sum();
        self.claim(CAP_LEVEL, first, bytes.div_ceil(cap_unit::<T>()))
    }

    fn cap_bytes(&self, node: &Node<T::Stored>, origin: [u32; 3], octant: u32) -> usize {
        let size = extent(self.view.dims(), child_origin(origin, NODE_LEVEL, octant), CAP_LEVEL);
        bytes_of::<T>(width::<T>(node.range(octant as usize)), product(size))
    }

    fn claim(&mut self, level: u32, first: usize, count: usize) -> bool {
        let claimed = &mut self.claimed[level as usize];
        let Some(range) = claimed.get_mut(first..).and_then(|rest| rest.get_mut(..count)) else {
            return false;
        };
        range.iter_mut().all(|c| !std::mem::replace(c, true))
    }
}

/// Depth-first verification of values and ranges, in a structure whose links are sound.
struct Contents<'v, 'a, T: Scalar> {
    view: &'v OctreeView<'a, T>,
    /// Parents of caps verified.
    done: usize,
    /// Told the share of them.
    progress: &'v mut dyn FnMut(f64),
}

/// Parents of caps between two reports of progress.
const REPORT_INTERVAL: usize = 1 << 12;

impl<T: Scalar> Contents<'_, '_, T> {
    fn check(
        &mut self,
        node: &Node<T::Stored>,
        level: u32,
        index: usize,
        origin: [u32; 3],
    ) -> Result<(), Malformed> {
        let error = |what| Err(Malformed { level, index, what });
        for octant in 0..8 {
            let corner = child_origin(origin, level, octant);
            let value: T = node.values[octant as usize].into();
            let is_stored = node.is_stored(octant);
            if self.view.dims().contains(corner) && !self.view.sample(corner).same_bits(value) {
                return error("a child's value is not that of its low corner");
            }
            if is_stored && level == NODE_LEVEL && self.is_uniform(node, origin, octant) {
                return error("a cap is stored whose samples are all equal");
            }
            let expected = if is_stored && level > NODE_LEVEL {
                let child_index = node.child(octant);
                let Some(child) = self.view.nodes(level - 1).get(child_index) else {
                    return error("a link leads outside its array");
                };
                self.check(child, level - 1, child_index, corner)?;
                (0..8).map(|n| child.range(n)).fold(Range::EMPTY, Range::union)
            } else {
                self.leaf_range(corner, level - 1, (!is_stored).then_some(value))
            };
            if expected != node.range(octant as usize) {
                return error("a child's range is not that of its samples");
            }
        }
        if level == NODE_LEVEL {
            self.done += 1;
            if self.done.is_multiple_of(REPORT_INTERVAL) {
                (self.progress)(self.done as f64 / self.view.nodes(NODE_LEVEL).len() as f64);
            }
        }
        Ok(())
    }

    fn is_uniform(&self, node: &Node<T::Stored>, origin: [u32; 3], octant: u32) -> bool {
        let block = self.view.block(node, origin, octant);
        let [nx, ny, nz] = extent(self.view.dims(), child_origin(origin, NODE_LEVEL, octant), CAP_LEVEL);
        let first = block.sample([0; 3]);
        (0..nx * ny * nz).all(|n| block.sample([n % nx, n / nx % ny, n / nx / ny]).same_bits(first))
    }

    /// The range of the cells of a leaf: its samples, all `constant` if it is a scalar leaf, and their forward
    /// neighbours, inside the domain.
    fn leaf_range(&self, corner: [u32; 3], level: u32, constant: Option<T>) -> Range<T> {
        let n = self.view.dims().axes();
        let mut range = Range::EMPTY;
        if (0..3).any(|a| corner[a] + 1 >= n[a]) {
            return range;
        }
        let beyond = corner.map(|c| c + (1 << level));
        let last: [u32; 3] = std::array::from_fn(|a| beyond[a].min(n[a] - 1));
        match constant {
            None => self.include_box([corner, last], &mut range),
            Some(value) => {
                range.include(value);
                // Of the samples outside a constant leaf, those on its three forward sides: the last layer.
                for a in (0..3).filter(|&a| last[a] == beyond[a]) {
                    let mut from = corner;
                    from[a] = beyond[a];
                    self.include_box([from, last], &mut range);
                }
            }
        }
        range
    }

    /// Extends `range` by the samples of the box from `low` to `high`, both included and inside the domain.
    fn include_box(&self, [low, high]: [[u32; 3]; 2], range: &mut Range<T>) {
        if let Some(root) = self.view.root() {
            self.include_below(root, self.view.root_level(), [0; 3], [low, high], range);
        }
    }

    fn include_below(
        &self,
        node: &Node<T::Stored>,
        level: u32,
        origin: [u32; 3],
        [low, high]: [[u32; 3]; 2],
        range: &mut Range<T>,
    ) {
        let last = (1 << (level - 1)) - 1;
        for octant in 0..8 {
            let corner = child_origin(origin, level, octant);
            let from: [u32; 3] = std::array::from_fn(|a| low[a].max(corner[a]));
            let to: [u32; 3] = std::array::from_fn(|a| high[a].min(corner[a] + last));
            if (0..3).any(|a| from[a] > to[a]) {
                continue;
            }
            if level == NODE_LEVEL {
                let [from, to] = [from, to].map(|p| std::array::from_fn(|a| p[a] - corner[a]));
                include_block(&self.view.block(node, origin, octant), from, to, range);
            } else if !node.is_stored(octant) {
                range.include(node.values[octant as usize].into());
            } else if let Some(child) = self.view.nodes(level - 1).get(node.child(octant)) {
                self.include_below(child, level - 1, corner, [low, high], range);
            }
        }
    }
}

/// Extends `range` by the samples of a block from offset `from` to offset `to`, both included.
fn include_block<T: Scalar>(block: &Block<'_, T>, from: [u32; 3], to: [u32; 3], range: &mut Range<T>) {
    match block.as_constant() {
        Some(value) => range.include(value),
        None => {
            for z in from[2]..=to[2] {
                for y in from[1]..=to[1] {
                    (from[0]..=to[0]).for_each(|x| range.include(block.sample([x, y, z])));
                }
            }
        }
    }
}
