//! The traversal loop: from the root to the blocks that the ray meets, in order.

use std::ops::ControlFlow;

use isoray_grid::{Scalar, Threshold};
use isoray_octree::{CAP_LEVEL, MAX_LEVELS, NODE_LEVEL, Node, OctreeView, Path};
use wide::f64x4;

use crate::block::{ALL_BORDERS, BlockWalk, EVERYWHERE};
use crate::children::Children;
use crate::hit::{AnyHit, FirstHit, Hit, HitPolicy};
use crate::neighborhood::Neighborhood;
use crate::place::Place;
use crate::ray::{ClippedRay, Ray};
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

/// A node, or a part of a scalar leaf, that the ray is in, with its children on the way.
#[derive(Clone, Copy, Debug)]
struct Frame<'a, T: Scalar> {
    /// Where the ray crosses the mid-planes of the lower and of the upper children. They are computed
    /// before it is known which child comes next, to keep them out of the chain of dependencies from level to level.
    lower: f64x4,
    upper: f64x4,
    children: Children,
    /// `None` in a scalar leaf.
    node: Option<&'a Node<T::Stored>>,
    place: Place,
    level: u32,
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
        let children = Children::default();
        let place = Place::ORIGIN;
        let empty = Frame { lower: zero, upper: zero, children, node: None, place, level: 1, borders: 0 };
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
        let mid = ray.crossings(Place::ORIGIN.planes(level));
        let all = [ray.t_begin, ray.t_end];
        let Some(children) = Children::new(|| root.active(threshold), mid, ray.backward, all) else { return };
        self.path.enter_node(level, root);
        counters.node();
        self.stack[0].enter(&ray, children, Some(root), Place::ORIGIN, level, 0);
        let mut top = 0;
        loop {
            let frame = &mut self.stack[top];
            let Some((octant, stretch)) = frame.children.next() else {
                if top == 0 {
                    return;
                }
                top -= 1;
                continue;
            };
            let level = frame.level - 1;
            let place = frame.place.child(level, octant);
            counters.node();
            let (block, borders) = if level == CAP_LEVEL {
                match frame.node {
                    Some(node) => (view.block(node, place.parent(CAP_LEVEL), octant), ALL_BORDERS),
                    None => (self.path.leaf_block(), frame.borders & octant),
                }
            } else {
                let mid = frame.mid_of(octant);
                let (child, borders) = match frame.node {
                    Some(node) if node.is_stored(octant) => {
                        let Some(child) = view.nodes(level).get(node.child(octant)) else { return };
                        self.path.enter_node(level, child);
                        (Some(child), 0)
                    }
                    Some(node) => {
                        self.path.enter_leaf(level, node, octant);
                        (None, ALL_BORDERS)
                    }
                    None => (None, frame.borders & octant),
                };
                let active = || child.map_or_else(|| octants_at(borders), |child| child.active(threshold));
                if let Some(children) = Children::new(active, mid, ray.backward, stretch) {
                    // A frame without further children gives its place to its last child's.
                    top += usize::from(!frame.children.is_empty());
                    let Some(next) = self.stack.get_mut(top) else { return };
                    next.enter(&ray, children, child, place, level, borders);
                }
                continue;
            };
            let borders = if block.as_constant().is_some() { borders } else { EVERYWHERE };
            self.neighborhood.begin(block, threshold);
            let ControlFlow::Continue(()) = walk.cells(
                &mut self.neighborhood,
                &self.path,
                place,
                borders,
                stretch[0],
                stretch[1],
                policy,
                counters,
            ) else {
                return;
            };
        }
    }
}

impl<'a, T: Scalar> Frame<'a, T> {
    #[inline(always)]
    fn enter(
        &mut self,
        ray: &ClippedRay,
        children: Children,
        node: Option<&'a Node<T::Stored>>,
        place: Place,
        level: u32,
        borders: u32,
    ) {
        if level > NODE_LEVEL {
            let [lower, upper] = place.child_planes(level);
            self.lower = ray.crossings(lower);
            self.upper = ray.crossings(upper);
        }
        self.children = children;
        self.node = node;
        self.place = place;
        self.level = level;
        self.borders = borders;
    }

    /// Where the ray crosses the mid-planes of child `octant`.
    #[inline(always)]
    fn mid_of(&self, octant: u32) -> f64x4 {
        f64x4::new(UPPER_LANES[octant as usize & 7].map(f64::from_bits)).select(self.upper, self.lower)
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
