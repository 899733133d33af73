//! The field of a mesh.

mod continuity;
mod linear;
mod meshes;
mod oracle;
mod rays;
mod refusals;
