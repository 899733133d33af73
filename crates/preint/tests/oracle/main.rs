//! Schemes against the float64 reference.

mod bounded;
mod common;
mod schemes;
