//! One module a command.

pub(crate) mod build;
pub(crate) mod check;
mod cpu;
pub(crate) mod demo;
pub(crate) mod info;
mod mesh_info;
pub(crate) mod render;
pub(crate) mod synth;
pub(crate) mod tf;

use anyhow::{Context, Result};

/// Sets the number of threads of the whole process.
fn use_threads(threads: Option<usize>) -> Result<()> {
    match threads {
        Some(n) => {
            rayon::ThreadPoolBuilder::new().num_threads(n).build_global().context("cannot start the threads")
        }
        None => Ok(()),
    }
}

/// Bytes with a binary unit, for people.
pub(crate) fn bytes(n: u64) -> String {
    const UNITS: [&str; 5] = ["B", "KiB", "MiB", "GiB", "TiB"];
    let power = (n.max(1).ilog2() / 10).min(4);
    match power {
        0 => format!("{n} B"),
        _ => format!("{:.2} {}", n as f64 / f64::from(1u32 << 10).powi(power as i32), UNITS[power as usize]),
    }
}
