//! Adaptive meshes: patches of several levels, and the continuous field through their values.

mod block;
mod bricks;
mod cells;
mod cuboid;
mod error;
mod hybrid;
mod levels;
mod mesh;
mod overlap;
mod patches;
mod skeleton;
mod tree;
mod vertices;

pub use cells::Border;
pub use error::MeshError;
pub use mesh::{Mesh, MeshOptions, MeshSize, Piece};
pub use patches::{Centering, Patch, Patches};
pub use tree::SplitRule;
