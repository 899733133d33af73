//! Time series: many inputs to one folder, and what is told of such a folder.

mod build;
mod check;
mod info;
mod inputs;
mod number;
mod record;

pub(crate) use build::build;
pub(crate) use check::check;
pub(crate) use info::info;
pub(crate) use inputs::{Inputs, expand};
pub(crate) use number::NumberPattern;

/// `1 step`, `2 steps`.
fn steps(count: usize) -> String {
    format!("{count} step{}", if count == 1 { "" } else { "s" })
}
