//! Packets through levels of detail.

use std::ops::ControlFlow;

use isoray_grid::Scalar;
use isoray_octree::lod::DetailView;
use isoray_trace::{Counters, Crossing, DepartingRay, DetailTracer, Hit, HitPolicy, Ray, Trace};

use crate::packet::Packet;
use crate::tracer::{TracePackets, Traversal, first_hits_on, first_hits_singly};

/// Traces packets of rays, and single ones, through a volume at levels of detail. Make one per thread and picture, as a [`DetailTracer`].
#[derive(Clone, Debug)]
pub struct DetailPacketTracer<'a, T: Scalar> {
    tracer: DetailTracer<'a, T>,
    packet: Packet,
    /// Rays that have hit nothing yet: which, as they are on a level's lattice, and what they hit there.
    left: Vec<u32>,
    parts: Vec<Ray>,
    found: Vec<Option<Hit>>,
}

impl<'a, T: Scalar> DetailPacketTracer<'a, T> {
    /// A tracer of what `view` shows.
    pub fn new(view: &'a DetailView<'a, T>) -> Self {
        let tracer = DetailTracer::new(view);
        Self { tracer, packet: Packet::default(), left: Vec::new(), parts: Vec::new(), found: Vec::new() }
    }
}

impl<T: Scalar> TracePackets for DetailPacketTracer<'_, T> {
    /// Level by level.
    fn first_hits(
        &mut self,
        rays: &[Ray],
        isovalue: f32,
        traversal: Traversal,
        hits: &mut [Option<Hit>],
        counters: &mut impl Counters,
    ) {
        let Self { tracer, packet, left, parts, found } = self;
        let finest = tracer.levels().start;
        let is_whole = |ray: &Ray| tracer.is_outward(ray) && tracer.part(ray, finest).is_some();
        if traversal == Traversal::Single || !rays.iter().all(is_whole) {
            return first_hits_singly(tracer, rays, isovalue, hits, counters);
        }
        hits.fill(None);
        left.clear();
        left.extend(0..rays.len() as u32);
        for level in tracer.levels() {
            parts.clear();
            parts.extend(left.iter().filter_map(|&n| tracer.part(&rays[n as usize], level)));
            found.clear();
            found.resize(left.len(), None);
            first_hits_on(tracer.level(level), packet, (parts, isovalue, traversal), found, counters);
            for (&n, found) in left.iter().zip(&*found) {
                hits[n as usize] = found.map(|hit| hit.on_level(level));
            }
            left.retain(|&n| hits[n as usize].is_none());
        }
    }
}

/// Single rays.
impl<T: Scalar> Trace for DetailPacketTracer<'_, T> {
    #[inline(always)]
    fn trace(&mut self, ray: &Ray, isovalue: f32, policy: &mut impl HitPolicy, counters: &mut impl Counters) {
        self.tracer.trace(ray, isovalue, policy, counters);
    }

    fn trace_departing(
        &mut self,
        ray: &DepartingRay,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        self.tracer.trace_departing(ray, isovalue, policy, counters);
    }

    fn crossings(
        &mut self,
        ray: &Ray,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        self.tracer.crossings(ray, isovalues, visit, counters)
    }

    fn departing_crossings(
        &mut self,
        ray: &DepartingRay,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        self.tracer.departing_crossings(ray, isovalues, visit, counters)
    }

    fn value(&mut self, cell: [u32; 3], local: [f32; 3]) -> Option<f32> {
        self.tracer.value(cell, local)
    }

    fn central_gradient(&mut self, hit: &Hit) -> [f32; 3] {
        self.tracer.central_gradient(hit)
    }

    fn occluded(&mut self, ray: &DepartingRay, isovalue: f32, counters: &mut impl Counters) -> bool {
        self.tracer.occluded(ray, isovalue, counters)
    }
}
