//! Packets through levels of detail.

use isoray_grid::Scalar;
use isoray_octree::lod::DetailView;
use isoray_trace::{Counters, DetailTracer, Hit, Ray};

use crate::packet::first_hit;
use crate::tracer::{Packets, TracePackets, Traversal, first_hits_singly, is_single};

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
        hits.fill(None);
        packet.take(rays, |n| hits[n] = first_hit(tracer, &rays[n], isovalue, counters));
        for level in tracer.levels() {
            // Two tell how far apart they are.
            let parts: [Ray; 2] = std::array::from_fn(|n| tracer.part(&rays[n.min(last)], level));
            if is_single(tracer.level(level), &parts[..=last.min(1)], isovalue, traversal) {
                for n in 0..rays.len() {
                    if !packet.is_alive(n) {
                        continue;
                    }
                    let part = tracer.part(&rays[n], level);
                    if let Some(hit) = first_hit(tracer.level(level), &part, isovalue, counters) {
                        hits[n] = Some(hit.on_level(level));
                        packet.end(n);
                    }
                }
                continue;
            }
            let within = tracer.within(level);
            packet.follow(tracer.level(level), (rays, isovalue), (level, within), hits, counters);
        }
    }
}
