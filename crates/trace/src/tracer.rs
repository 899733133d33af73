//! The first crossing of an isosurface.

use std::ops::ControlFlow;

use isoray_grid::{Scalar, Threshold};
use isoray_octree::{Node, OctreeView};

use crate::block::BlockWalk;
use crate::descent::{BlockVisit, Descent, Search};
use crate::hit::{AnyHit, FirstHit, Hit, HitPolicy};
use crate::neighborhood::Neighborhoods;
use crate::ray::{ClippedRay, Ray};
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
    descent: Descent<'a, T>,
    /// What the next two hold for.
    threshold: Option<T>,
    /// Where there can be surface; `None`: nowhere.
    region: Option<Region>,
    neighborhoods: Neighborhoods<'a, T>,
}

impl<'a, T: Scalar> Tracer<'a, T> {
    /// A tracer of the volume behind `view`.
    pub fn new(view: &'a OctreeView<'a, T>) -> Self {
        Self {
            view,
            descent: Descent::new(),
            threshold: None,
            region: None,
            neighborhoods: Neighborhoods::new(),
        }
    }

    /// Prepares for another threshold: forgets what was found out for the last one.
    #[cold]
    fn turn_to(&mut self, threshold: T) {
        self.threshold = Some(threshold);
        self.region = Region::new(self.view, |node| node.active(threshold));
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
        let walk = BlockWalk { view: self.view, ray, isovalue, threshold };
        let mut search = Surface { walk, neighborhoods: &mut self.neighborhoods, policy };
        let _ = self.descent.follow(self.view, ray, &mut search, counters);
    }
}

/// The search for an isosurface.
struct Surface<'s, 'a, T: Scalar, P> {
    walk: BlockWalk<'s, 'a, T>,
    neighborhoods: &'s mut Neighborhoods<'a, T>,
    policy: &'s mut P,
}

impl<'a, T: Scalar, P: HitPolicy> Search<'a, T> for Surface<'_, 'a, T, P> {
    const SEES_INSIDE: bool = false;

    #[inline(always)]
    fn active(&self, node: &Node<T::Stored>) -> u32 {
        node.active(self.walk.threshold)
    }

    #[inline(always)]
    fn sees_inside(&self, _: T) -> bool {
        false
    }

    #[inline(always)]
    fn inside(&mut self, _: T, _: [f64; 2]) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn block(&mut self, visit: BlockVisit<'_, 'a, T>, counters: &mut impl Counters) -> ControlFlow<()> {
        let BlockVisit { place, mid, t, t_end, path, .. } = visit;
        let neighborhood = self.neighborhoods.of(place, self.walk.threshold, || visit.own(self.walk.view));
        self.walk.cells(neighborhood, path, place, mid, t, t_end, self.policy, counters)
    }
}
