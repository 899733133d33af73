//! Which octants of a node a ray meets.

use wide::f64x4;

/// The octants that a ray meets between `t` and `t_end`, which crosses the mid-planes at `mid` and is `backward` along those axes: all
/// of them, and others only where it crosses two mid-planes at once.
///
/// Known before the ray is followed from octant to octant, they tell a node without surface on the ray at once.
#[inline(always)]
pub(crate) fn reachable(mid: f64x4, t: f64, t_end: f64, backward: u32) -> u32 {
    let crossed = mid.simd_le(f64x4::splat(t)).to_bitmask() & 7;
    let crossed_in_the_end = mid.simd_lt(f64x4::splat(t_end)).to_bitmask() & 7;
    let [x, y, z, idle] = mid.to_array();
    let order = mid.simd_lt(f64x4::new([y, z, x, idle])).to_bitmask() & 7;
    let first = crossed ^ backward;
    let axes = crossed ^ crossed_in_the_end;
    REACHABLE[first as usize & 7][axes as usize & 7][order as usize & 7].into()
}

/// By the first octant, the axes whose mid-planes are crossed, and their order: bit `a` tells that the plane of axis `a` is crossed
/// before that of the next axis, z being followed by x.
const REACHABLE: [[[u8; 8]; 8]; 8] = {
    let mut reachable = [[[0; 8]; 8]; 8];
    let mut n = 0;
    while n < 8 * 8 * 8 * 8 {
        let (octant, axes, order, first) = (n & 7, n >> 3 & 7, n >> 6 & 7, n >> 9);
        if is_reachable(first ^ octant, axes, order) {
            reachable[first][axes][order] |= 1 << octant;
        }
        n += 1;
    }
    reachable
};

/// Whether, at some time, the ray has crossed the planes `crossed` out of `axes` and no others.
const fn is_reachable(crossed: usize, axes: usize, order: usize) -> bool {
    if crossed & !axes != 0 {
        return false;
    }
    // No plane is before the next all around the circle: all three are crossed at once, or, for 7, the order is none.
    if order == 0 || order == 7 {
        return true;
    }
    let mut a = 0;
    while a < 3 {
        let b = (a + 1) % 3;
        let (earlier, later) = if order >> a & 1 == 1 { (a, b) } else { (b, a) };
        // A tie counts as `b` first.
        if axes >> earlier & 1 == 1 && crossed >> later & 1 == 1 && crossed >> earlier & 1 == 0 {
            return false;
        }
        a += 1;
    }
    true
}

#[cfg(test)]
mod tests {
    use isoray_oracle::SplitMix64;

    use super::*;
    use crate::ray::BEYOND;

    /// Follows the ray from crossing to crossing.
    fn met(mid: [f64; 3], t: f64, t_end: f64, backward: u32) -> u32 {
        let octant = |t: f64| (0..3).fold(backward, |o, a| o ^ u32::from(mid[a] <= t) << a);
        let later = mid.into_iter().filter(|&m| m > t && m < t_end);
        later.fold(1 << octant(t), |met, m| met | 1 << octant(m))
    }

    #[test]
    fn reachable_octants_are_those_met_step_by_step() {
        let mut random = SplitMix64::new(7);
        for _ in 0..200_000 {
            // Few values, so that many are equal.
            let mut some = || f64::from(random.below(6));
            let mid = [some(), some(), some()];
            let t = some();
            let t_end = t + 0.5 + some();
            let backward = random.below(8);
            let met = met(mid, t, t_end, backward);
            let found = reachable(f64x4::new([mid[0], mid[1], mid[2], BEYOND]), t, t_end, backward);
            let is_tie = mid[0] == mid[1] || mid[1] == mid[2] || mid[2] == mid[0];
            let is_right = if is_tie { found & met == met } else { found == met };
            assert!(is_right, "{found:b}, {met:b}: {mid:?} in {t}..{t_end}");
        }
    }
}
