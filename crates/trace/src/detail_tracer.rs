//! Rays through levels of detail.

use std::ops::ControlFlow;

use isoray_grid::{Scalar, Stencil};
use isoray_octree::lod::DetailView;

use crate::beam::Beam;
use crate::detailed::Detailed;
use crate::hit::{Candidate, Hit, HitPolicy};
use crate::normal::CornerGradients;
use crate::ray::{DepartingRay, Line, Ray};
use crate::several::{Crossing, Departure};
use crate::trace::{Trace, value_in};
use crate::tracer::Tracer;
use crate::work::Counters;

/// Traces rays through the lattice of one level, to what is drawn at it.
pub type LevelTracer<'a, T> = Tracer<'a, T, Detailed<'a, T>>;

/// Traces rays through a volume at levels of detail that depend on the place: the isosurfaces of the one continuous field that
/// [`DetailView`] describes, on which levels meet without a gap.
///
/// Rays from the eye never come from a level to a finer one, and go through the levels one after the other. All others are sent through every level, and what they meet is put
/// in order.
///
/// No ray passes between inside and outside without a hit, where levels meet neither: both sides of the common face see the same values but for their rounding, and
/// where that decides, the face itself is hit ([`HitPolicy::jump`]).
#[derive(Clone, Debug)]
pub struct DetailTracer<'a, T: Scalar> {
    view: &'a DetailView<'a, T>,
    /// From the finest that is drawn; made when first needed.
    levels: Vec<Option<Box<LevelTracer<'a, T>>>>,
    finest: u32,
    /// Of their levels, from the eye.
    reaches: Vec<[f64; 2]>,
    eye: [f32; 3],
    /// With where the stretch begins of which they are told.
    events: Vec<(f64, Event)>,
    crossings: Vec<Crossing>,
    gradients: CornerGradients,
}

/// Whether numbers can be divided by two as often as there are levels, exactly.
pub fn can_be_divided(numbers: [f32; 3]) -> bool {
    const LEAST: f32 = f32::MIN_POSITIVE * (1u64 << 32) as f32;
    numbers.iter().fold(true, |all, c| all & ((*c == 0.0) | (c.abs() >= LEAST)))
}

/// A stretch without what is not known of it: zero over zero, of rays along slices.
fn told([from, to]: [f64; 2]) -> [f64; 2] {
    let [least, most] = Beam::ALL;
    [if from.is_nan() { least } else { from }, if to.is_nan() { most } else { to }]
}

/// What is told to a policy.
#[derive(Clone, Copy, Debug)]
enum Event {
    Candidate(Candidate),
    Jump(Hit),
}

impl<'a, T: Scalar> DetailTracer<'a, T> {
    /// A tracer of what `view` shows. Make one per thread and picture.
    pub fn new(view: &'a DetailView<'a, T>) -> Self {
        let levels = view.detail().levels();
        Self {
            view,
            finest: *levels.start(),
            reaches: levels.clone().map(|level| view.detail().reach(level)).collect(),
            levels: vec![None; levels.count()],
            eye: view.detail().eye().map(|c| c as f32),
            events: Vec::new(),
            crossings: Vec::new(),
            gradients: CornerGradients::default(),
        }
    }

    /// The levels that may be drawn.
    pub fn levels(&self) -> std::ops::Range<u32> {
        self.finest..self.finest + self.levels.len() as u32
    }

    /// The tracer of a level's lattice.
    pub fn level(&mut self, level: u32) -> &mut LevelTracer<'a, T> {
        let view = self.view;
        self.levels[(level - self.finest) as usize]
            .get_or_insert_with(|| Box::new(Tracer::of(view.lattice(level), Detailed::new(view, level))))
    }

    /// As [`Trace::trace`], but level by level, not in the order of the ray.
    pub fn trace_in_any_order(
        &mut self,
        ray: &Ray,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        let line = Line::from(ray);
        let _ = self
            .levels()
            .try_for_each(|level| self.level(level).follow(line.on_level(level), isovalue, policy, counters));
    }

    /// Whether the levels that the ray comes to never become finer.
    fn is_outward(&self, ray: &Ray) -> bool {
        self.levels.len() == 1 || ray.origin == self.eye
    }

    /// Where the rays of a beam from the eye can be at a level.
    pub fn within(&self, level: u32) -> impl Fn(&Beam) -> [f64; 2] + use<'a, T> {
        let detail = self.view.detail();
        // One level is everywhere.
        let reach = (self.levels.len() > 1).then(|| self.reaches[(level - self.finest) as usize]);
        move |beam| {
            let Some([from, to]) = reach else { return Beam::ALL };
            let [slowest, fastest] = beam.speeds.map(|speeds| detail.length(|a| speeds[a]));
            told([from / fastest, to / slowest])
        }
    }

    /// Where a ray from the eye can be at a level.
    fn stretch(&self, ray: &Ray, level: u32) -> [f32; 2] {
        let speeds = ray.direction.map(|d| f64::from(d.abs()));
        let beam = Beam { speeds: [speeds; 2], ..Beam::nothing(0) };
        // Both are a little more than needed, by more than a rounding to single precision takes away.
        self.within(level)(&beam).map(|t| t as f32)
    }

    /// Of a ray from the eye, the part that can be at a level, on that level's lattice.
    fn line(&self, ray: &Ray, level: u32) -> Line {
        Line::from(ray).on_level(level).within(self.stretch(ray, level))
    }

    /// Whether the rays go through the levels one after the other, and [`part`](Self::part) is a ray of each, bit for bit.
    pub fn have_parts(&self, rays: &[Ray]) -> bool {
        rays.iter()
            .all(|ray| self.is_outward(ray) & can_be_divided(ray.origin) & can_be_divided(ray.direction))
    }

    /// The part of such a ray that can be at a level, on that level's lattice.
    pub fn part(&self, ray: &Ray, level: u32) -> Ray {
        let by = 1.0 / (1u64 << level) as f32;
        let [from, to] = self.stretch(ray, level);
        Ray {
            origin: ray.origin.map(|c| c * by),
            direction: ray.direction.map(|c| c * by),
            t_min: ray.t_min.max(from),
            t_max: ray.t_max.min(to),
        }
    }

    /// The samples around a cell on the lattice of its level. Those in a last plane that is nearer than others are left out, unless they are corners of the cell.
    fn stencil(&mut self, cell: [u32; 3], level: u32) -> Stencil<f32> {
        let whole = self.view.volume().dims().axes().map(|n| (n - 1) >> level);
        let cell = cell.map(|c| c >> level);
        let content = self.level(level).content();
        let corners = content.cell(cell);
        Stencil::new(|index| {
            if index.iter().all(|i| (1..=2).contains(i)) {
                let [x, y, z] = index.map(|i| i as usize - 1);
                return Some(corners[x + 2 * y + 4 * z]);
            }
            let p: [u32; 3] = std::array::from_fn(|a| (cell[a] + index[a]).wrapping_sub(1));
            (0..3).all(|a| p[a] <= whole[a]).then(|| content.sample(p))
        })
    }

    fn trace_in_order(
        &mut self,
        line: Line,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        let mut events = std::mem::take(&mut self.events);
        events.clear();
        for level in self.levels() {
            let mut gather = Gather(&mut events);
            let line = line.on_level(level);
            let _ = self.level(level).follow(line, isovalue, &mut OnLevel(level, &mut gather), counters);
        }
        // Stretches do not overlap, and what is told of one stays together.
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        let _ = events.iter().try_for_each(|(_, event)| match event {
            Event::Candidate(candidate) => policy.candidate(candidate),
            Event::Jump(hit) => policy.jump(hit),
        });
        self.events = events;
    }

    fn crossings_in_order(
        &mut self,
        line: Line,
        isovalues: &[f32],
        departure: Option<Departure>,
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let mut crossings = std::mem::take(&mut self.crossings);
        crossings.clear();
        for level in self.levels() {
            let mut gather = |crossing: &Crossing| {
                crossings.push(Crossing { hit: crossing.hit.on_level(level), ..*crossing });
                ControlFlow::Continue(())
            };
            let _ = self.level(level).follow_to_all(
                line.on_level(level),
                isovalues,
                departure,
                &mut gather,
                counters,
            );
        }
        crossings.sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t));
        let end = crossings.iter().try_for_each(visit);
        self.crossings = crossings;
        end
    }
}

/// Tells a policy of the finest lattice about cells of another one.
struct OnLevel<'p, P>(u32, &'p mut P);

impl<P: HitPolicy> HitPolicy for OnLevel<'_, P> {
    #[inline(always)]
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        let level = self.0;
        self.1.candidate(&Candidate { level, cell: candidate.cell.map(|c| c << level), ..*candidate })
    }

    fn jump(&mut self, hit: &Hit) -> ControlFlow<()> {
        self.1.jump(&hit.on_level(self.0))
    }
}

struct Gather<'e>(&'e mut Vec<(f64, Event)>);

impl HitPolicy for Gather<'_> {
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        let begin = candidate.interval[0];
        // A jump before it came first.
        if let Some((known, Event::Jump(_))) = self.0.last_mut()
            && known.is_nan()
        {
            *known = begin;
        }
        self.0.push((begin, Event::Candidate(*candidate)));
        ControlFlow::Continue(())
    }

    fn jump(&mut self, hit: &Hit) -> ControlFlow<()> {
        let begin = match self.0.last() {
            Some((begin, Event::Candidate(c))) if (c.level, c.cell) == (hit.level, hit.cell) => *begin,
            _ => f64::NAN,
        };
        self.0.push((begin, Event::Jump(*hit)));
        ControlFlow::Continue(())
    }
}

impl<T: Scalar> Trace for DetailTracer<'_, T> {
    fn trace(&mut self, ray: &Ray, isovalue: f32, policy: &mut impl HitPolicy, counters: &mut impl Counters) {
        if !self.is_outward(ray) {
            return self.trace_in_order(ray.into(), isovalue, policy, counters);
        }
        for level in self.levels() {
            let part = self.line(ray, level);
            let end = self.level(level).follow(part, isovalue, &mut OnLevel(level, policy), counters);
            if end.is_break() {
                return;
            }
        }
    }

    fn trace_departing(
        &mut self,
        ray: &DepartingRay,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        self.trace_in_order(ray.into(), isovalue, policy, counters);
    }

    fn crossings(
        &mut self,
        ray: &Ray,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        if !self.is_outward(ray) {
            return self.crossings_in_order(ray.into(), isovalues, None, visit, counters);
        }
        self.levels().try_for_each(|level| {
            let part = self.line(ray, level);
            let mut visit =
                |crossing: &Crossing| visit(&Crossing { hit: crossing.hit.on_level(level), ..*crossing });
            self.level(level).follow_to_all(part, isovalues, None, &mut visit, counters)
        })
    }

    fn departing_crossings(
        &mut self,
        ray: &DepartingRay,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        self.crossings_in_order(ray.into(), isovalues, Some(ray.into()), visit, counters)
    }

    /// In no order.
    fn occluded(&mut self, ray: &DepartingRay, isovalue: f32, counters: &mut impl Counters) -> bool {
        self.levels().any(|level| self.level(level).is_occluded_on(ray, level, isovalue, counters))
    }

    fn value(&mut self, cell: [u32; 3], local: [f32; 3]) -> Option<f32> {
        let level = self.view.detail().level(cell);
        let within: [u32; 3] = cell.map(|c| c & ((1 << level) - 1));
        let width = (1u64 << level) as f32;
        let local = std::array::from_fn(|a| (within[a] as f32 + local[a]) / width);
        let corners = self.level(level).content().cell(cell.map(|c| c >> level));
        value_in(&corners, local)
    }

    /// Between differences on the lattice of the hit's level, across to another level too: there it can jump.
    fn central_gradient(&mut self, hit: &Hit) -> [f32; 3] {
        let mut gradients = std::mem::take(&mut self.gradients);
        let gradient = gradients.at(hit, || self.stencil(hit.cell, hit.level));
        self.gradients = gradients;
        gradient.map(|g| g / (1u64 << hit.level) as f32)
    }
}
