//! What the project's own tasks measure and compare: `cargo xtask` builds and calls it.

mod bench;
mod catalog;
mod figure;
mod finest;
mod for_oracle;
mod golden;
mod shells;
mod stress;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
// What the tool renders with is compiled there, once for both.
use isoray as _;

/// The project's own tasks.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Compare rendered scenes with stored references and with the float64 oracle
    Golden(golden::Args),
    /// Render the single cell by several schemes of volume rendering, and print their errors
    Figure(figure::Args),
    /// Measure sizes, build rate and throughput; print a table and write JSON
    Bench(bench::Args),
    /// Try adversarial inputs in great numbers
    #[command(subcommand)]
    Stress(stress::Args),
}

fn main() -> ExitCode {
    let result = match Cli::parse().task {
        Task::Golden(args) => golden::run(&args),
        Task::Figure(args) => figure::run(&args),
        Task::Bench(args) => bench::run(&args),
        Task::Stress(args) => stress::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            error.chain().skip(1).for_each(|cause| eprintln!("  caused by: {cause}"));
            ExitCode::FAILURE
        }
    }
}

/// The workspace's root folder.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(PathBuf::new, Path::to_owned)
}
