//! The traversal loop: from the root to the blocks that the ray meets, in order.

use std::ops::ControlFlow;

use isoray_grid::{Scalar, Threshold};
use isoray_octree::{CAP_EDGE, CAP_LEVEL, MAX_LEVELS, NODE_LEVEL, Node, OctreeView, Path};
use wide::f64x4;

use crate::block::{ALL_BORDERS, BlockWalk};
use crate::hit::{AnyHit, FirstHit, Hit, HitPolicy};
use crate::neighborhood::Neighborhood;
use crate::place::Place;
use crate::ray::{BEYOND, ClippedRay, Ray, least, least_lane};
use crate::work::Counters;

/// Traces rays through one volume: the borrowed structure, and the stack that a traversal needs.
///
/// Make one per thread and keep it: tracing allocates nothing.
#[derive(Clone, Debug)]
pub struct Tracer<'a, T: Scalar> {
    view: &'a OctreeView<'a, T>,
    stack: [Frame<'a, T>; MAX_LEVELS],
    path: Path<'a, T>,
    neighborhood: Neighborhood<'a, T>,
}

/// A node, or a part of a scalar leaf, that the ray is in.
#[derive(Clone, Copy, Debug)]
struct Frame<'a, T: Scalar> {
    place: Place,
    /// Where the ray crosses the three mid-planes, and those of the lower and of the upper children. The latter are
    /// computed before it is known which child comes next, to keep them out of the chain from level to level.
    mid: f64x4,
    lower: f64x4,
    upper: f64x4,
    /// How far the ray has come, and where it leaves.
    t: f64,
    t_end: f64,
    /// `None` in a scalar leaf.
    node: Option<&'a Node<T::Stored>>,
    level: u32,
    /// The children that can hold surface and have not been visited.
    active: u32,
    /// In a scalar leaf, bit `a`: the region reaches the leaf's upper face of axis `a`; only the cells at those faces
    /// can hold surface.
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
        let zero = f64x4::ZERO;
        let place = Place::root(1);
        let (t, t_end) = (0.0, 0.0);
        let empty = Frame {
            place,
            mid: zero,
            lower: zero,
            upper: zero,
            t,
            t_end,
            node: None,
            level: 1,
            active: 0,
            borders: 0,
        };
        Self { view, stack: [empty; MAX_LEVELS], path: Path::default(), neighborhood: Neighborhood::new() }
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
        let view = self.view;
        let walk = BlockWalk { view, ray: &ray, isovalue, threshold };
        let level = view.root_level();
        let place = Place::root(level);
        self.path.enter_node(level, root);
        counters.node();
        // The frame at hand is kept apart from the stack, in registers; those below wait for the ray to come back.
        let [lower, upper] = child_planes(&ray, place, level);
        let mut frame = Frame {
            place,
            mid: ray.crossings(place.center),
            lower,
            upper,
            t: ray.t_begin,
            t_end: ray.t_end,
            node: Some(root),
            level,
            active: root.active(threshold),
            borders: 0,
        };
        let mut top = 0;
        loop {
            let Some((octant, t, t_end)) = frame.next_child(ray.backward) else {
                if top == 0 {
                    return;
                }
                top -= 1;
                frame = self.stack[top];
                continue;
            };
            let level = frame.level - 1;
            counters.node();
            if level > CAP_LEVEL {
                let place = frame.place.child(level, octant);
                let mid = frame.mid_of(octant);
                let (node, active, borders) = match frame.node {
                    Some(node) if node.is_stored(octant) => {
                        let Some(child) = view.nodes(level).get(node.child(octant)) else { return };
                        self.path.enter_node(level, child);
                        (Some(child), child.active(threshold), 0)
                    }
                    Some(node) => {
                        self.path.enter_leaf(level, node, octant);
                        (None, octants_at(ALL_BORDERS), ALL_BORDERS)
                    }
                    None => (None, octants_at(frame.borders & octant), frame.borders & octant),
                };
                if frame.active != 0 && frame.t < frame.t_end {
                    let Some(slot) = self.stack.get_mut(top) else { return };
                    *slot = frame;
                    top += 1;
                }
                let [lower, upper] = child_planes(&ray, place, level);
                frame = Frame { place, mid, lower, upper, t, t_end, node, level, active, borders };
                continue;
            }
            // A place of its own: the walk takes it by reference, which would keep it in memory for all of the above.
            let place = frame.place.child(level, octant);
            let (block, borders) = match frame.node {
                Some(node) => (view.block(node, parent_corner(place), octant), ALL_BORDERS),
                None => (self.path.leaf_block(), frame.borders & octant),
            };
            let borders = block.as_constant().map(|_| borders);
            self.neighborhood.begin(block, threshold);
            let ControlFlow::Continue(()) =
                walk.cells(&mut self.neighborhood, &self.path, place, borders, t, t_end, policy, counters)
            else {
                return;
            };
        }
    }
}

/// Low corner of the node whose child, a block, lies at `place`.
#[inline(always)]
fn parent_corner(place: Place) -> [u32; 3] {
    place.corner().map(|c| c & !CAP_EDGE)
}

/// Where the ray crosses the mid-planes of the lower and of the upper children of a node of `level` at `place`; nowhere
/// in particular if those are blocks, which have none.
#[inline(always)]
fn child_planes(ray: &ClippedRay, place: Place, level: u32) -> [f64x4; 2] {
    if level > NODE_LEVEL {
        place.child_planes(level).map(|planes| ray.crossings(planes))
    } else {
        [f64x4::ZERO; 2]
    }
}

/// Lanes, all ones, of the axes along which an octant is the upper one.
const UPPER_LANES: [[u64; 4]; 8] = {
    let mut lanes = [[0; 4]; 8];
    let mut n = 0;
    while n < 8 {
        let mut a = 0;
        while a < 3 {
            if n >> a & 1 == 1 {
                lanes[n][a] = u64::MAX;
            }
            a += 1;
        }
        n += 1;
    }
    lanes
};

impl<T: Scalar> Frame<'_, T> {
    /// Where the ray crosses the mid-planes of child `octant`.
    #[inline(always)]
    fn mid_of(&self, octant: u32) -> f64x4 {
        f64x4::new(UPPER_LANES[octant as usize & 7].map(f64::from_bits)).select(self.upper, self.lower)
    }

    /// The next active octant on the ray, and where it enters and leaves that; `None` when none is left or the ray has left.
    #[inline(always)]
    fn next_child(&mut self, backward: u32) -> Option<(u32, f64, f64)> {
        let mut t = self.t;
        while t < self.t_end && self.active != 0 {
            let is_crossed = self.mid.simd_le(f64x4::splat(t));
            let octant = (is_crossed.to_bitmask() & 7) ^ backward;
            let next = least(least_lane(is_crossed.select(f64x4::splat(BEYOND), self.mid)), self.t_end);
            if self.active >> octant & 1 == 1 {
                self.active &= !(1 << octant);
                self.t = next;
                return Some((octant, t, next));
            }
            t = next;
        }
        None
    }
}
