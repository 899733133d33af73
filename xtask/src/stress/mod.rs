//! `cargo xtask stress`: any number of adversarial inputs, in parallel, in shards that can be resumed.

mod amr;
mod cell;
mod integrate;
mod shard;
mod traverse;

use anyhow::Result;

use crate::catalog::Entry;

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

/// Something to be tried a few times.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    Cell,
    Traverse,
    TraverseDetail,
    Integrate,
    Amr,
}

impl Kind {
    /// All that there are.
    pub(crate) const ALL: [Self; 5] =
        [Self::Cell, Self::Traverse, Self::TraverseDetail, Self::Integrate, Self::Amr];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Cell => "cell",
            Self::Traverse => "traverse",
            Self::TraverseDetail => "traverse, levels of detail",
            Self::Integrate => "integrate",
            Self::Amr => "amr",
        }
    }
}

/// Tries about `count` inputs of one kind, rays on `entry`: at once, in this process, without files.
pub(crate) fn few(kind: Kind, entry: &Entry, count: u64, seed: u64) -> Result<shard::Outcome> {
    Ok(match kind {
        Kind::Cell => cell::few(count, seed),
        Kind::Traverse => traverse::few(entry, count, seed, false)?,
        Kind::TraverseDetail => traverse::few(entry, count, seed, true)?,
        Kind::Integrate => integrate::few(count, seed),
        Kind::Amr => amr::few(count, seed),
    })
}
