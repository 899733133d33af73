//! Small dense volumes of awkward sizes and contents, and their octrees.

use isoray_build::build;
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_octree::{AnyVolume, OctreeVolume};

/// Sizes below, at and beyond the edges of caps and nodes, flat and long ones among them.
pub(crate) const SIZES: [[u32; 3]; 14] = [
    [1, 1, 1],
    [1, 7, 3],
    [2, 2, 2],
    [4, 4, 4],
    [5, 4, 4],
    [8, 8, 8],
    [9, 8, 7],
    [5, 9, 17],
    [33, 31, 5],
    [64, 3, 1],
    [3, 1, 70],
    [1, 65, 2],
    [17, 16, 15],
    [32, 32, 32],
];

/// A sample type that small numbers can be turned into.
pub(crate) trait Sample: Scalar
where
    AnyVolume: From<OctreeVolume<Self>>,
{
    /// Number `n`; the floating-point type makes its special values of the first ones.
    fn of(n: u8) -> Self;
    /// The samples of an opened volume, if they are of this type.
    fn from_any(volume: AnyVolume) -> Option<OctreeVolume<Self>>;
}

macro_rules! sample {
    ($($t:ty => $variant:ident, $of:expr;)*) => { $(
        impl Sample for $t {
            fn of(n: u8) -> Self {
                let of: fn(u8) -> $t = $of;
                of(n)
            }
            fn from_any(volume: AnyVolume) -> Option<OctreeVolume<Self>> {
                if let AnyVolume::$variant(volume) = volume { Some(volume) } else { None }
            }
        }
    )* };
}
sample! {
    u8 => U8, |n| n;
    i8 => I8, |n| n.cast_signed();
    u16 => U16, |n| u16::from(n) * 257;
    i16 => I16, |n| (i16::from(n) - 128) * 250;
    f32 => F32, |n| match n {
        0 => 0.0,
        1 => -0.0,
        2 => f32::NAN,
        3 => f32::from_bits(0x7fc0_0001),
        4 => f32::INFINITY,
        5 => f32::NEG_INFINITY,
        6 => f32::from_bits(1),
        _ => (f32::from(n) - 100.0) / 3.0,
    };
}

/// A hash of a position: the contents below are made of it.
fn hash(p: [u32; 3], seed: u32) -> u32 {
    let mut h = seed.wrapping_mul(0x9e37_79b9);
    for c in p {
        h = (h ^ c).wrapping_mul(0x85eb_ca6b);
        h ^= h >> 13;
        h = h.wrapping_mul(0xc2b2_ae35);
        h ^= h >> 16;
    }
    h
}

/// What fills a volume.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Content {
    /// Every number anywhere.
    Noise,
    /// Three numbers, the second and third of them rare.
    FewValued,
    /// Blocks of 8 and of 16 samples that are constant, among noise: scalar leaves of several levels.
    Blocks,
    /// Constant but for one sample in each 16³.
    Specks,
    /// The same number everywhere.
    Constant(u8),
    /// A ramp, clamped to a constant at both ends.
    Ramp,
}

/// Every content.
pub(crate) const CONTENTS: [Content; 7] = [
    Content::Noise,
    Content::FewValued,
    Content::Blocks,
    Content::Specks,
    Content::Constant(2),
    Content::Constant(77),
    Content::Ramp,
];

impl Content {
    fn at(self, p: [u32; 3]) -> u8 {
        let byte = |n: u32| (n % 251) as u8;
        match self {
            Self::Noise => byte(hash(p, 1)),
            Self::FewValued => match hash(p, 2) % 40 {
                0 => 1,
                1 => 2,
                _ => 0,
            },
            Self::Blocks => match hash(p.map(|c| c / 16), 3) % 3 {
                0 => byte(hash(p.map(|c| c / 16), 4) % 8),
                1 => byte(hash(p.map(|c| c / 8), 5) % 8),
                _ if hash(p.map(|c| c / 4), 6).is_multiple_of(2) => 7,
                _ => byte(hash(p, 7)),
            },
            Self::Specks => match hash(p.map(|c| c / 16), 8) % 4096 {
                n if n == p[0] % 16 + p[1] % 16 * 16 + p[2] % 16 * 256 => 200,
                _ => 1,
            },
            Self::Constant(n) => n,
            Self::Ramp => byte((p[0] + 2 * p[1] + p[2]).clamp(20, 40)),
        }
    }
}

/// The samples of a volume of `size`.
pub(crate) fn dense<T: Sample>(size: [u32; 3], content: Content) -> Vec<T>
where
    AnyVolume: From<OctreeVolume<T>>,
{
    let [nx, ny, nz] = size;
    let row = |y, z| (0..nx).map(move |x| T::of(content.at([x, y, z])));
    (0..nz).flat_map(|z| (0..ny).flat_map(move |y| row(y, z))).collect()
}

/// The octree of `samples`.
pub(crate) fn octree<T: Scalar>(size: [u32; 3], samples: &[T]) -> OctreeVolume<T> {
    let dims = Dims::new(size).unwrap();
    let placement = glam::DAffine3::from_scale(glam::DVec3::new(1.0, 2.0, 0.5));
    build(&mut DenseVolume::new(dims, samples).unwrap(), placement, |_| {}).unwrap()
}

/// Calls `$check::<T>(size, content)` for all sample types, sizes and contents.
macro_rules! for_all_volumes {
    ($check:ident) => {
        for size in crate::octree::volumes::SIZES {
            for content in crate::octree::volumes::CONTENTS {
                $check::<u8>(size, content);
                $check::<i8>(size, content);
                $check::<u16>(size, content);
                $check::<i16>(size, content);
                $check::<f32>(size, content);
            }
        }
    };
}
pub(crate) use for_all_volumes;

/// Every lattice point of a box of `size`.
pub(crate) fn points(size: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let [nx, ny, nz] = size;
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// The sample at `p` of a dense array.
pub(crate) fn at<T: Copy>(samples: &[T], [nx, ny, _]: [u32; 3], [x, y, z]: [u32; 3]) -> T {
    samples[(z as usize * ny as usize + y as usize) * nx as usize + x as usize]
}
