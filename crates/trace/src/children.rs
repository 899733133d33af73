//! The children of a node on a ray, in order.

use wide::f64x4;

use crate::ray::{greatest, least};

/// The up to four children that a ray meets, of those that can hold surface.
///
/// The three mid-planes part the ray's stretch in a node into four; a part of no length is no child. In the part that begins when
/// `n` of the planes have been crossed the ray is in the octant whose bits are those axes, mirrored along the axes on which it runs backward. All
/// is found at once and without branches, which the processor could not foresee.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Children {
    /// Begin and end of the four parts. In pairs, so that what is read at once has been written at once: the processor
    /// forwards a pair from one store, but waits for two to reach the cache.
    parts: [[f64; 2]; 4],
    /// The octants still to be visited, mirrored; along the ray they ascend.
    left: u32,
    backward: u32,
}

/// By which of x ≤ y, x ≤ z and y ≤ z hold between the crossings of the three mid-planes: the mirrored octants of the four
/// parts, as a bit mask. (Two of the eight cannot be.)
const PARTS: [u8; 8] = {
    let mut table = [0; 8];
    let mut n = 0;
    while n < 8 {
        let (xy, xz, yz) = (n & 1 == 1, n >> 1 & 1 == 1, n >> 2 & 1 == 1);
        let first = if xy && xz {
            1
        } else if !xy && yz {
            2
        } else {
            4
        };
        let last = if xz && yz {
            4
        } else if xy && !yz {
            2
        } else {
            1
        };
        table[n] = 1 | 1 << first | 1 << (7 & !last) | 1 << 7;
        n += 1;
    }
    table
};

/// The mirrored octants of the part that begins after none, one, two and three crossings.
const AFTER: [u32; 4] = [0b0000_0001, 0b0001_0110, 0b0110_1000, 0b1000_0000];

/// Mirrors a bit mask of octants: bit `n` goes to `n ^ backward`.
#[inline(always)]
fn mirror(octants: u32, backward: u32) -> u32 {
    let swap = |m: u32, shift: u32, low: u32| (m & low) << shift | (m >> shift & low);
    let m = if backward & 1 == 0 { octants } else { swap(octants, 1, 0x55) };
    let m = if backward & 2 == 0 { m } else { swap(m, 2, 0x33) };
    if backward & 4 == 0 { m } else { swap(m, 4, 0x0f) }
}

impl Children {
    /// The children in `active` on the stretch from `t` to `t_end`, of a ray that crosses the mid-planes at `mid` and runs
    /// backward along the axes in `backward`; `None` if there are none.
    #[inline(always)]
    pub(crate) fn new(
        active: impl FnOnce() -> u32,
        mid: f64x4,
        backward: u32,
        [t, t_end]: [f64; 2],
    ) -> Option<Self> {
        let [x, y, z, _] = mid.to_array();
        let order = u32::from(x <= y) | u32::from(x <= z) << 1 | u32::from(y <= z) << 2;
        // The three in ascending order, those outside the stretch moved to its ends.
        let (low, high) = (least(x, y), greatest(x, y));
        let clamp = |c: f64| least(greatest(c, t), t_end);
        let [first, second, third] =
            [clamp(least(low, z)), clamp(greatest(low, least(high, z))), clamp(greatest(high, z))];
        let lengths = [t < first, first < second, second < third, third < t_end];
        let has_length = (0..4).fold(0, |m, n| m | AFTER[n] & u32::from(lengths[n]).wrapping_neg());
        let on_path = u32::from(PARTS[order as usize]) & has_length;
        // Mirrored before the node's ranges are there, which may take long: whether anything is left is then known at once.
        let on_path = mirror(on_path, backward);
        let visited = active() & on_path;
        if visited == 0 {
            return None;
        }
        let parts = [[t, first], [first, second], [second, third], [third, t_end]];
        Some(Self { parts, left: mirror(visited, backward), backward })
    }

    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.left == 0
    }

    /// The next child and the ray's stretch in it.
    #[inline(always)]
    pub(crate) fn next(&mut self) -> Option<(u32, [f64; 2])> {
        if self.left == 0 {
            return None;
        }
        let mirrored = self.left.trailing_zeros() & 7;
        let part = mirrored.count_ones() as usize;
        self.left &= self.left - 1;
        Some((mirrored ^ self.backward, self.parts[part]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The children by the definition: from crossing to crossing, the octant told by the planes crossed so far.
    fn by_definition(
        active: u32,
        mid: [f64; 3],
        backward: u32,
        [mut t, t_end]: [f64; 2],
    ) -> Vec<(u32, [f64; 2])> {
        let mut children = Vec::new();
        while t < t_end {
            let crossed: u32 = (0..3).map(|a| u32::from(mid[a] <= t) << a).sum();
            let next = mid.into_iter().filter(|&m| m > t).fold(t_end, f64::min);
            let octant = crossed ^ backward;
            if active >> octant & 1 == 1 {
                children.push((octant, [t, next]));
            }
            t = next;
        }
        children
    }

    #[test]
    fn every_order_and_tie_of_crossings_is_as_defined() {
        let places = [f64::NEG_INFINITY, -1.0, 0.0, 0.25, 0.5, 0.75, 1.0, 2.0, f64::INFINITY];
        let mut tested = 0;
        for n in 0..9 * 9 * 9 {
            let [x, y, z] = [places[n % 9], places[n / 9 % 9], places[n / 81]];
            for backward in 0..8 {
                for active in [0xff, 0x00, 0x5a, 0xa5, 0x0f, 0x81] {
                    let found = Children::new(|| active, f64x4::new([x, y, z, 0.0]), backward, [0.0, 1.0]);
                    let expected = by_definition(active, [x, y, z], backward, [0.0, 1.0]);
                    assert_eq!(found.is_none(), expected.is_empty());
                    let mut found = found.unwrap_or_default();
                    for child in expected {
                        assert_eq!(found.next(), Some(child), "{x} {y} {z} {backward:b} {active:b}");
                    }
                    assert_eq!(found.next(), None);
                    tested += 1;
                }
            }
        }
        assert_eq!(tested, 9 * 9 * 9 * 8 * 6);
    }
}
