//! `cargo xtask`: the project's own tasks. Compiles in seconds; what renders is another program, built when a task needs it.

mod ci;
mod instructions;
mod tidy;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};

/// The project's own tasks.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
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
    /// Count the instructions of each kernel by valgrind
    Instructions(instructions::Args),
    /// Compare rendered scenes with stored references and with the float64 oracle
    #[command(disable_help_flag = true)]
    Golden(Passed),
    /// Render the single cell by several schemes of volume rendering, and print their errors
    #[command(disable_help_flag = true)]
    Figure(Passed),
    /// Measure sizes, build rate, throughput and errors; print tables and write a page and JSON
    #[command(disable_help_flag = true)]
    Bench(Passed),
    /// Try adversarial inputs in great numbers
    #[command(disable_help_flag = true)]
    Stress(Passed),
}

/// What the program that renders reads by itself.
#[derive(Debug, clap::Args)]
struct Passed {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    arguments: Vec<OsString>,
}

fn main() -> ExitCode {
    let result = match Cli::parse().task {
        Task::Ci => ci::run().map(|()| ExitCode::SUCCESS),
        Task::Tidy => tidy::run().map(|()| ExitCode::SUCCESS),
        Task::Instructions(args) => instructions::run(&args).map(|()| ExitCode::SUCCESS),
        Task::Golden(passed) => pass_on("golden", &passed),
        Task::Figure(passed) => pass_on("figure", &passed),
        Task::Bench(passed) => pass_on("bench", &passed),
        Task::Stress(passed) => pass_on("stress", &passed),
    };
    result.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        error.chain().skip(1).for_each(|cause| eprintln!("  caused by: {cause}"));
        ExitCode::FAILURE
    })
}

/// Builds the program that renders as what is measured must be built, and runs it where the caller stands: paths are relative to that.
fn pass_on(task: &str, passed: &Passed) -> Result<ExitCode> {
    let manifest = root().join("Cargo.toml");
    let status = Command::new("cargo")
        .args(["run", "--release", "--package", "xtask", "--manifest-path"])
        .arg(manifest)
        .args(["--", task])
        .args(&passed.arguments)
        .status()
        .context("cannot run cargo")?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}

/// The workspace's root folder.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).map_or_else(PathBuf::new, Path::to_owned)
}
