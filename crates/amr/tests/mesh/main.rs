//! The field of a mesh.

mod continuity;
mod levels;
mod linear;
mod meshes;
mod oracle;
mod rays;
mod refusals;
