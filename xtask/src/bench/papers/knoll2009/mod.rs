//! The figures of Knoll, Wald and Hansen 2009 (Coherent Multiresolution Isosurface Ray Tracing) beside ours of the same kind, on one thread.
//!
//! Their machines are long gone and most of their data cannot be had, so that the third number, ours over theirs, says more about twenty years of processors
//! than about methods; how many times as fast one traversal is as another, on one machine, is what can be compared.
//!
//! That no more than 5 to 15 % of the time goes into traversal (section 8.2) is left out too: packets do both in one loop. For single rays `cargo xtask bench single` has it.

mod frames;
mod packets;
pub(in crate::bench) mod slices;

use anyhow::Result;

use super::{PaperRow, Setting};

/// What the paper measured on.
const HEADER: &str = "\nKnoll, Wald and Hansen 2009 beside ours, one thread: paper, ours, ours over the paper's.
Theirs: Core Duo 2.16 GHz (laptop, 2 cores), 8 cores of Xeon 3 GHz. Frames/s are of as many rays as their pictures have, and Table 4's a core.
Scenes: HEP64 and HEP302 are a heptane fire of 64^3 and 302^3, RM the Richtmyer-Meshkov instability, 2048^2 x 1920, at a time step.
Of Figures 11 and 12 the text says that frame rates are 15 to 30 % lower with central normals and 20 to 30 % with shadows, theirs through a coarser level than the picture, ours exact.
Of 1024x1024 for 512x512 it says twice as long or better, with packets; in Table 4 it is 2.8 to 5.6 times.";

pub(super) fn run(setting: Setting<'_>) -> Result<Vec<PaperRow>> {
    println!("{HEADER}");
    let mut rows = slices::run(setting)?;
    rows.extend(packets::run(setting)?);
    rows.extend(frames::run(setting)?);
    Ok(rows)
}
