//! The format of files, read by its description alone.

use isoray_octree::{AnyVolume, OctreeVolume};

use super::files::bytes;
use super::volumes::{Content, Sample, at, dense, octree, points};

/// A file, read at offsets that the byte map gives.
struct File<'a> {
    bytes: &'a [u8],
    dims: [u32; 3],
    root_level: u32,
    is_integer: bool,
    /// Bytes of a sample.
    size: usize,
    is_signed: bool,
}

impl<'a> File<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        assert_eq!(bytes[..8], *b"ISORAYOV");
        let (size, is_signed) = match bytes[12] {
            1 => (1, false),
            2 => (1, true),
            3 => (2, false),
            4 => (2, true),
            5 => (4, true),
            other => panic!("sample type {other}"),
        };
        let file =
            Self { bytes, dims: [0; 3], root_level: bytes[13].into(), is_integer: size < 4, size, is_signed };
        assert_eq!(file.u32(8), 1, "version");
        Self { dims: [16, 20, 24].map(|offset| file.u32(offset)), ..file }
    }

    fn u32(&self, offset: usize) -> u32 {
        u32::from_le_bytes(self.bytes[offset..][..4].try_into().unwrap())
    }

    /// Where the section of this kind and level begins.
    fn section(&self, kind: u32, level: u32) -> usize {
        let entries = (0..self.u32(28) as usize).map(|n| 2304 + 32 * n);
        let mut found = entries.filter(|&entry| [self.u32(entry), self.u32(entry + 4)] == [kind, level]);
        self.u32(found.next().unwrap() + 8) as usize
    }

    /// A number at `offset`: an integer's value, or the bits of a floating-point number.
    fn number(&self, offset: usize) -> i64 {
        let bytes = &self.bytes[offset..][..self.size];
        self.of_bits(bytes.iter().rev().fold(0, |bits, &byte| bits << 8 | i64::from(byte)))
    }

    fn of_bits(&self, bits: i64) -> i64 {
        let sign = 1i64 << (8 * self.size - 1);
        if self.is_integer && self.is_signed { (bits ^ sign) - sign } else { bits }
    }

    /// The sample at `p`, likewise.
    fn sample(&self, p: [u32; 3]) -> i64 {
        let (mut level, mut index) = (self.root_level, 0);
        loop {
            let node = self.section(2, level) + index * (24 * self.size + 5);
            let octant: usize = (0..3).map(|a| (p[a] as usize >> (level - 1) & 1) << a).sum();
            let (first, mask) = (self.u32(node + 24 * self.size), self.bytes[node + 24 * self.size + 4]);
            if mask >> octant & 1 == 0 {
                return self.number(node + (16 + octant) * self.size);
            }
            let before = (0..octant).filter(|n| mask >> n & 1 == 1);
            if level > 3 {
                (level, index) = (level - 1, first as usize + before.count());
                continue;
            }
            let corner = |n: usize| std::array::from_fn(|a| (p[a] & !7) + 4 * (n as u32 >> a & 1));
            let unit = 8 * self.size;
            let start = self.section(1, 2) + first as usize * unit;
            let start = before.fold(start, |start, n| start + self.cap_bytes(node, n, corner(n)));
            return self.in_cap(start, self.range(node, octant), corner(octant), p);
        }
    }

    fn range(&self, node: usize, octant: usize) -> [i64; 2] {
        [octant, 8 + octant].map(|n| self.number(node + n * self.size))
    }

    /// Samples along each axis of the cap at `corner`.
    fn cap_size(&self, corner: [u32; 3]) -> [usize; 3] {
        std::array::from_fn(|a| (self.dims[a] - corner[a]).min(4) as usize)
    }

    fn width(&self, [min, max]: [i64; 2]) -> usize {
        match self.is_integer && min <= max {
            true => (i64::BITS - (max - min).leading_zeros()) as usize,
            false => 8 * self.size,
        }
    }

    fn cap_bytes(&self, node: usize, octant: usize, corner: [u32; 3]) -> usize {
        let count: usize = self.cap_size(corner).iter().product();
        (count * self.width(self.range(node, octant))).div_ceil(8)
    }

    fn in_cap(&self, start: usize, range: [i64; 2], corner: [u32; 3], p: [u32; 3]) -> i64 {
        let [nx, ny, nz] = self.cap_size(corner);
        let [x, y, z] = [0, 1, 2].map(|a| (p[a] - corner[a]) as usize);
        let n = x + nx * (y + ny * z);
        if !self.is_integer {
            return self.number(start + n * self.size);
        }
        let bit = |plane: usize| {
            let bit = plane * nx * ny * nz + n;
            i64::from(self.bytes[start + bit / 8] >> (bit % 8) & 1)
        };
        let distance: i64 = (0..self.width(range)).map(|plane| bit(plane) << plane).sum();
        if range[0] <= range[1] { range[0] + distance } else { self.of_bits(distance) }
    }
}

/// Whatever changes these bytes takes another version: files are kept for years.
#[test]
fn files_are_what_their_description_says() {
    fn check<T: Sample>(content: Content, checksum: u32)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        const SIZE: [u32; 3] = [21, 17, 10];
        let samples = dense::<T>(SIZE, content);
        let bytes = bytes(&octree(SIZE, &samples));
        let file = File::new(&bytes);
        assert_eq!(file.dims, SIZE);
        for p in points(SIZE) {
            let (found, expected) = (file.sample(p), at(&samples, SIZE, p));
            let is_same = if T::IS_INTEGER {
                found as f32 == expected.to_f32()
            } else {
                f32::from_bits(found as u32).to_bits() == expected.to_f32().to_bits()
            };
            assert!(is_same, "{:?} {content:?} at {p:?}: {found}, not {expected:?}", T::TYPE);
        }
        assert_eq!(crc32fast::hash(&bytes), checksum, "{:?} {content:?}", T::TYPE);
    }
    check::<u8>(Content::Blocks, 0x1d32_20a5);
    check::<i8>(Content::Noise, 0xa622_6407);
    check::<u16>(Content::Noise, 0x2ef2_c73d);
    check::<i16>(Content::FewValued, 0x5323_cc43);
    check::<f32>(Content::Noise, 0x8aea_0520);
}
