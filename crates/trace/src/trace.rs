//! What tracers have in common.

use std::ops::ControlFlow;

use isoray_cell::{Cubic, trilinear};

use crate::hit::{AnyHit, Candidate, FirstHit, Hit, HitPolicy};
use crate::ray::{DepartingRay, Ray};
use crate::several::Crossing;
use crate::work::Counters;

/// What traces rays through a volume to its isosurfaces, whatever structure it goes through: the same hits, bit for bit.
///
/// A tracer keeps what a ray found out for the next one: make one per thread and keep it.
pub trait Trace {
    /// Hands to `policy`, in order along the ray, the cells on its path whose corners lie on both sides of
    /// `isovalue`, until it breaks. A ray with a component that is not finite, or without direction, meets none.
    fn trace(&mut self, ray: &Ray, isovalue: f32, policy: &mut impl HitPolicy, counters: &mut impl Counters);

    /// The same along a ray that starts on a surface.
    fn trace_departing(
        &mut self,
        ray: &DepartingRay,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    );

    /// Calls `visit` for all crossings of several isosurfaces, in order along the ray, in a cell too, until it breaks, which is what is then
    /// returned. Crossings at one `t` come in the order in which the field passes the isovalues.
    fn crossings(
        &mut self,
        ray: &Ray,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()>;

    /// The same along a ray that starts on one of the surfaces: the crossings behind its start.
    fn departing_crossings(
        &mut self,
        ray: &DepartingRay,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()>;

    /// The field at a cell-local position in a cell of the finest lattice; `None` in one that has a corner that is not finite.
    fn value(&mut self, cell: [u32; 3], local: [f32; 3]) -> Option<f32>;

    /// The gradient at a hit, interpolated between central differences at the cell's corners, per unit of index space
    /// (*central* normals): continuous across cells, where the forward gradient jumps.
    ///
    /// At the border of the domain, and beside samples that are not finite, differences are one-sided of second order.
    fn central_gradient(&mut self, hit: &Hit) -> [f32; 3];

    /// The first crossing of the isosurface of `isovalue`.
    #[inline(always)]
    fn first_hit(&mut self, ray: &Ray, isovalue: f32) -> Option<Hit> {
        let mut policy = FirstHit::default();
        self.trace(ray, isovalue, &mut policy, &mut ());
        policy.0
    }

    /// Whether the ray crosses the isosurface of `isovalue` at all.
    #[inline(always)]
    fn any_hit(&mut self, ray: &Ray, isovalue: f32) -> bool {
        let mut policy = AnyHit::default();
        self.trace(ray, isovalue, &mut policy, &mut ());
        policy.0
    }

    /// Whether a ray that starts on the isosurface of `isovalue` meets it again, or leaves to the other side than it is expected to.
    ///
    /// Ask [`Hit::faces_away`] first: light that comes from behind the surface is hidden by it, and takes no ray to tell. Where the hit lies on the face of a cell whose samples there are the isovalue itself
    /// (5 of 12 000 hits of one scan; a sixth grazes), such a ray may leave through the cell beside, and meet nothing.
    #[inline(always)]
    fn occluded(&mut self, ray: &DepartingRay, isovalue: f32, counters: &mut impl Counters) -> bool {
        let mut policy = Occlusion::of(ray);
        self.trace_departing(ray, isovalue, &mut policy, counters);
        policy.is_occluded
    }
}

/// The field in a cell, unless that is empty.
pub(crate) fn value_in(corners: &[f32; 8], local: [f32; 3]) -> Option<f32> {
    corners.iter().all(|c| c.is_finite()).then(|| trilinear(corners, local))
}

/// Stops at the first hit of a ray that starts on the surface.
pub(crate) struct Occlusion {
    into_inside: bool,
    pub(crate) is_occluded: bool,
}

impl DepartingRay {
    /// Whether it is occluded in a cell on its way; if in none, it is not.
    pub fn is_occluded_in(&self, candidate: &Candidate) -> bool {
        Occlusion::of(self).candidate(candidate).is_break()
    }
}

impl Occlusion {
    pub(crate) fn of(ray: &DepartingRay) -> Self {
        Self { into_inside: ray.into_inside, is_occluded: false }
    }
}

impl HitPolicy for Occlusion {
    #[inline(always)]
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        let cubic = Cubic::along(&candidate.corners, &candidate.segment);
        // Only the first cell begins where the ray does.
        self.is_occluded = if candidate.interval[0] <= 0.0 {
            let departing = cubic.departing();
            departing.leaves_inside() != self.into_inside || departing.crosses()
        } else {
            cubic.first_root().found
        };
        if self.is_occluded { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn jump(&mut self, _: &Hit) -> ControlFlow<()> {
        self.is_occluded = true;
        ControlFlow::Break(())
    }
}
