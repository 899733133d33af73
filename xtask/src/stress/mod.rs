//! `cargo xtask stress`: any number of adversarial inputs, in parallel, in shards that can be resumed.

mod amr;
mod cell;
mod integrate;
mod shard;
mod traverse;

use anyhow::Result;

/// What is stressed.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum Args {
    /// Adaptive meshes: both sides of faces, edges and vertices, linear fields, ranges, rays through levels
    Amr(shard::Args),
    /// Ray-cell pairs against the float64 oracle: missed, false and misplaced roots, and lanes against scalars
    Cell(shard::Args),
    /// Segments of volumes against the float64 oracle: colours and opacities off by more than the bound
    Integrate(shard::Args),
    /// Rays through whole volumes: no change of side between consecutive cells without a hit
    Traverse(traverse::Args),
}

pub(crate) fn run(args: &Args) -> Result<()> {
    match args {
        Args::Amr(args) => amr::run(args),
        Args::Cell(args) => cell::run(args),
        Args::Integrate(args) => integrate::run(args),
        Args::Traverse(args) => traverse::run(args),
    }
}
