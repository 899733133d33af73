//! First hits in an octree volume.

use std::hint::black_box;

use isoray_octree::OctreeVolume;
use isoray_packet::{PacketTracer, TracePackets, Traversal};
use isoray_trace::{Ray, Tracer};

use super::{Answer, ISOVALUE, Viewing, dims, octree};
use crate::knoll2006::PaperOctree;
use crate::volumes::marschner_lobb;

/// A picture of the Marschner-Lobb signal; the depth of its hits is what is found.
#[derive(Debug)]
pub struct Rays {
    volume: OctreeVolume<u8>,
    /// Packet by packet.
    rays: Vec<Ray>,
}

impl Rays {
    /// Samples along each edge of the volume.
    pub const EDGE: usize = super::EDGE;
    /// Pixels along each side.
    const PIXELS: u32 = 128;
    /// And along those of a packet.
    const PACKET: u32 = 8;

    /// The rays of a view of it.
    pub fn new(viewing: Viewing) -> Self {
        let view = viewing(dims(), Self::PIXELS, Self::PIXELS);
        let rays = view.packets(Self::PACKET).iter().map(|&direction| view.ray(direction)).collect();
        Self { volume: octree(&marschner_lobb(Self::EDGE)), rays }
    }

    /// The same volume as the system of the 2006 paper has it.
    pub fn paper() -> PaperOctree<u8> {
        PaperOctree::build(dims(), &marschner_lobb(Self::EDGE))
    }

    /// How many.
    pub fn count(&self) -> u64 {
        self.rays.len() as u64
    }

    /// One after the other.
    #[inline(never)]
    pub fn single(&self) -> Answer {
        let view = self.volume.view();
        let mut tracer = Tracer::new(&view);
        let hits = self.rays.iter().filter_map(|ray| tracer.first_hit(ray, ISOVALUE));
        Answer::of(hits.map(|hit| f64::from(hit.t)))
    }

    /// As [`single`](Self::single), with the gradients at the hits, which the other system has too: the answer is the same.
    #[inline(never)]
    pub fn with_gradients(&self) -> Answer {
        let view = self.volume.view();
        let mut tracer = Tracer::new(&view);
        let hits = self.rays.iter().filter_map(|ray| tracer.first_hit(ray, ISOVALUE));
        Answer::of(hits.map(|hit| {
            black_box(hit.gradient());
            f64::from(hit.t)
        }))
    }

    /// Hits and gradients by the system of the 2006 paper.
    #[inline(never)]
    pub fn by_paper(&self, paper: &PaperOctree<u8>) -> Answer {
        let rays = self.rays.iter();
        let hits = rays.filter_map(|ray| paper.first_hit(ray.origin, ray.direction, ISOVALUE));
        Answer::of(hits.map(|hit| {
            black_box(hit.gradient);
            f64::from(hit.t)
        }))
    }

    /// By packets of 8².
    #[inline(never)]
    pub fn packets(&self, traversal: Traversal) -> Answer {
        let view = self.volume.view();
        let mut tracer = PacketTracer::new(&view);
        let mut hits = [None; (Self::PACKET * Self::PACKET) as usize];
        let packets = self.rays.chunks_exact(hits.len()).flat_map(|rays| {
            tracer.first_hits(rays, ISOVALUE, traversal, &mut hits, &mut ());
            hits
        });
        Answer::of(packets.flatten().map(|hit| f64::from(hit.t)))
    }
}
