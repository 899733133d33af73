//! Numbers of the 4³ parts of a cube: `x + 4y + 16z`, two bits an axis.
//!
//! Sets of axes, and steps along them, are kept *spread*, on bits 0, 2 and 4, where they can be compared with such a number.

/// Spread form of a set of axes.
pub(crate) const SPREAD: [u32; 8] = [0, 1, 4, 5, 16, 17, 20, 21];

/// The plain form of a spread set; other bits are left out.
#[inline(always)]
pub(crate) fn axes(spread: u32) -> u32 {
    spread & 1 | spread >> 1 & 2 | spread >> 2 & 4
}

/// The axes, spread, along which an offset is the last: 3.
#[inline(always)]
pub(crate) fn lasts(offset: u32) -> u32 {
    offset & offset >> 1 & SPREAD[7]
}

/// The octant of the cube that holds the part, and the octant of that which the part is.
#[inline(always)]
pub(crate) fn octants(offset: u32) -> [u32; 2] {
    [axes(offset >> 1), axes(offset)]
}

/// By axis: the parts that are the last along it.
pub(crate) const LAST_PARTS: [u64; 3] = [0x8888_8888_8888_8888, 0xf000_f000_f000_f000, 0xffff_0000_0000_0000];

/// The parts that are the last along any of some axes.
pub(crate) fn last_parts(axes: u32) -> u64 {
    (0..3).filter(|a| axes >> a & 1 == 1).fold(0, |parts, a| parts | LAST_PARTS[a])
}

/// By axis, the first and the last: the parts from one to the other, in the order of the lattice.
const PARTS: [[[u64; 4]; 4]; 3] = {
    let mut parts = [[[0; 4]; 4]; 3];
    let mut n = 0;
    while n < 48 {
        let [axis, first, last] = [n / 16, n / 4 % 4, n % 4];
        let mut part = first;
        while part <= last {
            parts[axis][first][last] |= LAST_PARTS[axis] >> ((1 << (2 * axis)) * (3 - part));
            part += 1;
        }
        n += 1;
    }
    parts
};

/// The parts from the `first` to the `last` one along an axis, both below 4.
#[inline(always)]
pub(crate) fn parts_between(axis: usize, first: u32, last: u32) -> u64 {
    PARTS[axis][first as usize % 4][last as usize % 4]
}

/// The first `count` parts along an axis, of four.
#[inline(always)]
pub(crate) fn first_parts(axis: usize, count: u32) -> u64 {
    count.checked_sub(1).map_or(0, |last| parts_between(axis, 0, last.min(3)))
}

/// What takes the number of a part in the order of the lattice to that in the order of a ray that runs `backward` along some axes, or back, by
/// exclusive or.
#[inline(always)]
pub(crate) fn mirror(backward: u32) -> u32 {
    3 * SPREAD[backward as usize & 7]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_parts_along_an_axis() {
        for axis in 0..3 {
            for count in 0..6 {
                let expected =
                    (0..64).filter(|n| n >> (2 * axis) & 3 < count).fold(0, |parts, n| parts | 1 << n);
                assert_eq!(first_parts(axis, count), expected, "axis {axis}, {count}");
            }
            for (first, last) in (0..4).flat_map(|first| (0..4).map(move |last| (first, last))) {
                let expected = first_parts(axis, last + 1) & !first_parts(axis, first);
                assert_eq!(parts_between(axis, first, last), expected, "axis {axis}, {first} to {last}");
            }
        }
    }
}
