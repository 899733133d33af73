//! The traversal loop: from the root to the blocks that the ray meets, in order.

use std::ops::ControlFlow;

use isoray_grid::Scalar;
use isoray_octree::{Block, CAP_EDGE, NODE_LEVEL, Node, OctreeView, Path};
use wide::f64x4;

use crate::place::{Place, child_centers, root_center};
use crate::ray::{BEYOND, ClippedRay, least, least_lane};
use crate::reach::reachable;
use crate::work::Counters;

/// What a traversal looks for.
pub(crate) trait Search<'a, T: Scalar> {
    /// The children of `node` that matter.
    fn active(&self, node: &Node<T::Stored>) -> u32;

    /// Whether the inside of a scalar leaf of `value` matters.
    fn sees_inside(&self, value: T) -> bool;

    /// Passes through the inside of a scalar leaf.
    fn inside(&mut self, value: T, interval: [f64; 2]) -> ControlFlow<()>;

    /// Passes through a block.
    fn block(&mut self, visit: BlockVisit<'_, 'a, T>, counters: &mut impl Counters) -> ControlFlow<()>;
}

/// A block on the ray's way.
pub(crate) struct BlockVisit<'p, 'a, T: Scalar> {
    pub(crate) place: Place,
    /// Where the ray crosses its mid-planes.
    pub(crate) mid: f64x4,
    /// Where the ray is in it.
    pub(crate) t: f64,
    pub(crate) t_end: f64,
    pub(crate) path: &'p Path<'a, T>,
    /// Its parent, if that is no scalar leaf, and which child it is.
    node: Option<&'a Node<T::Stored>>,
    octant: u32,
}

impl<'a, T: Scalar> BlockVisit<'_, 'a, T> {
    /// The block itself.
    #[inline(always)]
    pub(crate) fn own(&self, view: &OctreeView<'a, T>) -> Block<'a, T> {
        match self.node {
            Some(node) => view.block(node, parent_corner(self.place), self.octant),
            None => self.path.leaf_block(),
        }
    }
}

/// Room for every level: a power of two, so that a masked level is an index that needs no check.
const LEVELS: usize = 32;

/// A node, or a part of a scalar leaf, that the ray is in.
#[derive(Clone, Copy, Debug)]
struct Frame<'a, T: Scalar> {
    /// Centre coordinates.
    center: f64x4,
    /// Where the ray crosses the three mid-planes, and those of the children on this and on the far side of them. The latter are
    /// computed before it is known which child comes next, to keep them out of the chain from level to level.
    mid: f64x4,
    near: f64x4,
    far: f64x4,
    /// How far the ray has come, and where it leaves.
    t: f64,
    t_end: f64,
    /// `None` in a scalar leaf.
    node: Option<&'a Node<T::Stored>>,
    /// The children that matter, that the ray meets, and that have not been visited.
    active: u32,
    /// In a scalar leaf, bit `a`: the region reaches the leaf's upper face of axis `a`; only the cells at those faces
    /// are not constant.
    borders: u32,
}

/// All three upper faces.
pub(crate) const ALL_BORDERS: u32 = 0b111;

/// All children of a node.
pub(crate) const ALL_OCTANTS: u32 = 0xff;

/// The octants in the upper half of axis 0, 1, 2.
const UPPER_OCTANTS: [u32; 3] = [0b1010_1010, 0b1100_1100, 0b1111_0000];

/// The octants that reach the given upper faces of their parent.
pub(crate) fn octants_at(borders: u32) -> u32 {
    (0..3).filter(|a| borders >> a & 1 == 1).map(|a| UPPER_OCTANTS[a]).fold(0, |m, o| m | o)
}

/// The stack of a traversal.
#[derive(Clone, Debug)]
pub(crate) struct Descent<'a, T: Scalar> {
    /// By level: what is left to do in a node above the one at hand.
    stack: [Frame<'a, T>; LEVELS],
    path: Path<'a, T>,
}

impl<'a, T: Scalar> Descent<'a, T> {
    pub(crate) fn new() -> Self {
        let zero = f64x4::ZERO;
        let (t, t_end) = (0.0, 0.0);
        let empty = Frame {
            center: zero,
            mid: zero,
            near: zero,
            far: zero,
            t,
            t_end,
            node: None,
            active: 0,
            borders: 0,
        };
        Self { stack: [empty; LEVELS], path: Path::default() }
    }

    /// Takes `search` through all that matters on the way of `ray`, in order, until it breaks.
    ///
    /// Depth-first in the order of the ray: at each node the mid-planes that the ray has crossed tell the octant
    /// it is in, and the next crossing tells when it moves on (Knoll 2006, section 4.3, with plane parameters compared in
    /// place of positions). Children that do not matter are passed by.
    #[inline(always)]
    pub(crate) fn follow<S: Search<'a, T>>(
        &mut self,
        view: &OctreeView<'a, T>,
        ray: &ClippedRay,
        search: &mut S,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let Some(root) = view.root() else { return ControlFlow::Continue(()) };
        let mut level = view.root_level();
        let mut center = root_center(level);
        let mut node = Some(root);
        let mut mid = ray.crossings(center);
        let [mut near, mut far] = child_centers(center, level, ray.step).map(|center| ray.crossings(center));
        let (mut t, mut t_end) = (ray.t_begin, ray.t_end);
        let mut active = search.active(root) & reachable(mid, t, t_end, ray.backward);
        let mut borders = 0;
        // Of the scalar leaf at hand: its value, and whether its inside matters.
        let (mut leaf, mut is_seen) = (T::default(), false);
        // Bit `l`: the frame of level `l` has children left.
        let mut pending = 0u32;
        self.path.enter_node(level, root);
        counters.node();
        loop {
            if active == 0 || t >= t_end {
                if pending == 0 {
                    return ControlFlow::Continue(());
                }
                level = pending.trailing_zeros();
                pending &= pending - 1;
                Frame { center, mid, near, far, t, t_end, node, active, borders } =
                    self.stack[level as usize % LEVELS];
                continue;
            }
            // The octant that the ray is in at `t`, and where it leaves that.
            let is_crossed = mid.simd_le(f64x4::splat(t));
            let octant = (is_crossed.to_bitmask() & 7) ^ ray.backward;
            let next = least(least_lane(is_crossed.select(f64x4::splat(BEYOND), mid)), t_end);
            if active >> octant & 1 == 0 {
                t = next;
                continue;
            }
            active &= !(1 << octant);
            counters.node();
            let [this_side, far_side] = child_centers(center, level, ray.step);
            let child_center = is_crossed.select(far_side, this_side);
            if node.is_none() && borders & octant == 0 {
                search.inside(leaf, [t, next])?;
                t = next;
                continue;
            }
            if level == NODE_LEVEL {
                search.block(
                    BlockVisit {
                        place: Place::around(child_center),
                        mid: is_crossed.select(far, near),
                        t,
                        t_end: next,
                        path: &self.path,
                        node,
                        octant,
                    },
                    counters,
                )?;
                t = next;
                continue;
            }
            if active != 0 && next < t_end {
                self.stack[level as usize % LEVELS] =
                    Frame { center, mid, near, far, t: next, t_end, node, active, borders };
                pending |= 1 << level;
            }
            level -= 1;
            center = child_center;
            mid = is_crossed.select(far, near);
            [near, far] = child_centers(center, level, ray.step).map(|center| ray.crossings(center));
            t_end = next;
            match node {
                Some(parent) if parent.is_stored(octant) => {
                    let Some(child) = view.nodes(level).get(parent.child(octant)) else {
                        return ControlFlow::Continue(());
                    };
                    self.path.enter_node(level, child);
                    (node, active) =
                        (Some(child), search.active(child) & reachable(mid, t, t_end, ray.backward));
                }
                Some(parent) => {
                    self.path.enter_leaf(level, parent, octant);
                    leaf = parent.value(octant);
                    is_seen = search.sees_inside(leaf);
                    (node, borders) = (None, ALL_BORDERS);
                    active = if is_seen { ALL_OCTANTS } else { octants_at(borders) };
                }
                None => {
                    borders &= octant;
                    active = if is_seen { ALL_OCTANTS } else { octants_at(borders) };
                }
            }
        }
    }
}

/// Low corner of the node whose child, a block, lies at `place`.
#[inline(always)]
fn parent_corner(place: Place) -> [u32; 3] {
    place.corner().map(|c| c & !CAP_EDGE)
}
