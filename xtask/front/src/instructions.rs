//! `cargo xtask instructions`: how many instructions each kernel takes, counted by valgrind.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::root;

/// What to count, and what to compare it with.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// For the counting program, after `--`: names of kernels, `--save-baseline=NAME`, `--baseline=NAME`, `--callgrind-limits='ir=3%'`, …; `-- --help` prints all
    #[arg(last = true)]
    arguments: Vec<OsString>,
}

/// The variable that says where the runner is, if it is not on the path.
const RUNNER: &str = "GUNGRAUN_RUNNER";

/// Valgrind knows AVX2 and fused multiply-add, and no AVX-512. As in the tests on x86-64-v3, which share the folder.
const FLAGS: &str = "-C target-cpu=x86-64-v3";
const TARGET: &str = "target/v3";

pub(crate) fn run(args: &Args) -> Result<()> {
    let lock = fs::read_to_string(root().join("Cargo.lock")).context("Cargo.lock cannot be read")?;
    let version = runner_version(&lock)?;
    let valgrind = on_path("valgrind");
    let runner = env::var_os(RUNNER).map(PathBuf::from).or_else(|| on_path("gungraun-runner"));
    let runner = runner.filter(|runner| runner.is_file());
    let mut missing = Vec::new();
    if valgrind.is_none() {
        missing.push("valgrind: `apt-get install valgrind`, or as your system has it".to_owned());
    }
    if runner.is_none() {
        missing.push(format!(
            "gungraun-runner {version}: `cargo install --locked --version {version} gungraun-runner`; {RUNNER} says where it is, if not on the path"
        ));
    }
    let (Some(_), Some(runner)) = (valgrind, runner) else {
        bail!("counting instructions needs what is not installed:\n  {}", missing.join("\n  "));
    };
    println!("Instructions of each kernel on one thread, built with RUSTFLAGS=\"{FLAGS}\" in {TARGET}");
    let status = Command::new("cargo")
        .args([
            "bench",
            "-p",
            "isoray-benches",
            "--features",
            "instructions",
            "--bench",
            "instructions",
            "--",
        ])
        .args(&args.arguments)
        .env("RUSTFLAGS", FLAGS)
        .env("CARGO_TARGET_DIR", root().join(TARGET))
        .env(RUNNER, fs::canonicalize(&runner)?)
        .current_dir(root())
        .status()
        .context("cannot run cargo")?;
    ensure!(status.success(), "counting instructions failed ({status}): see above");
    Ok(())
}

/// The program of this name in a folder of the path.
fn on_path(name: &str) -> Option<PathBuf> {
    let folders = env::var_os("PATH")?;
    env::split_paths(&folders).map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// That of the library, which the runner must have too.
fn runner_version(lock: &str) -> Result<&str> {
    let rest = lock.split_once("name = \"gungraun\"\nversion = \"").map(|(_, rest)| rest);
    let version = rest.and_then(|rest| rest.split_once('"')).map(|(version, _)| version);
    version.context("Cargo.lock has no version of gungraun")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_of_the_runner_is_that_of_the_library() {
        let lock = "[[package]]\nname = \"gungraun-common\"\nversion = \"0.1.0\"\n\n[[package]]\nname = \"gungraun\"\nversion = \"0.20.0\"\n";
        assert_eq!(runner_version(lock).unwrap(), "0.20.0");
        assert!(runner_version("").is_err());
        let ours = fs::read_to_string(root().join("Cargo.lock")).unwrap();
        assert!(runner_version(&ours).unwrap().starts_with("0."));
    }
}
