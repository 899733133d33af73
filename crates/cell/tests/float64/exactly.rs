//! What rounding must leave exact.

use isoray_cell::{Cubic, Segment, central_differences, lerp, trilinear};
use isoray_oracle::SplitMix64;
use proptest::prelude::*;

use crate::cases::{cell, point};

proptest! {
    #[test]
    fn lerp_is_exact_at_both_ends(a in -1e30f32..1e30, b in -1e30f32..1e30) {
        prop_assert_eq!(lerp(a, b, 0.0), a);
        prop_assert_eq!(lerp(a, b, 1.0), b);
    }

    #[test]
    fn lerp_is_of_the_ends_sign(
        a in 0.0f32..1.0, b in 0.0f32..1.0, from in -30..30, to in -30..30, t in 0.0f32..=1.0
    ) {
        let (a, b) = (a * 10_f32.powi(from), b * 10_f32.powi(to));
        prop_assert!(lerp(a, b, t) >= 0.0);
        prop_assert!(lerp(-a, -b, t) <= 0.0);
        // Strictly so, unless t leaves only an end that is zero.
        prop_assert!((a == 0.0 || b == 0.0) || lerp(-a, -b, t) < 0.0);
    }

    #[test]
    fn central_difference_is_exact_on_quadratics(a in -64i16..64, b in -64i16..64, c in -64i16..64) {
        let line = [-2, -1, 0, 1, 2].map(|x| f32::from(a * x * x + b * x + c));
        let (slope, [o, x]) = (f32::from(b), [false, true]);
        let of = |exists| central_differences(line, exists);
        prop_assert_eq!(of([x, x, x, x, x]), slope);
        prop_assert_eq!(of([o, o, x, x, x]), slope);
        prop_assert_eq!(of([x, x, x, o, o]), slope);
        // With one neighbour, the slope of the line through the two.
        prop_assert_eq!(of([o, o, x, x, o]), f32::from(a + b));
        prop_assert_eq!(of([o, x, x, o, o]), f32::from(b - a));
        prop_assert_eq!(of([x, o, x, o, x]), 0.0);
    }
}

/// The value where a ray passes from one cell to the next is the same from both.
#[test]
fn cells_agree_on_the_face_they_share() {
    let mut rng = SplitMix64::new(7);
    for seed in 0..200_000 {
        let axis = (seed % 3) as usize;
        let here = cell(&mut rng, seed).corners;
        let mut next = cell(&mut rng, seed / 3 + 1).corners;
        for n in (0..8).filter(|n| n >> axis & 1 == 0) {
            next[n] = here[n | 1 << axis];
        }
        let mut exit = point(&mut rng);
        exit[axis] = 1.0;
        let mut entry = exit;
        entry[axis] = 0.0;
        let before = Cubic::along(&here, &Segment { entry: point(&mut rng), exit }).0[3];
        let after = Cubic::along(&next, &Segment { entry, exit: point(&mut rng) }).0[0];
        // Zeros may differ in sign, which no comparison sees.
        let same = |a: f32, b: f32| a.to_bits() == b.to_bits() || (a == 0.0 && b == 0.0);
        assert!(same(before, after), "{before} and {after} at {exit:?}, axis {axis}");
        assert!(same(trilinear(&here, exit), trilinear(&next, entry)));
        assert!(same(before, trilinear(&here, exit)));
    }
}
