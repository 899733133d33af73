//! The public face.

use std::ops::ControlFlow;

use isoray_grid::{Samples, Scalar};
use isoray_octree::OctreeView;
use isoray_trace::{
    Beam, Content, Counters, Crossing, DepartingRay, GridTracer, Hit, HitPolicy, Ray, Slicing, SurfaceBlock,
    Sweep, Trace, Tracer,
};

use crate::hull::hull;
use crate::kind::{Departing, Primary};
use crate::packet::{Packet, first_hit};

/// How a packet of rays goes through a volume. The hits are the same, bit for bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Traversal {
    /// As packets, unless its rays are too far apart where they enter: more than [`Traversal::WIDEST`] voxels.
    #[default]
    Auto,
    /// One ray after the other.
    Single,
    /// Down the octree as one, and in lanes at its cells.
    Masked,
    /// By slabs across the axis along which they are fastest (Knoll 2009, section 5), and in lanes at the cells of their slices.
    Coherent(Slicing),
}

impl Traversal {
    /// Voxels between neighbouring rays up to which they have enough in common. Measured (`cargo xtask bench packet`): at 0.7 packets of 64 are 1.3 to 1.8
    /// times as fast as single rays, at 1.1 from 0.9 to 1.03 times.
    pub const WIDEST: f64 = 1.0;
    /// Voxels between the starts of neighbouring rays to a light up to which they have enough in common. Measured on heptane: where pixels are 0.1 and 0.2 voxels apart packets
    /// take half the time of single rays, at 0.3 the same, at 0.6 and 0.9 from 1.3 to 1.5 times as much.
    pub const WIDEST_STARTS: f64 = 0.4;

    /// How to go by slabs, if so.
    pub(crate) fn slicing(self) -> Option<Slicing> {
        if let Self::Coherent(slicing) = self { Some(slicing) } else { None }
    }
}

/// What traces packets.
pub trait TracePackets: Trace {
    /// The first crossing of each ray with the isosurface of `isovalue`: what [`Trace::first_hit`] gives for it. Every sixteen rays that follow each
    /// other share lanes, and gain from being close.
    ///
    /// # Panics
    /// Unless there is room for one hit of each ray.
    fn first_hits(
        &mut self,
        rays: &[Ray],
        isovalue: f32,
        traversal: Traversal,
        hits: &mut [Option<Hit>],
        counters: &mut impl Counters,
    );

    /// Whether rays of a beam may hit the isosurface of `isovalue` at all. If not, none does.
    fn may_hit(&mut self, beam: &Beam, isovalue: f32, counters: &mut impl Counters) -> bool;

    /// Which of these rays, which start on the isosurface of `isovalue`, meet it again, or leave it to the other side than is expected of them: what [`Trace::occluded`] tells of each.
    /// Rays that start close to each other and run the same way gain most.
    ///
    /// # Panics
    /// Unless there is room for one answer of each ray.
    fn occluded_all(
        &mut self,
        rays: &[DepartingRay],
        isovalue: f32,
        traversal: Traversal,
        occluded: &mut [bool],
        counters: &mut impl Counters,
    );
}

/// [`TracePackets::occluded_all`] of what has no packets.
///
/// # Panics
/// Unless there is room for one answer of each ray.
pub fn occluded_singly(
    tracer: &mut impl Trace,
    rays: &[DepartingRay],
    isovalue: f32,
    occluded: &mut [bool],
    counters: &mut impl Counters,
) {
    assert_eq!(rays.len(), occluded.len(), "one answer for each ray");
    for (ray, occluded) in rays.iter().zip(occluded) {
        *occluded = tracer.occluded(ray, isovalue, counters);
    }
}

/// Whether rays that start on a surface are better traced each alone: most of the first ones start too far apart.
pub(crate) fn are_single(rays: &[DepartingRay], traversal: Traversal) -> bool {
    const FIRST: usize = 9;
    let is_near = |pair: &&[DepartingRay]| {
        let square: f64 = (0..3).map(|a| (pair[1].origin()[a] - pair[0].origin()[a]).powi(2)).sum();
        square <= Traversal::WIDEST_STARTS * Traversal::WIDEST_STARTS
    };
    match traversal {
        Traversal::Single => true,
        Traversal::Masked | Traversal::Coherent(_) => false,
        Traversal::Auto => {
            let pairs = rays.windows(2).take(FIRST - 1);
            2 * pairs.clone().filter(is_near).count() <= pairs.len()
        }
    }
}

/// [`TracePackets::first_hits`] of what has no packets.
///
/// # Panics
/// Unless there is room for one hit of each ray.
pub fn first_hits_singly(
    tracer: &mut impl Trace,
    rays: &[Ray],
    isovalue: f32,
    hits: &mut [Option<Hit>],
    counters: &mut impl Counters,
) {
    assert_eq!(rays.len(), hits.len(), "one hit for each ray");
    counters.alone(rays.len());
    for (ray, hit) in rays.iter().zip(hits) {
        *hit = first_hit(tracer, ray, isovalue, counters);
    }
}

/// Traces packets of rays, and single ones as `R` does. Make one per thread and keep it.
#[derive(Clone, Debug)]
pub struct Packets<R> {
    pub(crate) tracer: R,
    pub(crate) packet: Packet,
}

/// Through one octree volume.
pub type PacketTracer<'a, T> = Packets<Tracer<'a, T>>;

impl<R> Packets<R> {
    pub(crate) fn of(tracer: R) -> Self {
        Self { tracer, packet: Packet::default() }
    }
}

impl<'a, T: Scalar> PacketTracer<'a, T> {
    /// A tracer of the volume behind `view`.
    pub fn new(view: &'a OctreeView<'a, T>) -> Self {
        Self::of(Tracer::new(view))
    }
}

/// Whether neighbouring rays are so far apart where the first of them enters that it is better to trace each alone.
fn are_apart<'a, T: Scalar, C: Content<'a, T>>(
    tracer: &mut Tracer<'a, T, C>,
    rays: &[Ray],
    isovalue: f32,
) -> bool {
    let [first, next, ..] = rays else { return true };
    let Some(t) = tracer.entry(first, isovalue) else { return false };
    first.square_apart(next, t) > Traversal::WIDEST * Traversal::WIDEST
}

/// Whether rays are better traced each alone, from where the first ones enter a lattice.
pub(crate) fn is_single<'a, T: Scalar, C: Content<'a, T>>(
    tracer: &mut Tracer<'a, T, C>,
    rays: &[Ray],
    isovalue: f32,
    traversal: Traversal,
) -> bool {
    match traversal {
        Traversal::Single => true,
        Traversal::Auto => are_apart(tracer, rays, isovalue),
        Traversal::Masked | Traversal::Coherent(_) => false,
    }
}

/// The first block with surface that a beam meets.
struct AnyBlock<'c, C>(&'c mut C);

impl<T: Scalar, C: Counters> Sweep<T> for AnyBlock<'_, C> {
    fn meets(&mut self, _: [u32; 3], _: u32) -> bool {
        self.0.node();
        true
    }

    fn block<'a, B: Content<'a, T>>(&mut self, _: &mut SurfaceBlock<'_, 'a, T, B>) -> ControlFlow<()> {
        ControlFlow::Break(())
    }
}

/// Whether a beam comes to any block with surface, as far as its hull tells.
pub(crate) fn comes_to_a_block<'a, T: Scalar, C: Content<'a, T>>(
    tracer: &mut Tracer<'a, T, C>,
    beam: &Beam,
    isovalue: f32,
    counters: &mut impl Counters,
) -> bool {
    tracer.sweep(beam, isovalue, &mut AnyBlock(counters)).is_none_or(|swept| swept.is_break())
}

impl<T: Scalar> TracePackets for PacketTracer<'_, T> {
    fn may_hit(&mut self, beam: &Beam, isovalue: f32, counters: &mut impl Counters) -> bool {
        comes_to_a_block(&mut self.tracer, beam, isovalue, counters)
    }

    fn first_hits(
        &mut self,
        rays: &[Ray],
        isovalue: f32,
        traversal: Traversal,
        hits: &mut [Option<Hit>],
        counters: &mut impl Counters,
    ) {
        let Self { tracer, packet } = self;
        if is_single(tracer, rays, isovalue, traversal) {
            return first_hits_singly(tracer, rays, isovalue, hits, counters);
        }
        if let Some(beam) = hull(rays)
            && !comes_to_a_block(tracer, &beam, isovalue, counters)
        {
            hits.fill(None);
            return counters.packet(true);
        }
        let mut rays = Primary::new(rays, hits);
        packet.take(&mut rays, tracer, isovalue, counters);
        packet.follow(tracer, &mut rays, isovalue, traversal.slicing(), (0, |_: &Beam| Beam::ALL), counters);
        packet.count(counters);
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
        if are_single(rays, traversal) {
            return occluded_singly(tracer, rays, isovalue, occluded, counters);
        }
        let mut rays = Departing::new(rays, occluded);
        packet.take(&mut rays, tracer, isovalue, counters);
        packet.follow(tracer, &mut rays, isovalue, traversal.slicing(), (0, |_: &Beam| Beam::ALL), counters);
    }
}

/// One ray after the other.
impl<S: Samples> TracePackets for GridTracer<'_, S> {
    fn may_hit(&mut self, _: &Beam, _: f32, _: &mut impl Counters) -> bool {
        true
    }

    fn first_hits(
        &mut self,
        rays: &[Ray],
        isovalue: f32,
        _: Traversal,
        hits: &mut [Option<Hit>],
        counters: &mut impl Counters,
    ) {
        first_hits_singly(self, rays, isovalue, hits, counters);
    }

    fn occluded_all(
        &mut self,
        rays: &[DepartingRay],
        isovalue: f32,
        _: Traversal,
        occluded: &mut [bool],
        counters: &mut impl Counters,
    ) {
        occluded_singly(self, rays, isovalue, occluded, counters);
    }
}

/// Single rays.
impl<R: Trace> Trace for Packets<R> {
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

    #[inline(always)]
    fn occluded(&mut self, ray: &DepartingRay, isovalue: f32, counters: &mut impl Counters) -> bool {
        self.tracer.occluded(ray, isovalue, counters)
    }
}
