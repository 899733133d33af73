//! The kinds of rays that packets are of.

use isoray_grid::Scalar;
use isoray_trace::{Content, Counters, DepartingRay, Hit, Ray, SurfaceBlock, Trace, Tracer};

use crate::lanes::{F64s, LANES};
use crate::packet::first_hit;
use crate::packlet::Packlet;
use crate::pairs::{Cell, Hits, Rays};

/// Rays of one kind, and what is found out about them.
pub(crate) trait Kind {
    /// Whether they start on the surface: in the cell in which a ray begins, [`at_start`](Self::at_start) tells.
    const DEPART: bool;

    /// What ends a ray.
    type End: Copy;

    /// In single precision, from which the margin allows for a rounding; there is `room` for them.
    fn rounded<'r>(&'r self, room: &'r mut Vec<Ray>) -> &'r [Ray];

    /// Traces ray `n`, which no packet can have.
    fn trace(&mut self, n: usize, tracer: &mut impl Trace, isovalue: f32, counters: &mut impl Counters);

    /// Traces ray `n` by itself on the lattice of a level; whether it ends there.
    fn trace_on<'a, T: Scalar, C: Content<'a, T>>(
        &mut self,
        n: usize,
        tracer: &mut Tracer<'a, T, C>,
        level: u32,
        isovalue: f32,
        counters: &mut impl Counters,
    ) -> bool;

    /// In double precision, on a lattice whose cells are so much longer than those of the rays' own; `ray` tells which ray is in each lane.
    fn lanes(&self, by: f32, ray: impl Fn(usize) -> usize) -> Rays;

    /// Those of the packlet of this number, which is on that lattice.
    fn of_packlet(&self, by: f32, number: usize, packlet: &Packlet) -> Rays;

    /// What ends ray `n` in a cell of a block, found for it alone.
    fn in_block<'a, T: Scalar, B: Content<'a, T>>(
        &self,
        n: usize,
        block: &mut SurfaceBlock<'_, 'a, T, B>,
        place: &Place,
    ) -> Option<Self::End>;

    /// What ends ray `n`, in a lane, in the cell in which it begins.
    fn at_start(&self, n: usize, found: &Hits, lane: usize, cell: &Cell) -> Option<Self::End>;

    /// What a hit in a lane is.
    fn of_lane(found: &Hits, lane: usize, cell: &Cell) -> Self::End;

    /// Ray `n` ends, on the lattice of `level`, earlier than it was known to.
    fn note(&mut self, n: usize, end: Self::End, level: u32);
}

/// A cell of a block, on which lattice, and what is looked for.
pub(crate) struct Place {
    pub(crate) number: u32,
    pub(crate) level: u32,
    pub(crate) isovalue: f32,
}

/// Lengths on the lattice of a level, in those of the finest.
pub(crate) fn scale(level: u32) -> f32 {
    1.0 / (1u64 << level) as f32
}

/// A ray on the lattice of a level.
fn on_level(ray: &Ray, level: u32) -> Ray {
    let by = scale(level);
    let [origin, direction] = [ray.origin, ray.direction].map(|of| of.map(|c| c * by));
    Ray { origin, direction, ..*ray }
}

/// Rays of which the first hits are wanted.
pub(crate) struct Primary<'r> {
    pub(crate) rays: &'r [Ray],
    hits: &'r mut [Option<Hit>],
}

impl<'r> Primary<'r> {
    /// Rays that have hit nothing.
    pub(crate) fn new(rays: &'r [Ray], hits: &'r mut [Option<Hit>]) -> Self {
        assert_eq!(rays.len(), hits.len(), "one hit for each ray");
        hits.fill(None);
        Self { rays, hits }
    }
}

impl Kind for Primary<'_> {
    const DEPART: bool = false;
    type End = Hit;

    #[inline(always)]
    fn rounded<'r>(&'r self, _: &'r mut Vec<Ray>) -> &'r [Ray] {
        self.rays
    }

    fn trace(&mut self, n: usize, tracer: &mut impl Trace, isovalue: f32, counters: &mut impl Counters) {
        counters.alone(1);
        self.hits[n] = first_hit(tracer, &self.rays[n], isovalue, counters);
    }

    fn trace_on<'a, T: Scalar, C: Content<'a, T>>(
        &mut self,
        n: usize,
        tracer: &mut Tracer<'a, T, C>,
        level: u32,
        isovalue: f32,
        counters: &mut impl Counters,
    ) -> bool {
        let hit = first_hit(tracer, &on_level(&self.rays[n], level), isovalue, counters);
        hit.is_some_and(|hit| {
            self.note(n, hit, level);
            true
        })
    }

    #[inline(always)]
    fn lanes(&self, by: f32, ray: impl Fn(usize) -> usize) -> Rays {
        Rays::new(|lane| self.rays[ray(lane)], by)
    }

    #[inline(always)]
    fn of_packlet(&self, _: f32, _: usize, packlet: &Packlet) -> Rays {
        packlet.exactly()
    }

    fn in_block<'a, T: Scalar, B: Content<'a, T>>(
        &self,
        n: usize,
        block: &mut SurfaceBlock<'_, 'a, T, B>,
        place: &Place,
    ) -> Option<Hit> {
        block.first_hit(&on_level(&self.rays[n], place.level), place.number, place.isovalue)
    }

    fn at_start(&self, _: usize, _: &Hits, _: usize, _: &Cell) -> Option<Hit> {
        None
    }

    #[inline(always)]
    fn of_lane(found: &Hits, lane: usize, cell: &Cell) -> Hit {
        found.of(lane, cell)
    }

    #[inline(always)]
    fn note(&mut self, n: usize, hit: Hit, level: u32) {
        self.hits[n] = Some(hit.on_level(level));
    }
}

/// Rays that start on the surface, of which it is wanted whether they meet it again.
pub(crate) struct Departing<'r> {
    rays: &'r [DepartingRay],
    occluded: &'r mut [bool],
}

impl<'r> Departing<'r> {
    /// Rays that have met nothing.
    pub(crate) fn new(rays: &'r [DepartingRay], occluded: &'r mut [bool]) -> Self {
        assert_eq!(rays.len(), occluded.len(), "one answer for each ray");
        occluded.fill(false);
        Self { rays, occluded }
    }
}

impl Kind for Departing<'_> {
    const DEPART: bool = true;
    type End = ();

    fn rounded<'r>(&'r self, room: &'r mut Vec<Ray>) -> &'r [Ray] {
        room.clear();
        room.extend(self.rays.iter().map(DepartingRay::rounded));
        room
    }

    fn trace(&mut self, n: usize, tracer: &mut impl Trace, isovalue: f32, counters: &mut impl Counters) {
        self.occluded[n] = tracer.occluded(&self.rays[n], isovalue, counters);
    }

    fn trace_on<'a, T: Scalar, C: Content<'a, T>>(
        &mut self,
        n: usize,
        tracer: &mut Tracer<'a, T, C>,
        level: u32,
        isovalue: f32,
        counters: &mut impl Counters,
    ) -> bool {
        let is_occluded = tracer.is_occluded_on(&self.rays[n], level, isovalue, counters);
        self.occluded[n] |= is_occluded;
        is_occluded
    }

    fn lanes(&self, by: f32, ray: impl Fn(usize) -> usize) -> Rays {
        let by = F64s::splat(by.into());
        let lanes = |of: &dyn Fn(&DepartingRay) -> f64| F64s::from_fn(|lane| of(&self.rays[ray(lane)]));
        let origin = [0, 1, 2].map(|a| lanes(&|ray| ray.origin()[a]) * by);
        let direction = [0, 1, 2].map(|a| lanes(&|ray| ray.direction[a].into()) * by);
        Rays::from_exact(origin, direction, [F64s::splat(0.0), lanes(&|ray| ray.t_max.into())])
    }

    fn of_packlet(&self, by: f32, number: usize, _: &Packlet) -> Rays {
        self.lanes(by, |lane| (number * LANES + lane).min(self.rays.len() - 1))
    }

    fn in_block<'a, T: Scalar, B: Content<'a, T>>(
        &self,
        n: usize,
        block: &mut SurfaceBlock<'_, 'a, T, B>,
        place: &Place,
    ) -> Option<()> {
        block.occludes(&self.rays[n], place.level, place.number, place.isovalue).then_some(())
    }

    fn at_start(&self, n: usize, found: &Hits, lane: usize, cell: &Cell) -> Option<()> {
        self.rays[n].is_occluded_in(&found.candidate(lane, cell)).then_some(())
    }

    fn of_lane(_: &Hits, _: usize, _: &Cell) {}

    fn note(&mut self, n: usize, (): (), _: u32) {
        self.occluded[n] = true;
    }
}
