//! Packets through levels of detail.

use isoray_grid::Scalar;
use isoray_octree::lod::DetailView;
use isoray_trace::{
    Beam, Counters, DepartingRay, DetailTracer, Hit, LevelTracer, Ray, Trace, can_be_divided,
};

use crate::kind::{Departing, Primary, scaled};
use crate::packet::first_hit;
use crate::tracer::{
    ALL, Packets, TracePackets, Traversal, are_single, first_hits_singly, is_single, occluded_singly,
};

/// Through a volume at levels of detail, in one picture.
pub type DetailPacketTracer<'a, T> = Packets<DetailTracer<'a, T>>;

impl<'a, T: Scalar> DetailPacketTracer<'a, T> {
    /// A tracer of what `view` shows.
    pub fn new(view: &'a DetailView<'a, T>) -> Self {
        Self::of(DetailTracer::new(view))
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
        let Self { tracer, packet } = self;
        let Some(last) = rays.len().checked_sub(1) else { return };
        if traversal == Traversal::Single || !tracer.have_parts(rays) {
            return first_hits_singly(tracer, rays, isovalue, hits, counters);
        }
        assert_eq!(rays.len(), hits.len(), "one hit for each ray");
        hits.fill(None);
        packet.take(rays, |n| {
            counters.alone(1);
            hits[n] = first_hit(tracer, &rays[n], isovalue, counters);
        });
        let mut primary = Primary { rays, hits };
        let taken = (0..rays.len()).filter(|&n| packet.is_alive(n)).count();
        let mut are_together = false;
        for level in tracer.levels() {
            // Two tell how far apart they are.
            let parts: [Ray; 2] = std::array::from_fn(|n| tracer.part(&rays[n.min(last)], level));
            let alone = |part: &Ray,
                         on_level: &mut LevelTracer<'_, T>,
                         rays: &mut Primary<'_>,
                         n: usize,
                         counters: &mut _| {
                let hit = first_hit(on_level, part, isovalue, counters);
                rays.hits[n] = hit.map(|hit| hit.on_level(level));
                hit.is_some()
            };
            if is_single(tracer.level(level), &parts[..=last.min(1)], isovalue, traversal) {
                for n in 0..rays.len() {
                    let part = tracer.part(&rays[n], level);
                    if packet.is_alive(n) && alone(&part, tracer.level(level), &mut primary, n, counters) {
                        packet.end(n);
                    }
                }
                continue;
            }
            are_together = true;
            let within = tracer.within(level);
            let by = 1.0 / (1u64 << level) as f32;
            let alone =
                |on_level: &mut LevelTracer<'_, T>, rays: &mut Primary<'_>, n: usize, counters: &mut _| {
                    alone(&scaled(&rays.rays[n], by), on_level, rays, n, counters)
                };
            packet.follow(tracer.level(level), &mut primary, isovalue, (level, within), alone, counters);
        }
        match are_together {
            true => packet.count(counters),
            false => counters.alone(taken),
        }
    }

    /// Level by level, in no order.
    fn occluded_all(
        &mut self,
        rays: &[DepartingRay],
        isovalue: f32,
        traversal: Traversal,
        occluded: &mut [bool],
        counters: &mut impl Counters,
    ) {
        let Self { tracer, packet } = self;
        if are_single(rays, traversal) || !rays.iter().all(|ray| can_be_divided(ray.direction)) {
            return occluded_singly(tracer, rays, isovalue, occluded, counters);
        }
        occluded.fill(false);
        packet.take_departing(rays, |n| occluded[n] = tracer.occluded(&rays[n], isovalue, counters));
        let mut departing = Departing { rays, occluded };
        for level in tracer.levels() {
            let alone =
                |on_level: &mut LevelTracer<'_, T>, rays: &mut Departing<'_>, n: usize, counters: &mut _| {
                    let is_occluded = on_level.is_occluded_on(&rays.rays[n], level, isovalue, counters);
                    rays.occluded[n] |= is_occluded;
                    is_occluded
                };
            packet.follow(
                tracer.level(level),
                &mut departing,
                isovalue,
                (level, |_: &Beam| ALL),
                alone,
                counters,
            );
        }
    }
}
