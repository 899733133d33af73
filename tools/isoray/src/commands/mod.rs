//! One module a command.

pub(crate) mod build;
pub(crate) mod check;
pub(crate) mod demo;
pub(crate) mod info;
pub(crate) mod render;
pub(crate) mod stats;

use std::path::Path;

use anyhow::{Context, Result, bail};

/// Refuses an output path whose folder is missing, before any work is done for it.
fn check_folder(output: &Path) -> Result<()> {
    let folder = match output.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        bail!("{}: cannot be written: the folder {} does not exist", output.display(), folder.display());
    }
    if output.is_dir() {
        bail!("{}: cannot be written: it is a folder", output.display());
    }
    Ok(())
}

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
fn bytes(n: u64) -> String {
    const UNITS: [&str; 5] = ["B", "KiB", "MiB", "GiB", "TiB"];
    let power = (n.max(1).ilog2() / 10).min(4);
    match power {
        0 => format!("{n} B"),
        _ => format!("{:.2} {}", n as f64 / f64::from(1u32 << 10).powi(power as i32), UNITS[power as usize]),
    }
}
