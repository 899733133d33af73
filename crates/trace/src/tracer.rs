//! The traversal loop: from the root to the blocks that the ray meets, in order.

use std::ops::ControlFlow;

use isoray_grid::{Scalar, Threshold};
use isoray_octree::{CAP_EDGE, NODE_LEVEL, Node, OctreeView, Path};
use wide::f64x4;

use crate::block::BlockWalk;
use crate::hit::{AnyHit, FirstHit, Hit, HitPolicy};
use crate::neighborhood::Neighborhoods;
use crate::place::{Place, child_centers, root_center};
use crate::ray::{BEYOND, ClippedRay, Ray, least, least_lane};
use crate::reach::reachable;
use crate::region::Region;
use crate::work::Counters;

/// Traces rays through one volume: the borrowed structure, and the stack that a traversal needs.
///
/// Make one per thread and keep it: tracing allocates nothing, and what a ray found out about some 500 blocks (150 KB) is kept for
/// the next, as long as the isovalue stays the same. Rays that follow each other closely, in the rows or tiles of a picture, gain
/// most.
#[derive(Clone, Debug)]
pub struct Tracer<'a, T: Scalar> {
    view: &'a OctreeView<'a, T>,
    /// By level: what is left to do in a node above the one at hand.
    stack: [Frame<'a, T>; LEVELS],
    path: Path<'a, T>,
    /// What the next two hold for.
    threshold: Option<T>,
    /// Where there can be surface; `None`: nowhere.
    region: Option<Region>,
    neighborhoods: Neighborhoods<'a, T>,
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
    /// The children that can hold surface, that the ray meets, and that have not been visited.
    active: u32,
    /// In a scalar leaf, bit `a`: the region reaches the leaf's upper face of axis `a`; only the cells at those faces
    /// can hold surface.
    borders: u32,
}

/// All three upper faces.
const ALL_BORDERS: u32 = 0b111;

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
        Self {
            view,
            stack: [empty; LEVELS],
            path: Path::default(),
            threshold: None,
            region: None,
            neighborhoods: Neighborhoods::new(),
        }
    }

    /// Prepares for another threshold: forgets what was found out for the last one.
    #[cold]
    fn turn_to(&mut self, threshold: T) {
        self.threshold = Some(threshold);
        self.region = Region::new(self.view, threshold);
        self.neighborhoods.forget();
    }

    /// The first crossing of the isosurface of `isovalue`.
    #[inline(always)]
    pub fn first_hit(&mut self, ray: &Ray, isovalue: f32) -> Option<Hit> {
        let mut policy = FirstHit::default();
        self.trace(ray, isovalue, &mut policy, &mut ());
        policy.0
    }

    /// Whether the ray crosses the isosurface of `isovalue` at all.
    #[inline(always)]
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
    // Out of line, a ray and its hit go through memory: 28 of 170 ns.
    #[inline(always)]
    pub fn trace(
        &mut self,
        ray: &Ray,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        let Threshold::AtLeast(threshold) = T::threshold(isovalue) else { return };
        if self.threshold != Some(threshold) {
            self.turn_to(threshold);
        }
        let Some(region) = &self.region else { return };
        let Some(ray) = &ClippedRay::new(ray, region) else { return };
        let view = self.view;
        let Some(root) = view.root() else { return };
        let walk = BlockWalk { view, ray, isovalue, threshold };
        let mut level = view.root_level();
        let mut center = root_center(level);
        let mut node = Some(root);
        let mut mid = ray.crossings(center);
        let [mut near, mut far] = child_centers(center, level, ray.step).map(|center| ray.crossings(center));
        let (mut t, mut t_end) = (ray.t_begin, ray.t_end);
        let mut active = root.active(threshold) & reachable(mid, t, t_end, ray.backward);
        let mut borders = 0;
        // Bit `l`: the frame of level `l` has children left.
        let mut pending = 0u32;
        self.path.enter_node(level, root);
        counters.node();
        loop {
            if active == 0 || t >= t_end {
                if pending == 0 {
                    return;
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
            if level == NODE_LEVEL {
                let place = Place::around(child_center);
                let neighborhood = self.neighborhoods.of(place, threshold, || match node {
                    Some(node) => view.block(node, parent_corner(place), octant),
                    None => self.path.leaf_block(),
                });
                let ControlFlow::Continue(()) = walk.cells(
                    neighborhood,
                    &self.path,
                    place,
                    is_crossed.select(far, near),
                    t,
                    next,
                    policy,
                    counters,
                ) else {
                    return;
                };
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
                    let Some(child) = view.nodes(level).get(parent.child(octant)) else { return };
                    self.path.enter_node(level, child);
                    (node, active) =
                        (Some(child), child.active(threshold) & reachable(mid, t, t_end, ray.backward));
                }
                Some(parent) => {
                    self.path.enter_leaf(level, parent, octant);
                    (node, active, borders) = (None, octants_at(ALL_BORDERS), ALL_BORDERS);
                }
                None => {
                    borders &= octant;
                    active = octants_at(borders);
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
