//! The `.ovol` file format, version 1. It is stable: whatever a reader of this version could misread is a change of version.
//!
//! All numbers are little-endian. The header and the section table are contiguous and covered by one checksum;
//! sections begin at multiples of [`ALIGNMENT`] bytes, in the order of the table, with zeros between.
//!
//! ```text
//! offset  size  field
//!      0     8  magic "ISORAYOV"
//!      8     4  version, 1
//!     12     1  sample type: 1 u8, 2 i8, 3 u16, 4 i16, 5 f32
//!     13     1  root level R: the root spans 2^R samples along each axis
//!     14     1  cap level, 2: a cap spans 4 samples
//!     15     1  coarse samples: 0 none, 1 injected, 2 mean, 3 filtered
//!     16    12  nx, ny, nz
//!     28     4  number of sections
//!     32    96  index to world: four columns of three f64 (x, y and z axes, then translation)
//!    128    16  least and greatest finite sample, f64; both NaN if there is none
//!    144     8  number of NaN and infinite samples
//!    152     8  length of the whole file
//!    160     4  unit of links to caps in bytes: 8 times the size of a sample
//!    164     4  CRC-32 of the header with this field zero, followed by the section table
//!    168  2048  histogram: 256 counts of finite samples in equal bins over the range
//!   2216     8  f64: how far a sample may be from what it was; 0 if the volume is lossless
//!   2224     8  f64: how far isosurfaces may be displaced, in voxels; NaN if there is no such bound
//!   2232    16  f64: least and greatest isovalue of these
//!   2248    16  f64: range of values that are kept exactly; NaN if there is none
//!   2264     4  1 if isovalues between the two are meant as well, else 0
//!   2268    36  zero
//!   2304  32·n  section table: for each section
//!          +0     4  kind: 1 caps, 2 nodes
//!          +4     4  level: 2 for caps, 3 to R for nodes
//!          +8     8  offset from the start of the file
//!         +16     8  length in bytes
//!         +24     4  CRC-32 of the section
//!         +28     4  zero
//! ```
//!
//! # Nodes
//!
//! A nodes' section is an array of [`Node`](crate::Node)s, the root being the only one of level R. A node of level `l` spans `2^l` samples along each axis. With `s` the
//! size of a sample:
//!
//! ```text
//! offset  size  field
//!      0    8s  least finite sample of each octant's cells, forward corners included
//!     8s    8s  greatest; below the least where an octant has no cells or no finite samples
//!    16s    8s  coarse sample at each octant's low corner; where the octant is not stored, the value of all its samples
//!    24s     4  where stored octants begin: an index into the nodes of level l - 1; for l = 3, into the caps, in units
//!  24s+4     1  which octants are stored, as bits
//! ```
//!
//! Octant `n` begins at half the node's edge along x if `n & 1`, y if `n & 2`, z if `n & 4`. Stored ones follow each other in that order. Ranges also bound the coarse samples of
//! means and filters where octants span 8 or more.
//!
//! # Caps
//!
//! The caps of a node of level 3 follow each other without gaps, those of the next node from the next multiple of the unit on; behind the last are zeros, as many bytes as 64 samples
//! take. A cap holds the samples of its 4³ that are in the domain, x fastest, `c` in all. *Floating-point numbers* stand as they are. *Integers* are distances from the
//! octant's least sample, of as many bits `w` as that of its greatest has: all lowest bits, then all second ones, and so on, bit `n` of sample `k` being bit `nc + k` of the cap
//! from the lowest bit of its first byte on, in `⌈wc/8⌉` bytes. Of an octant without a range they are samples of all their bits.

use zerocopy::little_endian::{F64, U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

use crate::volume::HISTOGRAM_BINS;

pub(crate) const MAGIC: [u8; 8] = *b"ISORAYOV";
pub(crate) const VERSION: u32 = 1;
pub(crate) const KIND_CAPS: u32 = 1;
pub(crate) const KIND_NODES: u32 = 2;

/// Sections begin at multiples of this: a cache line, and a whole cap of bytes.
pub const ALIGNMENT: usize = 64;

#[derive(Clone, Copy, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub(crate) struct Header {
    pub(crate) magic: [u8; 8],
    pub(crate) version: U32,
    pub(crate) scalar: u8,
    pub(crate) root_level: u8,
    pub(crate) cap_level: u8,
    pub(crate) coarse: u8,
    pub(crate) dims: [U32; 3],
    pub(crate) section_count: U32,
    pub(crate) index_to_world: [F64; 12],
    pub(crate) range: [F64; 2],
    pub(crate) non_finite: U64,
    pub(crate) file_length: U64,
    pub(crate) cap_unit: U32,
    pub(crate) checksum: U32,
    pub(crate) histogram: [U64; HISTOGRAM_BINS],
    pub(crate) tolerance: F64,
    pub(crate) displacement: F64,
    pub(crate) isovalues: [F64; 2],
    pub(crate) kept: [F64; 2],
    pub(crate) is_range: U32,
    pub(crate) padding: [u8; 36],
}

#[derive(Clone, Copy, Debug, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub(crate) struct SectionEntry {
    pub(crate) kind: U32,
    pub(crate) level: U32,
    pub(crate) offset: U64,
    pub(crate) length: U64,
    pub(crate) checksum: U32,
    pub(crate) reserved: U32,
}

/// The checksum that the header holds: of itself with that field zero, and the section table.
pub(crate) fn header_checksum(header: &Header, table: &[SectionEntry]) -> u32 {
    let mut blank = *header;
    blank.checksum = U32::ZERO;
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(blank.as_bytes());
    hasher.update(table.as_bytes());
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn byte_map_holds() {
        assert_eq!(std::mem::offset_of!(Header, index_to_world), 32);
        assert_eq!(std::mem::offset_of!(Header, checksum), 164);
        assert_eq!(std::mem::offset_of!(Header, histogram), 168);
        assert_eq!(std::mem::offset_of!(Header, tolerance), 2216);
        assert_eq!(size_of::<Header>(), 2304);
        assert_eq!(size_of::<crate::Node<zerocopy::little_endian::F32>>(), 24 * 4 + 5);
        assert_eq!(std::mem::offset_of!(crate::Node<u8>, first), 24);
        assert_eq!(size_of::<SectionEntry>(), 32);
    }
}
