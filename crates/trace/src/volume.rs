//! Emission and absorption along a ray.

use std::ops::ControlFlow;

use isoray_grid::Scalar;
use isoray_octree::{Node, OctreeView, Path};
use isoray_preint::{Integrate, Lighting, Radiance, Segments, Visibility};

use crate::brick::{Bricks, SAMPLES};
use crate::descent::{BlockVisit, Descent, Search};
use crate::gather::Gather;
use crate::ray::{ClippedRay, Ray};
use crate::ray_group::RayGroup;
use crate::region::Region;
use crate::shown::Shown;
use crate::steps::Cube;
use crate::work::Counters;

/// Integrates emission and absorption along rays through one volume.
///
/// Cells, and whole regions, whose values the transfer function hides are passed by; the inside of a scalar leaf is one segment. Make one per
/// thread and keep it, as with [`Tracer`](crate::Tracer).
#[derive(Clone, Debug)]
pub struct VolumeTracer<'a, T: Scalar> {
    pub(crate) view: &'a OctreeView<'a, T>,
    pub(crate) visible: Visibility,
    pub(crate) shown: Shown<T>,
    /// Where anything can be visible; `None`: nowhere.
    pub(crate) region: Option<Region>,
    descent: Descent<'a, T>,
    pub(crate) bricks: Bricks,
    segments: Segments,
    /// Room for rays that go together, and where they are.
    pub(crate) groups: Vec<RayGroup>,
    pub(crate) path: Path<'a, T>,
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
            groups: Vec::new(),
            path: Path::default(),
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
        let Some(region) = &self.region else { return Radiance::default() };
        let Some(ray) = &ClippedRay::new(ray, region) else { return Radiance::default() };
        self.along(ray, world_per_t, scheme, lighting, counters)
    }

    /// Likewise, of a ray that is clipped to the region.
    #[inline(always)]
    pub(crate) fn along(
        &mut self,
        ray: &ClippedRay,
        world_per_t: f64,
        scheme: &impl Integrate,
        lighting: Option<&Lighting>,
        counters: &mut impl Counters,
    ) -> Radiance {
        let gather = Gather::new(ray, world_per_t, scheme, lighting, &mut self.segments);
        let mut search = Integral {
            view: self.view,
            visible: &self.visible,
            shown: &self.shown,
            bricks: &mut self.bricks,
            gather,
        };
        // If it breaks, nothing is left to gather.
        let _ = self.descent.follow(self.view, ray, &mut search, counters);
        search.gather.finish()
    }
}

/// The search for what is visible.
struct Integral<'s, 'a, T: Scalar, I> {
    view: &'a OctreeView<'a, T>,
    visible: &'s Visibility,
    shown: &'s Shown<T>,
    bricks: &'s mut Bricks,
    gather: Gather<'s, I>,
}

impl<'a, T: Scalar, I: Integrate> Search<'a, T> for Integral<'_, 'a, T, I> {
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
        self.gather.constant(value.to_f32(), interval)
    }

    #[inline(never)]
    fn block(&mut self, visit: BlockVisit<'_, 'a, T>, counters: &mut impl Counters) -> ControlFlow<()> {
        let (place, gather) = (visit.place, &mut self.gather);
        let brick = self.bricks.of(place.key(), |brick| {
            counters.lookups(SAMPLES as u32);
            brick.fill(self.view, visit.path, place, visit.own(self.view), self.visible);
        });
        let block = Cube { center: place.center, mid: visit.mid, step: gather.ray.step };
        gather.block(brick, block, [visit.t, visit.t_end], counters)
    }
}
