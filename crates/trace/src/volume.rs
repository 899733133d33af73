//! Emission and absorption along a ray.

use std::ops::ControlFlow;

use isoray_cell::Segment;
use isoray_grid::Scalar;
use isoray_octree::{Node, OctreeView};
use isoray_preint::{Integrate, Lighting, Radiance, Segments, Visibility};

use crate::block::Steps;
use crate::brick::Bricks;
use crate::descent::{BlockVisit, Descent, Search};
use crate::ray::{ClippedRay, Ray, least, least_lane};
use crate::region::Region;
use crate::shown::Shown;
use crate::work::Counters;

/// Integrates emission and absorption along rays through one volume.
///
/// Cells, and whole regions, whose values the transfer function hides are passed by; the inside of a scalar leaf is one segment. Make one per
/// thread and keep it, as with [`Tracer`](crate::Tracer).
#[derive(Clone, Debug)]
pub struct VolumeTracer<'a, T: Scalar> {
    view: &'a OctreeView<'a, T>,
    visible: Visibility,
    shown: Shown<T>,
    /// Where anything can be visible; `None`: nowhere.
    region: Option<Region>,
    descent: Descent<'a, T>,
    bricks: Bricks,
    segments: Segments,
}

impl<'a, T: Scalar> VolumeTracer<'a, T> {
    /// A tracer of what is `visible` of the volume behind `view`.
    pub fn new(view: &'a OctreeView<'a, T>, visible: &Visibility) -> Self {
        let shown = Shown::new(visible);
        Self {
            view,
            region: Region::new(view, |node| shown.children(node)),
            shown,
            visible: visible.clone(),
            descent: Descent::new(),
            bricks: Bricks::new(),
            segments: Segments::default(),
        }
    }

    /// What `scheme` gathers along the ray, front to back, a unit of whose parameter is `world_per_t` long in the world.
    ///
    /// A ray with a component that is not finite, or without direction, gathers nothing.
    pub fn integrate(
        &mut self,
        ray: &Ray,
        world_per_t: f64,
        scheme: &impl Integrate,
        lighting: Option<&Lighting>,
        counters: &mut impl Counters,
    ) -> Radiance {
        let mut radiance = Radiance::default();
        let Some(region) = &self.region else { return radiance };
        let Some(ray) = &ClippedRay::new(ray, region) else { return radiance };
        self.segments.clear();
        let mut search = Integral {
            view: self.view,
            visible: &self.visible,
            shown: &self.shown,
            bricks: &mut self.bricks,
            segments: &mut self.segments,
            ray,
            world_per_t,
            scheme,
            lighting,
            radiance: &mut radiance,
        };
        if self.descent.follow(self.view, ray, &mut search, counters).is_continue() {
            let _ = search.flush();
        }
        radiance
    }
}

/// The search for what is visible.
struct Integral<'s, 'a, T: Scalar, I> {
    view: &'a OctreeView<'a, T>,
    visible: &'s Visibility,
    shown: &'s Shown<T>,
    bricks: &'s mut Bricks,
    segments: &'s mut Segments,
    ray: &'s ClippedRay,
    world_per_t: f64,
    scheme: &'s I,
    lighting: Option<&'s Lighting>,
    radiance: &'s mut Radiance,
}

impl<T: Scalar, I: Integrate> Integral<'_, '_, T, I> {
    /// Integrates the segments gathered so far.
    #[inline(never)]
    fn flush(&mut self) -> ControlFlow<()> {
        self.scheme.integrate(self.segments, self.lighting, self.radiance);
        self.segments.clear();
        if self.radiance.is_done { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    #[inline(always)]
    fn flush_if_full(&mut self) -> ControlFlow<()> {
        if self.segments.is_full() { self.flush() } else { ControlFlow::Continue(()) }
    }

    #[inline(always)]
    fn length(&self, [begin, end]: [f64; 2]) -> f32 {
        ((end - begin) * self.world_per_t) as f32
    }
}

impl<'a, T: Scalar, I: Integrate> Search<'a, T> for Integral<'_, 'a, T, I> {
    const SEES_INSIDE: bool = true;

    #[inline(always)]
    fn active(&self, node: &Node<T::Stored>) -> u32 {
        self.shown.children(node)
    }

    #[inline(always)]
    fn sees_inside(&self, value: T) -> bool {
        self.shown.has(value) && value.is_finite()
    }

    #[inline(always)]
    fn inside(&mut self, value: T, interval: [f64; 2]) -> ControlFlow<()> {
        let length = self.length(interval);
        self.segments.push_constant(value.to_f32(), length);
        self.flush_if_full()
    }

    #[inline(never)]
    fn block(&mut self, visit: BlockVisit<'_, 'a, T>, counters: &mut impl Counters) -> ControlFlow<()> {
        let (ray, place, mut t) = (self.ray, visit.place, visit.t);
        let brick = self.bricks.of(place, |brick| {
            counters.lookups(125);
            brick.fill(self.view, visit.path, place, visit.own(self.view), self.visible);
        });
        if brick.shown() == 0 {
            return ControlFlow::Continue(());
        }
        let mut steps = Steps::at(ray, place.center, visit.mid, t);
        loop {
            let t_out = least(least_lane(steps.far), visit.t_end);
            let offset = steps.offset(ray);
            if brick.shown() >> offset & 1 == 1 {
                counters.cell();
                let Segment { entry, exit } = steps.segment(ray, [t, t_out]);
                self.segments.push(
                    &brick.corners(offset),
                    entry,
                    exit,
                    ((t_out - t) * self.world_per_t) as f32,
                );
                if self.segments.is_full() {
                    self.scheme.integrate(self.segments, self.lighting, self.radiance);
                    self.segments.clear();
                    if self.radiance.is_done {
                        return ControlFlow::Break(());
                    }
                }
            }
            if t_out >= visit.t_end || !steps.cross(ray, t_out) {
                return ControlFlow::Continue(());
            }
            t = t_out;
        }
    }
}
