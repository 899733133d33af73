//! The first crossing of an isosurface.

use std::ops::ControlFlow;

use isoray_cell::relative;
use isoray_cell::root::Crossing as CellCrossing;
use isoray_grid::{Scalar, Threshold};
use isoray_octree::OctreeView;

use crate::beam::Beam;
use crate::content::{Content, Finest};
use crate::hit::{AnyHit, Candidate, FirstHit, Hit, HitPolicy};
use crate::jump::jumps;
use crate::march::{March, Slicing};
use crate::normal::CornerGradients;
use crate::ray::{ClippedRay, DepartingRay, Line, Ray};
use crate::several::{CellOnWay, Crossing, Crossings, Departure};
use crate::sweep::Sweep;
use crate::thresholds::Thresholds;
use crate::trace::{Occlusion, Trace, value_in};
use crate::walk::{MixedCell, Walk};
use crate::work::Counters;

/// Traces rays through one volume: the borrowed structure, and the stack that a traversal needs.
///
/// Make one per thread and keep it: tracing allocates nothing, and what a ray found out about some thousand cubes, blocks and cells (half a MB, 0.7 of floating-point samples)
/// is kept for the next, as long as the isovalue stays the same. Rays that follow each other closely, in the tiles of a picture, gain most.
#[derive(Clone, Debug)]
pub struct Tracer<'a, T: Scalar, C = Finest<'a, T>> {
    view: &'a OctreeView<'a, T>,
    walk: Walk<'a, T, C>,
    several: Several<T>,
    gradients: CornerGradients,
}

/// What several isosurfaces need beside the walk.
#[derive(Clone, Debug)]
struct Several<T> {
    /// Those asked for last, and what they are for the walk: nothing if none can have a surface.
    isovalues: Vec<f32>,
    thresholds: Option<Thresholds<T>>,
    /// Room for the crossings in one cell.
    found: Vec<CellCrossing>,
}

impl<'a, T: Scalar> Tracer<'a, T> {
    /// A tracer of the volume behind `view`.
    pub fn new(view: &'a OctreeView<'a, T>) -> Self {
        Self::of(view, Finest::new())
    }
}

impl<'a, T: Scalar, C: Content<'a, T>> Tracer<'a, T, C> {
    /// A tracer of this content, the nodes above which are behind `view`.
    pub(crate) fn of(view: &'a OctreeView<'a, T>, content: C) -> Self {
        let several = Several { isovalues: Vec::new(), thresholds: None, found: Vec::new() };
        Self { view, walk: Walk::new(view, content), several, gradients: CornerGradients::default() }
    }

    pub(crate) fn content(&mut self) -> &mut C {
        &mut self.walk.content
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

    /// Hands to `policy`, in order along the ray, the cells on its path whose corners lie on both sides of
    /// `isovalue`, until it breaks. A ray with a component that is not finite, or without direction, meets none.
    // Out of line, a ray and its hit go through memory: 28 of 170 ns.
    #[inline(always)]
    pub fn trace(
        &mut self,
        ray: &Ray,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        let _ = self.follow(ray, isovalue, policy, counters);
    }

    /// Where a ray enters a box that holds all of the isosurface of `isovalue`, or where it begins in it; `None` if it misses it.
    pub fn entry(&mut self, ray: &Ray, isovalue: f32) -> Option<f64> {
        self.turn_to(isovalue)?;
        ClippedRay::new(ray, self.walk.region.as_ref()?).map(|ray| ray.t_begin)
    }

    /// By how many voxels single precision may misplace the rays of a beam in this volume: `2⁻¹⁹` of the largest distance, along an axis, of a plane of
    /// the octree from their origins. [`sweep`](Self::sweep) takes it into account.
    pub fn margin(&self, beam: &Beam) -> f32 {
        beam.margin(self.walk.outermost_edge()) as f32
    }

    /// Sends `rays`, which are those of `beam`, to the blocks with isosurface of `isovalue` that any of them may meet, until they break, in an order that suits them all: none
    /// meets a block after one that comes later. `None` if there may be more of them, because numbers of the beam are too large, too small or too far
    /// apart for single precision.
    #[inline(always)]
    pub fn sweep(&mut self, beam: &Beam, isovalue: f32, rays: &mut impl Sweep<T>) -> Option<ControlFlow<()>> {
        if self.turn_to(isovalue).is_none() {
            return Some(ControlFlow::Continue(()));
        }
        self.walk.sweep(beam, rays)
    }

    /// What [`sweep`](Self::sweep) does, by slabs: blocks come in another order, that suits all rays too.
    pub fn march(
        &mut self,
        beam: &Beam,
        isovalue: f32,
        slicing: Slicing,
        rays: &mut impl March<T>,
    ) -> Option<ControlFlow<()>> {
        if self.turn_to(isovalue).is_none() {
            return Some(ControlFlow::Continue(()));
        }
        self.walk.march(beam, slicing, rays)
    }

    /// Makes the walk one for `isovalue`; `None` if there can be no surface.
    #[inline(always)]
    fn turn_to(&mut self, isovalue: f32) -> Option<()> {
        let Threshold::AtLeast(first) = T::threshold(isovalue) else { return None };
        let is_same = self.walk.thresholds().is_some_and(|thresholds| thresholds.is_only(first));
        if !(is_same && self.walk.content.is_for(&[isovalue])) {
            self.walk.turn_to(Thresholds { first, others: Vec::new() }, &[isovalue]);
        }
        Some(())
    }

    #[inline(always)]
    pub(crate) fn follow(
        &mut self,
        ray: impl Into<Line>,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        if self.turn_to(isovalue).is_none() {
            return ControlFlow::Continue(());
        }
        self.walk.follow(ray, |mixed: &MixedCell| offer(mixed, isovalue, policy), counters)
    }

    /// Whether a ray that starts on the isosurface, on the finest lattice, is occluded by what is on this one, that of `level`; of the finest it is what
    /// [`Trace::occluded`] tells.
    pub fn is_occluded_on(
        &mut self,
        ray: &DepartingRay,
        level: u32,
        isovalue: f32,
        counters: &mut impl Counters,
    ) -> bool {
        self.follow(Line::from(ray).on_level(level), isovalue, &mut Occlusion::of(ray), counters).is_break()
    }

    pub(crate) fn follow_to_all(
        &mut self,
        line: Line,
        isovalues: &[f32],
        departure: Option<Departure>,
        visit: &mut impl FnMut(&Crossing) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        if self.several.isovalues != isovalues {
            self.several.turn_to(isovalues);
        }
        let Some(thresholds) = &self.several.thresholds else { return ControlFlow::Continue(()) };
        if self.walk.thresholds() != Some(thresholds) || !self.walk.content.is_for(isovalues) {
            self.walk.turn_to(thresholds.clone(), isovalues);
        }
        let found = &mut self.several.found;
        let mut crossings = Crossings { isovalues, departure, t_min: line.t_min.into(), found };
        let in_cell = |mixed: &MixedCell| {
            let MixedCell { cell, samples, segment, interval, beyond } = mixed;
            crossings.cell(&CellOnWay { cell: *cell, samples, segment, interval: *interval, beyond }, visit)
        };
        self.walk.follow(line, in_cell, counters)
    }
}

/// Hands a cell to a policy.
#[inline(always)]
pub(crate) fn offer(mixed: &MixedCell, isovalue: f32, policy: &mut impl HitPolicy) -> ControlFlow<()> {
    let &MixedCell { cell, samples, segment, interval, .. } = mixed;
    let candidate = Candidate { level: 0, cell, corners: relative(&samples, isovalue), segment, interval };
    if let [None, None] = mixed.beyond {
        return policy.candidate(&candidate);
    }
    let [before, behind] = jumps(&candidate, &mixed.beyond, isovalue);
    before.map_or(ControlFlow::Continue(()), |hit| policy.jump(&hit))?;
    policy.candidate(&candidate)?;
    behind.map_or(ControlFlow::Continue(()), |hit| policy.jump(&hit))
}

impl<T: Scalar> Several<T> {
    /// Takes other isovalues.
    #[cold]
    fn turn_to(&mut self, isovalues: &[f32]) {
        let thresholds = isovalues.iter().filter_map(|&isovalue| match T::threshold(isovalue) {
            Threshold::AtLeast(least) => Some(least),
            Threshold::NoSurface => None,
        });
        let mut others: Vec<T> = Vec::new();
        for threshold in thresholds {
            if !others.contains(&threshold) {
                others.push(threshold);
            }
        }
        self.thresholds = (!others.is_empty()).then(|| {
            let first = others.remove(0);
            Thresholds { first, others }
        });
        self.isovalues = isovalues.to_vec();
    }
}

impl<'a, T: Scalar, C: Content<'a, T>> Trace for Tracer<'a, T, C> {
    #[inline(always)]
    fn trace(&mut self, ray: &Ray, isovalue: f32, policy: &mut impl HitPolicy, counters: &mut impl Counters) {
        Tracer::trace(self, ray, isovalue, policy, counters);
    }

    fn trace_departing(
        &mut self,
        ray: &DepartingRay,
        isovalue: f32,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) {
        let _ = self.follow(ray, isovalue, policy, counters);
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
        value_in(&self.view.corners(cell).map(Scalar::to_f32), local)
    }

    fn central_gradient(&mut self, hit: &Hit) -> [f32; 3] {
        self.gradients.of(self.view, hit)
    }
}
