//! What is built, against what it is built of. One program: what is built is compiled once.

mod levels;
mod lossy;
mod octree;
mod streaming;
