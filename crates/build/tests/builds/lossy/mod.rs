//! Lossy compression against what it promises, on volumes made to break it and on a real one.

mod common;
mod displacement;
mod range;
mod real;
mod surface;
mod tolerance;
