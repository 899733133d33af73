//! First hits of single rays.

use std::hint::black_box;
use std::ops::ControlFlow;

use anyhow::{Result, ensure};
use isoray_benches::path;
use isoray_benches::views::View;
use isoray_grid::{DenseVolume, Scalar};
use isoray_trace::{Candidate, Counters, FirstHit, Hit, HitPolicy, Trace, Tracer, Work};

use super::{Setting, SkippingRow};
use crate::bench::recorded::ray;
use crate::bench::timer::interleave;
use crate::catalog::{Dense, DenseVisitor};

pub(super) struct Surfaces<'a>(pub(super) Setting<'a>);

/// Keeps the first hit, and looks at all that comes after.
#[derive(Default)]
struct Unending(Option<Hit>);

impl HitPolicy for Unending {
    #[inline(always)]
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        let hit = black_box(candidate.first_hit());
        self.0 = self.0.or(hit);
        ControlFlow::Continue(())
    }

    fn jump(&mut self, hit: &Hit) -> ControlFlow<()> {
        self.0 = self.0.or(Some(*hit));
        ControlFlow::Continue(())
    }
}

type Hits = Vec<Option<Hit>>;

impl DenseVisitor for Surfaces<'_> {
    type Output = Result<Vec<SkippingRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let Self(setting) = self;
        let size = setting.size(64, 256);
        let octree = volume.octree()?;
        let octree = octree.view();
        let dense = DenseVolume::new(volume.dims, &volume.samples)?;
        let isovalue = setting.entry.isovalues[0];
        let mut rows = Vec::new();
        for (scene, view) in [
            ("surface far", View::far(volume.dims, size, size)),
            ("surface close", View::close(volume.dims, size, size)),
        ] {
            let mut counted: [Work; 3] = Default::default();
            let mut tracer = Tracer::new(&octree);
            let found = first_hits(&mut tracer, &view, isovalue, &mut counted[0]);
            let all_cells = every_cell(&dense, &view, isovalue, &mut counted[1]);
            let to_the_end = unending_hits(&mut tracer, &view, isovalue, &mut counted[2]);
            ensure!(
                found == all_cells,
                "{}, {scene}: other hits if every cell is looked at",
                setting.entry.name
            );
            ensure!(found == to_the_end, "{}, {scene}: other hits if rays go on", setting.entry.name);
            let tracer = std::cell::RefCell::new(tracer);
            let of = |shade: Shade| shaded(&mut *tracer.borrow_mut(), &view, isovalue, shade);
            let times = interleave(
                setting.repeat,
                &mut [
                    &mut || _ = black_box(first_hits(&mut *tracer.borrow_mut(), &view, isovalue, &mut ())),
                    &mut || _ = black_box(every_cell(&dense, &view, isovalue, &mut ())),
                    &mut || _ = black_box(unending_hits(&mut *tracer.borrow_mut(), &view, isovalue, &mut ())),
                    &mut || of(Shade::No),
                    &mut || of(Shade::Forward),
                    &mut || of(Shade::Central),
                ],
            );
            let rays = view.directions.len() as f64;
            let ns = |with: usize, without: usize| [times[with], times[without]].map(|s| s * 1e9 / rays);
            let work = |without: usize| {
                let per_ray =
                    |count: fn(&Work) -> u64| [0, without].map(|n| count(&counted[n]) as f64 / rays);
                [
                    ("nodes", per_ray(|work| work.nodes)),
                    ("look-ups", per_ray(|work| work.lookups)),
                    ("cells", per_ray(|work| work.cells)),
                ]
            };
            let share = found.iter().flatten().count() as f64 / rays;
            let normals = [("normals", [0.0, share])];
            rows.push(setting.row(scene, "regions by their range", ns(0, 1), &work(1)));
            rows.push(setting.row(scene, "what is behind the first hit", ns(0, 2), &work(2)));
            rows.push(setting.row(scene, "normals not asked for, forward", ns(3, 4), &normals));
            rows.push(setting.row(scene, "normals not asked for, central", ns(3, 5), &normals));
        }
        Ok(rows)
    }
}

#[inline(never)]
fn first_hits(tracer: &mut impl Trace, view: &View, isovalue: f32, counters: &mut impl Counters) -> Hits {
    let hit = |&direction: &[f32; 3]| {
        let mut policy = FirstHit::default();
        tracer.trace(&ray(view, direction), isovalue, &mut policy, counters);
        policy.0
    };
    view.directions.iter().map(hit).collect()
}

#[inline(never)]
fn unending_hits(tracer: &mut impl Trace, view: &View, isovalue: f32, counters: &mut impl Counters) -> Hits {
    let hit = |&direction: &[f32; 3]| {
        let mut policy = Unending::default();
        tracer.trace(&ray(view, direction), isovalue, &mut policy, counters);
        policy.0
    };
    view.directions.iter().map(hit).collect()
}

/// By looking at the samples of every cell on the way, in the array.
#[inline(never)]
fn every_cell<T: Scalar>(
    samples: &DenseVolume<'_, T>,
    view: &View,
    isovalue: f32,
    counters: &mut impl Counters,
) -> Hits {
    let hit = |&direction: &[f32; 3]| path::first_hit(samples, &ray(view, direction), isovalue, counters);
    view.directions.iter().map(hit).collect()
}

/// Which normals are found, and dropped.
#[derive(Clone, Copy)]
enum Shade {
    No,
    Forward,
    Central,
}

/// Depths, and maybe normals with them.
#[inline(never)]
fn shaded(tracer: &mut impl Trace, view: &View, isovalue: f32, shade: Shade) {
    for &direction in &view.directions {
        let mut policy = FirstHit::default();
        tracer.trace(&ray(view, direction), isovalue, &mut policy, &mut ());
        let Some(hit) = policy.0 else { continue };
        black_box(hit.t);
        match shade {
            Shade::No => (),
            Shade::Forward => _ = black_box(hit.gradient()),
            Shade::Central => _ = black_box(tracer.central_gradient(&hit)),
        }
    }
}
