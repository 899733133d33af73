//! A range that is kept: its samples and all its isosurfaces, bit for bit.

use isoray_build::Loss;
use isoray_grid::Scalar;
use isoray_oracle::{DenseLattice, RayKind, SplitMix64, adversarial_isovalue, all_hits};
use isoray_trace::{Ray, Tracer};

use super::common::{for_all_types, lose, octree, samples, size, widened};

#[derive(Debug, Default)]
struct Tally {
    hits: u32,
    changed: u64,
}

fn is_kept<T: Scalar>(seed: u64, tally: &mut Tally) {
    let dims = size(seed);
    let before: Vec<T> = samples(dims, seed);
    let wide = widened(&before);
    let [a, b] = [seed * 2, seed * 2 + 1].map(|n| adversarial_isovalue(&wide, n));
    let [low, high] = [a.min(b), a.max(b)];
    let loss = Loss { range: Some([low.into(), high.into()]), ..Loss::default() };
    let (after, changes) = lose(dims, &before, &loss);
    tally.changed += changes.samples;
    for (a, b) in before.iter().zip(&after) {
        let s = a.to_f32();
        assert!(a.same_bits(*b) || s < low || s > high, "{a:?} in {low}..{high} became {b:?}");
        assert!((s < low) == (b.to_f32() < low) && (s >= high) == (b.to_f32() >= high), "{a:?} {b:?}");
    }
    let (again, _) = lose(dims, &after, &loss);
    assert!(
        again.iter().zip(&after).all(|(a, b)| a.same_bits(*b)),
        "not the same twice: {dims:?}, seed {seed}"
    );

    let volumes = [octree(dims, &before), octree(dims, &after)];
    assert!(volumes[1].file_bytes() <= volumes[0].file_bytes());
    let views = [volumes[0].view(), volumes[1].view()];
    let [mut first, mut second] = [Tracer::new(&views[0]), Tracer::new(&views[1])];
    let lattices = [wide, widened(&after)].map(|s| DenseLattice::from_vec(dims, s).unwrap());
    let random = &mut SplitMix64::new(seed);
    let between = random.range(low.into(), high.into()) as f32;
    for v in [low, high, between.clamp(low, high), low.next_up().min(high), high.next_down().max(low)] {
        for kind in RayKind::ALL {
            for n in 0..3 {
                let r = kind.generate(dims, seed * 100 + n);
                let ray = Ray { origin: r.origin, direction: r.direction, t_min: r.t_min, t_max: r.t_max };
                let hits = [first.first_hit(&ray, v), second.first_hit(&ray, v)];
                assert_eq!(hits[0], hits[1], "isovalue {v} of {low}..{high}, {dims:?}, seed {seed}, {ray:?}");
                let [a, b] = [0, 1].map(|n| all_hits(&lattices[n], &r, v.into()));
                assert_eq!(a, b, "isovalue {v} of {low}..{high}, {dims:?}, seed {seed}, {ray:?}");
                tally.hits += a.len() as u32;
            }
        }
    }
}

#[test]
fn isosurfaces_in_the_range_are_kept_to_the_bit() {
    let mut tally = Tally::default();
    for seed in 0..48 {
        for_all_types!(is_kept(seed, &mut tally));
    }
    println!("{tally:?}");
    assert!(tally.hits > 10_000 && tally.changed > 10_000, "too little to mean anything: {tally:?}");
}

#[test]
fn an_end_that_is_no_f32_takes_in_the_isovalue_it_is_rounded_to() {
    // 0.7f32 is less than 0.7, and 0.1f32 more than 0.1: both are isovalues that somebody who keeps 0.7 to 0.1 may mean.
    for end in [0.7, 0.1] {
        let before = [end as f32; 64];
        let loss = Loss { range: Some([end, end]), ..Loss::default() };
        assert_eq!(lose([4; 3], &before, &loss).1.samples, 0);
    }
}
