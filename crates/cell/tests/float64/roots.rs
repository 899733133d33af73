//! Where roots are found.

use isoray_cell::{Cubic, EXCURSION_UNITS, ROOT_STEP, Segment};
use isoray_oracle::SplitMix64;

use crate::cases::{U, cell, segment};
use crate::exact;

/// A step is left undone at the root, and the parameter is rounded.
const STEPS: f64 = 2.0 * ROOT_STEP as f64;

/// Magnitudes at which sums of three values neither overflow nor lose digits to underflow.
const MAGNITUDES: std::ops::Range<f64> = 1e-35..1e37;

/// Whatever an error within the bounds does: the root lies between where the exact cubic first comes so near to zero that it
/// can change side, and where it first is so far beyond that it must have.
#[test]
fn the_first_root_is_where_the_exact_cubic_first_changes_side() {
    const CASES: u64 = 400_000;
    let mut rng = SplitMix64::new(3);
    let [mut surely, mut surely_not, mut grazing] = [0; 3];
    for seed in 0..CASES {
        let cell = cell(&mut rng, seed);
        if !MAGNITUDES.contains(&cell.magnitude) {
            continue;
        }
        let segment = segment(&mut rng);
        let found = Cubic::along(&cell.corners, &segment).first_root().get().map(f64::from);
        let exact = exact::Cubic::along(&cell.exact, &segment);
        let bound = f64::from(EXCURSION_UNITS) * U * cell.magnitude;
        if exact.0[0].abs() <= bound {
            grazing += 1;
            continue;
        }
        // From here on the cubic starts above zero.
        let sign = exact.0[0].signum();
        let above = exact::Cubic(exact.0.map(|b| sign * b));
        match (above.first_at_most(bound), above.first_at_most(-bound)) {
            (None, _) => {
                surely_not += 1;
                assert_eq!(found, None, "seed {seed}: {above:?}");
            }
            (Some(can), Some(must)) => {
                surely += 1;
                let root = found.unwrap_or_else(|| panic!("seed {seed}: no root in {above:?}"));
                assert!(
                    (can - STEPS..=must + STEPS).contains(&root),
                    "seed {seed}: {root}, not in {can}..={must} of {above:?}"
                );
            }
            (Some(can), None) => {
                grazing += 1;
                assert!(
                    found.is_none_or(|root| root >= can - STEPS),
                    "seed {seed}: {found:?}, not from {can}"
                );
            }
        }
    }
    println!("{surely} roots, {surely_not} without, {grazing} grazing");
    assert!(surely > CASES / 8 && surely_not > CASES / 8, "{surely} {surely_not} {grazing}");
}

/// The bound as the documentation states it, for roots at which the slope stays about the same.
#[test]
fn a_simple_root_is_within_the_bound_over_the_slope() {
    let mut rng = SplitMix64::new(4);
    let mut tested = 0;
    for seed in 0..200_000 {
        let cell = cell(&mut rng, seed);
        let segment = segment(&mut rng);
        let exact = exact::Cubic::along(&cell.exact, &segment);
        let [a, b, c, d] = exact.0;
        let slopes = [b - a, c - b, d - c];
        let least = slopes.iter().fold(f64::INFINITY, |m, s| m.min(s.abs())) * 3.0;
        let is_monotone = slopes.iter().all(|s| s.signum() == slopes[0].signum());
        let bound = f64::from(EXCURSION_UNITS) * U * cell.magnitude;
        if !is_monotone || a.abs().min(d.abs()) <= bound || a.signum() == d.signum() {
            continue;
        }
        tested += 1;
        let sign = a.signum();
        let root = exact::Cubic(exact.0.map(|b| sign * b)).first_at_most(0.0).unwrap();
        let found = f64::from(Cubic::along(&cell.corners, &segment).first_root().get().unwrap());
        assert!((found - root).abs() <= bound / least + STEPS, "seed {seed}: {found}, not {root}");
    }
    assert!(tested > 10_000, "only {tested}");
}

#[test]
fn different_ends_always_give_a_root() {
    let mut rng = SplitMix64::new(5);
    for _ in 0..300_000 {
        let scale = 10_f64.powf(rng.range(-40.0, 38.0));
        let zero = rng.below(12) as usize;
        let b: [f32; 4] =
            std::array::from_fn(|n| if n == zero { 0.0 } else { (scale * rng.range(-1.0, 1.0)) as f32 });
        let root = Cubic(b).first_root().get();
        assert!(root.is_none_or(|s| (0.0..=1.0).contains(&s)), "{root:?} of {b:?}");
        if (b[0] >= 0.0) != (b[3] >= 0.0) {
            assert!(root.is_some(), "{b:?}");
        }
        if b.iter().all(|&c| c >= 0.0) || b.iter().all(|&c| c < 0.0) {
            assert_eq!(root, None, "{b:?}");
        }
    }
}

/// Numbers that never come from a valid volume; the evaluations are counted in the code, so that no input can make it run long.
#[test]
fn any_bits_are_survived() {
    let mut rng = SplitMix64::new(6);
    let special = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        1e30,
        -1e30,
        1e-45,
        -1e-45,
        1e-40,
        0.0,
        -0.0,
    ];
    for _ in 0..300_000 {
        let corners: [f32; 8] = std::array::from_fn(|_| match rng.below(4) {
            0 => f32::from_bits(rng.next_u64() as u32),
            1 => rng.range(-1.0, 1.0) as f32,
            _ => special[rng.below(special.len() as u32) as usize],
        });
        let segment = segment(&mut rng);
        let root = Cubic::along(&corners, &segment).first_root().get();
        assert!(root.is_none_or(|s| (0.0..=1.0).contains(&s)), "{root:?} of {corners:?} {segment:?}");
        let Segment { entry, .. } = segment;
        let _ = (isoray_cell::trilinear(&corners, entry), isoray_cell::gradient(&corners, entry));
    }
}
