//! Opacity of an optical depth.

use isoray_cell::Real;

/// `1 − e^(−depth)` for an optical depth of at least 0: the opacity, accurate to 4 roundings of itself, however small the depth is.
///
/// With `depth = n·ln 2 + r`, `|r| ≤ ½ ln 2`, it is `(1 − 2⁻ⁿ) + 2⁻ⁿ·(1 − e^(−r))`, the last factor by its power series.
#[inline(always)]
pub fn opacity<R: Real>(depth: R) -> R {
    let one = R::splat(1.0);
    // Beyond, the opacity rounds to 1.
    let depth = depth.min(R::splat(if is_single::<R>() { 80.0 } else { 600.0 }));
    let rounder = R::splat(R::ROUNDER);
    let shifted = depth.fma(R::splat(-std::f64::consts::LOG2_E), rounder);
    let n = shifted - rounder;
    // The first part of ln 2 has so few digits that its product with n is exact.
    let [high, low] = if is_single::<R>() {
        [0.693_359_375, -2.121_944_400_546_905_8e-4]
    } else {
        [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10]
    };
    let r = n.fma(R::splat(low), n.fma(R::splat(high), depth));
    // r − r²/2 + r³/6 − …, what is left out being less than a quarter of a rounding.
    let terms = if is_single::<R>() { 7 } else { 13 };
    let mut sum = one;
    for k in (2..=terms).rev() {
        sum = (r * R::splat(-1.0 / f64::from(k))).fma(sum, one);
    }
    let scale = shifted.power_of_two();
    scale.fma(r * sum, one - scale)
}

/// Whether numbers are of single precision.
#[inline(always)]
pub(crate) fn is_single<R: Real>() -> bool {
    R::EPSILON > 1e-10
}

#[cfg(test)]
mod tests {
    use wide::f32x16;

    use super::*;

    #[test]
    fn opacities_are_accurate_to_roundings() {
        let mut worst = [0.0f64; 2];
        for n in 0..2_000_000u32 {
            let depth = f64::from((f64::from(n) * 1e-4 - 100.0).exp2() as f32);
            let exact = -(-depth).exp_m1();
            let error = |found: f64| ((found - exact) / exact).abs();
            worst[0] = worst[0].max(error(opacity(depth as f32).into()) / f64::from(f32::EPSILON) * 2.0);
            worst[1] = worst[1].max(error(opacity(depth)) / f64::EPSILON * 2.0);
        }
        println!("{worst:?} roundings");
        assert!(worst.iter().all(|&w| w <= 4.0), "{worst:?} roundings");
    }

    #[test]
    fn ends_are_exact_and_lanes_agree() {
        assert_eq!((opacity(0.0f32), opacity(1e6f32), opacity(f32::INFINITY)), (0.0, 1.0, 1.0));
        assert_eq!((opacity(0.0f64), opacity(1e6f64), opacity(1e-30f64)), (0.0, 1.0, 1e-30));
        for n in 0..10_000 {
            let depths: [f32; 16] = std::array::from_fn(|k| (k as f32 + 0.3) * 1.003f32.powi(n - 8000));
            let found = opacity(f32x16::new(depths)).to_array();
            assert_eq!(found, depths.map(opacity));
        }
    }
}
