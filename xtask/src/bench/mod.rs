//! `cargo xtask bench`: measured figures, in ratios of one run.

mod cell;
mod overview;
mod report;
mod timer;

use std::path::PathBuf;

use anyhow::{Context, Result, bail};

use crate::catalog::Entry;
use crate::root;
use report::Report;

/// Flags of `cargo xtask bench`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// What to measure [default: all of it]
    #[arg(value_enum)]
    suites: Vec<Suite>,
    /// A short run on the bundled volume and a small generated one
    #[arg(long)]
    quick: bool,
    /// Folder of real volumes; those that are there are measured
    #[arg(long, value_name = "DIR", default_value = "../shared/data")]
    data: PathBuf,
    /// Only volumes whose name contains this
    #[arg(long)]
    only: Option<String>,
    /// Timed repetitions of each variant [default: 9, with --quick 3]
    #[arg(long)]
    repeat: Option<usize>,
    /// Replace the table of first-root finders in the documentation, and its chart, by what is measured
    #[arg(long)]
    docs: bool,
    /// Where the JSON goes
    #[arg(long, value_name = "FILE", default_value = "target/bench/report.json")]
    json: PathBuf,
}

/// A group of measurements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Suite {
    /// Sizes, build rate and throughput
    Overview,
    /// First-root finders: time against error
    Cell,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let repeat = args.repeat.unwrap_or(if args.quick { 3 } else { 9 });
    let (entries, sizes): (Vec<_>, &[u32]) = match args.quick {
        true => (vec![Entry::fixture(), Entry::marschner_lobb(64)], &[256]),
        false => (entries(args), &[512, 1024]),
    };
    let wanted = |e: &&Entry| args.only.as_ref().is_none_or(|only| e.name.contains(only));
    let entries: Vec<Entry> = entries.iter().filter(wanted).cloned().collect();
    if entries.is_empty() {
        bail!("no volume is named like {:?}", args.only.as_deref().unwrap_or_default());
    }
    let mut report = Report::new(repeat);
    if args.runs(Suite::Overview) {
        println!("{}", overview::HEADER);
        for entry in &entries {
            report.overview.extend(entry.visit(overview::Overview { entry, sizes, repeat })??);
        }
    }
    let json = root().join(&args.json);
    if args.runs(Suite::Cell) {
        report.cell = cell_suite(args, &entries, repeat)?;
    }
    report.save(&json)?;
    if let Some(set) = report.cell.first().map(|row| row.set.clone()) {
        let rows: Vec<_> = report.cell.iter().filter(|row| row.set == set).collect();
        cell::chart(&rows, &json.with_file_name("cell.svg"))?;
        if args.docs {
            cell::chart(&rows, &root().join("docs/pictures/cell.svg"))?;
            let table = root().join("crates/cell/methods.md");
            std::fs::write(&table, cell::markdown(&report.cell, &report.machine()))
                .with_context(|| format!("{}: cannot be written", table.display()))?;
        }
    }
    Ok(())
}

impl Args {
    fn runs(&self, suite: Suite) -> bool {
        self.suites.is_empty() || self.suites.contains(&suite)
    }
}

/// Cells of two volumes, the first real ones there are, and random ones; with `--quick` those of one.
fn cell_suite(args: &Args, entries: &[Entry], repeat: usize) -> Result<Vec<cell::CellRow>> {
    let real = entries.iter().filter(|e| e.is_real()).take(if args.quick { 1 } else { 2 });
    let mut sets = Vec::new();
    for entry in real {
        sets.extend(entry.visit(cell::Collect(entry))??);
    }
    sets.extend(cell::random_sets());
    println!("\n{}", cell::HEADER);
    let mut rows = Vec::new();
    for set in &sets {
        rows.extend(cell::measure(set, repeat)?);
    }
    Ok(rows)
}

/// The bundled volume, the generated ones, and what is there of the data folder.
fn entries(args: &Args) -> Vec<Entry> {
    let data = root().join(&args.data);
    let mut entries = vec![Entry::fixture(), Entry::marschner_lobb(256), Entry::turbulence(512)];
    if data.is_dir() {
        entries.extend(Entry::real(&data));
    } else {
        println!("SKIPPED: the real volumes; there is no folder {}", data.display());
    }
    entries
}
