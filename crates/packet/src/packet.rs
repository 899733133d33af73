//! Rays that are on their way together.

use std::ops::ControlFlow;

use isoray_cell::relative;
use isoray_grid::Scalar;
use isoray_octree::CAP_EDGE;
use isoray_trace::{
    Beam, Content, Counters, Extents, FirstHit, Hit, March, Ray, Slicing, SurfaceBlock, Sweep, Trace, Tracer,
};

use crate::frustum::Frustum;
use crate::kind::{Kind, Place, scale};
use crate::lanes::{F32s, F64s, LANES, columns};
use crate::packlet::{Layers, Packlet};
use crate::pairs::{Cell, Facing, Hits, Rays, intersect};

/// Rays of a packlet that meet one cell, from which on they are intersected with it as they are, some lanes idle; fewer wait until lanes can
/// be filled.
const MANY: u32 = LANES as u32 / 4 + 1;

/// A ray that may meet a cell.
#[derive(Clone, Copy, Debug)]
struct Pair {
    ray: u32,
    cell: u32,
}

/// No cell's number.
const NEVER: u32 = u32::MAX;

/// Room for all that a packet needs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Packet {
    packlets: Vec<Packlet>,
    /// The length of a cell of the lattice on which they are now.
    by: f32,
    /// That of those that run to some sides, as they were taken.
    beam: Option<Beam>,
    /// By packlet: its rays in double precision, if they have been needed.
    exactly: Vec<Rays>,
    is_exact: Vec<bool>,
    /// By packlet: those of the current block, if it meets it.
    layers: Vec<Layers>,
    meeting: Vec<usize>,
    /// In the order of the rays.
    cells: Vec<Cell>,
    pending: Vec<Pair>,
    /// By ray: the cell in which it ends.
    hit_in: Vec<u32>,
    rounded: Vec<Ray>,
    /// How many rays have been taken, and whether they have been led to a block.
    taken: usize,
    has_met: bool,
}

impl Packet {
    /// Takes rays, of which nothing is known yet; those that packets cannot have are traced at once.
    pub(crate) fn take<K: Kind>(
        &mut self,
        rays: &mut K,
        tracer: &mut impl Trace,
        isovalue: f32,
        counters: &mut impl Counters,
    ) {
        let rounded = rays.rounded(&mut self.rounded);
        self.packlets.clear();
        self.packlets.extend(rounded.chunks(LANES).map(Packlet::new));
        self.hit_in.clear();
        self.hit_in.resize(rounded.len(), NEVER);
        let count = self.packlets.len();
        self.layers.resize(count.max(self.layers.len()), Layers::NONE);
        self.exactly.resize_with(count.max(self.exactly.len()), || Packlet::new(&[]).exactly());
        self.beam = None;
        self.by = 1.0;
        self.taken = self.packlets.iter().map(Packlet::count).sum();
        self.has_met = false;
        for (packlet, first) in self.packlets.iter().zip((0..).step_by(LANES)) {
            packlet.unusual().for_each(|n| rays.trace(first + n, tracer, isovalue, counters));
        }
    }

    /// How many rays have been taken.
    pub(crate) fn taken(&self) -> usize {
        self.taken
    }

    /// Counts the rays that were taken as a packet, if there were any.
    pub(crate) fn count(&self, counters: &mut impl Counters) {
        if self.taken > 0 {
            counters.packet(!self.has_met);
        }
    }

    /// Whether ray `n` has been taken and has not ended.
    pub(crate) fn is_alive(&self, n: usize) -> bool {
        self.packlets[n / LANES].is_alive(n % LANES)
    }

    /// Ray `n` is not followed any further.
    pub(crate) fn end(&mut self, n: usize) {
        self.packlets[n / LANES].end(n % LANES);
    }

    /// The beam of the rays that run to these sides, as they were taken.
    fn beam(&mut self, backward: u32) -> Beam {
        if let Some(beam) = self.beam
            && beam.backward == backward
        {
            return beam;
        }
        let mut beam = Beam::nothing(backward);
        self.packlets.iter().filter(|packlet| packlet.current() != 0).for_each(|p| p.widen(&mut beam));
        let by = f64::from(self.by).recip();
        for bounds in beam.origins.iter_mut().chain(&mut beam.speeds) {
            *bounds = bounds.map(|c| c * by);
        }
        self.beam = Some(beam);
        beam
    }

    /// Finds what ends `rays`, those taken that have not ended yet, on the lattice of a level, by slabs or block by block. All that they can meet there lies
    /// `within` parts of beams.
    // Never inlined, so that crates share what one of them has compiled: it takes long.
    #[inline(never)]
    pub(crate) fn follow<'a, T: Scalar, C: Content<'a, T>>(
        &mut self,
        tracer: &mut Tracer<'a, T, C>,
        rays: &mut impl Kind,
        isovalue: f32,
        slicing: Option<Slicing>,
        (level, within): (u32, impl Fn(&Beam) -> [f64; 2]),
        counters: &mut impl Counters,
    ) {
        let by = scale(level);
        self.is_exact.clear();
        self.is_exact.resize(self.packlets.len(), false);
        self.packlets.iter_mut().for_each(|packlet| packlet.wait());
        if by != self.by {
            let ratio = by / self.by;
            self.packlets.iter_mut().for_each(|packlet| packlet.scale(ratio));
            self.by = by;
        }
        // Once for each way to face; nearly always there is one.
        while let Some(backward) = self.packlets.iter().find_map(Packlet::facing) {
            self.packlets.iter_mut().for_each(|packlet| packlet.turn_to(backward));
            let beam = self.beam(backward);
            let Some(beam) = part(beam, by, within(&beam)) else { continue };
            let margin = tracer.margin(&beam);
            self.cells.clear();
            let facing = Facing::new(backward);
            let (rays, counters) = (&mut *rays, &mut *counters);
            let mut way = Way {
                packet: self,
                rays,
                level,
                facing,
                backward,
                margin,
                isovalue,
                slicing,
                axis: 0,
                leave: 0.0,
                frustum: None,
                has_ended: false,
                counters,
            };
            let swept = match slicing {
                None => tracer.sweep(&beam, isovalue, &mut way),
                Some(slicing) => tracer.march(&beam, isovalue, slicing, &mut way),
            };
            way.finish();
            if swept.is_none() {
                // Beyond what single precision tells apart.
                for (packlet, first) in self.packlets.iter_mut().zip((0..).step_by(LANES)) {
                    let current = packlet.current();
                    for n in (0..LANES).filter(|lane| current >> lane & 1 == 1) {
                        if rays.trace_on(first + n, tracer, level, isovalue, counters) {
                            packlet.end(n);
                        }
                    }
                }
            }
        }
    }
}

/// A beam on a lattice whose cells are of another length, without what is nowhere `within`; `None` if nothing is left.
pub(crate) fn part(beam: Beam, by: f32, within: [f64; 2]) -> Option<Beam> {
    let [begin, end] = [beam.interval[0].max(within[0]), beam.interval[1].min(within[1])];
    let scaled = |of: [[f64; 3]; 2]| of.map(|bounds| bounds.map(|c| c * f64::from(by)));
    let (origins, speeds) = (scaled(beam.origins), scaled(beam.speeds));
    (begin <= end).then_some(Beam { origins, speeds, interval: [begin, end], ..beam })
}

/// That of a ray alone.
pub(crate) fn first_hit(
    tracer: &mut impl Trace,
    ray: &Ray,
    isovalue: f32,
    counters: &mut impl Counters,
) -> Option<Hit> {
    let mut first = FirstHit::default();
    tracer.trace(ray, isovalue, &mut first, counters);
    first.0
}

/// A packet on its way through the volume.
struct Way<'p, K, C> {
    packet: &'p mut Packet,
    rays: &'p mut K,
    level: u32,
    facing: Facing,
    backward: u32,
    margin: f32,
    isovalue: f32,
    slicing: Option<Slicing>,
    /// Of a march: along which axis it goes, to which plane; what the rays extend to, and whether some have ended since.
    axis: usize,
    leave: f64,
    frustum: Option<Frustum>,
    has_ended: bool,
    counters: &'p mut C,
}

impl<T: Scalar, K: Kind, C: Counters> Sweep<T> for Way<'_, K, C> {
    #[inline(always)]
    fn meets(&mut self, corner: [u32; 3], edge: u32) -> bool {
        self.counters.node();
        let (backward, margin) = (self.backward, self.margin);
        let Packet { packlets, layers, meeting, .. } = &mut *self.packet;
        let mut current = packlets.iter().enumerate().filter(|(_, packlet)| packlet.current() != 0);
        if edge > CAP_EDGE {
            return current.any(|(_, packlet)| packlet.meets(corner, edge as f32, backward, margin));
        }
        meeting.clear();
        meeting.extend(
            current
                .filter(|&(n, packlet)| packlet.enter(corner, backward, margin, &mut layers[n]))
                .map(|(n, _)| n),
        );
        !meeting.is_empty()
    }

    #[inline(always)]
    fn block<'a, B: Content<'a, T>>(&mut self, block: &mut SurfaceBlock<'_, 'a, T, B>) -> ControlFlow<()> {
        self.packet.has_met = true;
        let corner = block.corner();
        let mut cells = block.cells();
        let peculiar = block.peculiar();
        while cells != 0 {
            let number = cells.trailing_zeros();
            cells &= cells - 1;
            self.cell(block, corner, number, peculiar >> number & 1 == 1);
        }
        while self.packet.pending.len() >= LANES {
            self.intersect_pending();
        }
        let left: u32 = self.packet.packlets.iter().map(|packlet| packlet.current().count_ones()).sum();
        // Where most rays wait for an answer, it is better to have it than to go on.
        if 2 * self.packet.pending.len() as u32 > left {
            self.finish();
        }
        if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl<T: Scalar, K: Kind, C: Counters> March<T> for Way<'_, K, C> {
    fn begin(&mut self, axis: usize, planes: [f64; 2]) {
        self.axis = axis;
        self.leave = planes[1];
        self.renew_frustum(planes[0]);
    }

    #[inline(always)]
    fn extents(&mut self, planes: [u32; 2]) -> Option<Extents> {
        if self.has_ended && self.slicing >= Some(Slicing::Active) {
            self.renew_frustum(planes[0].into());
        }
        let frustum = self.frustum.as_ref()?;
        let [low, high] = [planes[0].min(planes[1]), planes[0].max(planes[1])];
        let mut extents = [[low, high - 1]; 3];
        for (a, [least, most]) in frustum.others().into_iter().zip(frustum.between(planes)?) {
            if most < 0.0 {
                return None;
            }
            // Those below 0 become 0, those too large the largest number.
            extents[a] = [least as u32, most as u32];
        }
        Some(extents)
    }

    #[inline(always)]
    fn cube(&mut self) {
        self.counters.node();
    }

    fn looked_up(&mut self) {
        self.counters.lookups(8);
    }
}

impl<K: Kind, C: Counters> Way<'_, K, C> {
    /// Finds out what the rays extend to from a plane on.
    fn renew_frustum(&mut self, enter: f64) {
        let all = self.slicing < Some(Slicing::Active);
        let planes = [enter, self.leave];
        self.frustum = Frustum::new(&self.packet.packlets, self.axis, planes, all, self.margin);
        self.has_ended = false;
    }

    /// The packlets that meet the block, in one of its cells.
    #[inline(always)]
    fn cell<'a, T: Scalar, B: Content<'a, T>>(
        &mut self,
        block: &mut SurfaceBlock<'_, 'a, T, B>,
        corner: [u32; 3],
        number: u32,
        is_peculiar: bool,
    ) {
        let mut cell = None;
        for n in 0..self.packet.meeting.len() {
            let Packet { packlets, layers, meeting, cells, pending, .. } = &mut *self.packet;
            let packlet = meeting[n];
            let mut met = layers[packlet].met(number) & packlets[packlet].current();
            if met == 0 {
                continue;
            }
            if cell.is_none() {
                let Some(samples) = block.corners(number) else { return };
                self.counters.packet_cell();
                if self.slicing.is_none_or(|slicing| slicing == Slicing::Mixed) {
                    self.counters.lookups(8);
                }
                let offset = block.offset(number);
                let corner = std::array::from_fn(|a| corner[a] + offset[a]);
                cells.push(Cell { corner, values: relative(&samples, self.isovalue) });
                cell = Some(cells.len() as u32 - 1);
            }
            let cell = cell.unwrap_or_default();
            (0..met.count_ones()).for_each(|_| self.counters.cell());
            if is_peculiar {
                let place = Place { number, level: self.level, isovalue: self.isovalue };
                while met != 0 {
                    let ray = packlet * LANES + met.trailing_zeros() as usize;
                    met &= met - 1;
                    if let Some(end) = self.rays.in_block(ray, block, &place) {
                        self.note(ray, cell, end);
                    }
                }
                continue;
            }
            if met.count_ones() >= MANY {
                self.intersect_packlet(packlet, cell, met);
                continue;
            }
            while met != 0 {
                pending.push(Pair { ray: (packlet * LANES) as u32 + met.trailing_zeros(), cell });
                met &= met - 1;
            }
        }
    }

    /// Intersects rays of one packlet with one cell.
    #[inline(always)]
    fn intersect_packlet(&mut self, packlet: usize, number: u32, lanes: u32) {
        let Packet { packlets, exactly, is_exact, cells, by, .. } = &mut *self.packet;
        let cell = cells[number as usize];
        let corner = cell.corner.map(|c| F64s::splat(c.into()));
        if !is_exact[packlet] {
            exactly[packlet] = self.rays.of_packlet(*by, packlet, &packlets[packlet]);
            is_exact[packlet] = true;
        }
        let values = cell.values.map(F32s::splat);
        let found = intersect(&exactly[packlet], corner, &values, &self.facing, lanes, K::DEPART);
        let Some(found) = found else { return };
        self.note_lanes(&found, |lane| Pair { ray: (packlet * LANES + lane) as u32, cell: number });
    }

    /// Intersects as many pairs as there are lanes, those that wait longest.
    #[inline(always)]
    fn intersect_pending(&mut self) {
        let Packet { pending, cells, by, .. } = &mut *self.packet;
        let count = pending.len().min(LANES);
        let Some(last) = count.checked_sub(1) else { return };
        let pairs: [Pair; LANES] = std::array::from_fn(|n| pending[n.min(last)]);
        pending.drain(..count);
        let rays = self.rays.lanes(*by, |n| pairs[n].ray as usize);
        let cell = |n: usize| &cells[pairs[n].cell as usize];
        let corner = std::array::from_fn(|a| F64s::from_fn(|n| f64::from(cell(n).corner[a] as i32)));
        let values = columns(|n| cell(n).values);
        let found = intersect(&rays, corner, &values, &self.facing, (1 << count) - 1, K::DEPART);
        let Some(found) = found else { return };
        self.note_lanes(&found, |lane| pairs[lane]);
    }

    /// Takes note of all lanes that end.
    #[inline(always)]
    fn note_lanes(&mut self, found: &Hits, pair: impl Fn(usize) -> Pair) {
        let mut lanes = found.lanes;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let Pair { ray, cell } = pair(lane);
            let end = K::of_lane(found, lane, &self.packet.cells[cell as usize]);
            self.note(ray as usize, cell, end);
        }
        let mut starting = found.starting;
        while starting != 0 {
            let lane = starting.trailing_zeros() as usize;
            starting &= starting - 1;
            let Pair { ray, cell } = pair(lane);
            let end = self.rays.at_start(ray as usize, found, lane, &self.packet.cells[cell as usize]);
            if let Some(end) = end {
                self.note(ray as usize, cell, end);
            }
        }
    }

    /// Ray `n` ends in a cell; so it goes no further. What it meets in earlier ones may not be known yet.
    #[inline(always)]
    fn note(&mut self, n: usize, cell: u32, end: K::End) {
        self.packet.packlets[n / LANES].end(n % LANES);
        self.has_ended = true;
        let hit_in = &mut self.packet.hit_in[n];
        if cell < *hit_in {
            *hit_in = cell;
            self.rays.note(n, end, self.level);
        }
    }

    /// Intersects all that waits.
    fn finish(&mut self) {
        while !self.packet.pending.is_empty() {
            self.intersect_pending();
        }
    }
}
