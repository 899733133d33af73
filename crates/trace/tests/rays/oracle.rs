//! Traversal against the float64 reference, on small adversarial volumes and rays.

use std::ops::ControlFlow;

use isoray_build::build;
use isoray_cell::{Cubic, VALUE_ERROR_UNITS};
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_octree::OctreeVolume;
use isoray_oracle::{DenseLattice, OracleRay, RayKind, SplitMix64, Verdict, error_in_ulps, judge};
use isoray_oracle::{adversarial_isovalue, adversarial_lattice};
use isoray_trace::{Candidate, Hit, HitPolicy, Ray, Tracer};
use rayon::prelude::*;

/// The largest error of a hit that does not graze, in voxels along the ray (DESIGN section 4).
const VOXEL_BOUND: f64 = 1e-2;

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    rays: u32,
    hits: u32,
    grazing: u32,
    undecided: u32,
}

/// Keeps the cell of the first hit.
#[derive(Default)]
struct HitCell(Option<Candidate>);

impl HitPolicy for HitCell {
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        match candidate.first_hit() {
            Some(_) => {
                self.0 = Some(*candidate);
                ControlFlow::Break(())
            }
            None => ControlFlow::Continue(()),
        }
    }

    fn jump(&mut self, _: &Hit) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Whether the whole stretch in the cell of the hit lies within the error bound of the isovalue, so that
/// either answer is right. (Moving the isovalue does not show this: the stretch is then all on one side.)
fn is_undecided<T: Scalar>(tracer: &mut Tracer<'_, T>, ray: &Ray, isovalue: f32) -> bool {
    let mut policy = HitCell::default();
    tracer.trace(ray, isovalue, &mut policy, &mut ());
    policy.0.is_some_and(|c| {
        let largest = c.corners.iter().fold(0f32, |m, &x| m.max(x.abs()));
        let bound = VALUE_ERROR_UNITS * f32::EPSILON / 2.0 * largest;
        Cubic::along(&c.corners, &c.segment).0.iter().all(|b| b.abs() <= bound)
    })
}

fn volume<T: Scalar>(dims: [u32; 3], samples: &[T]) -> OctreeVolume<T> {
    let mut source = DenseVolume::new(Dims::new(dims).unwrap(), samples).unwrap();
    build(&mut source, glam::DAffine3::IDENTITY, |_| {}).unwrap()
}

fn ray(r: &OracleRay) -> Ray {
    Ray { origin: r.origin, direction: r.direction, t_min: r.t_min, t_max: r.t_max }
}

fn agrees(hit: Option<Hit>, verdict: &Verdict, direction: [f32; 3]) -> Result<(), String> {
    match (hit, verdict.hit) {
        (None, None) => Ok(()),
        (Some(h), Some(o)) => {
            let length = direction.iter().map(|&d| f64::from(d).powi(2)).sum::<f64>().sqrt();
            let voxels = (f64::from(h.t) - o.t).abs() * length;
            // The rounding of t to f32 alone can be more than that for an origin far away.
            let ulps = error_in_ulps(h.t, o.t);
            let close = voxels <= VOXEL_BOUND || ulps <= 1.0;
            if close { Ok(()) } else { Err(format!("{voxels} voxels, {ulps} ulp apart: {h:?} {o:?}")) }
        }
        (h, o) => Err(format!("found {h:?}, expected {o:?}")),
    }
}

/// Every kind of ray against one kind of volume in the sample type that `convert` gives.
fn check<T: Scalar + Into<f64>>(seeds: std::ops::Range<u64>, convert: impl Fn(f32) -> T + Sync) -> Tally {
    let per_volume = |seed: u64| {
        let side = |n: u64| 2 + (seed.wrapping_mul(n) % 19) as u32;
        let dims = [side(7), side(11), side(13)];
        let values = adversarial_lattice(dims, seed);
        let samples: Vec<T> = values.iter().map(|&s| convert(s)).collect();
        let widened: Vec<f32> = samples.iter().map(|s| s.to_f32()).collect();
        let isovalue = adversarial_isovalue(&widened, seed);
        let built = volume(dims, &samples);
        let lattice = DenseLattice::from_vec(dims, samples).unwrap();
        let view = built.view();
        let mut tracer = Tracer::new(&view);
        let mut tally = Tally::default();
        for kind in RayKind::ALL {
            for n in 0..40 {
                let oracle_ray = kind.generate(dims, seed.wrapping_mul(1000) + n);
                let verdict = judge(&lattice, &oracle_ray, isovalue);
                tally.rays += 1;
                if verdict.grazing {
                    tally.grazing += 1;
                    continue;
                }
                tally.hits += u32::from(verdict.hit.is_some());
                let hit = tracer.first_hit(&ray(&oracle_ray), isovalue);
                if let Err(what) = agrees(hit, &verdict, oracle_ray.direction) {
                    if is_undecided(&mut tracer, &ray(&oracle_ray), isovalue) {
                        tally.undecided += 1;
                        continue;
                    }
                    panic!(
                        "{kind:?} seed {seed} ray {n} {dims:?} isovalue {isovalue}: {what}\n{oracle_ray:?}"
                    );
                }
                assert_eq!(tracer.any_hit(&ray(&oracle_ray), isovalue), hit.is_some(), "{kind:?} {seed} {n}");
            }
        }
        tally
    };
    let join = |a: Tally, b: Tally| Tally {
        rays: a.rays + b.rays,
        hits: a.hits + b.hits,
        grazing: a.grazing + b.grazing,
        undecided: a.undecided + b.undecided,
    };
    seeds.into_par_iter().map(per_volume).reduce(Tally::default, join)
}

fn report(name: &str, tally: Tally) {
    println!("{name}: {tally:?}");
    assert!(tally.hits * 10 > tally.rays, "{name}: too few hits to mean anything: {tally:?}");
    assert!(tally.undecided * 10_000 <= tally.rays, "{name}: too many undecided: {tally:?}");
    assert!(tally.grazing * 2 < tally.rays, "{name}: most rays graze: {tally:?}");
}

#[test]
fn f32_volumes_agree_with_the_reference() {
    report("f32", check(0..300, |s| s));
}

#[test]
fn u8_volumes_agree_with_the_reference() {
    report("u8", check(1000..1300, |s| s.clamp(0.0, 255.0) as u8));
}

#[test]
fn i16_volumes_agree_with_the_reference() {
    report("i16", check(2000..2300, |s| (s * 100.0 - 50.0).clamp(-32768.0, 32767.0) as i16));
}

/// A tracer remembers what it found out about blocks: rays in any order, isovalues in turn, and more blocks than it has room for
/// must give what a fresh tracer gives.
#[test]
fn what_a_tracer_remembers_changes_no_hit() {
    // 17×11×5 blocks: almost twice those that are remembered, and the last ones cut short.
    let dims = [67, 43, 18];
    for seed in 0..4 {
        // Regions of 8³ samples, some of noise and some of one value.
        let mut random = SplitMix64::new(seed);
        let lattice = (0..dims[2]).flat_map(|z| {
            (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| x / 8 + y / 8 * 3 + z / 8 * 5))
        });
        let samples: Vec<u8> = lattice
            .map(|region| if region % 3 == 0 { random.below(256) as u8 } else { (region * 37 % 256) as u8 })
            .collect();
        let built = volume(dims, &samples);
        let view = built.view();
        let mut tracer = Tracer::new(&view);
        let mut hits = 0;
        for n in 0..400 {
            // Two rays of each isovalue, so that the second meets what the first found out.
            let isovalue = [40.5, 100.0, 128.0, 200.5, 7.0][n as usize / 2 % 5];
            for kind in RayKind::ALL {
                let ray = ray(&kind.generate(dims, seed * 1000 + n));
                let hit = tracer.first_hit(&ray, isovalue);
                assert_eq!(hit, Tracer::new(&view).first_hit(&ray, isovalue), "{kind:?} seed {seed} ray {n}");
                hits += u32::from(hit.is_some());
            }
        }
        println!("seed {seed}: {hits} hits");
        assert!(hits > 100, "seed {seed}: too few hits to mean anything: {hits}");
    }
}
