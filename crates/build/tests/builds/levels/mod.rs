//! Coarse samples: every kind against a dense computation, their ranges, and the check of both.

mod check;
mod dense;
mod files;
mod ramps;
mod ranges;
mod samples;
