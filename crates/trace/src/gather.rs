//! Segments of a ray on their way to an integration scheme.

use std::ops::ControlFlow;

use isoray_cell::Segment;
use isoray_preint::{Integrate, Lighting, Radiance, Segments};

use crate::brick::Brick;
use crate::ray::ClippedRay;
use crate::steps::Cube;
use crate::work::Counters;

/// What is gathered along one ray.
pub struct Gather<'s, I> {
    pub(crate) ray: &'s ClippedRay,
    world_per_t: f64,
    scheme: &'s I,
    lighting: Option<&'s Lighting>,
    segments: &'s mut Segments,
    radiance: Radiance,
}

impl<'s, I: Integrate> Gather<'s, I> {
    /// Nothing yet; a unit of the ray's parameter is `world_per_t` long in the world.
    pub fn new(
        ray: &'s ClippedRay,
        world_per_t: f64,
        scheme: &'s I,
        lighting: Option<&'s Lighting>,
        segments: &'s mut Segments,
    ) -> Self {
        segments.clear();
        Self { ray, world_per_t, scheme, lighting, segments, radiance: Radiance::default() }
    }

    /// Adds the stretches in the visible cells of a block, `brick`, on the ray's stretch `interval` in it.
    #[inline(always)]
    pub(crate) fn block(
        &mut self,
        brick: &Brick,
        block: Cube,
        interval: [f64; 2],
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        if brick.shown() == 0 {
            return ControlFlow::Continue(());
        }
        block.walk(self.ray, interval, |steps, offset, interval| {
            if brick.shown() >> offset & 1 == 0 {
                return ControlFlow::Continue(());
            }
            counters.cell();
            self.cell(&brick.corners(offset), steps.segment(self.ray, interval), interval)
        })
    }

    /// Adds a stretch in a cell with these corner values, x fastest; breaks if what is left cannot matter.
    #[inline(always)]
    fn cell(
        &mut self,
        corners: &[f32; 8],
        Segment { entry, exit }: Segment,
        interval: [f64; 2],
    ) -> ControlFlow<()> {
        self.segments.push(corners, entry, exit, self.length(interval));
        self.flush_if_full()
    }

    /// Adds the segments that `write` makes of the ray, a unit of whose parameter is that long in the world; breaks if what is left cannot matter.
    #[inline(always)]
    pub fn batch(&mut self, write: impl FnOnce(&mut Segments, &ClippedRay, f64)) -> ControlFlow<()> {
        write(self.segments, self.ray, self.world_per_t);
        self.flush()
    }

    /// Adds a stretch along which the field is constant.
    #[inline(always)]
    pub(crate) fn constant(&mut self, value: f32, interval: [f64; 2]) -> ControlFlow<()> {
        self.segments.push_constant(value, self.length(interval));
        self.flush_if_full()
    }

    /// All that has been gathered.
    pub fn finish(mut self) -> Radiance {
        if !self.radiance.is_done && self.segments.count() > 0 {
            let _ = self.flush();
        }
        self.radiance
    }

    #[inline(always)]
    fn length(&self, [begin, end]: [f64; 2]) -> f32 {
        ((end - begin) * self.world_per_t) as f32
    }

    #[inline(always)]
    fn flush_if_full(&mut self) -> ControlFlow<()> {
        if self.segments.is_full() { self.flush() } else { ControlFlow::Continue(()) }
    }

    /// What has been integrated so far: not what was added since the last [flush](Self::flush).
    pub fn radiance(&self) -> &Radiance {
        &self.radiance
    }

    /// Integrates the segments gathered so far; breaks if what is left cannot matter.
    #[inline(never)]
    pub fn flush(&mut self) -> ControlFlow<()> {
        self.scheme.integrate(self.segments, self.lighting, &mut self.radiance);
        self.segments.clear();
        if self.radiance.is_done { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
