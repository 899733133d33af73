//! Shadows through coarser levels of detail (Knoll 2009, section 7.2).
//!
//! Coarse surfaces are displaced, and a point of the picture may lie on either side of the coarse surface beside it. So a ray to a light begins one cell, of the coarse
//! level that is drawn where it starts, from its start; and it is hidden if it comes from the side of the surface to which it was sent to the other one. What it begins
//! in hides nothing. Where the finest level is drawn, rays are traced as others are.
//!
//! # What is dark that should not be
//!
//! Let the coarse surface be displaced by at most `δ`, and the surface be flat as far as that matters. At an angle `α` to it the ray is `r·sin α` above it where it
//! begins, `r` from its start, and the coarse surface hides it only if that is less than `δ`. Lambert's law gives the light then a weight of `sin α < δ/r`: no more than this
//! can be taken from a point by its own surface.
//!
//! # What is lit that should not be
//!
//! What lies within `r`, a coarse cell, hides nothing; and the shadows of features that coarse levels lack are gone.

use std::ops::ControlFlow;

use isoray_cell::Cubic;
use isoray_grid::Scalar;
use isoray_octree::lod::DetailView;
use isoray_trace::{Beam, Candidate, Counters, Crossing, DepartingRay, Hit, HitPolicy, Ray, Trace};

use crate::detail::DetailPacketTracer;
use crate::tracer::{TracePackets, Traversal, are_single};

/// Traces as `R` does, but what hides a point from a light is looked for at coarser levels.
pub struct FarShadows<'a, T: Scalar, R> {
    picture: R,
    far: DetailPacketTracer<'a, T>,
    view: &'a DetailView<'a, T>,
    room: Room,
}

/// Room for the rays of a packet.
#[derive(Debug, Default)]
struct Room {
    far: Vec<FarRay>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// Those that are traced as others are.
    exact: Vec<DepartingRay>,
    exact_from: Vec<u32>,
    occluded: Vec<bool>,
}

/// A ray that begins away from the surface that it was sent from.
#[derive(Clone, Copy, Debug)]
struct FarRay {
    /// Its number among those that are traced together.
    from: u32,
    ray: Ray,
    /// On which side of the surface it is taken to begin.
    from_inside: bool,
}

impl<'a, T: Scalar, R: Trace> FarShadows<'a, T, R> {
    /// Traces as `picture` does, and shadows through what `view` shows of the same volume.
    pub fn new(picture: R, view: &'a DetailView<'a, T>) -> Self {
        Self { picture, far: DetailPacketTracer::new(view), view, room: Room::default() }
    }

    /// What is traced in place of a ray, if it starts where a coarse level is drawn.
    fn far(&self, from: u32, ray: &DepartingRay) -> Option<FarRay> {
        let last = self.view.volume().dims().axes().map(|n| n.saturating_sub(2));
        let origin = ray.origin();
        let cell = std::array::from_fn(|a| (origin[a] as u32).min(last[a]));
        let level = self.view.detail().level(cell);
        let length = ray.direction.iter().map(|&d| f64::from(d).powi(2)).sum::<f64>().sqrt();
        let begin = (f64::from(1u32 << level) / length) as f32;
        let far = Ray { t_min: begin, ..ray.rounded() };
        (level > 0).then_some(FarRay { from, ray: far, from_inside: ray.into_inside })
    }
}

/// Whether a ray that lies on one side of a surface comes to the other one.
struct Crosses {
    from_inside: bool,
    does: bool,
}

impl HitPolicy for Crosses {
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        let cubic = Cubic::along(&candidate.corners, &candidate.segment);
        if cubic.first_root().found {
            // If it begins on the other side, it comes back to it only if it ends there.
            self.does = cubic.starts_inside() == self.from_inside || cubic.ends_inside() != self.from_inside;
        }
        if self.does { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn jump(&mut self, hit: &Hit) -> ControlFlow<()> {
        self.does = hit.is_entering != self.from_inside;
        if self.does { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl<T: Scalar> DetailPacketTracer<'_, T> {
    /// Whether it does.
    fn crosses(&mut self, far: &FarRay, isovalue: f32, counters: &mut impl Counters) -> bool {
        let mut policy = Crosses { from_inside: far.from_inside, does: false };
        self.tracer.trace_in_any_order(&far.ray, isovalue, &mut policy, counters);
        policy.does
    }
}

impl<T: Scalar, R: TracePackets> TracePackets for FarShadows<'_, T, R> {
    fn first_hits(
        &mut self,
        rays: &[Ray],
        isovalue: f32,
        traversal: Traversal,
        hits: &mut [Option<Hit>],
        counters: &mut impl Counters,
    ) {
        self.picture.first_hits(rays, isovalue, traversal, hits, counters);
    }

    fn may_hit(&mut self, beam: &Beam, isovalue: f32, counters: &mut impl Counters) -> bool {
        self.picture.may_hit(beam, isovalue, counters)
    }

    fn occluded_all(
        &mut self,
        rays: &[DepartingRay],
        isovalue: f32,
        traversal: Traversal,
        occluded: &mut [bool],
        counters: &mut impl Counters,
    ) {
        assert_eq!(rays.len(), occluded.len(), "one answer for each ray");
        let mut room = std::mem::take(&mut self.room);
        room.far.clear();
        room.exact.clear();
        room.exact_from.clear();
        for (n, ray) in (0..).zip(rays) {
            match self.far(n, ray) {
                Some(far) => room.far.push(far),
                None => {
                    room.exact.push(*ray);
                    room.exact_from.push(n);
                }
            }
        }
        room.occluded.resize(room.exact.len(), false);
        self.picture.occluded_all(&room.exact, isovalue, traversal, &mut room.occluded, counters);
        for (&n, &is_occluded) in room.exact_from.iter().zip(&room.occluded) {
            occluded[n as usize] = is_occluded;
        }
        room.rays.clear();
        room.rays.extend(room.far.iter().map(|far| far.ray));
        room.hits.resize(room.far.len(), None);
        let are_together = !are_single(rays, traversal)
            && self.far.any_hits(&room.rays, isovalue, traversal, &mut room.hits, counters);
        for (far, hit) in room.far.iter().zip(&room.hits) {
            occluded[far.from as usize] = match hit {
                None if are_together => false,
                Some(hit) if are_together && hit.is_entering != far.from_inside => true,
                // Nothing is known, or a crossing by which it leaves what it began in: there may be others.
                _ => self.far.crosses(far, isovalue, counters),
            };
        }
        self.room = room;
    }
}

impl<T: Scalar, R: Trace> Trace for FarShadows<'_, T, R> {
    fn trace(&mut self, ray: &Ray, isovalue: f32, policy: &mut impl HitPolicy, counters: &mut impl Counters) {
        self.picture.trace(ray, isovalue, policy, counters);
    }

    fn trace_departing(
        &mut self,
        ray: &DepartingRay,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        self.picture.trace_departing(ray, isovalue, policy, counters);
    }

    fn crossings(
        &mut self,
        ray: &Ray,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        self.picture.crossings(ray, isovalues, visit, counters)
    }

    fn departing_crossings(
        &mut self,
        ray: &DepartingRay,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        self.picture.departing_crossings(ray, isovalues, visit, counters)
    }

    fn value(&mut self, cell: [u32; 3], local: [f32; 3]) -> Option<f32> {
        self.picture.value(cell, local)
    }

    fn central_gradient(&mut self, hit: &Hit) -> [f32; 3] {
        self.picture.central_gradient(hit)
    }

    fn occluded(&mut self, ray: &DepartingRay, isovalue: f32, counters: &mut impl Counters) -> bool {
        match self.far(0, ray) {
            Some(far) => self.far.crosses(&far, isovalue, counters),
            None => self.picture.occluded(ray, isovalue, counters),
        }
    }
}
