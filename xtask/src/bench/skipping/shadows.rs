//! Rays to a lamp from points that face away from it.

use std::hint::black_box;

use anyhow::{Result, ensure};
use glam::DVec3;
use isoray_benches::views::View;
use isoray_grid::Scalar;
use isoray_trace::{Counters, Hit, Trace, Tracer, Work};

use super::{Setting, SkippingRow};
use crate::bench::picture::LAMP;
use crate::bench::recorded::ray;
use crate::bench::timer::interleave;
use crate::catalog::{Dense, DenseVisitor};

/// So many of all points may face away by their gradient and still send a ray to the lamp that meets nothing: where the ray runs along the surface, and where the surface is
/// a face of its cell, with samples of just the isovalue, and there is none in the cell that the ray leaves to.
const UNMET: f64 = 2e-3;

pub(super) struct Shadows<'a>(pub(super) Setting<'a>);

/// Whether the surface at a hit turns its back to a light: the renderer's test, which spares a ray.
fn faces_away(hit: &Hit, to_light: [f32; 3]) -> bool {
    let slope: f32 = hit.gradient().iter().zip(to_light).map(|(g, d)| g * d).sum();
    slope == 0.0 || (slope < 0.0) != hit.is_entering
}

impl DenseVisitor for Shadows<'_> {
    type Output = Result<Vec<SkippingRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let Self(setting) = self;
        let size = setting.size(96, 256);
        let octree = volume.octree()?;
        let octree = octree.view();
        let isovalue = setting.entry.isovalues[0];
        let to_light =
            volume.index_to_world.inverse().transform_vector3(LAMP.normalize_or(DVec3::Y)).as_vec3();
        let view = View::far(volume.dims, size, size);
        let mut tracer = Tracer::new(&octree);
        let hits: Vec<Hit> =
            view.directions.iter().filter_map(|&d| tracer.first_hit(&ray(&view, d), isovalue)).collect();
        ensure!(!hits.is_empty(), "{}: no ray hits", setting.entry.name);
        let lamp = Lamp { hits: &hits, to_light: to_light.to_array(), isovalue };
        let mut works: [Work; 2] = Default::default();
        let [spared, traced] = [true, false].map(|spares| {
            let mut lit = Vec::new();
            lamp.light(&mut tracer, spares, &mut lit, &mut works[usize::from(!spares)]);
            lit
        });
        ensure!(spared == traced, "{}: other shadows if all rays are traced", setting.entry.name);
        let unmet = lamp.unmet_behind(&mut tracer);
        ensure!(
            unmet as f64 <= UNMET * hits.len() as f64,
            "{}: {unmet} of {} rays from points that face away meet nothing",
            setting.entry.name,
            hits.len()
        );
        let mut lit = [Vec::new(), Vec::new()];
        let [with, without] = &mut lit;
        let tracer = std::cell::RefCell::new(tracer);
        let times = interleave(
            setting.repeat,
            &mut [&mut || lamp.light(&mut *tracer.borrow_mut(), true, with, &mut ()), &mut || {
                lamp.light(&mut *tracer.borrow_mut(), false, without, &mut ())
            }],
        );
        ensure!(lit[0] == spared && lit[1] == spared, "{}: other shadows when timed", setting.entry.name);
        let points = hits.len() as f64;
        let per_point = |count: fn(&Work) -> u64| [0, 1].map(|n| count(&works[n]) as f64 / points);
        let counts = [
            ("rays", per_point(|w| w.shadow_rays)),
            ("nodes", per_point(|w| w.nodes)),
            ("% of rays behind that meet nothing", [0.0, 100.0 * unmet as f64 / points]),
        ];
        let ns = [times[0], times[1]].map(|seconds| seconds * 1e9 / points);
        Ok(vec![setting.row("shadows far, a point", "rays to a lamp behind the surface", ns, &counts)])
    }
}

struct Lamp<'a> {
    hits: &'a [Hit],
    /// In index space.
    to_light: [f32; 3],
    isovalue: f32,
}

impl Lamp<'_> {
    /// Which points the lamp reaches; `spares`: without a ray where the surface faces away from it.
    #[inline(never)]
    fn light(
        &self,
        tracer: &mut impl Trace,
        spares: bool,
        lit: &mut Vec<bool>,
        counters: &mut impl Counters,
    ) {
        lit.clear();
        lit.extend(self.hits.iter().map(|hit| {
            let faces_away = faces_away(hit, self.to_light);
            let is_traced = !(spares && faces_away);
            counters.shadow(is_traced);
            let reaches = is_traced && !black_box(self.is_occluded(hit, tracer, counters));
            reaches && !faces_away
        }));
    }

    fn is_occluded(&self, hit: &Hit, tracer: &mut impl Trace, counters: &mut impl Counters) -> bool {
        let ray = hit.departing_ray(self.to_light, f32::INFINITY, !hit.is_entering);
        tracer.occluded(&ray, self.isovalue, counters)
    }

    /// Rays from points that face away which meet nothing, not even the surface that they start on.
    fn unmet_behind(&self, tracer: &mut impl Trace) -> usize {
        let behind = self.hits.iter().filter(|hit| faces_away(hit, self.to_light));
        behind.filter(|hit| !self.is_occluded(hit, tracer, &mut ())).count()
    }
}
