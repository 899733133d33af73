//! The octree volume: structure, placement and statistics, in memory or mapped.

use glam::DAffine3;
use isoray_grid::{Dims, MappedFile, Scalar, ScalarType};
use zerocopy::{FromBytes, IntoBytes};

use crate::fidelity::{Coarse, Fidelity};
use crate::format::{ALIGNMENT, Header, SectionEntry};
use crate::geometry::{MAX_LEVELS, NODE_LEVEL};
use crate::node::Node;
use crate::view::OctreeView;

/// Number of bins of the stored histogram.
pub const HISTOGRAM_BINS: usize = 256;

/// What is known of a volume beside its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Meta {
    /// Size of the lattice.
    pub dims: Dims,
    /// World position of an index position.
    pub index_to_world: DAffine3,
    /// Least and greatest finite sample; `None` if there is none.
    pub range: Option<[f64; 2]>,
    /// Number of NaN and infinite samples.
    pub non_finite: u64,
    /// Finite samples by value, in equal bins over `range`; the last one includes its upper end.
    pub histogram: Box<[u64; HISTOGRAM_BINS]>,
    /// What the samples are true to.
    pub fidelity: Fidelity,
    /// What its coarse samples are.
    pub coarse: Coarse,
}

/// The arrays of a structure that was built in memory.
#[derive(Clone, Debug)]
pub struct Parts<T: Scalar> {
    /// Nodes by level, the parents of caps first, the root's last.
    pub levels: Vec<Vec<Node<T::Stored>>>,
    /// The bytes of all caps, and [`cap_reach`](crate::cap_reach) zeros.
    pub caps: Vec<u8>,
}

/// A losslessly compressed volume; [`view`](Self::view) gives its structure.
#[derive(Clone, Debug)]
pub struct OctreeVolume<T: Scalar> {
    meta: Meta,
    root_level: u32,
    storage: Storage<T>,
}

#[derive(Clone, Debug)]
enum Storage<T: Scalar> {
    Owned(Parts<T>),
    Mapped { file: MappedFile, levels: Vec<Section>, caps: Section },
}

/// A range of bytes of a mapped file, inside it and a whole number of elements long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Section {
    pub(crate) offset: usize,
    pub(crate) length: usize,
}

impl Section {
    pub(crate) fn of(self, bytes: &[u8]) -> &[u8] {
        bytes.get(self.offset..).and_then(|rest| rest.get(..self.length)).unwrap_or(&[])
    }
}

impl<T: Scalar> OctreeVolume<T> {
    /// A volume from its parts; `parts.levels` has one entry a level up to the root's.
    pub fn from_parts(meta: Meta, parts: Parts<T>) -> Self {
        let root_level = crate::geometry::root_level(meta.dims);
        Self { meta, root_level, storage: Storage::Owned(parts) }
    }

    pub(crate) fn from_mapped(meta: Meta, file: MappedFile, levels: Vec<Section>, caps: Section) -> Self {
        let root_level = crate::geometry::root_level(meta.dims);
        Self { meta, root_level, storage: Storage::Mapped { file, levels, caps } }
    }

    /// What is known of the volume beside its samples.
    pub fn meta(&self) -> &Meta {
        &self.meta
    }

    /// The structure, borrowed. Cheap: call it once a frame, not once a ray.
    pub fn view(&self) -> OctreeView<'_, T> {
        let mut levels: [&[Node<T::Stored>]; MAX_LEVELS] = [&[]; MAX_LEVELS];
        let caps = match &self.storage {
            Storage::Owned(parts) => {
                for (slot, nodes) in levels.iter_mut().zip(&parts.levels) {
                    *slot = nodes;
                }
                parts.caps.as_slice()
            }
            Storage::Mapped { file, levels: sections, caps } => {
                for (slot, section) in levels.iter_mut().zip(sections) {
                    *slot = <[Node<T::Stored>]>::ref_from_bytes(section.of(file)).unwrap_or(&[]);
                }
                caps.of(file)
            }
        };
        OctreeView { dims: self.meta.dims, root_level: self.root_level, levels, caps }
    }

    /// The mapped file, if the volume was opened from one.
    pub(crate) fn mapped(&self) -> Option<&MappedFile> {
        match &self.storage {
            Storage::Owned(_) => None,
            Storage::Mapped { file, .. } => Some(file),
        }
    }

    /// Bytes of nodes and caps.
    pub fn structure_bytes(&self) -> usize {
        self.statistics().iter().map(|s| s.bytes).sum()
    }

    /// Bytes of the volume as a file, header included.
    pub fn file_bytes(&self) -> usize {
        let table = size_of::<SectionEntry>() * (1 + (self.root_level - NODE_LEVEL + 1) as usize);
        let sections = self.statistics().into_iter().map(|s| s.bytes);
        sections.fold(size_of::<Header>() + table, |end, bytes| end.next_multiple_of(ALIGNMENT) + bytes)
    }

    /// Bytes of the same samples as a plain array.
    pub fn raw_bytes(&self) -> usize {
        self.meta.dims.samples() * T::TYPE.size()
    }

    /// Elements and bytes by level: the caps first, then nodes upwards.
    pub fn statistics(&self) -> Vec<LevelStatistics> {
        let view = self.view();
        let caps_stored = view.nodes(NODE_LEVEL).iter().map(|n| n.mask.count_ones() as usize).sum();
        let caps =
            LevelStatistics { edge: crate::geometry::CAP_EDGE, count: caps_stored, bytes: view.caps.len() };
        let nodes = (NODE_LEVEL..=self.root_level).map(|level| LevelStatistics {
            edge: 1 << level,
            count: view.nodes(level).len(),
            bytes: view.nodes(level).as_bytes().len(),
        });
        std::iter::once(caps).chain(nodes).collect()
    }
}

/// How much of one level is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelStatistics {
    /// Samples along the edge of one element.
    pub edge: u32,
    /// Caps (at the first level) or nodes.
    pub count: usize,
    /// Their bytes.
    pub bytes: usize,
}

/// An octree volume of any sample type, as a file holds it.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the variants are the sample types")]
pub enum AnyVolume {
    U8(OctreeVolume<u8>),
    I8(OctreeVolume<i8>),
    U16(OctreeVolume<u16>),
    I16(OctreeVolume<i16>),
    F32(OctreeVolume<f32>),
}

/// An operation on a volume of any sample type.
pub trait VolumeVisitor {
    /// What it gives.
    type Output;
    /// The operation.
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Self::Output;
}

impl AnyVolume {
    /// Runs `visitor` on the volume in its own type.
    pub fn visit<V: VolumeVisitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::U8(v) => visitor.visit(v),
            Self::I8(v) => visitor.visit(v),
            Self::U16(v) => visitor.visit(v),
            Self::I16(v) => visitor.visit(v),
            Self::F32(v) => visitor.visit(v),
        }
    }

    /// What is known of the volume beside its samples.
    pub fn meta(&self) -> &Meta {
        match self {
            Self::U8(v) => v.meta(),
            Self::I8(v) => v.meta(),
            Self::U16(v) => v.meta(),
            Self::I16(v) => v.meta(),
            Self::F32(v) => v.meta(),
        }
    }

    /// The sample type.
    pub fn scalar(&self) -> ScalarType {
        match self {
            Self::U8(_) => ScalarType::U8,
            Self::I8(_) => ScalarType::I8,
            Self::U16(_) => ScalarType::U16,
            Self::I16(_) => ScalarType::I16,
            Self::F32(_) => ScalarType::F32,
        }
    }
}

macro_rules! into_any {
    ($($t:ty => $variant:ident),*) => { $(
        impl From<OctreeVolume<$t>> for AnyVolume {
            fn from(volume: OctreeVolume<$t>) -> Self {
                Self::$variant(volume)
            }
        }
    )* };
}
into_any!(u8 => U8, i8 => I8, u16 => U16, i16 => I16, f32 => F32);
