//! Packets against single rays. One program: what they go through is compiled once.

mod detail;
mod far_shadows;
mod shadows;
mod single_rays;
mod traversals;
