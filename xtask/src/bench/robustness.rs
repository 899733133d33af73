//! Adversarial inputs, a few of every kind: that what is measured beside them holds where it is hardest. `cargo xtask stress` tries as many as one likes.

use std::time::Instant;

use anyhow::{Result, bail};
use serde::Serialize;

use crate::catalog::Entry;
use crate::stress::{self, Kind};

/// One kind of inputs.
#[derive(Debug, Serialize)]
pub(crate) struct RobustnessRow {
    kind: &'static str,
    /// The same inputs by every run.
    seed: u64,
    cases: u64,
    /// Of which the reference cannot tell what is right.
    doubtful: u64,
    /// None, or the run fails.
    failures: u64,
    /// On all threads.
    seconds: f64,
}

/// Titles of the columns.
const HEADER: &str = "\nAdversarial inputs of every kind against the oracle and the rules: none may fail.
kind                              cases   doubtful   failures  seconds";

/// Which inputs.
const SEED: u64 = 2006;

/// Inputs of a kind in a short run, and by how many times as many others are longer; together two seconds on two cores.
fn count(kind: Kind) -> u64 {
    match kind {
        Kind::Cell => 200_000,
        Kind::Traverse => 100_000,
        Kind::TraverseDetail => 30_000,
        Kind::Integrate => 16_384,
        // Twice every shape of mesh, with either kind of values.
        Kind::Amr => 24 * 512,
    }
}
const LONGER: u64 = 20;

/// # Errors
/// Any input that comes to something it must not.
pub(crate) fn run(quick: bool) -> Result<Vec<RobustnessRow>> {
    println!("{HEADER}");
    let entry = Entry::fixture();
    let mut rows = Vec::new();
    let mut offending = String::new();
    for kind in Kind::ALL {
        let begin = Instant::now();
        let count = count(kind) * if quick { 1 } else { LONGER };
        let outcome = stress::few(kind, &entry, count, SEED)?;
        let row = RobustnessRow {
            kind: kind.name(),
            seed: SEED,
            cases: outcome.cases,
            doubtful: outcome.doubtful,
            failures: outcome.failures,
            seconds: begin.elapsed().as_secs_f64(),
        };
        println!(
            "{:<28} {:>10} {:>10} {:>10} {:>8.2}",
            row.kind, row.cases, row.doubtful, row.failures, row.seconds
        );
        if row.failures > 0 {
            offending +=
                &format!("\n{}: {} failures, such as\n{}", row.kind, row.failures, outcome.offending);
        }
        rows.push(row);
    }
    if !offending.is_empty() {
        bail!("adversarial inputs failed:{offending}");
    }
    Ok(rows)
}
