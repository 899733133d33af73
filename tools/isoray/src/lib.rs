//! `isoray`: exact pictures of scalar volumes, from the command line. A library, so that the project's own tasks need not compile once more what
//! both programs render with.

#![cfg_attr(
    test,
    allow(
        dead_code,
        unused_imports,
        reason = "tests of the parts need no renderers: without `run` these are not compiled once more, which takes minutes"
    )
)]

mod cli;
mod commands;
mod conversion;
mod failure;
mod isovalue;
mod load;
mod memory;
mod mesh;
mod output;
mod plot;
mod progress;
mod series;
mod transfer;

use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command};

/// Does what the command line asks for.
#[cfg(not(test))]
pub fn run() -> ExitCode {
    let result = match Cli::parse().command {
        None => commands::demo::run(),
        Some(Command::Build(args)) => commands::build::run(&args),
        Some(Command::Info(args)) => commands::info::run(&args),
        Some(Command::Check(args)) => commands::check::run(&args),
        Some(Command::Render(args)) => commands::render::run(&args),
        Some(Command::Tf(command)) => commands::tf::run(&command),
        Some(Command::Synth(args)) => commands::synth::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failure::report(&error),
    }
}
