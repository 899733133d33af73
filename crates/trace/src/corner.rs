//! Lattice points in one word.

/// Bits of a coordinate: the largest axis has 2²¹ samples.
const BITS: u32 = 21;
const MASK: u64 = (1 << BITS) - 1;

/// The low corner of a cube of edge 2^level, whose coordinates are whole multiples of that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Corner(pub u64);

impl Corner {
    /// No cube's: with the bit above the coordinates.
    pub(crate) const NONE: Self = Self(1 << (3 * BITS));

    /// Of non-negative whole numbers below 2²¹.
    #[inline(always)]
    pub const fn new([x, y, z]: [u32; 3]) -> Self {
        Self(x as u64 | (y as u64) << BITS | (z as u64) << (2 * BITS))
    }

    /// Lattice coordinates.
    #[inline(always)]
    pub fn coordinates(self) -> [u32; 3] {
        [self.0 & MASK, self.0 >> BITS & MASK, self.0 >> (2 * BITS) & MASK].map(|c| c as u32)
    }

    /// That of the part at `offset`, of edge 2^`part_level`.
    #[inline(always)]
    pub(crate) fn of_part(self, offset: u32, part_level: u32) -> Self {
        let offset = u64::from(offset);
        let parts = offset & 3 | (offset >> 2 & 3) << BITS | (offset >> 4 & 3) << (2 * BITS);
        Self(self.0.wrapping_add(parts << part_level))
    }

    /// That of the neighbouring cube of edge 2^`level` in `direction`: bit 0 along x, 1 y, 2 z.
    #[inline(always)]
    pub(crate) fn neighbor(self, direction: u32, level: u32) -> Self {
        let d = u64::from(direction);
        let step = d & 1 | (d >> 1 & 1) << BITS | (d >> 2 & 1) << (2 * BITS);
        Self(self.0.wrapping_add(step << level))
    }

    /// That of the cube of edge 2^`level` around.
    #[inline(always)]
    pub fn around(self, level: u32) -> Self {
        let axis = MASK >> level << level;
        Self(self.0 & (axis | axis << BITS | axis << (2 * BITS)))
    }

    /// The offset of the part of edge 2^`part_level` that holds it, in the cube four times as large.
    #[inline(always)]
    pub fn offset(self, part_level: u32) -> u32 {
        let at = self.0 >> part_level;
        (at & 3 | (at >> BITS & 3) << 2 | (at >> (2 * BITS) & 3) << 4) as u32
    }

    /// A number below 2^`bits`.
    #[inline(always)]
    pub(crate) fn slot(self, bits: u32) -> usize {
        spread(self.0, bits)
    }

    /// Different for the cubes of edge 4 of any window of 16³ of them, modulo 4096: in blocks, the sum of the coordinates with weights
    /// 256, 16 and 1.
    #[inline(always)]
    pub(crate) fn block_slot(self) -> usize {
        // At the top of a word.
        const TOP: u32 = u64::BITS - 12;
        const WEIGHTS: u64 = 1 << (TOP + 8 - 2) | 1 << (TOP + 4 - 2 - BITS) | 1 << (TOP - 2 - 2 * BITS);
        (self.0.wrapping_mul(WEIGHTS) >> TOP) as usize
    }
}

/// To which side a ray runs along each axis, in bits of a [`Key`] that corners do not use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facing(u64);

impl Facing {
    const ALL: u64 = 3 << BITS | 1 << (2 * BITS);

    /// Bit `a` of `backward`: towards smaller coordinates of axis `a`.
    #[inline(always)]
    pub(crate) fn new(backward: u32) -> Self {
        let backward = u64::from(backward);
        Self((backward & 3) << BITS | (backward >> 2 & 1) << (2 * BITS))
    }

    /// Parts of a cube, bit by bit, from the order of the lattice to that of the ray, which meets a part only after those with lower bits;
    /// or back.
    pub(crate) fn ordered(self, mut parts: u64) -> u64 {
        if self.0 >> BITS & 1 != 0 {
            parts = (parts & 0x1111_1111_1111_1111) << 3
                | (parts & 0x2222_2222_2222_2222) << 1
                | parts >> 1 & 0x2222_2222_2222_2222
                | parts >> 3 & 0x1111_1111_1111_1111;
        }
        if self.0 >> (BITS + 1) & 1 != 0 {
            parts = (parts & 0x000f_000f_000f_000f) << 12
                | (parts & 0x00f0_00f0_00f0_00f0) << 4
                | parts >> 4 & 0x00f0_00f0_00f0_00f0
                | parts >> 12 & 0x000f_000f_000f_000f;
        }
        if self.0 >> (2 * BITS) & 1 != 0 {
            parts = parts.rotate_left(32);
            parts = (parts & 0x0000_ffff_0000_ffff) << 16 | parts >> 16 & 0x0000_ffff_0000_ffff;
        }
        parts
    }
}

/// What something known about a cube is found by: its corner and level, and the facing of the rays that it is kept for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key(u64);

impl Key {
    /// No cube's.
    pub(crate) const NONE: Self = Self(0);

    /// Of a cube of edge 2^`level`, at least 4. The lowest bit of x that is set tells the level, since the corner has none below.
    #[inline(always)]
    pub(crate) fn new(corner: Corner, level: u32, facing: Facing) -> Self {
        Self(corner.0 | 1 << (level - 1) | facing.0)
    }

    /// Whether the cube is the same.
    #[inline(always)]
    pub(crate) fn is_of_same_cube(self, other: Self) -> bool {
        (self.0 ^ other.0) & !Facing::ALL == 0
    }

    pub(crate) fn facing(self) -> Facing {
        Facing(self.0 & Facing::ALL)
    }

    /// Below 2^`bits`.
    #[inline(always)]
    pub(crate) fn slot(self, bits: u32) -> usize {
        spread(self.0, bits)
    }
}

/// Fibonacci hashing (Knuth, The Art of Computer Programming 3, section 6.4): neighbours in a row along any axis are spread.
#[inline(always)]
fn spread(word: u64, bits: u32) -> usize {
    (word.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (u64::BITS - bits)) as usize
}

#[cfg(test)]
mod tests {
    use isoray_oracle::SplitMix64;

    use super::*;
    use crate::offset::mirror;

    #[test]
    fn corners_are_packed_and_unpacked() {
        let mut random = SplitMix64::new(1);
        for _ in 0..10_000 {
            let p = [(); 3].map(|()| random.below(1 << BITS));
            let level = random.below(10);
            let around = Corner::new(p).around(level + 2);
            assert_eq!(Corner::new(p).coordinates(), p);
            assert_eq!(around.coordinates(), p.map(|c| c >> (level + 2) << (level + 2)));
            let part = around.of_part(Corner::new(p).offset(level), level);
            assert_eq!(part, Corner::new(p).around(level), "{p:?}, level {level}");
            let inner = p.map(|c| c & 0xffff);
            let direction = random.below(8);
            let expected = std::array::from_fn(|a| inner[a] + ((direction >> a & 1) << level));
            assert_eq!(Corner::new(inner).neighbor(direction, level).coordinates(), expected);
        }
    }

    #[test]
    fn slots_differ_in_a_window() {
        let low = [4 * 777, 4 * 3, 4 * 120_001];
        let mut taken = vec![false; 4096];
        for n in 0..4096 {
            let block = [n & 15, n >> 4 & 15, n >> 8];
            let slot = Corner::new(std::array::from_fn(|a| low[a] + 4 * block[a])).block_slot();
            assert!(!std::mem::replace(&mut taken[slot], true), "{block:?}");
        }
    }

    #[test]
    fn keys_tell_cubes_and_facings_apart() {
        let mut keys = std::collections::HashSet::new();
        for level in [2, 4, 6, 20] {
            for n in 0..27u32 {
                let corner = Corner::new([n % 3, n / 3 % 3, n / 9].map(|c| (c << level) & 0xf_ffff));
                let corner = corner.around(level);
                for backward in 0..8 {
                    let key = Key::new(corner, level, Facing::new(backward));
                    assert_eq!(key.facing(), Facing::new(backward));
                    keys.insert((key.0, corner.0, level, backward));
                    assert!(key.is_of_same_cube(Key::new(corner, level, Facing::new(0))));
                }
            }
        }
        let different: std::collections::HashSet<u64> = keys.iter().map(|k| k.0).collect();
        assert_eq!(different.len(), keys.len());
    }

    #[test]
    fn parts_are_ordered_along_the_ray_and_back() {
        for backward in 0..8 {
            let facing = Facing::new(backward);
            for n in 0..64u32 {
                assert_eq!(facing.ordered(1 << n), 1 << (n ^ mirror(backward)));
            }
            let some = 0x0123_4567_89ab_cdef;
            assert_eq!(facing.ordered(facing.ordered(some)), some);
        }
    }
}
