//! Packets through levels of detail.

use isoray_grid::Scalar;
use isoray_octree::lod::DetailView;
use isoray_trace::{Beam, Counters, DepartingRay, DetailTracer, Hit, Ray, can_be_divided};

use crate::kind::{Departing, Kind, Primary, scale};
use crate::packet::{Packet, first_hit, part};
use crate::tracer::{
    Packets, TracePackets, Traversal, are_single, comes_to_a_block, first_hits_singly, is_single,
    occluded_singly,
};

/// Through a volume at levels of detail, in one picture.
pub type DetailPacketTracer<'a, T> = Packets<DetailTracer<'a, T>>;

impl<'a, T: Scalar> DetailPacketTracer<'a, T> {
    /// A tracer of what `view` shows.
    pub fn new(view: &'a DetailView<'a, T>) -> Self {
        Self::of(DetailTracer::new(view))
    }

    /// Some crossing of each ray with the isosurface of `isovalue`, from anywhere: not the first one where it meets several at different levels. Whether that could be
    /// told of them together.
    pub(crate) fn any_hits(
        &mut self,
        rays: &[Ray],
        isovalue: f32,
        traversal: Traversal,
        hits: &mut [Option<Hit>],
        counters: &mut impl Counters,
    ) -> bool {
        let Self { tracer, packet } = self;
        if !rays.iter().all(|ray| can_be_divided(ray.origin) && can_be_divided(ray.direction)) {
            return false;
        }
        let mut primary = Primary::new(rays, hits);
        packet.take(&mut primary, tracer, isovalue, counters);
        packet.follow_everywhere(tracer, &mut primary, isovalue, traversal, counters);
        true
    }
}

impl Packet {
    /// Level by level, in no order.
    fn follow_everywhere<T: Scalar>(
        &mut self,
        tracer: &mut DetailTracer<'_, T>,
        rays: &mut impl Kind,
        isovalue: f32,
        traversal: Traversal,
        counters: &mut impl Counters,
    ) {
        for level in tracer.levels() {
            let part = (level, |_: &Beam| Beam::ALL);
            self.follow(tracer.level(level), rays, isovalue, traversal.slicing(), part, counters);
        }
    }
}

impl<T: Scalar> TracePackets for DetailPacketTracer<'_, T> {
    fn may_hit(&mut self, beam: &Beam, isovalue: f32, counters: &mut impl Counters) -> bool {
        let Self { tracer, .. } = self;
        tracer.levels().any(|level| {
            let part = part(*beam, scale(level), Beam::ALL);
            part.is_none_or(|part| comes_to_a_block(tracer.level(level), &part, isovalue, counters))
        })
    }

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
        let mut primary = Primary::new(rays, hits);
        packet.take(&mut primary, tracer, isovalue, counters);
        let slicing = traversal.slicing();
        let mut are_together = false;
        for level in tracer.levels() {
            // Two tell how far apart they are.
            let parts: [Ray; 2] = std::array::from_fn(|n| tracer.part(&rays[n.min(last)], level));
            if !is_single(tracer.level(level), &parts[..=last.min(1)], isovalue, traversal) {
                are_together = true;
                let within = tracer.within(level);
                packet.follow(
                    tracer.level(level),
                    &mut primary,
                    isovalue,
                    slicing,
                    (level, within),
                    counters,
                );
                continue;
            }
            for n in 0..rays.len() {
                if !packet.is_alive(n) {
                    continue;
                }
                let part = tracer.part(&rays[n], level);
                if let Some(hit) = first_hit(tracer.level(level), &part, isovalue, counters) {
                    primary.note(n, hit, level);
                    packet.end(n);
                }
            }
        }
        match are_together {
            true => packet.count(counters),
            false => counters.alone(packet.taken()),
        }
    }

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
        let mut departing = Departing::new(rays, occluded);
        packet.take(&mut departing, tracer, isovalue, counters);
        packet.follow_everywhere(tracer, &mut departing, isovalue, traversal, counters);
    }
}
