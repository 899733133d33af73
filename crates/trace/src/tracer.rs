//! The traversal loop: from the root to the blocks that the ray meets, in order.

use std::ops::ControlFlow;

use isoray_grid::{Scalar, Threshold};
use isoray_octree::{Block, CAP_LEVEL, MAX_LEVELS, NODE_LEVEL, Node, OctreeView, Path, child_origin};

use crate::block::{ALL_BORDERS, BlockWalk};
use crate::hit::{AnyHit, FirstHit, Hit, HitPolicy};
use crate::ray::{ClippedRay, Ray};
use crate::work::Counters;

/// Traces rays through one volume: the borrowed structure, and the stack that a traversal needs.
///
/// Make one per thread and keep it: tracing allocates nothing.
#[derive(Clone, Debug)]
pub struct Tracer<'a, T: Scalar> {
    view: &'a OctreeView<'a, T>,
    stack: [Frame; MAX_LEVELS],
    path: Path<T>,
}

/// A node, or a part of a scalar leaf, that the ray is in.
#[derive(Clone, Copy, Debug, Default)]
struct Frame {
    /// Where the ray crosses the three mid-planes.
    mid: [f64; 3],
    /// How far the ray has come, and where it leaves.
    t: f64,
    t_end: f64,
    origin: [u32; 3],
    level: u32,
    /// Index of the node at its level; unused in a leaf.
    index: u32,
    /// The children that can hold surface.
    active: u32,
    /// In a scalar leaf, bit `a`: the region reaches the leaf's upper face of axis `a`. Zero for a node, since
    /// only the cells at those faces of a leaf can hold surface.
    borders: u32,
}

/// The octants in the upper half of axis 0, 1, 2.
const UPPER_OCTANTS: [u32; 3] = [0b1010_1010, 0b1100_1100, 0b1111_0000];

/// The octants that reach the given upper faces of their parent.
fn octants_at(borders: u32) -> u32 {
    (0..3).filter(|a| borders >> a & 1 == 1).map(|a| UPPER_OCTANTS[a]).fold(0, |m, o| m | o)
}

impl<'a, T: Scalar> Tracer<'a, T> {
    /// A tracer of the volume behind `view`.
    pub fn new(view: &'a OctreeView<'a, T>) -> Self {
        Self { view, stack: [Frame::default(); MAX_LEVELS], path: Path::default() }
    }

    /// The first crossing of the isosurface of `isovalue`.
    #[inline]
    pub fn first_hit(&mut self, ray: &Ray, isovalue: f32) -> Option<Hit> {
        let mut policy = FirstHit::default();
        self.trace(ray, isovalue, &mut policy, &mut ());
        policy.0
    }

    /// Whether the ray crosses the isosurface of `isovalue` at all.
    #[inline]
    pub fn any_hit(&mut self, ray: &Ray, isovalue: f32) -> bool {
        let mut policy = AnyHit::default();
        self.trace(ray, isovalue, &mut policy, &mut ());
        policy.0
    }

    /// Hands to `policy`, in order along the ray, the cells on its path whose corners lie on both sides of
    /// `isovalue`, until it breaks. A ray with a component that is not finite, or without direction, meets none.
    ///
    /// Depth-first in the order of the ray: at each node the mid-planes that the ray has crossed tell the octant
    /// it is in, and the next crossing tells when it moves on (Knoll 2006, section 4.3, with plane parameters compared in
    /// place of positions). Children whose range does not hold the isovalue are passed by.
    pub fn trace(
        &mut self,
        ray: &Ray,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        let Threshold::AtLeast(threshold) = T::threshold(isovalue) else { return };
        let Some(ray) = ClippedRay::new(ray, self.view.dims()) else { return };
        let Some(root) = self.view.root() else { return };
        let walk = BlockWalk { view: self.view, ray: &ray, isovalue, threshold };
        let mut top = 0;
        let root_level = self.view.root_level();
        self.path.enter_node(root_level, 0);
        counters.node();
        self.stack[0] = Frame::of_node(root, root_level, 0, [0; 3], threshold, &ray, ray.t_begin, ray.t_end);
        loop {
            let frame = &mut self.stack[top];
            let Some((octant, t, t_end)) = frame.next_child(ray.backward) else {
                if top == 0 {
                    return;
                }
                top -= 1;
                continue;
            };
            if frame.active >> octant & 1 == 0 {
                continue;
            }
            let level = frame.level - 1;
            let origin = child_origin(frame.origin, frame.level, octant);
            let child = if frame.borders != 0 {
                Child::Leaf(frame.borders & octant)
            } else {
                let Some(node) = self.view.nodes(frame.level).get(frame.index as usize) else { return };
                if level == CAP_LEVEL {
                    Child::Block(self.view.block(node, frame.origin, octant))
                } else if node.is_stored(octant) {
                    Child::Node(node.child(octant) as u32)
                } else {
                    self.path.enter_leaf(level, node.values[octant as usize].into());
                    Child::Leaf(ALL_BORDERS)
                }
            };
            let block = match child {
                Child::Node(index) => {
                    let Some(node) = self.view.nodes(level).get(index as usize) else { return };
                    self.path.enter_node(level, index);
                    counters.node();
                    top += 1;
                    self.stack[top] = Frame::of_node(node, level, index, origin, threshold, &ray, t, t_end);
                    continue;
                }
                Child::Leaf(borders) if level >= NODE_LEVEL => {
                    counters.node();
                    top += 1;
                    self.stack[top] = Frame::of_leaf(level, origin, borders, &ray, t, t_end);
                    continue;
                }
                Child::Leaf(borders) => (Block::Constant(self.path.leaf_value()), borders),
                Child::Block(block) => (block, ALL_BORDERS),
            };
            counters.node();
            let ControlFlow::Continue(()) =
                walk.cells(&self.path, block.0, origin, block.1, [t, t_end], policy, counters)
            else {
                return;
            };
        }
    }
}

/// What a traversal descends to.
enum Child<'a, T: Scalar> {
    Node(u32),
    /// Part of a scalar leaf, with the upper faces of the leaf that it reaches.
    Leaf(u32),
    Block(Block<'a, T>),
}

impl Frame {
    #[expect(clippy::too_many_arguments, reason = "the fields of a frame, computed where they are known")]
    #[inline(always)]
    fn of_node<T: Scalar>(
        node: &Node<T::Stored>,
        level: u32,
        index: u32,
        origin: [u32; 3],
        threshold: T,
        ray: &ClippedRay,
        t: f64,
        t_end: f64,
    ) -> Self {
        let active = node.active(threshold);
        Self { mid: mid_planes(ray, origin, level), t, t_end, origin, level, index, active, borders: 0 }
    }

    #[inline]
    fn of_leaf(level: u32, origin: [u32; 3], borders: u32, ray: &ClippedRay, t: f64, t_end: f64) -> Self {
        let active = octants_at(borders);
        Self { mid: mid_planes(ray, origin, level), t, t_end, origin, level, index: 0, active, borders }
    }

    /// The octant the ray is in and its stretch there, and moves on to the next; `None` when the ray has left.
    #[inline(always)]
    fn next_child(&mut self, backward: u32) -> Option<(u32, f64, f64)> {
        let t = self.t;
        if t >= self.t_end {
            return None;
        }
        let mut crossed = 0;
        let mut next = self.t_end;
        for a in 0..3 {
            let is_crossed = self.mid[a] <= t;
            crossed |= u32::from(is_crossed) << a;
            if !is_crossed && self.mid[a] < next {
                next = self.mid[a];
            }
        }
        self.t = next;
        Some((crossed ^ backward, t, next))
    }
}

#[inline(always)]
fn mid_planes(ray: &ClippedRay, origin: [u32; 3], level: u32) -> [f64; 3] {
    std::array::from_fn(|a| ray.crossing(a, origin[a] + (1 << (level - 1))))
}
