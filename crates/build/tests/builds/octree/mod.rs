//! The octree volume against the dense array it was made of, and against damaged files.

mod damage;
mod files;
mod format;
mod lookup;
mod structure;
pub(crate) mod volumes;
