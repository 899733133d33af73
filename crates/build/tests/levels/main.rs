//! Coarse samples: every kind against a dense computation, their ranges, and the check of both.

#[path = "../octree/volumes.rs"]
#[expect(dead_code, unused_imports, unused_macros, reason = "tests of the structure use more of it")]
mod volumes;

mod check;
mod dense;
mod files;
mod ramps;
mod ranges;
mod samples;
