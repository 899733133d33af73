//! Where roots are found.

use isoray_cell::{Cubic, EXCURSION_UNITS, MAGNITUDES, ROOT_STEP, Segment, relative};
use isoray_oracle::{CellCase, CellVerdict, DoubleDouble, SegmentCubic, SplitMix64, adversarial_case};

use crate::cases::{U, cell, segment};

/// A step is left undone at the root, and the parameter is rounded.
const STEPS: f64 = 2.0 * ROOT_STEP as f64;

/// Adversarial cases on which `verdict` may be no violation, and must be a decision often enough.
fn judge_all(count: u64, verdict: impl Fn(&CellCase, &Segment) -> CellVerdict) {
    let [mut roots, mut nothing, mut undecided] = [0; 3];
    for seed in 0..count {
        let case = adversarial_case(seed);
        if !MAGNITUDES.contains(&case.magnitude()) {
            continue;
        }
        let verdict = verdict(&case, &Segment { entry: case.entry, exit: case.exit });
        assert!(!verdict.is_violation(), "seed {seed}: {verdict:?} in {case:?}");
        match verdict {
            CellVerdict::Found(_) => roots += 1,
            CellVerdict::Nothing => nothing += 1,
            _ => undecided += 1,
        }
    }
    println!("{roots} roots, {nothing} without, {undecided} undecided");
    assert!(roots > count / 8 && nothing > count / 8, "{roots} {nothing} {undecided}");
}

#[test]
fn the_first_root_is_where_the_exact_cubic_first_changes_side() {
    judge_all(400_000, |case, segment| {
        let found = Cubic::along(&relative(&case.samples, case.isovalue), segment).first_root().get();
        case.judge(found, EXCURSION_UNITS, 2.0 * ROOT_STEP)
    });
}

/// In `f64`, with the same bounds in its own unit roundoff, against twice that precision.
#[test]
fn the_bounds_hold_in_double_precision() {
    const ROUNDOFF: f64 = f64::EPSILON / 2.0;
    /// The parameter's error and that of the reference's bisection.
    const STEP: f64 = f64::EPSILON + 1.0 / (1_u64 << 49) as f64;
    judge_all(40_000, |case, segment| {
        let corners = relative(&case.samples.map(f64::from), f64::from(case.isovalue));
        let [entry, exit] = [segment.entry, segment.exit].map(|p| p.map(f64::from));
        let found = Cubic::along(&corners, &Segment { entry, exit }).first_root().get();
        let bound = f64::from(EXCURSION_UNITS) * ROUNDOFF * case.magnitude();
        SegmentCubic::<DoubleDouble>::new(case).judge(found, bound, STEP)
    });
}

/// The bound as the documentation states it, for roots at which the slope stays about the same.
#[test]
fn a_simple_root_is_within_the_bound_over_the_slope() {
    let mut rng = SplitMix64::new(4);
    let mut tested = 0;
    for seed in 0..200_000 {
        let cell = cell(&mut rng, seed);
        let segment = segment(&mut rng);
        let exact = cell.along(&segment);
        let [a, b, c, d] = exact.bernstein;
        let slopes = [b - a, c - b, d - c];
        let least = slopes.iter().fold(f64::INFINITY, |m, s| m.min(s.abs())) * 3.0;
        let is_monotone = slopes.iter().all(|s| s.signum() == slopes[0].signum());
        let bound = f64::from(EXCURSION_UNITS) * U * cell.magnitude;
        if !is_monotone || a.abs().min(d.abs()) <= bound || a.signum() == d.signum() {
            continue;
        }
        tested += 1;
        let sign = a.signum();
        let root = exact.times(sign).first_at_most(0.0).unwrap();
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
