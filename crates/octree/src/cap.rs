//! How the samples of a cap are stored.
//!
//! *Integers* are stored as their distances from the least value of the cap's cells, in as many bits as the widest
//! distance in these cells needs; both are told by the range in the parent, so that no cap needs a header. The
//! bits lie in *planes*: all lowest bits, then all second ones, and so on, each plane with the bit of sample
//! `(x, y, z)` at `x + 4y + 16z`. A plane of a whole cap is one 64-bit word, so that a cap is compared with an isovalue by a
//! few operations on words, and one sample is read by one test of all planes.
//!
//! A cap that the domain's border cuts short holds samples of the domain only: its planes have as many bits as it has samples, x
//! fastest, and follow each other without gaps. A child without cells has no range; its samples are stored in full.
//!
//! *Floating-point numbers* are stored as they are, x fastest.

use isoray_grid::Scalar;
use wide::{i8x64, u64x8};
use zerocopy::{FromBytes, IntoBytes};

use crate::geometry::{CAP_EDGE, CAP_SAMPLES, product};
use crate::node::Range;

/// Planes that are read at once.
const PLANES: usize = 8;
/// Bytes of that many whole planes.
const PLANES_BYTES: usize = PLANES * PLANE_BYTES;
const PLANE_BYTES: usize = size_of::<u64>();
/// Bytes of a whole cap of the widest type.
const MOST_BYTES: usize = cap_reach::<f32>();

/// The caps of one parent begin at a multiple of this many bytes.
pub const fn cap_unit<T: Scalar>() -> usize {
    PLANE_BYTES * size_of::<T>()
}

/// Bytes that must be readable from the start of a whole cap on, whatever it takes itself.
pub const fn cap_reach<T: Scalar>() -> usize {
    CAP_SAMPLES * size_of::<T>()
}

/// Bits of a sample in a stored cap whose cells have this range.
#[inline(always)]
pub(crate) fn width<T: Scalar>(range: Range<T>) -> u32 {
    let is_told = T::IS_INTEGER && range.min <= range.max;
    if is_told {
        u32::BITS - (range.max.steps_above(range.min) as u32).leading_zeros()
    } else {
        full_width::<T>()
    }
}

const fn full_width<T: Scalar>() -> u32 {
    u8::BITS * size_of::<T>() as u32
}

/// What the distances of a cap's samples are counted from.
#[inline(always)]
pub(crate) fn base<T: Scalar>(range: Range<T>) -> T {
    if range.min <= range.max { range.min } else { T::from_bits(0) }
}

/// Bytes of a cap of `samples` samples of `width` bits.
#[inline(always)]
pub(crate) fn bytes_of<T: Scalar>(width: u32, samples: usize) -> usize {
    if T::IS_INTEGER {
        (width as usize * samples).div_ceil(u8::BITS as usize)
    } else {
        samples * size_of::<T>()
    }
}

/// Appends the samples of a cap, x fastest, whose cells have the given range; `size` tells how many there are along each axis.
pub fn push_cap<T: Scalar>(samples: &[T; CAP_SAMPLES], size: [u32; 3], range: Range<T>, out: &mut Vec<u8>) {
    let count = product(size);
    if !T::IS_INTEGER {
        samples[..count].iter().for_each(|&s| out.extend_from_slice(T::Stored::from(s).as_bytes()));
        return;
    }
    let (base, width) = (base(range).to_bits(), width(range));
    let distance = |s: T| s.to_bits().wrapping_sub(base);
    if count == CAP_SAMPLES {
        // Byte by byte, so that lanes need be no wider than that.
        push_planes(&samples.map(|s| distance(s) as i8), width.min(u8::BITS), out);
        if width > u8::BITS {
            push_planes(&samples.map(|s| (distance(s) >> u8::BITS) as i8), width - u8::BITS, out);
        }
    } else {
        let bits =
            (0..width).flat_map(|plane| samples[..count].iter().map(move |&s| distance(s) >> plane & 1));
        let start = out.len();
        out.resize(start + bytes_of::<T>(width, count), 0);
        for (n, bit) in bits.enumerate() {
            out[start + n / 8] |= (bit as u8) << (n % 8);
        }
    }
}

/// The lowest `count` planes of 64 bytes.
fn push_planes(bytes: &[i8; CAP_SAMPLES], count: u32, out: &mut Vec<u8>) {
    let lanes = i8x64::new(*bytes);
    let planes: [u64; PLANES] = std::array::from_fn(|plane| {
        let bit = i8x64::splat(1 << plane);
        u64::to_le((lanes & bit).simd_eq(bit).to_bitmask())
    });
    out.extend_from_slice(&planes.as_bytes()[..count as usize * PLANE_BYTES]);
}

/// A region of the size of a cap, aligned like one: all of one value, or stored sample by sample.
#[derive(Clone, Copy, Debug)]
pub struct Block<'a, T> {
    /// Of a whole cap [`cap_reach`] bytes, which can be more than it takes; of one that is cut short its own, which are fewer. None of
    /// a constant block.
    bytes: &'a [u8],
    /// The value of a constant block.
    base: T,
    /// Bits of a sample.
    width: u8,
    /// Samples along each axis.
    size: [u8; 3],
}

impl<T: Scalar> Default for Block<'_, T> {
    /// What a link that leads nowhere reads as: a block of zeros.
    #[inline(always)]
    fn default() -> Self {
        Self::constant(T::default())
    }
}

/// By the number of planes: a mask for the words that hold them.
const OWN_PLANES: [[u64; PLANES]; PLANES + 1] = {
    let mut masks = [[0; PLANES]; PLANES + 1];
    let mut count = 0;
    while count <= PLANES {
        let mut plane = 0;
        while plane < count {
            masks[count][plane] = u64::MAX;
            plane += 1;
        }
        count += 1;
    }
    masks
};

#[inline(always)]
fn words(planes: &[u8; PLANES_BYTES]) -> u64x8 {
    let (words, _) = planes.as_chunks::<PLANE_BYTES>();
    u64x8::new(std::array::from_fn(|n| u64::from_le_bytes(words[n])))
}

impl<'a, T: Scalar> Block<'a, T> {
    /// A block whose samples all have one value.
    #[inline(always)]
    pub fn constant(value: T) -> Self {
        Self { bytes: &[], base: value, width: 0, size: [CAP_EDGE as u8; 3] }
    }

    /// The cap at the start of `bytes`, whose cells have the given range; `None` if they are too few.
    #[inline(always)]
    pub(crate) fn cap(bytes: &'a [u8], range: Range<T>, size: [u32; 3]) -> Option<Self> {
        let width = width(range);
        let count = product(size);
        let length = if count == CAP_SAMPLES { cap_reach::<T>() } else { bytes_of::<T>(width, count) };
        let bytes = bytes.get(..length)?;
        Some(Self { bytes, base: base(range), width: width as u8, size: size.map(|n| n as u8) })
    }

    /// The value of all samples, unless the block is a cap.
    #[inline(always)]
    pub fn as_constant(&self) -> Option<T> {
        self.bytes.is_empty().then_some(self.base)
    }

    #[inline(always)]
    fn is_whole_cap(&self) -> bool {
        self.bytes.len() == cap_reach::<T>()
    }

    /// The sample at offset `(x, y, z)` from the block's low corner; see [`sample_at`](Self::sample_at).
    #[inline(always)]
    pub fn sample(&self, [x, y, z]: [u32; 3]) -> T {
        self.sample_at(x + CAP_EDGE * (y + CAP_EDGE * z))
    }

    /// The sample `x + 4y + 16z`.
    ///
    /// The offset must lie in the block and in the domain. Beyond the end of a cap that the domain's border cuts
    /// short it may give another sample of the same cap, or the type's default value: it is in bounds, but means
    /// nothing. A constant block gives its value at any offset.
    #[inline(always)]
    pub fn sample_at(&self, at: u32) -> T {
        if self.is_whole_cap() {
            self.whole_sample(at)
        } else if self.bytes.is_empty() {
            self.base
        } else {
            self.border_sample(at)
        }
    }

    /// The same without a test of what kind of block it is.
    #[inline(always)]
    fn whole_sample(&self, at: u32) -> T {
        let at = at % CAP_SAMPLES as u32;
        if !T::IS_INTEGER {
            return stored(self.bytes, at as usize);
        }
        let bit = 1 << at;
        let low = self.planes(0).map_or(0, |planes| set_in(planes, bit));
        let high = match self.width > 8 {
            true => self.planes(1).map_or(0, |planes| set_in(planes, bit)),
            false => 0,
        };
        self.at_distance((high << PLANES | low) & self.all_bits())
    }

    /// The lowest or the next eight planes of a whole cap; some of the last may not be its own.
    #[inline(always)]
    fn planes(&self, n: usize) -> Option<&'a [u8; PLANES_BYTES]> {
        self.bytes.as_chunks().0.get(n)
    }

    /// A mask for the bits of a distance.
    #[inline(always)]
    fn all_bits(&self) -> u32 {
        ((1u64 << self.width) - 1) as u32
    }

    /// The value at some distance from the least one.
    #[inline(always)]
    fn at_distance(&self, distance: u32) -> T {
        T::from_bits(self.base.to_bits().wrapping_add(distance))
    }

    /// [`sample_at`](Self::sample_at) in a cap that is not whole. By value: a reference would keep the caller's block in memory.
    #[cold]
    fn border_sample(self, at: u32) -> T {
        let [nx, ny, nz] = self.size.map(u32::from);
        let (mask, shift) = (CAP_EDGE - 1, CAP_EDGE.ilog2());
        let at = ((at >> (2 * shift) & mask) * ny + (at >> shift & mask)) * nx + (at & mask);
        if !T::IS_INTEGER {
            return stored(self.bytes, at as usize);
        }
        let count = nx * ny * nz;
        let bit = |plane: u32| {
            let n = (plane * count + at) as usize;
            u32::from(self.bytes.get(n / 8).map_or(0, |byte| byte >> (n % 8) & 1))
        };
        self.at_distance((0..self.width.into()).fold(0, |d, plane| d | bit(plane) << plane))
    }

    /// The eight samples at the corners of a cell inside the block, its low corner at `x + 4y + 16z`; x fastest.
    #[inline(always)]
    pub fn corners(&self, at: u32) -> [T; 8] {
        /// From the low corner to each.
        const STEPS: [u32; 8] = [0, 1, 4, 5, 16, 17, 20, 21];
        if self.is_whole_cap() {
            STEPS.map(|step| self.whole_sample(at + step))
        } else {
            STEPS.map(|step| self.sample_at(at + step))
        }
    }

    /// All samples: `x + 4y + 16z`. Those outside the domain have no meaning.
    #[inline(always)]
    pub fn samples(&self) -> [T; CAP_SAMPLES] {
        if self.is_whole_cap() {
            self.whole_samples()
        } else if self.bytes.is_empty() {
            [self.base; CAP_SAMPLES]
        } else {
            self.border_samples()
        }
    }

    #[inline(always)]
    fn whole_samples(&self) -> [T; CAP_SAMPLES] {
        if !T::IS_INTEGER {
            return <[T::Stored; CAP_SAMPLES]>::ref_from_bytes(self.bytes)
                .map_or([T::default(); CAP_SAMPLES], |samples| samples.map(Into::into));
        }
        let of = |n: usize, own: u8| match self.planes(n) {
            Some(planes) if own > 0 => unpack(planes, own.into()),
            _ => [0; CAP_SAMPLES],
        };
        let low = of(0, self.width.min(8));
        if size_of::<T>() == 1 {
            low.map(|d| self.at_distance(d.into()))
        } else {
            let high = of(1, self.width.saturating_sub(8));
            std::array::from_fn(|n| self.at_distance(u32::from(low[n]) | u32::from(high[n]) << PLANES))
        }
    }

    #[cold]
    fn border_samples(self) -> [T; CAP_SAMPLES] {
        self.made_whole(&mut [0; MOST_BYTES]).whole_samples()
    }

    /// A cap that is not whole as one that is, in `bytes`.
    fn made_whole<'b>(&self, bytes: &'b mut [u8; MOST_BYTES]) -> Block<'b, T> {
        let [nx, ny, nz] = self.size.map(u32::from);
        let rows = (0..nz).flat_map(|z| (0..ny).map(move |y| CAP_EDGE * (y + CAP_EDGE * z)));
        if T::IS_INTEGER {
            let (count, row) = (nx * ny * nz, (1 << nx) - 1);
            for (plane, to) in (0..u32::from(self.width)).zip(bytes.as_chunks_mut().0) {
                let mut bits = bits_at(self.bytes, plane * count);
                let mut word = 0;
                for at in rows.clone() {
                    word |= (bits & row) << at;
                    bits >>= nx;
                }
                *to = u64::to_le_bytes(word);
            }
        } else {
            let size = size_of::<T>();
            for (row, at) in self.bytes.chunks(nx as usize * size).zip(rows) {
                bytes[at as usize * size..][..row.len()].copy_from_slice(row);
            }
        }
        Block { bytes: &bytes[..cap_reach::<T>()], size: [CAP_EDGE as u8; 3], ..*self }
    }

    /// The samples at even offsets along each axis, x fastest. Those outside the domain have no meaning.
    #[inline(always)]
    pub fn every_other(&self) -> [T; 8] {
        /// Their numbers.
        const EVEN: [u32; 8] = [0, 2, 8, 10, 32, 34, 40, 42];
        if !(T::IS_INTEGER && self.is_whole_cap()) {
            return EVEN.map(|at| self.sample_at(at));
        }
        let of = |n: usize, own: u8| match self.planes(n) {
            Some(planes) if own > 0 => {
                let own = OWN_PLANES[usize::from(own) % OWN_PLANES.len()];
                let planes = (words(planes) & u64x8::new(own)).to_array();
                columns(u64::from_le_bytes(planes.map(even_bits))).to_le_bytes()
            }
            _ => [0; 8],
        };
        let low = of(0, self.width.min(8));
        if size_of::<T>() == 1 {
            return low.map(|d| self.at_distance(d.into()));
        }
        let high = of(1, self.width.saturating_sub(8));
        std::array::from_fn(|n| self.at_distance(u32::from(low[n]) | u32::from(high[n]) << PLANES))
    }

    /// Which samples are `≥ threshold`: bit `x + 4y + 16z`. Those outside the domain have no meaning.
    #[inline(always)]
    pub fn at_least(&self, threshold: T) -> u64 {
        if self.is_whole_cap() {
            self.whole_at_least(threshold)
        } else if self.bytes.is_empty() {
            if self.base >= threshold { u64::MAX } else { 0 }
        } else {
            self.border_at_least(threshold)
        }
    }

    #[inline(always)]
    fn whole_at_least(&self, threshold: T) -> u64 {
        if !T::IS_INTEGER {
            return <[T::Stored; CAP_SAMPLES]>::ref_from_bytes(self.bytes)
                .map_or(0, |samples| T::at_least_64(samples, threshold));
        }
        let distance = threshold.steps_above(self.base);
        if distance <= 0 {
            return u64::MAX;
        }
        if distance as u32 > self.all_bits() {
            return 0;
        }
        let low = self
            .planes(0)
            .map_or(0, |planes| at_least_of(planes, self.width.min(8), distance as u32, u64::MAX));
        match self.width > 8 {
            true => self
                .planes(1)
                .map_or(0, |planes| at_least_of(planes, self.width - 8, distance as u32 >> PLANES, low)),
            false => low,
        }
    }

    /// [`at_least`](Self::at_least) of a cap that is not whole. By samples, whose order is that of their distances only if there is a range.
    #[cold]
    fn border_at_least(self, threshold: T) -> u64 {
        T::at_least_64(&self.border_samples().map(Into::into), threshold)
    }
}

/// The bits from `start` on that lie in the eight bytes there: at least 57. Zeros behind the end.
#[inline(always)]
fn bits_at(bytes: &[u8], start: u32) -> u64 {
    let rest = bytes.get(start as usize / 8..).unwrap_or_default();
    let word = match rest.first_chunk() {
        Some(bytes) => u64::from_le_bytes(*bytes),
        None => (0..8).zip(rest).fold(0, |word, (n, &byte)| word | u64::from(byte) << (8 * n)),
    };
    word >> (start % 8)
}

/// From the lowest bit up: at least so far, if the bit is greater, or equal and the lower bits are at least, which `lower` tells of those before
/// these planes. Those behind the `own` first ones are computed, too, and not used: that takes no branch.
#[inline(always)]
fn at_least_of(planes: &[u8; PLANES_BYTES], own: u8, distance: u32, lower: u64) -> u64 {
    let (words, _) = planes.as_chunks::<PLANE_BYTES>();
    let mut after = [lower; PLANES + 1];
    for plane in 0..PLANES {
        let word = u64::from_le_bytes(words[plane]);
        let so_far = after[plane];
        after[plane + 1] = if distance >> plane & 1 == 1 { word & so_far } else { word | so_far };
    }
    after[own as usize % after.len()]
}

/// Which of eight planes have a bit set.
#[inline(always)]
fn set_in(planes: &[u8; PLANES_BYTES], bit: u64) -> u32 {
    let bit = u64x8::splat(bit);
    (words(planes) & bit).simd_eq(bit).to_bitmask()
}

/// Sample `n` of those that are stored as they are.
#[inline(always)]
fn stored<T: Scalar>(bytes: &[u8], n: usize) -> T {
    let size = size_of::<T>();
    let sample = bytes.get(n * size..).and_then(|rest| T::Stored::read_from_prefix(rest).ok());
    sample.map_or(T::default(), |(sample, _)| sample.into())
}

/// What turns rows of bits into columns, across the diagonal (Warren, Hacker's Delight, section 7-3).
const EXCHANGES: [(u32, u64); 3] =
    [(7, 0x00aa_00aa_00aa_00aa), (14, 0x0000_cccc_0000_cccc), (28, 0x0000_0000_f0f0_f0f0)];

/// Bit `n` of byte `k`, for bit `k` of byte `n`.
#[inline(always)]
fn columns(rows: u64) -> u64 {
    EXCHANGES.into_iter().fold(rows, |bits, (shift, mask)| {
        let exchanged = (bits ^ (bits >> shift)) & mask;
        bits ^ exchanged ^ (exchanged << shift)
    })
}

/// Of the bits of a plane, those of the samples at even offsets along each axis.
#[inline(always)]
fn even_bits(plane: u64) -> u8 {
    let along_x = plane & 0x0000_0505_0000_0505;
    let along_x = (along_x | along_x >> 1) & 0x0000_0303_0000_0303;
    let along_y = (along_x | along_x >> 6) & 0x0000_000f_0000_000f;
    (along_y | along_y >> 28) as u8
}

/// The bytes of 64 samples from their lowest eight planes, of which `own` are theirs.
#[inline(always)]
fn unpack(planes: &[u8; PLANES_BYTES], own: usize) -> [u8; CAP_SAMPLES] {
    // Byte by byte of the planes: eight bytes that hold eight samples, a bit of each in every byte.
    let own = u64x8::new(OWN_PLANES[own % OWN_PLANES.len()]);
    let planes = (words(planes) & own).to_array().map(u64::to_le_bytes);
    let groups = std::array::from_fn(|g| u64::from_le_bytes(std::array::from_fn(|plane| planes[plane][g])));
    let mut bits = u64x8::new(groups);
    for (shift, mask) in EXCHANGES {
        let exchanged = (bits ^ (bits >> shift)) & u64x8::splat(mask);
        bits = bits ^ exchanged ^ (exchanged << shift);
    }
    let mut samples = [0; CAP_SAMPLES];
    for (to, word) in samples.as_chunks_mut().0.iter_mut().zip(bits.to_array()) {
        *to = word.to_le_bytes();
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that look random, and the same each time.
    fn random(n: u64) -> u64 {
        (n + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 17
    }

    /// Stores samples spread over `spread` bits from `low` on in a cap of `size`, and reads them in every way.
    fn round_trip<T: Scalar>(low: T, spread: u32, size: [u32; 3], seed: u64) {
        let count = product(size);
        let mut samples = [T::default(); CAP_SAMPLES];
        for (n, sample) in samples[..count].iter_mut().enumerate() {
            let distance = random(seed + n as u64) as u32 & ((1u64 << spread) - 1) as u32;
            *sample = T::from_bits(low.to_bits().wrapping_add(distance));
        }
        let mut range = Range::EMPTY;
        // Where a cap is one sample thick, it has no cells, and every second one here.
        if size.iter().all(|&n| n > 1) || seed.is_multiple_of(128) {
            samples[..count].iter().for_each(|&s| range.include(s));
        }
        let mut bytes = Vec::new();
        push_cap(&samples, size, range, &mut bytes);
        assert_eq!(bytes.len(), bytes_of::<T>(width(range), count));
        assert!(bytes.len() <= count * size_of::<T>(), "more than the samples themselves");
        // Whatever follows in the file.
        bytes.resize(bytes.len() + cap_reach::<T>(), 0xa5);

        let block = Block::<T>::cap(&bytes, range, size).unwrap();
        let (all, threshold) = (block.samples(), samples[count / 2]);
        let at_least = block.at_least(threshold);
        for (n, &sample) in samples[..count].iter().enumerate() {
            let n = n as u32;
            let p = [n % size[0], n / size[0] % size[1], n / size[0] / size[1]];
            let at = p[0] + CAP_EDGE * (p[1] + CAP_EDGE * p[2]);
            assert!(block.sample(p).same_bits(sample), "{size:?}, {spread} bits: {p:?}");
            assert!(all[at as usize].same_bits(sample), "{size:?}, {spread} bits: {p:?}");
            assert_eq!(at_least >> at & 1 == 1, sample >= threshold, "{size:?}, {spread} bits: {p:?}");
        }
        let even = block.every_other();
        for n in 0..8u32 {
            let p = [0, 1, 2].map(|a| 2 * (n >> a & 1));
            if (0..3).all(|a| p[a] < size[a]) {
                assert!(even[n as usize].same_bits(block.sample(p)), "{size:?}, {spread} bits: {p:?}");
            }
        }
        if count == CAP_SAMPLES {
            let corners = block.corners(0b10_1010);
            assert!(corners[7].same_bits(samples[0b11_1111]) && corners[0].same_bits(samples[0b10_1010]));
        }
    }

    #[test]
    fn caps_give_back_their_samples() {
        for seed in 0..40 {
            for size in [[4; 3], [3, 4, 4], [1, 2, 3], [4, 4, 1]] {
                for spread in 1..=8 {
                    round_trip::<u8>((seed % (257 - (1 << spread))) as u8, spread, size, seed * 64);
                    round_trip::<i8>(i8::MIN, spread, size, seed * 64);
                    round_trip::<i8>(i8::MIN >> (8 - spread), spread, size, seed * 64);
                }
                for spread in 1..=16 {
                    round_trip::<u16>(0, spread, size, seed * 64);
                    round_trip::<i16>(i16::MIN, spread, size, seed * 64);
                    round_trip::<i16>(i16::MIN >> (16 - spread), spread, size, seed * 64);
                }
                round_trip::<f32>(-3.5, 20, size, seed * 64);
            }
        }
    }

    #[test]
    fn thresholds_outside_the_range_are_on_one_side() {
        let samples: [u8; CAP_SAMPLES] = std::array::from_fn(|n| 100 + n as u8);
        let range = Range { min: 100, max: 163 };
        let mut bytes = Vec::new();
        push_cap(&samples, [4; 3], range, &mut bytes);
        bytes.resize(64, 0);
        let block = Block::cap(&bytes, range, [4; 3]).unwrap();
        for (threshold, inside) in [(0, 64), (100, 64), (101, 63), (163, 1), (164, 0), (255, 0)] {
            assert_eq!(block.at_least(threshold).count_ones(), inside, "{threshold}");
        }
    }
}
