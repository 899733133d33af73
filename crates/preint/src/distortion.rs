//! How far a monotone cubic is from the straight line that replaces it: theorems, with their proofs and constants.
//!
//! Marchesin and Colin de Verdière (2009, section 3.1) cut the cubic that a ray sees in a cell at its extrema, and take each monotone piece
//! as linear. No value is missed or invented, but isosurfaces move along the ray. The paper's section 6.1 reports the farthest move that a
//! random search found, 0.468 of the segment, and its conclusion asks for a proof of the maximum. Here it is.
//!
//! # Theorem 1: the distortion
//!
//! *Let `p` be a cubic with `p(0) = 0`, `p(1) = 1` that does not decrease on `[0, 1]`. Then*
//!
//! ```text
//! |p(t) − t| ≤ √((13√13 − 35) / 54) = 0.4688869…      for all t in [0, 1],
//! ```
//!
//! *and this is attained, by the cubics whose derivative has a double root at `½ ± √(2√13 − 5)/6`* ([`DISTORTION`], [`DISTORTION_ROOT`]).
//!
//! A piece from value `s0` to `s1` that rises or falls is `s0 + (s1 − s0)·p`. The value that it has at `t` is put at `p(t)` by the straight
//! line: isosurfaces move by `|p(t) − t|` of the piece's length.
//!
//! ## Proof
//!
//! **The cone.** `q = p'` is a quadratic, not negative on `[0, 1]`, and `∫₀¹ q = 1`. All quadratics `q ≥ 0` on `[0, 1]` are a closed convex
//! cone, and the condition `∫ q = 1` cuts a compact base out of it, because only `q = 0` has the integral 0. For fixed `t`, `p(t) − t` is linear
//! in `q`, so `sup_t |p(t) − t|` is convex in `q`, and takes its maximum over the base at an extreme point: `q` on an extreme ray.
//!
//! **Its extreme rays.** A `q` that is positive on all of `[0, 1]` is not on one, since `q ± ε·r` is in the cone for any `r` and small `ε`.
//! So `q` has a root `r` in `[0, 1]`.
//!
//! - If `0 < r < 1`, it is a double root: `q = a·(x − r)²`. If that is a sum of two members of the cone, both vanish at `r`, hence both are
//!   multiples of it. The ray is extreme.
//! - If `r = 0`, then `q = x·m(x)` with `m` linear and not negative on `[0, 1]`, that is `m = a·x + b·(1 − x)` with `a, b ≥ 0`: a sum of `x²`,
//!   which is `(x − r)²` with `r = 0`, and `x·(1 − x)`. Likewise for `r = 1`, with `(x − 1)²`.
//!
//! The extreme rays are those of `(x − r)²` with `r` in `[0, 1]`, and of `x·(1 − x)`.
//!
//! **The ray of `x·(1 − x)`.** `p = 3t² − 2t³` and `p − t = −t·(1 − t)·(1 − 2t)`, at most `√3/18 = 0.096…` in magnitude.
//!
//! **The rays of `(x − r)²`.** With `r = ½ + ρ`, `t = ½ + y` and `|ρ|, |y| ≤ ½`, integrating and dividing by `∫₀¹ q = (¼ + 3ρ²)/3`,
//!
//! ```text
//! d = p(t) − t = (¼ − y²)·(3ρ − y) / (¼ + 3ρ²).                               (1)
//! ```
//!
//! Changing the signs of both `ρ` and `y` changes that of `d`; so look for the greatest `d`. It is not on the border: at `y = ±½`, `d = 0`; and
//! for any `y`, with `w = √(y² + ¾) ≤ 1`,
//!
//! ```text
//! ∂d/∂ρ = 0   ⇔   9ρ² − 6ρy − ¾ = 0   ⇔   ρ = (y ± w)/3,                      (2)
//! ```
//!
//! of which the upper sign is the maximum, and it lies in `(0, ½]`, with `½` for `y = ½` only. There, `(3ρ − y)/(¼ + 3ρ²) = 1/(2ρ)`. Next,
//!
//! ```text
//! ∂d/∂y = 0   ⇔   3y² − 6ρy − ¼ = 0.                                          (3)
//! ```
//!
//! (2) minus (3) is `y² = 3ρ² − 1/6`. The square of (2), `36ρ²y² = (9ρ² − ¾)²`, becomes `27ρ⁴ + 15/2·ρ² − 9/16 = 0`, whose only positive
//! solution is
//!
//! ```text
//! ρ² = (2√13 − 5)/36,    so that    ¼ − y² = 5/12 − 3ρ² = (5 − √13)/6,
//!
//! d² = (¼ − y²)² / (4ρ²) = (19 − 5√13) / (2·(2√13 − 5)) = (13√13 − 35) / 54.  ∎
//! ```
//!
//! # Theorem 2: with a further cut at the inflection point
//!
//! *If the second derivative of `p` has one sign on `[0, 1]`, too, then `|p(t) − t| ≤ 2/(3√3) = 0.3849002…`, attained by `p = t³`*
//! ([`DISTORTION_WITH_INFLECTION`]).
//!
//! **Proof.** Let `p'' ≥ 0`; the other case is that of `1 − p(1 − t)`. Then `q = q(0) + ∫ q'` with `q(0) ≥ 0` and `q'` linear, not negative:
//! a sum of multiples of `x` and `1 − x`. So the cone of these `q` has the extreme rays `1`, `x²` and `2x − x²`, and the maximum is on one of
//! them, as above. `1` is the straight line itself. `x²` gives `t − t³`, whose maximum at `t = 1/√3` is `2/(3√3)`. `2x − x²` gives
//! `t − p = (v − v³)/2` with `v = 1 − t`: half of that. ∎
//!
//! The piece is then what lies between extrema *and* inflection.
//!
//! # Theorem 3: the optical depth
//!
//! *Let the extinction be linear in the value over the whole piece, not negative. Linearising the value then gives between `(3 − √3)/2`
//! `= 0.634` and `(3 + √3)/2 = 2.366` of the true optical depth, and both are attained* ([`DEPTH_FACTOR`]).
//!
//! **Proof.** With extinctions `τ0`, `τ1` at the ends and `m = ∫₀¹ p dt`, the true depth is `l·(τ0 + (τ1 − τ0)·m)`, the linearised one
//! `l·(τ0 + τ1)/2`. The ratio is monotone in `τ0/τ1`, so its extremes are at `τ0 = 0`, where it is `1/(2m)`, and at `τ1 = 0`, where it is
//! `1/(2·(1 − m))`. `m` is linear in `q`, so its extremes are on extreme rays. `x·(1 − x)` has `m = ½`. Of `(x − r)²`, by integrating (1),
//!
//! ```text
//! m − ½ = ρ/2 / (¼ + 3ρ²),
//! ```
//!
//! which is extreme where `ρ² = 1/12`: `m = ½ ± 1/(2√3)`, and `1/(2m) = 1/(1 ± 1/√3) = (3 ∓ √3)/2`. ∎
//!
//! If extinction is not linear in the value over the piece, there is no such bound: where the cubic rests, an arbitrarily narrow window of
//! extinction covers arbitrarily more of the ray than of the straight line.

/// The largest distance along a ray, in lengths of a monotone piece of a cubic, between a value's place on it and that on the straight line
/// through its ends: `√((13√13 − 35)/54)`. The random search of Marchesin and Colin de Verdière (2009, section 6.1) found 0.468.
pub const DISTORTION: f64 = 0.468_886_912_470_134_1;

/// Where the derivative of the cubics that attain [`DISTORTION`] has its double root, from the nearer end: `½ − √(2√13 − 5)/6`.
pub const DISTORTION_ROOT: f64 = 0.252_170_390_583_459_6;

/// The same as [`DISTORTION`] if the piece is cut at the inflection point, too: `2/(3√3)`.
pub const DISTORTION_WITH_INFLECTION: f64 = 0.384_900_179_459_750_5;

/// The largest factor by which linearising a monotone piece overstates its optical depth, where extinction is linear in the value and not
/// negative: `(3 + √3)/2`. The least is `(3 − √3)/2`.
pub const DEPTH_FACTOR: f64 = 2.366_025_403_784_439;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Coefficients of a quadratic from the constant up.
    type Quadratic = [f64; 3];

    fn square(r: f64) -> Quadratic {
        [r * r, -2.0 * r, 1.0]
    }

    /// The cubic with this derivative at `t`, its integral normalised.
    fn cubic(q: Quadratic, t: f64) -> f64 {
        let at = |t: f64| t * (q[0] + t * (q[1] / 2.0 + t * q[2] / 3.0));
        at(t) / at(1.0)
    }

    fn combine(terms: &[(f64, Quadratic)]) -> Quadratic {
        std::array::from_fn(|n| terms.iter().map(|(a, q)| a * q[n]).sum())
    }

    /// The greatest value of `f` on `[0, 1]` by a grid and then thirds around its best point.
    fn greatest(f: impl Fn(f64) -> f64) -> (f64, f64) {
        let grid = 200;
        let at = |n: i32| f64::from(n) / f64::from(grid);
        let best = (0..=grid).max_by(|&a, &b| f(at(a)).total_cmp(&f(at(b)))).unwrap();
        let [mut low, mut high] = [at((best - 1).max(0)), at((best + 1).min(grid))];
        for _ in 0..60 {
            let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
            if f(a) < f(b) { low = a } else { high = b }
        }
        (low, f(low))
    }

    fn distortion(q: Quadratic) -> f64 {
        greatest(|t| (cubic(q, t) - t).abs()).1
    }

    #[test]
    fn the_constants_are_their_formulas() {
        let root = 13.0_f64.sqrt();
        assert!((DISTORTION - ((13.0 * root - 35.0) / 54.0).sqrt()).abs() <= 1e-15);
        assert!((DISTORTION_ROOT - (0.5 - (2.0 * root - 5.0).sqrt() / 6.0)).abs() <= 1e-15);
        assert!((DISTORTION_WITH_INFLECTION - 2.0 / 27.0_f64.sqrt()).abs() <= 1e-15);
        assert!((DEPTH_FACTOR - (3.0 + 3.0_f64.sqrt()) / 2.0).abs() <= 1e-15);
    }

    #[test]
    fn extreme_rays_reach_the_distortion() {
        let (r, found) = greatest(|r| distortion(square(r)));
        assert!((found - DISTORTION).abs() <= 1e-12, "{found}");
        // A maximum is flat: the root is known to the square root of the roundings only.
        assert!((r.min(1.0 - r) - DISTORTION_ROOT).abs() <= 1e-6, "{r}");
        assert!((distortion([0.0, 1.0, -1.0]) - 3.0_f64.sqrt() / 18.0).abs() <= 1e-12);
        // The paper's random search came this close.
        assert!((0.468..0.469).contains(&found));
    }

    #[test]
    fn extreme_rays_reach_the_distortion_with_inflection() {
        assert!((distortion(square(0.0)) - DISTORTION_WITH_INFLECTION).abs() <= 1e-12);
        assert!((distortion(square(1.0)) - DISTORTION_WITH_INFLECTION).abs() <= 1e-12);
        assert!((distortion([0.0, 2.0, -1.0]) - 0.5 * DISTORTION_WITH_INFLECTION).abs() <= 1e-12);
    }

    /// Extinction equal to the value: the linearised depth is ½, the true one the mean of the cubic.
    fn overstated(q: Quadratic) -> f64 {
        let mean = q[0] / 2.0 + q[1] / 6.0 + q[2] / 12.0;
        0.5 * (q[0] + q[1] / 2.0 + q[2] / 3.0) / mean
    }

    #[test]
    fn extreme_rays_reach_the_depth_factor() {
        let (r, found) = greatest(|r| overstated(square(r)));
        assert!((found - DEPTH_FACTOR).abs() <= 1e-12, "{found}");
        assert!((r - (0.5 - 12.0_f64.sqrt().recip())).abs() <= 1e-6, "{r}");
        let (_, least) = greatest(|r| -overstated(square(r)));
        assert!((-least - (3.0 - DEPTH_FACTOR)).abs() <= 1e-12, "{least}");
    }

    proptest! {
        #[test]
        fn no_monotone_cubic_exceeds_the_distortion(
            r in prop::array::uniform3(-1.0_f64..2.0), a in prop::array::uniform3(0.0_f64..1.0), b in 0.0_f64..1.0,
        ) {
            let q = combine(&[(a[0], square(r[0])), (a[1], square(r[1])), (a[2], square(r[2])), (b, [0.0, 1.0, -1.0])]);
            prop_assert!(distortion(q) <= DISTORTION);
            prop_assert!((3.0 - DEPTH_FACTOR..=DEPTH_FACTOR).contains(&overstated(q)));
        }

        #[test]
        fn no_cubic_on_the_extreme_rays_exceeds_it(r in 0.0_f64..1.0) {
            prop_assert!(distortion(square(r)) <= DISTORTION + 1e-15);
        }

        #[test]
        fn nor_does_one_that_is_cut_at_the_inflection(
            start in 0.0_f64..1.0, slopes in prop::array::uniform2(0.0_f64..1.0), falls in any::<bool>(),
        ) {
            prop_assume!(start + slopes[0] + slopes[1] > 1e-3);
            // q' runs from one slope to the other; mirrored, q falls.
            let rising = [start, slopes[0], 0.5 * (slopes[1] - slopes[0])];
            let [a, b, c] = rising;
            let q = if falls { [a + b + c, -b - 2.0 * c, c] } else { rising };
            prop_assert!(distortion(q) <= DISTORTION_WITH_INFLECTION + 1e-15);
        }
    }
}
