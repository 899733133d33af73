//! The bound on displacements, of what is really done to volumes.

use isoray_build::{Isovalues, Loss, SurfaceTolerance};
use isoray_grid::Scalar;
use isoray_oracle::{DenseLattice, RayKind, SplitMix64, adversarial_isovalue, all_hits};

use super::common::{for_all_types, lose, octree, samples, size, widened};
use super::displacement::is_near;

#[derive(Debug, Default)]
struct Tally {
    hits: u32,
    changed: u64,
}

fn is_within<T: Scalar>(seed: u64, tally: &mut Tally) {
    let dims = size(seed);
    let before: Vec<T> = samples(dims, seed);
    let wide = widened(&before);
    // Beyond this, f64 arithmetic cannot judge at the accuracy asked for.
    if wide.iter().any(|s| s.is_finite() && s.abs() > 1e6) {
        return;
    }
    let [a, b] = [seed * 2, seed * 2 + 1].map(|n| adversarial_isovalue(&wide, n));
    let [low, high] = [a.min(b), a.max(b)];
    let random = &mut SplitMix64::new(seed);
    let displacement = [0.0, 0.1, 0.5, 1.0][random.below(4) as usize];
    let between = (random.range(low.into(), high.into()) as f32).clamp(low, high);
    let cases = [
        (Isovalues::List(vec![high, low]), vec![low, high]),
        (Isovalues::Range([low, high]), vec![low, between, high]),
    ];
    for (isovalues, tried) in cases {
        let loss = Loss { surface: Some(SurfaceTolerance { displacement, isovalues }), ..Loss::default() };
        let (after, changes) = lose(dims, &before, &loss);
        tally.changed += changes.samples;
        let caps = |samples: &[T]| octree(dims, samples).statistics()[0].count;
        assert!(caps(&after) <= caps(&before), "{dims:?}, seed {seed}");
        let [a, b] = [&wide, &widened(&after)].map(|s| DenseLattice::from_vec(dims, s.clone()).unwrap());
        for (v, kind) in tried.iter().flat_map(|&v| RayKind::ALL.into_iter().map(move |kind| (v, kind))) {
            let ray = kind.generate(dims, seed);
            for (on, other) in [(&a, &b), (&b, &a)] {
                for hit in all_hits(on, &ray, v.into()) {
                    let near = is_near(&hit, on, other, v.into(), displacement);
                    assert!(near, "isovalue {v}, {dims:?}, seed {seed}, {loss:?}, {ray:?}, {hit:?}");
                    tally.hits += 1;
                }
            }
        }
    }
}

#[test]
fn no_surface_is_farther_off_than_the_displacement() {
    let mut tally = Tally::default();
    for seed in 0..72 {
        for_all_types!(is_within(seed, &mut tally));
    }
    println!("{tally:?}");
    assert!(tally.hits > 5_000 && tally.changed > 10_000, "too little to mean anything: {tally:?}");
}
