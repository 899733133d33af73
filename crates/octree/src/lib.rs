//! The octree volume: a structured volume, losslessly compressed, that is its own acceleration structure.
//!
//! Knoll, Wald, Parker and Hansen (2006, sections 3 and 4) consolidate regions of equal samples bottom-up
//! into an octree and keep, for every region, the range of the cells in it, so that one structure holds the
//! data and tells a ray where a surface can be. This crate owns that structure; `isoray-build` makes one and
//! `isoray-trace` sends rays through it.
//!
//! # Structure
//!
//! Samples are grouped into *caps* of 4³. Nodes of level `l` (edge `2^l`, 3 and up) hold, for each of eight
//! children, the sample at its low corner, the range of its cells and whether it is stored; see [`Node`]. A
//! region of bitwise equal samples is a *scalar leaf*: nothing but the value in its parent. The range of a
//! region covers its samples *and their forward neighbours*, which the cells at its upper faces touch (2006,
//! section 3.3); samples outside the domain do not exist: they take part in no range, no comparison and no
//! stored byte, and a cap at the far border is cut short.
//!
//! A cap takes as many bits a sample as the range of its cells needs, which its parent has anyway; the bits lie in planes of one word each,
//! which makes comparing a cap with an isovalue a few operations on words. See [`push_cap`].
//!
//! A child mask with population count in place of the paper's eight offsets, and caps of 4³ in place of 2³,
//! make the structure smaller and faster on every volume measured; `docs/experiments.md` has the figures.
//!
//! # Looking up
//!
//! [`OctreeView`] is the borrowed structure. [`OctreeView::sample`] finds a sample from the root down;
//! [`Path::neighbor`] finds a block near another one, starting from the nodes on that one's way down and not
//! from the root; cells at the border of a cap need it.
//!
//! ```
//! use isoray_octree::{AnyVolume, Coarse, Fidelity, HISTOGRAM_BINS, Meta, Node, OctreeVolume, Parts};
//! use isoray_grid::Dims;
//!
//! // The smallest structure there is: one root whose children are scalar leaves.
//! // (`isoray-build` makes real ones.)
//! let root = Node { mins: [7u8; 8], maxs: [7; 8], values: [7; 8], first: 0.into(), mask: 0 };
//! let meta = Meta {
//!     dims: Dims::new([8, 8, 8])?,
//!     index_to_world: glam::DAffine3::IDENTITY,
//!     range: Some([7.0, 7.0]),
//!     non_finite: 0,
//!     histogram: Box::new([0; HISTOGRAM_BINS]),
//!     fidelity: Fidelity::LOSSLESS,
//!     coarse: Coarse::Injected,
//! };
//! let volume = OctreeVolume::<u8>::from_parts(meta, Parts { levels: vec![vec![root]], caps: Vec::new() });
//! assert_eq!(volume.view().sample([3, 4, 5]), 7);
//!
//! // To a file and back, memory-mapped.
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("seven.ovol");
//! volume.save(&path)?;
//! let AnyVolume::U8(mapped) = AnyVolume::open(&path)? else { unreachable!() };
//! assert_eq!(mapped.view().to_dense(), vec![7; 512]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Levels of detail
//!
//! The same structure is the volume at a half, a quarter, … of its resolution: [`OctreeView::coarse_sample`] reads the coarse lattices that
//! [`mod@lod`] describes, and [`OctreeView::coarse_range`] bounds what is in one of their cells.
//!
//! # Files
//!
//! The byte map of `.ovol` files stands in [`mod@format`]. Opening maps the file and checks the header and
//! the section table; [`AnyVolume::verify`] checks all of it. A damaged body can make wrong pictures but
//! neither a crash nor an endless loop: every link is bounds-checked where it is followed, and the depth is
//! fixed.
//!
//! # Time series
//!
//! A folder of `.ovol` files that agree in shape is a [`Series`]: its steps are opened one by one.

mod cap;
mod check;
mod counts;
mod fidelity;
pub mod format;
mod geometry;
pub mod lod;
mod node;
mod open;
mod path;
mod save;
mod series;
mod view;
mod volume;
mod walk;

pub use cap::{Block, cap_reach, cap_unit, push_cap};
pub use check::{Malformed, check_well_formed, check_well_formed_as};
pub use counts::Counts;
pub use fidelity::{Coarse, Fidelity, SurfaceFidelity};
pub use geometry::{
    CAP_EDGE, CAP_LEVEL, CAP_SAMPLES, MAX_LEVEL, MAX_LEVELS, NODE_LEVEL, child_origin, extent, is_whole,
    octant_of, product, root_level,
};
pub use lod::{coarse_dims, coarse_position, fill_coarse};
pub use node::{Node, Range};
pub use open::{OpenError, OpenProblem, is_ovol};
pub use path::Path;
pub use save::{SaveError, VolumeWriter};
pub use series::{PREFETCH_BUDGET, Prefetch, Series, SeriesError, Shape, ShapeDifference, is_series};
pub use view::{Around, OctreeView};
pub use volume::{AnyVolume, HISTOGRAM_BINS, LevelStatistics, Meta, OctreeVolume, Parts, VolumeVisitor};
pub use walk::Leaf;
