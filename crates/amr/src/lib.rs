//! Adaptive meshes: patches of several levels, the continuous field through their values, and rays through it.
//!
//! ```
//! use glam::DAffine3;
//! use isoray_amr::{Centering, Mesh, MeshOptions, MeshTracer, Patch, Patches};
//! use isoray_trace::{Ray, Trace};
//!
//! // 4³ cells, the eight around the centre of the domain refined; the values are those of x.
//! let patch = |level: u32, low: i32, cells: u32| {
//!     let edge = 0.5f32.powi(level as i32);
//!     let x = |n: u32| (low as f32 + (n % cells) as f32 + 0.5) * edge;
//!     Patch { level, low: [low; 3], cells: [cells; 3], values: (0..cells.pow(3)).map(x).collect::<Vec<_>>().into() }
//! };
//! let patches = Patches {
//!     centering: Centering::Cells,
//!     ratios: vec![2],
//!     index_to_world: DAffine3::IDENTITY,
//!     domain: ([0; 3], [4; 3]),
//!     patches: vec![patch(0, 0, 4), patch(1, 2, 4)],
//! };
//! let mesh = Mesh::new(&patches, MeshOptions::default())?;
//! assert_eq!(mesh.size().leaves, [64 - 8, 64]);
//!
//! // Index space counts the edges of the finest cells.
//! assert_eq!(mesh.value([3.5, 4.2, 4.0], 7), Some(1.75));
//! let ray = Ray { origin: [-1.0, 3.3, 4.6], direction: [1.0, 0.0, 0.0], t_min: 0.0, t_max: f32::INFINITY };
//! let hit = MeshTracer::new(&mesh).first_hit(&ray, 1.25).expect("the values go from 0 to 4");
//! assert_eq!(hit.t, 3.5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The field
//!
//! *Leaves* are the cells that no finer ones cover; the finest wins where levels overlap, and cells of any two levels may meet. The values are those of vertices, or become such:
//! that of a vertex of cells is the mean of what the eight octants around it have half an edge of the smallest leaf there away, where a larger leaf is taken as linear; exact for linear fields,
//! and within the averages of the leaves that touch it. It smooths: of a spike of one cell an eighth is left. At the border of the domain no rule is both exact for linear fields and bounded
//! ([`Border`]).
//!
//! A vertex has the value of the finest leaf whose corner it is, for all cells that touch it. A leaf that finer ones touch, be it along an edge, is taken apart into eight, in each of which the
//! field is trilinear, or which are taken apart again. Points that no leaf has as a corner get the values that Coons's patches have in the middle of edges, faces and cells, within those they
//! are made of. So the field is continuous on every mesh, but for rounding; linear fields are exact; no value lies outside of those at the vertices of leaves that touch the leaf it is
//! in. (Marchesin and Colin de Verdière 2009, section 3.3, leave the split open, and what they say of faces is not continuous.)
//!
//! A cell whose average, or one of whose vertices, is not finite is empty: it is not drawn, and does not count for others.
//!
//! # Structure
//!
//! A kd-tree (their section 4.1) cuts the domain into boxes of leaves of one level, each with the values at its vertices and, for every 4³ cells, their range, which of them are taken apart,
//! and which are empty. They call a box to be split until it is *homogeneous* and leave open what that is; here: until it holds cells of one level only. Planes are faces of patches, chosen by how
//! homogeneous both parts become, or by the surface-area heuristic ([`SplitRule`]).
//!
//! # Rays
//!
//! Rays run in index space, the lattice of the finest cells. In boxes of coarser ones they are scaled by a power of two, which changes no digit of any plane crossing: what holds of structured
//! volumes (`isoray-trace`) holds here. [`MeshTracer`] finds isosurfaces, [`MeshVolumeTracer`] integrates.

mod bins;
mod block;
mod block_at;
mod boxes;
mod bricks;
mod cells;
mod cuboid;
mod detail;
mod error;
mod hybrid;
mod level_rays;
mod levels;
mod mesh;
mod overlap;
mod part;
mod patches;
mod range;
mod samples;
mod skeleton;
mod stretches;
mod surface;
mod tree;
mod values;
mod vertices;
mod visit;
mod volume;
mod walk;

pub use boxes::LevelBox;
pub use cells::Border;
pub use error::MeshError;
pub use mesh::{Mesh, MeshOptions, MeshSize, Piece};
pub use patches::{Centering, OctreeLeaf, Patch, Patches};
pub use surface::MeshTracer;
pub use tree::SplitRule;
pub use values::Values;
pub use volume::MeshVolumeTracer;
