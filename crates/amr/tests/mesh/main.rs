//! The field of a mesh.

mod continuity;
mod detail;
mod levels;
mod linear;
mod meshes;
mod oracle;
mod rays;
mod refusals;
mod structured;
