//! Isosurfaces in a mesh.

use std::ops::ControlFlow;

use isoray_cell::root::Crossing as CellCrossing;
use isoray_cell::{Cubic, Segment, relative};
use isoray_grid::Stencil;
use isoray_packet::{TracePackets, Traversal, first_hits_singly, occluded_singly};
use isoray_trace::parts::{self, CellOnWay, ClippedRay, CornerGradients, Crossings, Departure, Region};
use isoray_trace::{Beam, Candidate, Counters, Crossing, DepartingRay, Hit, HitPolicy, Ray, Trace};

use crate::hybrid::Split;
use crate::mesh::Mesh;
use crate::range::range;
use crate::samples::fill;
use crate::visit::{BrickAt, Corners, CubeAt, Visit};
use crate::walk::Walk;

/// Traces rays through one mesh to its isosurfaces: hits are exact to the rounding of the cells' arithmetic, as in structured volumes. Make one per thread and
/// keep it.
///
/// Where cells of two levels meet, or parts of one that finer ones touch, both see the same values on their common face but for rounding. What the ray saw at the
/// end of the one is carried into the next, and if that sees another side, the face is hit: so no change of side falls between cells.
#[derive(Clone, Debug)]
pub struct MeshTracer<'m> {
    mesh: &'m Mesh,
    region: Option<Region>,
    walk: Walk,
    /// What the bricks that are kept were filled for.
    isovalues: Vec<f32>,
    found: Vec<CellCrossing>,
    gradients: CornerGradients,
}

impl<'m> MeshTracer<'m> {
    /// A tracer of a mesh.
    pub fn new(mesh: &'m Mesh) -> Self {
        Self {
            mesh,
            region: Region::whole(mesh.dims()),
            walk: Walk::new(mesh),
            isovalues: Vec::new(),
            found: Vec::new(),
            gradients: CornerGradients::default(),
        }
    }

    fn turn_to(&mut self, isovalues: &[f32]) {
        if self.isovalues != isovalues {
            self.isovalues.clear();
            self.isovalues.extend_from_slice(isovalues);
            self.walk.forget();
        }
    }

    fn follow_to_one(
        &mut self,
        ray: Option<ClippedRay>,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        self.turn_to(&[isovalue]);
        let Some(ray) = &ray else { return };
        let found = ToOne { isovalue, policy };
        let mut surfaces =
            Surfaces { mesh: self.mesh, isovalues: &self.isovalues, before: Before::Nothing, found };
        let _ = self.walk.follow(self.mesh, ray, &mut surfaces, counters);
    }

    fn follow_to_all(
        &mut self,
        ray: Option<ClippedRay>,
        isovalues: &[f32],
        departure: Option<Departure>,
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        self.turn_to(isovalues);
        let Some(ray) = &ray else { return ControlFlow::Continue(()) };
        let [t_min, _] = ray.interval();
        let crossings = Crossings { isovalues, departure, t_min, found: &mut self.found };
        let found = ToAll { crossings, visit };
        let mut surfaces =
            Surfaces { mesh: self.mesh, isovalues: &self.isovalues, before: Before::Nothing, found };
        self.walk.follow(self.mesh, ray, &mut surfaces, counters)
    }
}

/// What the ray saw last.
#[derive(Clone, Copy, Debug)]
enum Before {
    /// Nothing: it has just begun, or comes from an empty cell.
    Nothing,
    /// A cell, or more, all of it on that side of all surfaces on which this value is.
    Side(f32),
    /// A cell with some surface.
    Cell(OnWay),
}

/// A cube on the way.
#[derive(Clone, Copy, Debug)]
struct OnWay {
    samples: [f32; 8],
    segment: Segment,
    interval: [f64; 2],
    place: CubeAt,
}

impl OnWay {
    fn candidate(&self, isovalue: f32) -> Candidate {
        let CubeAt { numbers, exponent } = self.place;
        Candidate {
            level: exponent,
            cell: numbers.map(|c| c << exponent),
            corners: relative(&self.samples, isovalue),
            segment: self.segment,
            interval: self.interval,
        }
    }

    /// On which side the ray is where it enters and where it leaves.
    fn sides(&self, isovalue: f32) -> [bool; 2] {
        let cubic = Cubic::along(&relative(&self.samples, isovalue), &self.segment);
        [cubic.starts_inside(), cubic.ends_inside()]
    }

    /// The hit at the face by which the ray comes or, with `end` 1, goes.
    fn hit_at(&self, end: usize, is_entering: bool, isovalue: f32) -> Hit {
        let Candidate { level, cell, corners, segment, interval } = self.candidate(isovalue);
        let local = [segment.entry, segment.exit][end];
        Hit { t: interval[end] as f32, level, cell, local, corners, is_entering }
    }
}

impl Before {
    /// The hit at the face by which the ray enters a cell, if it sees another side there than it did just before.
    fn jump_into(&self, cell: &OnWay, isovalue: f32) -> Option<Hit> {
        let was_inside = match self {
            Self::Nothing => return None,
            &Self::Side(value) => value >= isovalue,
            Self::Cell(before) => before.sides(isovalue)[1],
        };
        let is_inside = cell.sides(isovalue)[0];
        (is_inside != was_inside).then(|| cell.hit_at(0, is_inside, isovalue))
    }

    /// The hit at the face by which it left the last one, into what is all on the side of a value, if that is another.
    fn jump_out(&self, value: f32, isovalue: f32) -> Option<Hit> {
        let Self::Cell(before) = self else { return None };
        let is_inside = value >= isovalue;
        (before.sides(isovalue)[1] != is_inside).then(|| before.hit_at(1, is_inside, isovalue))
    }
}

/// What is found on the way.
trait Find {
    /// In a cell, and before it.
    fn cell(&mut self, cell: &OnWay, before: &Before) -> ControlFlow<()>;

    /// Before what is all on the side of a value.
    fn passes(&mut self, value: f32, before: &Before) -> ControlFlow<()>;
}

struct ToOne<'p, P> {
    isovalue: f32,
    policy: &'p mut P,
}

impl<P: HitPolicy> Find for ToOne<'_, P> {
    #[inline(always)]
    fn cell(&mut self, cell: &OnWay, before: &Before) -> ControlFlow<()> {
        if let Some(hit) = before.jump_into(cell, self.isovalue) {
            self.policy.jump(&hit)?;
        }
        self.policy.candidate(&cell.candidate(self.isovalue))
    }

    #[inline(always)]
    fn passes(&mut self, value: f32, before: &Before) -> ControlFlow<()> {
        match before.jump_out(value, self.isovalue) {
            Some(hit) => self.policy.jump(&hit),
            None => ControlFlow::Continue(()),
        }
    }
}

struct ToAll<'p, V> {
    crossings: Crossings<'p>,
    visit: &'p mut V,
}

impl<V: FnMut(&Crossing) -> ControlFlow<()>> ToAll<'_, V> {
    /// Crossings of several surfaces at one face.
    fn jumps(&mut self, jump: impl Fn(f32) -> Option<Hit>) -> ControlFlow<()> {
        let isovalues = self.crossings.isovalues;
        let hits = isovalues.iter().enumerate();
        let mut jumps: Vec<Crossing> = hits
            .filter_map(|(surface, &isovalue)| Some(Crossing { surface, hit: jump(isovalue)? }))
            .collect();
        // Upwards the least isovalue comes first, downwards the largest.
        jumps.sort_by(|a, b| {
            let order = isovalues[a.surface].total_cmp(&isovalues[b.surface]);
            if a.hit.is_entering { order } else { order.reverse() }
        });
        jumps.iter().try_for_each(|crossing| (self.visit)(crossing))
    }
}

impl<V: FnMut(&Crossing) -> ControlFlow<()>> Find for ToAll<'_, V> {
    fn passes(&mut self, value: f32, before: &Before) -> ControlFlow<()> {
        match before {
            Before::Cell(_) => self.jumps(|isovalue| before.jump_out(value, isovalue)),
            _ => ControlFlow::Continue(()),
        }
    }

    fn cell(&mut self, cell: &OnWay, before: &Before) -> ControlFlow<()> {
        self.jumps(|isovalue| before.jump_into(cell, isovalue))?;
        let on_way = CellOnWay {
            cell: cell.place.numbers,
            samples: &cell.samples,
            segment: &cell.segment,
            interval: cell.interval,
            beyond: &[None, None],
        };
        let exponent = cell.place.exponent;
        let visit = &mut *self.visit;
        self.crossings.cell(&on_way, &mut |crossing: &Crossing| {
            visit(&Crossing { hit: crossing.hit.on_level(exponent), ..*crossing })
        })
    }
}

/// The search for some isosurfaces.
struct Surfaces<'s, F> {
    mesh: &'s Mesh,
    isovalues: &'s [f32],
    before: Before,
    found: F,
}

/// Whether values from `min` to `max` lie on both sides of any isovalue.
fn can_hold(isovalues: &[f32], [min, max]: [f32; 2]) -> bool {
    isovalues.iter().any(|&v| min < v && v <= max)
}

impl<'m, F: Find> Visit<'m> for Surfaces<'_, F> {
    const PASSES: bool = true;

    #[inline(always)]
    fn wants_node(&self, node: u32) -> bool {
        self.wants(self.mesh.ranges[node as usize])
    }

    #[inline(always)]
    fn wants(&self, range: [f32; 2]) -> bool {
        can_hold(self.isovalues, range)
    }

    fn find(&self, brick: &mut parts::Brick, at: &BrickAt<'m>, counters: &mut impl Counters) -> u64 {
        counters.lookups(parts::SAMPLES as u32);
        let whole = at.brick().own & !at.brick().split;
        brick.fill_mixed(|samples| fill(samples, at), self.isovalues, whole);
        // Of some part the values may not be finite.
        let splits = Split::of_brick(at).filter(|(_, split)| {
            let holds = |values: &[f32]| range(values).is_none_or(|range| self.wants(range));
            split.any(&at.mesh.bricks.splits, &holds)
        });
        splits.fold(brick.shown(), |cells, (offset, _)| cells | 1u64 << offset)
    }

    #[inline(always)]
    fn passes(&mut self, [min, max]: [f32; 2]) -> ControlFlow<()> {
        self.passes_cell((min <= max).then_some(max))
    }

    #[inline(always)]
    fn passes_cell(&mut self, value: Option<f32>) -> ControlFlow<()> {
        let before = std::mem::replace(&mut self.before, Before::Nothing);
        let Some(value) = value.filter(|value| value.is_finite()) else { return ControlFlow::Continue(()) };
        self.before = Before::Side(value);
        self.found.passes(value, &before)
    }

    #[inline(always)]
    fn cell(
        &mut self,
        corners: Corners<'m>,
        segment: impl FnOnce() -> Segment,
        interval: [f64; 2],
        place: CubeAt,
    ) -> ControlFlow<()> {
        let cell = OnWay { samples: corners.values(), segment: segment(), interval, place };
        let found = self.found.cell(&cell, &self.before);
        self.before = Before::Cell(cell);
        found
    }
}

impl Trace for MeshTracer<'_> {
    fn trace(&mut self, ray: &Ray, isovalue: f32, policy: &mut impl HitPolicy, counters: &mut impl Counters) {
        let ray = self.region.as_ref().and_then(|region| ClippedRay::of(ray, region));
        self.follow_to_one(ray, isovalue, policy, counters);
    }

    fn trace_departing(
        &mut self,
        ray: &DepartingRay,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        let ray = self.region.as_ref().and_then(|region| ClippedRay::departing(ray, region));
        self.follow_to_one(ray, isovalue, policy, counters);
    }

    fn crossings(
        &mut self,
        ray: &Ray,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let ray = self.region.as_ref().and_then(|region| ClippedRay::of(ray, region));
        self.follow_to_all(ray, isovalues, None, visit, counters)
    }

    fn departing_crossings(
        &mut self,
        ray: &DepartingRay,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let departure = Some(ray.into());
        let ray = self.region.as_ref().and_then(|region| ClippedRay::departing(ray, region));
        self.follow_to_all(ray, isovalues, departure, visit, counters)
    }

    fn value(&mut self, cell: [u32; 3], local: [f32; 3]) -> Option<f32> {
        let point = std::array::from_fn(|a| f64::from(cell[a]) + f64::from(local[a]));
        // In the cell itself, also at its upper faces.
        let octant = (0..3).filter(|&a| local[a] < 1.0).fold(0, |octant, a| octant | 1 << a);
        self.mesh.value(point, octant).map(|value| value as f32)
    }

    fn central_gradient(&mut self, hit: &Hit) -> [f32; 3] {
        let edge = 1i64 << hit.level;
        let last = self.mesh.dims().axes().map(|n| i64::from(n) - 1);
        let gradient = self.gradients.at(hit, || {
            Stencil::new(|at| {
                let p: [i64; 3] =
                    std::array::from_fn(|a| i64::from(hit.cell[a]) + (i64::from(at[a]) - 1) * edge);
                if (0..3).any(|a| p[a] < 0 || p[a] > last[a]) {
                    return None;
                }
                // Any octant that has a value has this one, but for rounding.
                (0..8).find_map(|octant| self.mesh.value(p.map(|c| c as f64), octant)).map(|v| v as f32)
            })
        });
        gradient.map(|g| g / edge as f32)
    }
}

/// Ray by ray.
impl TracePackets for MeshTracer<'_> {
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

    fn may_hit(&mut self, _: &Beam, _: f32, _: &mut impl Counters) -> bool {
        true
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
