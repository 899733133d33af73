//! Surfaces behind one another, and caps of cuts.

use std::ops::ControlFlow;

use glam::{DVec3, Vec3};
use isoray_trace::{Counters, Crossing, Ray, Trace};

use crate::clip::Plane;
use crate::frame::{Context, Look, Tracing};
use crate::image::Pixel;
use crate::shade::{Point, Shadows};

/// Transmittance below which what is behind cannot be seen: sRGB is steepest in the dark, 12.92 · 255 steps of eight bits to full light, of
/// which this is 0.4.
const INVISIBLE: f32 = 1.0 / 8192.0;

/// What is gathered along a ray, front to back.
pub(crate) struct Layers {
    color: Vec3,
    transmittance: f32,
    /// Of the first one.
    depth: f32,
    normal: Vec3,
}

impl Default for Layers {
    fn default() -> Self {
        Self { color: Vec3::ZERO, transmittance: 1.0, depth: f32::INFINITY, normal: Vec3::ZERO }
    }
}

impl Layers {
    pub(crate) fn pixel(&self) -> Pixel {
        Pixel { color: self.color.extend(1.0 - self.transmittance), depth: self.depth, normal: self.normal }
    }

    /// Adds a layer behind those there are; breaks if no further one could be seen.
    fn add(&mut self, color: Vec3, opacity: f32, depth: f32, normal: Vec3) -> ControlFlow<()> {
        self.color += self.transmittance * opacity * color;
        self.transmittance *= 1.0 - opacity;
        if self.depth == f32::INFINITY {
            (self.depth, self.normal) = (depth, normal);
        }
        if self.transmittance > INVISIBLE {
            return ControlFlow::Continue(());
        }
        self.transmittance = 0.0;
        ControlFlow::Break(())
    }

    /// Gathers what a ray meets. Crossings are found first, as many as can be seen, and then shaded, so that one tracer does for both.
    pub(crate) fn gather<R: Trace, C: Counters>(
        mut self,
        context: &Context<'_>,
        tracing: &mut Tracing<R>,
        look: &Look,
        ray: &Ray,
        counters: &mut C,
    ) -> Self {
        let Tracing { tracer, found, .. } = tracing;
        let scene = context.scene;
        let kept = scene.cap.then(|| scene.clip.kept(look.origin, look.direction)).flatten();
        let cut = |t: f64, n: Option<usize>| n.filter(|_| t > 0.0).map(|n| (t, scene.clip.0[n]));
        if let Some((t, plane)) = kept.and_then(|kept| cut(kept.begin, kept.enters))
            && self.cap(context, tracer, look, t, &plane, counters).is_break()
        {
            return self;
        }
        found.clear();
        let mut transmittance = self.transmittance;
        let end = tracer.crossings(
            ray,
            &context.isovalues,
            &mut |crossing| {
                found.push(*crossing);
                transmittance *= 1.0 - scene.surfaces[crossing.surface].opacity;
                if transmittance > INVISIBLE { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            },
            counters,
        );
        for Crossing { surface, hit } in &*found {
            let (color, normal) = context.hit(look, hit, *surface, tracer, counters);
            // Ends with the last of them at the latest.
            let _ = self.add(color, scene.surfaces[*surface].opacity, hit.t, normal);
        }
        if let (Some((t, plane)), ControlFlow::Continue(())) =
            (kept.and_then(|kept| cut(kept.end, kept.leaves)), end)
        {
            let _ = self.cap(context, tracer, look, t, &plane, counters);
        }
        self
    }

    /// Adds the cap at `t`, if the field is inside of a surface there.
    fn cap<R: Trace, C: Counters>(
        &mut self,
        context: &Context<'_>,
        tracer: &mut R,
        look: &Look,
        t: f64,
        plane: &Plane,
        counters: &mut C,
    ) -> ControlFlow<()> {
        let position = look.origin + look.direction * t;
        let Some((cell, local)) = context.cell_at(position) else { return ControlFlow::Continue(()) };
        let Some(value) = tracer.value(cell, local) else { return ControlFlow::Continue(()) };
        let surfaces = context.scene.surfaces.iter().enumerate();
        let innermost = surfaces
            .filter(|(_, surface)| surface.isovalue <= value)
            .max_by(|a, b| a.1.isovalue.total_cmp(&b.1.isovalue));
        let Some((surface, looks)) = innermost else { return ControlFlow::Continue(()) };
        let normal = plane.normal.normalize_or_zero().as_vec3();
        let point = Point {
            position,
            to_viewer: -look.direction,
            normal,
            color: context.color(surface, cell, local),
            hit: None,
            pixel: look.pixel,
        };
        let color = context.shader(tracer, counters, Shadows::Traced).shade(&point, 0);
        self.add(color, looks.opacity, t as f32, normal)
    }
}

impl Context<'_> {
    /// The cell at a point of the world, and the cell-local position; `None` outside the domain.
    fn cell_at(&self, position: DVec3) -> Option<([u32; 3], [f32; 3])> {
        let p = self.world_to_index.transform_point3(position).to_array();
        let last = self.dims.axes().map(|n| n - 1);
        if (0..3).any(|a| !(p[a] >= 0.0 && p[a] <= last[a].into()) || last[a] == 0) {
            return None;
        }
        let cell: [u32; 3] = std::array::from_fn(|a| (p[a] as u32).min(last[a] - 1));
        Some((cell, std::array::from_fn(|a| (p[a] - f64::from(cell[a])) as f32)))
    }
}
