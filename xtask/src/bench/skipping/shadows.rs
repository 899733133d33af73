//! Rays to a lamp from points that face away from it.

use std::cell::RefCell;
use std::hint::black_box;

use anyhow::{Result, ensure};
use glam::DVec3;
use isoray_benches::views::View;
use isoray_grid::Scalar;
use isoray_octree::OctreeVolume;
use isoray_trace::{Counters, Hit, Trace, Tracer, Work};

use super::{Per, Setting, SkippingRow};
use crate::bench::picture::LAMP;
use crate::bench::timer::interleave_kept;
use crate::catalog::Dense;

/// So many of all points may face away by their gradient and still send a ray to the lamp that meets nothing: where the ray runs along the surface, and where the surface is
/// a face of its cell, with samples of just the isovalue, and there is none in the cell that the ray leaves to.
const UNMET: f64 = 2e-3;

pub(super) fn measure<T: Scalar>(
    setting: Setting<'_>,
    volume: &Dense<T>,
    octree: &OctreeVolume<T>,
) -> Result<Vec<SkippingRow>> {
    let name = &setting.entry.name;
    let size = setting.size(96, 256);
    let octree = octree.view();
    let isovalue = setting.entry.isovalues[0];
    let to_light = volume.index_to_world.inverse().transform_vector3(LAMP.normalize_or(DVec3::Y)).as_vec3();
    let view = View::far(volume.dims, size, size);
    let mut tracer = Tracer::new(&octree);
    let hits: Vec<Hit> =
        view.directions.iter().filter_map(|&d| tracer.first_hit(&view.ray(d), isovalue)).collect();
    ensure!(!hits.is_empty(), "{name}: no ray hits");
    let lamp = Lamp { hits: &hits, to_light: to_light.to_array(), isovalue };
    let mut works: [Work; 2] = Default::default();
    let [with, without] = &mut works;
    let reached = [lamp.light(&mut tracer, true, with), lamp.light(&mut tracer, false, without)];
    // What tells whether a ray is needed looks at the gradient, and the ray at the cells: these agree, but for a few.
    let unlike = reached[0].iter().zip(&reached[1]).filter(|(spared, traced)| spared != traced).count();
    ensure!(
        unlike as f64 <= UNMET * hits.len() as f64,
        "{name}: {unlike} of {} points have another shadow if all rays are traced",
        hits.len()
    );
    let tracer = RefCell::new(tracer);
    let (times, timed) = interleave_kept(
        setting.repeat,
        &mut [&mut || lamp.light(&mut *tracer.borrow_mut(), true, &mut ()), &mut || {
            lamp.light(&mut *tracer.borrow_mut(), false, &mut ())
        }],
    );
    ensure!(timed == reached, "{name}: other shadows when timed");
    let points = hits.len() as f64;
    let per_point = |count: fn(&Work) -> u64| [0, 1].map(|n| count(&works[n]) as f64 / points);
    let counts = [
        ("rays", per_point(|w| w.shadow_rays)),
        ("nodes", per_point(|w| w.nodes)),
        ("% of points behind that are lit", reached.each_ref().map(|reached| lamp.lit_behind(reached))),
    ];
    let ns = [times[0], times[1]].map(|seconds| seconds * 1e9 / points);
    Ok(vec![
        setting
            .row(["shadows far", "rays to a lamp behind the surface"], Per::Point, ns, &counts)
            .spared()?,
    ])
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
    fn light(&self, tracer: &mut impl Trace, spares: bool, counters: &mut impl Counters) -> Vec<bool> {
        let reaches = |hit: &Hit| {
            let is_traced = !(spares && hit.faces_away(self.to_light));
            counters.shadow(is_traced);
            is_traced && !black_box(self.is_occluded(hit, tracer, counters))
        };
        self.hits.iter().map(reaches).collect()
    }

    fn is_occluded(&self, hit: &Hit, tracer: &mut impl Trace, counters: &mut impl Counters) -> bool {
        let ray = hit.departing_ray(self.to_light, f32::INFINITY, !hit.is_entering);
        tracer.occluded(&ray, self.isovalue, counters)
    }

    /// Of the points that face away, the percentage that is reached all the same: their rays meet nothing, not even the surface that they start on.
    fn lit_behind(&self, reached: &[bool]) -> f64 {
        let behind = self.hits.iter().zip(reached).filter(|(hit, _)| hit.faces_away(self.to_light));
        let (all, lit) = behind.fold((0, 0), |(all, lit), (_, &is_lit)| (all + 1, lit + u32::from(is_lit)));
        100.0 * f64::from(lit) / f64::from(all)
    }
}
