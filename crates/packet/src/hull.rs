//! Rays as one beam, before anything else is done with them.

use isoray_trace::{Beam, Ray};
use wide::f32x8;

/// The least component of directions, as in [`Packlet`](crate::packlet::Packlet).
const SLOWEST: f32 = 1.0 / (1u128 << 80) as f32;

/// The beam of all rays; `None` unless they run to the same side along every axis, and are made of numbers that packets can have.
#[inline(always)]
pub(crate) fn hull(rays: &[Ray]) -> Option<Beam> {
    // A ray is a row: its components are compared with those of the others all at once.
    let row = |&Ray { origin: [x, y, z], direction: [u, v, w], t_min, t_max }: &Ray| {
        f32x8::new([x, y, z, u, v, w, t_min, t_max])
    };
    let mut least = f32x8::splat(f32::INFINITY);
    let mut most = f32x8::splat(f32::NEG_INFINITY);
    let mut are_numbers = least.simd_gt(most);
    for ray in rays {
        let row = row(ray);
        least = least.fast_min(row);
        most = most.fast_max(row);
        are_numbers &= row.simd_eq(row);
    }
    if are_numbers.to_bitmask() != 0xff {
        return None;
    }
    let ([x, y, z, u, v, w, begin, _], [hx, hy, hz, hu, hv, hw, _, end]) =
        (least.to_array(), most.to_array());
    let [low, high] = [[u, v, w], [hu, hv, hw]];
    let is_backward = high.map(|h| h < 0.0);
    let slow = std::array::from_fn(|a| if is_backward[a] { -high[a] } else { low[a] });
    let fast: [f32; 3] = std::array::from_fn(|a| if is_backward[a] { -low[a] } else { high[a] });
    let are_usual = slow.iter().all(|&s: &f32| s >= SLOWEST)
        && fast.iter().chain(&[-x, -y, -z, hx, hy, hz]).all(|&c| c <= f32::MAX);
    are_usual.then(|| Beam {
        origins: [[x, y, z], [hx, hy, hz]].map(|origin| origin.map(f64::from)),
        speeds: [slow, fast].map(|speeds| speeds.map(f64::from)),
        backward: (0..3).map(|a| u32::from(is_backward[a]) << a).sum(),
        interval: [begin, end].map(f64::from),
    })
}
