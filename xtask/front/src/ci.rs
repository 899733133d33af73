//! `cargo xtask ci`: everything that must pass.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::{root, tidy};

/// One step: a name, cargo's arguments, and variables of its environment.
struct Step {
    name: &'static str,
    arguments: &'static [&'static str],
    environment: &'static [(&'static str, &'static str)],
}

/// The plain x86-64 build: the crates must work without native instructions too. What has lanes is tested; octrees are built and read by the tests of rays.
const PLAIN: &[(&str, &str)] = &[("RUSTFLAGS", "-C target-cpu=x86-64"), ("CARGO_TARGET_DIR", "target/plain")];

/// One with fused multiply-add and AVX2, but no AVX-512.
const V3: &[(&str, &str)] = &[("RUSTFLAGS", "-C target-cpu=x86-64-v3"), ("CARGO_TARGET_DIR", "target/v3")];

/// Snapshots of what the program prints are compared, never written, whatever the caller's environment says.
const SNAPSHOTS: &[(&str, &str)] = &[("INSTA_UPDATE", "no"), ("INSTA_FORCE_PASS", "0")];

const STEPS: &[Step] = &[
    Step { name: "formatting", arguments: &["fmt", "--all", "--check"], environment: &[] },
    Step {
        name: "lints",
        arguments: &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"],
        environment: &[],
    },
    Step {
        name: "documentation",
        arguments: &["doc", "--workspace", "--no-deps"],
        environment: &[("RUSTDOCFLAGS", "-D warnings")],
    },
    Step { name: "tests", arguments: &["test", "--workspace"], environment: SNAPSHOTS },
    // With one of the tests, for the sake of dependencies' features, which are more then: without it all crates would be compiled once more.
    Step {
        name: "what the steps below run",
        arguments: &["build", "--workspace", "--bins", "--test", "cli"],
        environment: &[],
    },
    Step {
        name: "tests on plain x86-64",
        arguments: &[
            "test",
            "-p",
            "isoray-cell",
            "-p",
            "isoray-preint",
            "-p",
            "isoray-synth",
            "-p",
            "isoray-trace",
            "-p",
            "isoray-packet",
        ],
        environment: PLAIN,
    },
    Step {
        name: "tests on x86-64-v3",
        arguments: &["test", "-p", "isoray-cell", "-p", "isoray-packet"],
        environment: V3,
    },
    Step {
        name: "stress, cells",
        arguments: &["xtask", "stress", "cell", "--count", "4000000", "--fresh"],
        environment: &[],
    },
    Step {
        name: "stress, rays",
        arguments: &["xtask", "stress", "traverse", "--count", "1000000", "--only", "fixture", "--fresh"],
        environment: &[],
    },
    Step {
        name: "stress, rays through levels of detail",
        arguments: &[
            "xtask", "stress", "traverse", "--lod", "--count", "300000", "--only", "fixture", "--fresh",
        ],
        environment: &[],
    },
    Step {
        name: "stress, integrals",
        arguments: &["xtask", "stress", "integrate", "--count", "300000", "--fresh"],
        environment: &[],
    },
    Step {
        name: "stress, adaptive meshes",
        arguments: &["xtask", "stress", "amr", "--count", "100000", "--fresh"],
        environment: &[],
    },
    Step { name: "golden checks", arguments: &["xtask", "golden"], environment: &[] },
    Step {
        name: "short benchmark",
        arguments: &["xtask", "bench", "--quick", "--repeat", "1"],
        environment: &[],
    },
];

pub(crate) fn run() -> Result<()> {
    let begin = Instant::now();
    tidy::run()?;
    let this_program = std::env::current_exe().context("cannot tell where this program is")?;
    let renders = this_program.with_file_name(format!("xtask{}", std::env::consts::EXE_SUFFIX));
    for step in STEPS {
        println!("\n== {}: cargo {}", step.name, step.arguments.join(" "));
        let this = Instant::now();
        // As the step that builds left it beside this one: optimised, with assertions.
        let (program, arguments) = match step.arguments {
            ["xtask", own @ ..] => (renders.as_path(), own),
            of_cargo => (Path::new("cargo"), of_cargo),
        };
        let mut command = Command::new(program);
        command.args(arguments).envs(step.environment.iter().copied()).current_dir(root());
        let status =
            command.status().with_context(|| format!("{}: cannot run {}", step.name, program.display()))?;
        if !status.success() {
            bail!("{}: `cargo {}` failed ({status})", step.name, step.arguments.join(" "));
        }
        println!("== {}: {:.0} s", step.name, this.elapsed().as_secs_f64());
    }
    println!("\n== all of it: {:.0} s", begin.elapsed().as_secs_f64());
    Ok(())
}
