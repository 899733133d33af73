//! What the generators promise: the same for the same seed, and of the kind that was asked for.

use isoray_oracle::{
    LatticeKind, OracleRay, RayKind, SplitMix64, adversarial_cell, adversarial_isovalue, adversarial_lattice,
    adversarial_ray,
};

const DIMS: [u32; 3] = [7, 4, 9];
const SEEDS: u64 = 3200;

fn rays(kind: RayKind) -> impl Iterator<Item = OracleRay> {
    (0..SEEDS).map(move |seed| kind.generate(DIMS, seed))
}

fn is_integer(x: f32) -> bool {
    x == x.round()
}

#[test]
fn seeds_repeat_and_cycle_through_the_kinds() {
    for seed in 0..64 {
        assert_eq!(adversarial_ray(DIMS, seed), RayKind::ALL[seed as usize % 16].generate(DIMS, seed));
        assert_eq!(adversarial_cell(seed), adversarial_cell(seed));
        let (a, b) = (adversarial_lattice(DIMS, seed), adversarial_lattice(DIMS, seed));
        assert!(a.iter().zip(&b).all(|(a, b)| a.to_bits() == b.to_bits()));
        assert_eq!(a.len(), DIMS.iter().map(|&n| n as usize).product());
        assert!(adversarial_isovalue(&a, seed).is_finite());
    }
    // Of the published reference code, seed 1234567.
    let mut rng = SplitMix64::new(1_234_567);
    assert_eq!([rng.next_u64(), rng.next_u64()], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
}

#[test]
fn rays_are_finite_and_have_a_direction() {
    for kind in RayKind::ALL {
        for ray in rays(kind) {
            assert!(ray.origin.iter().chain(&ray.direction).all(|c| c.is_finite()), "{kind:?} {ray:?}");
            assert!(ray.direction != [0.0; 3] && ray.t_min < ray.t_max, "{kind:?} {ray:?}");
        }
    }
}

#[test]
fn rays_are_of_their_kind() {
    let parallel = |ray: &OracleRay| ray.direction.iter().filter(|&&d| d == 0.0).count();
    assert!(rays(RayKind::AxisParallel).all(|r| parallel(&r) == 2));
    assert!(
        rays(RayKind::AlongEdges).all(|r| (0..3).all(|a| r.direction[a] != 0.0 || is_integer(r.origin[a])))
    );
    assert!(rays(RayKind::InFace).all(|r| (0..3).any(|a| r.direction[a] == 0.0 && is_integer(r.origin[a]))));
    assert!(rays(RayKind::InBorderFace).all(|r| {
        (0..3).any(|a| r.direction[a] == 0.0 && [0.0, (DIMS[a] - 1) as f32].contains(&r.origin[a]))
    }));
    assert!(rays(RayKind::Diagonal).all(|r| r.origin.iter().all(|&c| is_integer(c))));
    assert!(rays(RayKind::FromVertex).all(|r| r.origin.iter().all(|&c| is_integer(c))));
    assert!(rays(RayKind::FromFace).all(|r| r.origin.iter().any(|&c| is_integer(c))));
    let tiny = |d: f32| d != 0.0 && d.abs() < 1e-19;
    assert!(rays(RayKind::TinyComponents).all(|r| r.direction.iter().any(|&d| tiny(d))));
    assert!(rays(RayKind::TinyComponents).any(|r| r.direction.iter().any(|d| d.is_subnormal())));
    let negative_zero = |d: &f32| *d == 0.0 && d.is_sign_negative();
    assert!(rays(RayKind::NegativeZero).all(|r| r.direction.iter().any(negative_zero)));
    assert!(rays(RayKind::FarOrigin).all(|r| r.origin.iter().any(|c| c.abs() > 2e3)));
    let outside = |r: &OracleRay| (0..3).any(|a| r.origin[a] < 0.0 || r.origin[a] > (DIMS[a] - 1) as f32);
    for kind in [RayKind::ThroughVertex, RayKind::ThroughEdge, RayKind::ThroughFace, RayKind::Random] {
        assert!(rays(kind).all(|r| outside(&r)), "{kind:?}");
    }
}

#[test]
fn degenerate_dimensions_do_not_panic() {
    for dims in [[0, 0, 0], [1, 1, 1], [2, 1, 5]] {
        for seed in 0..160 {
            adversarial_ray(dims, seed);
            adversarial_isovalue(&adversarial_lattice(dims, seed), seed);
        }
    }
    assert!(LatticeKind::NonFinite.generate([8; 3], 1).iter().any(|s| !s.is_finite()));
}
