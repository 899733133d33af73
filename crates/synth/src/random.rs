//! Random numbers that depend on nothing but a seed and a lattice point.

/// The random numbers along one row of a lattice.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    keys: [u32; 2],
}

impl Row {
    /// The row at `j`, `k` of the lattice numbered `lattice`.
    pub(crate) fn new(seed: u64, lattice: u32, j: i32, k: i32) -> Self {
        let point = u64::from(j as u32) | u64::from(k as u32) << 32;
        let key = mix(mix(mix(seed) ^ u64::from(lattice)) ^ point);
        Self { keys: [key as u32, (key >> 32) as u32] }
    }

    /// 32 random bits for position `i`: two rounds of multiplication and shifts (with the multipliers of Wellons'
    /// `lowbias32`), into each of which one half of the row's key enters.
    #[inline(always)]
    pub(crate) fn bits(self, i: u32) -> u32 {
        let mut h = i.wrapping_mul(0x9e37_79b1) ^ self.keys[0];
        h = (h ^ h >> 16).wrapping_mul(0x7feb_352d).wrapping_add(self.keys[1]);
        h = (h ^ h >> 15).wrapping_mul(0x846c_a68b);
        h ^ h >> 16
    }

    /// A number from −1 to 1 for position `i`.
    #[inline(always)]
    pub(crate) fn signed(self, i: u32) -> f32 {
        const SCALE: f32 = 1.0 / (1u32 << 31) as f32;
        self.bits(i) as i32 as f32 * SCALE
    }
}

/// A bijection of 64 bits in which every bit of the result depends on every bit of `x` (the finaliser of SplitMix64).
fn mix(x: u64) -> u64 {
    let mut x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}
