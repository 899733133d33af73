//! Isosurfaces in a grid with macrocells (Parker 1998).

use std::ops::ControlFlow;

use isoray_cell::relative;
use isoray_cell::root::Crossing as CellCrossing;
use isoray_grid::{GridVolume, Samples, Scalar, ScalarType, Threshold, ValueRange};
use wide::f64x4;

use crate::corner::Corner;
use crate::grid_steps::{CORNER_STRIDES, Cubes, GridSteps};
use crate::hierarchy::Hierarchy;
use crate::hit::{AnyHit, Candidate, FirstHit, Hit, HitPolicy};
use crate::normal::CornerGradients;
use crate::ray::{ClippedRay, DepartingRay, Line, Ray};
use crate::region::Region;
use crate::several::{CellOnWay, Crossing, Crossings, Departure};
use crate::trace::{Trace, value_in};
use crate::walk::MixedCell;
use crate::work::Counters;

/// Traces rays through one volume of samples with a hierarchy of macrocells: an array, bricks, or anything that is read at any point.
///
/// It meets the same cells on the same stretches of the ray as [`Tracer`](crate::Tracer), bit for bit, and so finds the same hits. It needs no
/// structure but ranges that take a thirtieth of the array, and so is what to take for small or noisy volumes, which do not compress, and for a
/// program's own arrays. Tracing allocates nothing. Make one per thread and keep it.
#[derive(Clone, Debug)]
pub struct GridTracer<'a, S: Samples> {
    volume: &'a GridVolume<S>,
    hierarchy: Hierarchy<'a, S::Sample>,
    regions: Regions<S::Sample>,
    /// By level, lowest first: where the ray is in the macrocells of that level.
    stack: Box<[Stage]>,
    /// Room for the crossings in one cell.
    found: Vec<CellCrossing>,
    thresholds: Vec<S::Sample>,
    gradients: CornerGradients,
}

/// What is left to do in a macrocell: the ray's position among its parts, and where it leaves.
#[derive(Clone, Copy, Debug)]
struct Stage {
    steps: GridSteps,
    t_end: f64,
}

/// Of the isosurfaces met last, the boxes that they lie in; `None` where there are none.
#[derive(Clone, Debug)]
struct Regions<T> {
    known: Vec<(T, Option<Region>)>,
    /// Which to forget next.
    oldest: usize,
}

/// So many isosurfaces are remembered; a box takes some microseconds to find.
const REGIONS: usize = 16;

impl<T: Scalar> Regions<T> {
    fn new() -> Self {
        Self { known: Vec::with_capacity(REGIONS), oldest: 0 }
    }

    #[inline(always)]
    fn of(&mut self, hierarchy: &Hierarchy<'_, T>, threshold: T) -> Option<Region> {
        match self.known.iter().find(|(known, _)| *known == threshold) {
            Some((_, region)) => *region,
            None => self.find(hierarchy, threshold),
        }
    }

    #[cold]
    fn find(&mut self, hierarchy: &Hierarchy<'_, T>, threshold: T) -> Option<Region> {
        let region = hierarchy.region(|range| One(threshold).can_be_in(range));
        if self.known.len() < REGIONS {
            self.known.push((threshold, region));
        } else {
            self.known[self.oldest] = (threshold, region);
            self.oldest = (self.oldest + 1) % REGIONS;
        }
        region
    }

    /// The box around those of several.
    fn of_all(&mut self, hierarchy: &Hierarchy<'_, T>, thresholds: &[T]) -> Option<Region> {
        let join = |a: Region, b: Region| Region {
            low: a.low.fast_min(b.low),
            high: a.high.fast_max(b.high),
            last: a.last,
        };
        thresholds.iter().filter_map(|&threshold| self.of(hierarchy, threshold)).reduce(join)
    }
}

/// Isosurfaces in the form that compares with samples.
trait Seek<T: Scalar>: Copy {
    /// Whether cells whose corners have this range can hold any of them.
    fn can_be_in(self, range: &ValueRange<T>) -> bool;
    /// Whether the corners lie on both sides of any.
    fn are_mixed(self, corners: &[T; 8]) -> bool;
}

/// A single one.
#[derive(Clone, Copy)]
struct One<T>(T);

impl<T: Scalar> Seek<T> for One<T> {
    #[inline(always)]
    fn can_be_in(self, range: &ValueRange<T>) -> bool {
        range.max >= self.0 && range.min < self.0
    }

    #[inline(always)]
    fn are_mixed(self, corners: &[T; 8]) -> bool {
        let twice = std::array::from_fn(|n| corners[n & 7].into());
        let inside = T::at_least_16(&twice, self.0) & 0xff;
        inside != 0 && inside != 0xff
    }
}

impl<T: Scalar> Seek<T> for &[T] {
    fn can_be_in(self, range: &ValueRange<T>) -> bool {
        self.iter().any(|&threshold| One(threshold).can_be_in(range))
    }

    fn are_mixed(self, corners: &[T; 8]) -> bool {
        self.iter().any(|&threshold| One(threshold).are_mixed(corners))
    }
}

impl<'a, S: Samples> GridTracer<'a, S> {
    /// A tracer of `volume`.
    pub fn new(volume: &'a GridVolume<S>) -> Self {
        Self {
            volume,
            hierarchy: Hierarchy::new(volume.samples().dims(), volume.macrocells()),
            regions: Regions::new(),
            stack: vec![Stage { steps: GridSteps::NOWHERE, t_end: 0.0 }; volume.macrocells().levels().len()]
                .into(),
            found: Vec::new(),
            thresholds: Vec::new(),
            gradients: CornerGradients::default(),
        }
    }

    /// The first crossing of the isosurface of `isovalue`.
    #[inline(always)]
    pub fn first_hit(&mut self, ray: &Ray, isovalue: f32) -> Option<Hit> {
        let mut policy = FirstHit::default();
        self.trace(ray, isovalue, &mut policy, &mut ());
        policy.0
    }

    /// Whether the ray crosses the isosurface of `isovalue` at all.
    #[inline(always)]
    pub fn any_hit(&mut self, ray: &Ray, isovalue: f32) -> bool {
        let mut policy = AnyHit::default();
        self.trace(ray, isovalue, &mut policy, &mut ());
        policy.0
    }

    /// As [`Trace::trace`].
    #[inline(always)]
    pub fn trace(
        &mut self,
        ray: &Ray,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        self.follow_to_one(ray, isovalue, policy, counters);
    }

    #[inline(always)]
    fn follow_to_one(
        &mut self,
        ray: impl Into<Line>,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        let Threshold::AtLeast(threshold) = S::Sample::threshold(isovalue) else { return };
        let visit = |mixed: &MixedCell| {
            let &MixedCell { cell, samples, segment, interval, .. } = mixed;
            policy.candidate(&Candidate {
                level: 0,
                cell,
                corners: relative(&samples, isovalue),
                segment,
                interval,
            })
        };
        let Some(region) = self.regions.of(&self.hierarchy, threshold) else { return };
        let Some(ray) = &ClippedRay::new(ray, &region) else { return };
        let way =
            Way { samples: self.volume.samples(), hierarchy: &self.hierarchy, stack: &mut self.stack, ray };
        let _ = way.follow(One(threshold), visit, counters);
    }

    fn follow_to_all(
        &mut self,
        line: Line,
        isovalues: &[f32],
        departure: Option<Departure>,
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        self.thresholds.clear();
        self.thresholds.extend(isovalues.iter().filter_map(|&isovalue| {
            match S::Sample::threshold(isovalue) {
                Threshold::AtLeast(least) => Some(least),
                Threshold::NoSurface => None,
            }
        }));
        let found = &mut self.found;
        let mut crossings = Crossings { isovalues, departure, t_min: line.t_min.into(), found };
        let in_cell = |mixed: &MixedCell| {
            let MixedCell { cell, samples, segment, interval, beyond } = mixed;
            crossings.cell(&CellOnWay { cell: *cell, samples, segment, interval: *interval, beyond }, visit)
        };
        let Some(region) = self.regions.of_all(&self.hierarchy, &self.thresholds) else {
            return ControlFlow::Continue(());
        };
        let Some(ray) = &ClippedRay::new(line, &region) else { return ControlFlow::Continue(()) };
        let way =
            Way { samples: self.volume.samples(), hierarchy: &self.hierarchy, stack: &mut self.stack, ray };
        way.follow(self.thresholds.as_slice(), in_cell, counters)
    }
}

/// The traversal.
struct Way<'w, S: Samples> {
    samples: &'w S,
    hierarchy: &'w Hierarchy<'w, S::Sample>,
    stack: &'w mut [Stage],
    ray: &'w ClippedRay,
}

impl<S: Samples> Way<'_, S> {
    /// Calls `visit` for the mixed cells on the ray's way, in order, until it breaks.
    #[inline(always)]
    fn follow(
        self,
        seek: impl Seek<S::Sample>,
        mut visit: impl FnMut(&MixedCell) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let (ray, levels) = (self.ray, self.hierarchy.levels());
        let Some(mut number) = levels.len().checked_sub(1) else { return ControlFlow::Continue(()) };
        let backward = ray.backward as usize & 7;
        let mut level = &levels[number];
        let mut cubes = Cubes::new(ray, level.edge, level.inverse);
        let (mut t, mut t_end) = (ray.t_begin, ray.t_end);
        let mut steps = GridSteps::at(ray, &cubes, level.all(), t, |at| level.index(at));
        // Bit `l`: the stage of level `l` is not at its end.
        let mut pending = 0u32;
        loop {
            let leaves = steps.leaves();
            let out = if leaves < t_end { leaves } else { t_end };
            // Where the ray crosses two planes of an axis at once, there is no way between them.
            if t < out && level.range(steps.index()).is_some_and(|range| seek.can_be_in(range)) {
                counters.node();
                let parts = level.parts(steps.cube());
                if number == 0 {
                    self.cells(parts, seek, [t, out], &mut visit, counters)?;
                } else {
                    if out < t_end {
                        steps.cross(ray, &cubes, &level.strides[backward], out);
                        self.stack[number] = Stage { steps, t_end };
                        pending |= 1 << number;
                    }
                    number -= 1;
                    level = &levels[number];
                    cubes = Cubes::new(ray, level.edge, level.inverse);
                    steps = GridSteps::at(ray, &cubes, parts, t, |at| level.index(at));
                    t_end = out;
                    continue;
                }
            }
            t = out;
            if t < t_end {
                steps.cross(ray, &cubes, &level.strides[backward], t);
                continue;
            }
            if pending == 0 {
                return ControlFlow::Continue(());
            }
            number = pending.trailing_zeros() as usize;
            pending &= pending - 1;
            level = &levels[number];
            cubes = Cubes::new(ray, level.edge, level.inverse);
            Stage { steps, t_end } = self.stack[number];
        }
    }

    /// Visits the mixed cells on a stretch through the cells from the first to the last of `cells`.
    #[inline(always)]
    fn cells(
        &self,
        cells: [f64x4; 2],
        seek: impl Seek<S::Sample>,
        [mut t, t_end]: [f64; 2],
        visit: &mut impl FnMut(&MixedCell) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let ray = self.ray;
        let cubes = Cubes::new(ray, 1.0, 1.0);
        let strides = &CORNER_STRIDES[ray.backward as usize & 7];
        let mut steps = GridSteps::at(ray, &cubes, cells, t, |at| Corner::new(at).0);
        loop {
            let leaves = steps.leaves();
            let out = if leaves < t_end { leaves } else { t_end };
            let cell = Corner(steps.index()).coordinates();
            counters.lookups(8);
            let samples = self.samples.corners(cell);
            if seek.are_mixed(&samples)
                && (S::Sample::TYPE != ScalarType::F32 || samples.iter().all(|s| s.is_finite()))
            {
                counters.cell();
                let interval = [t, out];
                let segment = steps.segment(ray, interval);
                let samples = samples.map(S::Sample::to_f32);
                visit(&MixedCell { cell, samples, segment, interval, beyond: [None, None] })?;
            }
            if out >= t_end {
                return ControlFlow::Continue(());
            }
            steps.cross(ray, &cubes, strides, out);
            t = out;
        }
    }
}

impl<S: Samples> Trace for GridTracer<'_, S> {
    #[inline(always)]
    fn trace(&mut self, ray: &Ray, isovalue: f32, policy: &mut impl HitPolicy, counters: &mut impl Counters) {
        GridTracer::trace(self, ray, isovalue, policy, counters);
    }

    fn trace_departing(
        &mut self,
        ray: &DepartingRay,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        self.follow_to_one(ray, isovalue, policy, counters);
    }

    fn crossings(
        &mut self,
        ray: &Ray,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        self.follow_to_all(ray.into(), isovalues, None, visit, counters)
    }

    fn departing_crossings(
        &mut self,
        ray: &DepartingRay,
        isovalues: &[f32],
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        self.follow_to_all(ray.into(), isovalues, Some(ray.into()), visit, counters)
    }

    fn value(&mut self, cell: [u32; 3], local: [f32; 3]) -> Option<f32> {
        value_in(&self.volume.samples().corners(cell).map(S::Sample::to_f32), local)
    }

    fn central_gradient(&mut self, hit: &Hit) -> [f32; 3] {
        self.gradients.of(self.volume.samples(), hit)
    }
}
