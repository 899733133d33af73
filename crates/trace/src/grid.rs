//! Isosurfaces in a grid with macrocells (Parker 1998).

use std::ops::ControlFlow;

use isoray_cell::relative;
use isoray_cell::root::Crossing as CellCrossing;
use isoray_grid::{GridVolume, MacrocellLevel, Samples, Scalar, ScalarType, Threshold, ValueRange};

use crate::grid_steps::{GridSteps, Strides};
use crate::hit::{AnyHit, Candidate, FirstHit, Hit, HitPolicy};
use crate::normal::central_gradient;
use crate::ray::{ClippedRay, DepartingRay, Line, Ray};
use crate::region::Region;
use crate::several::{CellOnWay, Crossing, Crossings, Departure};
use crate::trace::Trace;
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
    /// `None`: there are no cells.
    region: Option<Region>,
    /// By level, lowest first: where the ray is in the macrocells of that level.
    stack: Vec<Stage>,
    /// Room for the crossings in one cell.
    found: Vec<CellCrossing>,
    thresholds: Vec<S::Sample>,
}

/// A stretch of the ray in a grid.
#[derive(Clone, Copy, Debug)]
struct Stage {
    steps: GridSteps,
    t: f64,
    t_end: f64,
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
        let inside = corners.iter().fold(0, |n, &s| n + u32::from(s >= self.0));
        inside != 0 && inside != 8
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
            region: Region::whole(volume.samples().dims()),
            stack: Vec::with_capacity(volume.macrocells().levels().len()),
            found: Vec::new(),
            thresholds: Vec::new(),
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
            let &MixedCell { cell, samples, segment, interval } = mixed;
            policy.candidate(&Candidate { cell, corners: relative(&samples, isovalue), segment, interval })
        };
        let way = Way { volume: self.volume, region: &self.region, stack: &mut self.stack };
        let _ = way.follow(ray, One(threshold), visit, counters);
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
            let MixedCell { cell, samples, segment, interval } = mixed;
            crossings.cell(&CellOnWay { cell: *cell, samples, segment, interval: *interval }, visit)
        };
        let way = Way { volume: self.volume, region: &self.region, stack: &mut self.stack };
        way.follow(line, self.thresholds.as_slice(), in_cell, counters)
    }
}

/// The traversal.
struct Way<'w, S: Samples> {
    volume: &'w GridVolume<S>,
    region: &'w Option<Region>,
    stack: &'w mut Vec<Stage>,
}

impl<S: Samples> Way<'_, S> {
    /// Calls `visit` for the mixed cells on the ray's way, in order, until it breaks.
    #[inline(always)]
    fn follow(
        self,
        ray: impl Into<Line>,
        seek: impl Seek<S::Sample>,
        mut visit: impl FnMut(&MixedCell) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let Some(region) = self.region else { return ControlFlow::Continue(()) };
        let Some(ray) = &ClippedRay::new(ray, region) else { return ControlFlow::Continue(()) };
        let levels = self.volume.macrocells().levels();
        let Some(mut level) = levels.len().checked_sub(1) else { return ControlFlow::Continue(()) };
        let strides = Strides::new(ray);
        let begin = |level: &MacrocellLevel<S::Sample>, t, t_end| Stage {
            steps: GridSteps::at(ray, level.edge(), t),
            t,
            t_end,
        };
        // Those above the level at hand; it is itself in `stage`.
        self.stack.clear();
        let mut stage = begin(&levels[level], ray.t_begin, ray.t_end);
        loop {
            if stage.t >= stage.t_end {
                let Some(above) = self.stack.pop() else { return ControlFlow::Continue(()) };
                stage = above;
                level += 1;
                continue;
            }
            let [x, y, z] = stage.steps.index().map(|c| c as usize);
            let t = stage.t;
            let leaves = stage.steps.leaves();
            stage.t = if leaves < stage.t_end { leaves } else { stage.t_end };
            stage.steps.cross(ray, &strides, leaves);
            let [nx, ny, _] = levels[level].blocks().map(|n| n as usize);
            let range = levels[level].ranges().get(x + nx * (y + ny * z));
            if !range.is_some_and(|range| seek.can_be_in(range)) {
                continue;
            }
            counters.node();
            if level == 0 {
                self.cells(ray, &strides, seek, [t, stage.t], &mut visit, counters)?;
                continue;
            }
            level -= 1;
            let below = begin(&levels[level], t, stage.t);
            self.stack.push(stage);
            stage = below;
        }
    }

    /// Visits the mixed cells on a stretch.
    #[inline(always)]
    fn cells(
        &self,
        ray: &ClippedRay,
        strides: &Strides,
        seek: impl Seek<S::Sample>,
        [mut t, t_end]: [f64; 2],
        visit: &mut impl FnMut(&MixedCell) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let mut steps = GridSteps::at(ray, 1, t);
        loop {
            let leaves = steps.leaves();
            let out = if leaves < t_end { leaves } else { t_end };
            let cell = steps.index();
            counters.lookups(8);
            let samples = self.volume.samples().corners(cell);
            if seek.are_mixed(&samples)
                && (S::Sample::TYPE != ScalarType::F32 || samples.iter().all(|s| s.is_finite()))
            {
                counters.cell();
                let interval = [t, out];
                let segment = steps.segment(ray, interval);
                visit(&MixedCell { cell, samples: samples.map(S::Sample::to_f32), segment, interval })?;
            }
            if out >= t_end {
                return ControlFlow::Continue(());
            }
            steps.cross(ray, strides, out);
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

    fn corners(&self, cell: [u32; 3]) -> [f32; 8] {
        self.volume.samples().corners(cell).map(S::Sample::to_f32)
    }

    fn central_gradient(&self, hit: &Hit) -> [f32; 3] {
        central_gradient(self.volume.samples(), hit)
    }
}
