//! First hits of single rays.

use std::cell::RefCell;
use std::hint::black_box;
use std::ops::ControlFlow;

use anyhow::{Result, ensure};
use isoray_benches::path;
use isoray_benches::views::View;
use isoray_grid::{DenseVolume, Scalar};
use isoray_octree::{OctreeView, OctreeVolume};
use isoray_trace::{Candidate, Counters, FirstHit, Hit, HitPolicy, Trace, Tracer, Work};

use super::{Per, Setting, SkippingRow};

use crate::bench::timer::interleave_kept;
use crate::catalog::Dense;

pub(super) fn measure<T: Scalar>(
    setting: Setting<'_>,
    volume: &Dense<T>,
    octree: &OctreeVolume<T>,
) -> Result<Vec<SkippingRow>> {
    let size = setting.size(64, 256);
    let octree = octree.view();
    let dense = DenseVolume::new(volume.dims, &volume.samples)?;
    let mut rows = Vec::new();
    for (name, view) in [
        ("surface far", View::far(volume.dims, size, size)),
        ("surface close", View::close(volume.dims, size, size)),
    ] {
        let isovalue = setting.entry.isovalues[0];
        let surface = Surface { setting, name, octree: &octree, dense: &dense, view, isovalue };
        let found = surface.first_hits(&mut Tracer::new(&octree), &mut ());
        ensure!(found.iter().any(Option::is_some), "{}, {name}: no ray hits", setting.entry.name);
        rows.extend(surface.ways(&found)?);
        rows.extend(surface.normals(&found)?);
    }
    Ok(rows)
}

struct Surface<'a, T: Scalar> {
    setting: Setting<'a>,
    name: &'static str,
    octree: &'a OctreeView<'a, T>,
    /// The same samples.
    dense: &'a DenseVolume<'a, T>,
    view: View,
    isovalue: f32,
}

type Hits = Vec<Option<Hit>>;

impl<T: Scalar> Surface<'_, T> {
    /// What is not looked at on the way to the first hit, and behind it.
    fn ways(&self, expected: &Hits) -> Result<[SkippingRow; 2]> {
        let volume = &self.setting.entry.name;
        let mut counted: [Work; 3] = Default::default();
        let [first, all, unending] = &mut counted;
        let mut tracer = Tracer::new(self.octree);
        let hits = [
            self.first_hits(&mut tracer, first),
            self.every_cell(all),
            self.unending_hits(&mut tracer, unending),
        ];
        let is_right = |hits: &[Hits]| hits.iter().all(|hits| hits == expected);
        ensure!(
            is_right(&hits),
            "{volume}, {}: other hits if every cell is looked at, or rays go on",
            self.name
        );
        let tracer = RefCell::new(tracer);
        let (times, hits) = interleave_kept(
            self.setting.repeat,
            &mut [
                &mut || self.first_hits(&mut *tracer.borrow_mut(), &mut ()),
                &mut || self.every_cell(&mut ()),
                &mut || self.unending_hits(&mut *tracer.borrow_mut(), &mut ()),
            ],
        );
        ensure!(is_right(&hits), "{volume}, {}: other hits when timed", self.name);
        let count = |what, of: fn(&Work) -> u64, without: usize| {
            (what, [0, without].map(|n| self.per_ray(of(&counted[n]) as f64)))
        };
        let ns = |without: usize| [0, without].map(|n| self.per_ray(times[n] * 1e9));
        let lookups = |without| count("look-ups", |work| work.lookups, without);
        let cells = |without| count("cells", |work| work.cells, without);
        // The array has no nodes.
        let in_array = [lookups(1), cells(1)];
        let behind = [lookups(2), cells(2), count("nodes", |work| work.nodes, 2)];
        Ok([
            self.setting
                .row([self.name, "a look at every cell, in the array"], Per::Ray, ns(1), &in_array)
                .spared()?,
            self.setting
                .row([self.name, "what is behind the first hit"], Per::Ray, ns(2), &behind)
                .spared()?,
        ])
    }

    /// Normals that nobody asks for.
    fn normals(&self, found: &Hits) -> Result<[SkippingRow; 2]> {
        let mut tracer = Tracer::new(self.octree);
        let expected = Shade::ALL.map(|shade| {
            let mut sums = Sums::default();
            for hit in found.iter().flatten() {
                sums.take(hit.t, shade.gradient(&mut tracer, hit));
            }
            sums
        });
        let tracer = RefCell::new(tracer);
        let of = |shade| self.shaded(&mut *tracer.borrow_mut(), shade);
        let (times, sums) = interleave_kept(
            self.setting.repeat,
            &mut [&mut || of(Shade::No), &mut || of(Shade::Forward), &mut || of(Shade::Central)],
        );
        ensure!(
            sums == expected,
            "{}, {}: {sums:?} when timed, not {expected:?}",
            self.setting.entry.name,
            self.name
        );
        let row = |skip, without: usize| {
            let ns = [0, without].map(|n| self.per_ray(times[n] * 1e9));
            let counts = [("normals", [0, without].map(|n| self.per_ray(sums[n].normals as f64)))];
            self.setting.row([self.name, skip], Per::Ray, ns, &counts).spared()
        };
        Ok([row("normals not asked for, forward", 1)?, row("normals not asked for, central", 2)?])
    }

    fn per_ray(&self, sum: f64) -> f64 {
        sum / self.view.directions.len() as f64
    }

    #[inline(never)]
    fn first_hits(&self, tracer: &mut impl Trace, counters: &mut impl Counters) -> Hits {
        let hit = |&direction: &[f32; 3]| {
            let mut policy = FirstHit::default();
            tracer.trace(&self.view.ray(direction), self.isovalue, &mut policy, counters);
            policy.0
        };
        self.view.directions.iter().map(hit).collect()
    }

    #[inline(never)]
    fn unending_hits(&self, tracer: &mut impl Trace, counters: &mut impl Counters) -> Hits {
        let hit = |&direction: &[f32; 3]| {
            let mut policy = Unending::default();
            tracer.trace(&self.view.ray(direction), self.isovalue, &mut policy, counters);
            policy.0
        };
        self.view.directions.iter().map(hit).collect()
    }

    #[inline(never)]
    fn every_cell(&self, counters: &mut impl Counters) -> Hits {
        let hit = |&direction: &[f32; 3]| {
            path::first_hit(self.dense, &self.view.ray(direction), self.isovalue, counters)
        };
        self.view.directions.iter().map(hit).collect()
    }

    /// Depths, and maybe normals with them.
    #[inline(never)]
    fn shaded(&self, tracer: &mut impl Trace, shade: Shade) -> Sums {
        let mut sums = Sums::default();
        for &direction in &self.view.directions {
            if let Some(hit) = tracer.first_hit(&self.view.ray(direction), self.isovalue) {
                sums.take(hit.t, shade.gradient(tracer, &hit));
            }
        }
        sums
    }
}

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

/// Which normals are found.
#[derive(Clone, Copy)]
enum Shade {
    No,
    Forward,
    Central,
}

impl Shade {
    const ALL: [Self; 3] = [Self::No, Self::Forward, Self::Central];

    #[inline(always)]
    fn gradient(self, tracer: &mut impl Trace, hit: &Hit) -> Option<[f32; 3]> {
        match self {
            Self::No => None,
            Self::Forward => Some(hit.gradient()),
            Self::Central => Some(tracer.central_gradient(hit)),
        }
    }
}

/// What hits come to: by this a timed run is known to have found what it should.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Sums {
    normals: u64,
    /// Of the bits of depths, and of gradients.
    depths: u64,
    gradients: u64,
}

impl Sums {
    #[inline(always)]
    fn take(&mut self, t: f32, gradient: Option<[f32; 3]>) {
        self.depths = self.depths.wrapping_add(t.to_bits().into());
        if let Some(gradient) = gradient {
            self.normals += 1;
            let bits = gradient
                .into_iter()
                .fold(0, |bits: u64, g| bits.wrapping_mul(3).wrapping_add(g.to_bits().into()));
            self.gradients = self.gradients.wrapping_add(bits);
        }
    }
}
