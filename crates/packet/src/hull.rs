//! Rays as one beam, before anything else is done with them.

use isoray_trace::{Beam, Ray};
use wide::f32x8;

use crate::packlet::SLOWEST;

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
    let [origins, directions] = [[[x, y, z], [hx, hy, hz]], [[u, v, w], [hu, hv, hw]]];
    if origins.iter().chain(&directions).flatten().any(|c| c.is_infinite()) {
        return None;
    }
    let in_double = |bounds: [[f32; 3]; 2]| bounds.map(|bounds| bounds.map(f64::from));
    let hull = Beam::between(in_double(origins), in_double(directions), [begin, end].map(f64::from))?;
    hull.speeds[0].iter().all(|&slowest| slowest >= SLOWEST.into()).then_some(hull)
}
