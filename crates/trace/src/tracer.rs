//! The first crossing of an isosurface.

use isoray_cell::relative;
use isoray_grid::{Scalar, Threshold};
use isoray_octree::OctreeView;

use crate::hit::{AnyHit, Candidate, FirstHit, Hit, HitPolicy};
use crate::ray::Ray;
use crate::thresholds::Thresholds;
use crate::walk::{MixedCell, Walk};
use crate::work::Counters;

/// Traces rays through one volume: the borrowed structure, and the stack that a traversal needs.
///
/// Make one per thread and keep it: tracing allocates nothing, and what a ray found out about some thousand cubes, blocks and cells (0.8 MB)
/// is kept for the next, as long as the isovalue stays the same. Rays that follow each other closely, in the tiles of a picture, gain most.
#[derive(Clone, Debug)]
pub struct Tracer<'a, T: Scalar> {
    walk: Walk<'a, T>,
}

impl<'a, T: Scalar> Tracer<'a, T> {
    /// A tracer of the volume behind `view`.
    pub fn new(view: &'a OctreeView<'a, T>) -> Self {
        Self { walk: Walk::new(view) }
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
        let Threshold::AtLeast(first) = T::threshold(isovalue) else { return };
        if !self.walk.thresholds().is_some_and(|thresholds| thresholds.is_only(first)) {
            self.walk.turn_to(Thresholds { first, others: Vec::new() });
        }
        let visit = |mixed: &MixedCell| {
            let &MixedCell { cell, samples, segment, interval } = mixed;
            policy.candidate(&Candidate { cell, corners: relative(&samples, isovalue), segment, interval })
        };
        let _ = self.walk.follow(ray, visit, counters);
    }
}
