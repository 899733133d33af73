//! Whether the structure is a tree that holds every stored element.

use isoray_grid::Scalar;

use super::Malformed;
use crate::cap::{bytes_of, cap_reach, cap_unit, width};
use crate::geometry::{CAP_LEVEL, MAX_LEVEL, NODE_LEVEL, child_origin, extent, product};
use crate::node::Node;
use crate::view::OctreeView;

pub(super) fn check<T: Scalar>(view: &OctreeView<'_, T>, root: &Node<T::Stored>) -> Result<(), Malformed> {
    let count = |level| match level {
        CAP_LEVEL => view.caps().len().saturating_sub(cap_reach::<T>()).div_ceil(cap_unit::<T>()),
        _ => view.nodes(level).len(),
    };
    let claimed = (0..=MAX_LEVEL).map(|level| Flags::new(count(level))).collect();
    let mut links = Links { view, claimed };
    let claimed = links.claim(view.root_level(), 0, 1);
    debug_assert!(claimed, "the first claim of all cannot collide");
    links.check(root, view.root_level(), 0, [0; 3])?;
    for (level, flags) in (0..).zip(&links.claimed) {
        if let Some(index) = flags.first_unset() {
            return Err(Malformed { level, index, what: "nothing links to it" });
        }
    }
    Ok(())
}

/// One bit for each element.
struct Flags {
    words: Vec<u64>,
    count: usize,
}

impl Flags {
    fn new(count: usize) -> Self {
        Self { words: vec![0; count.div_ceil(64)], count }
    }

    /// Sets `count` flags from `first` on; false if one is set already, or there is no such one.
    fn set(&mut self, first: usize, count: usize) -> bool {
        let is_inside = first.checked_add(count).is_some_and(|end| end <= self.count);
        is_inside
            && (first..first + count).all(|n| {
                let (word, bit) = (&mut self.words[n / 64], 1 << (n % 64));
                let is_new = *word & bit == 0;
                *word |= bit;
                is_new
            })
    }

    fn first_unset(&self) -> Option<usize> {
        let word = self.words.iter().position(|&word| word != u64::MAX)?;
        let index = word * 64 + self.words[word].trailing_ones() as usize;
        (index < self.count).then_some(index)
    }
}

/// Depth-first verification.
struct Links<'v, 'a, T: Scalar> {
    view: &'v OctreeView<'a, T>,
    /// By level, the nodes that have been linked to; of caps, the units of links to them.
    claimed: Vec<Flags>,
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
        if node.stored_before(8).any(|n| !self.view.dims().contains(child_origin(origin, level, n))) {
            return error("a child outside the domain is stored");
        }
        if node.mask != 0 && !self.claim_children(node, level, origin) {
            return error("a link leads outside its array or to what another node links to");
        }
        if level == NODE_LEVEL {
            return Ok(());
        }
        for octant in node.stored_before(8) {
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
        self.claimed.get_mut(level as usize).is_some_and(|flags| flags.set(first, count))
    }
}
