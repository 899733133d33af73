//! `cargo xtask`: the project's own tasks.

mod bench;
mod catalog;
mod ci;
mod figure;
mod finest;
mod for_oracle;
mod golden;
mod instructions;
mod shells;
mod stress;
mod tidy;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
// What the tool renders with is compiled there, once for both.
use isoray as _;

/// The project's own tasks.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Everything that must pass: formatting, lints, documentation, tests, golden checks, a short benchmark
    Ci,
    /// Check the crates' dependencies against the layering, and the house rules that no lint knows
    Tidy,
    /// Compare rendered scenes with stored references and with the float64 oracle
    Golden(golden::Args),
    /// Render the single cell by several schemes of volume rendering, and print their errors
    Figure(figure::Args),
    /// Measure sizes, build rate and throughput; print a table and write JSON
    Bench(bench::Args),
    /// Count the instructions of each kernel by valgrind
    Instructions(instructions::Args),
    /// Try adversarial inputs in great numbers
    #[command(subcommand)]
    Stress(stress::Args),
}

fn main() -> ExitCode {
    let result = match Cli::parse().task {
        Task::Ci => ci::run(),
        Task::Tidy => tidy::run(),
        Task::Golden(args) => golden::run(&args),
        Task::Figure(args) => figure::run(&args),
        Task::Bench(args) => bench::run(&args),
        Task::Instructions(args) => instructions::run(&args),
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
