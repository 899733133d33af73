//! Packets through levels of detail.

use isoray_grid::Scalar;
use isoray_octree::lod::DetailView;
use isoray_trace::{Counters, DetailTracer, Hit, Ray};

use crate::tracer::{Packets, TracePackets, Traversal, first_hits_on, first_hits_singly};

/// Through a volume at levels of detail, in one picture.
pub type DetailPacketTracer<'a, T> = Packets<DetailTracer<'a, T>>;

/// Rays that have hit nothing yet: which, as they are on a level's lattice, and what they hit there.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parts {
    left: Vec<u32>,
    rays: Vec<Ray>,
    found: Vec<Option<Hit>>,
}

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
        let Self { tracer, packet, parts: Parts { left, rays: parts, found } } = self;
        if traversal == Traversal::Single || !rays.iter().all(|ray| tracer.has_parts(ray)) {
            return first_hits_singly(tracer, rays, isovalue, hits, counters);
        }
        hits.fill(None);
        left.clear();
        left.extend(0..rays.len() as u32);
        for level in tracer.levels() {
            parts.clear();
            parts.extend(left.iter().map(|&n| tracer.part(&rays[n as usize], level)));
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
