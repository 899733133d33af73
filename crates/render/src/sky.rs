//! Directions to the sky.

use std::f64::consts::TAU;

use glam::DVec3;

/// The `n`-th of `count` directions around a unit `normal`, by the cosine to it: each stands for an equal share of what a matt surface receives
/// from a sky of one brightness.
///
/// The points of the disc below are a spiral with the golden angle between one and the next, which fills it evenly for any count; each pixel turns
/// it by an angle of its own, so that what is left of the error is fine noise, the same in every run.
pub(crate) fn direction(n: u32, count: u32, pixel: [u32; 2], normal: DVec3) -> DVec3 {
    /// The golden ratio less one.
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let square = (f64::from(n) + 0.5) / f64::from(count);
    let turn = f64::from(n) * GOLDEN + turn_of(pixel);
    let (sine, cosine) = (TAU * turn).sin_cos();
    let (across, up) = normal.any_orthonormal_pair();
    let radius = square.sqrt();
    (across * (radius * cosine) + up * (radius * sine) + normal * (1.0 - square).sqrt()).normalize_or(normal)
}

/// From 0 to 1, without visible order (the finaliser of MurmurHash3).
fn turn_of([x, y]: [u32; 2]) -> f64 {
    let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77);
    h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    f64::from(h ^ h >> 16) / f64::from(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_spread_by_the_cosine() {
        for (normal, pixel) in [(DVec3::Z, [0, 0]), (DVec3::new(0.6, -0.64, 0.48), [17, 300])] {
            const COUNT: u32 = 4096;
            let all: Vec<DVec3> = (0..COUNT).map(|n| direction(n, COUNT, pixel, normal)).collect();
            let mean = |f: &dyn Fn(&DVec3) -> f64| all.iter().map(f).sum::<f64>() / f64::from(COUNT);
            assert!(all.iter().all(|d| (d.length() - 1.0).abs() < 1e-12 && d.dot(normal) > 0.0));
            // Of the cosine itself the mean is 2/3, of its square 1/2; sideways, zero.
            assert!((mean(&|d| d.dot(normal)) - 2.0 / 3.0).abs() < 1e-3);
            assert!((mean(&|d| d.dot(normal).powi(2)) - 0.5).abs() < 1e-3);
            let (across, up) = normal.any_orthonormal_pair();
            assert!(mean(&|d| d.dot(across)).abs() < 1e-2 && mean(&|d| d.dot(up)).abs() < 1e-2);
        }
    }

    #[test]
    fn neighbouring_pixels_turn_differently() {
        let turns: std::collections::HashSet<u64> =
            (0..64).flat_map(|y| (0..64).map(move |x| turn_of([x, y]).to_bits())).collect();
        assert!(turns.len() > 4000, "{}", turns.len());
    }
}
