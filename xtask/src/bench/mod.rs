//! `cargo xtask bench`: measured figures, in ratios of one run.

mod overview;
mod report;
mod timer;

use std::path::PathBuf;

use anyhow::{Result, bail};

use crate::catalog::Entry;
use crate::root;
use report::Report;

/// Flags of `cargo xtask bench`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
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
    /// Where the JSON goes
    #[arg(long, value_name = "FILE", default_value = "target/bench/report.json")]
    json: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let repeat = args.repeat.unwrap_or(if args.quick { 3 } else { 9 });
    let (entries, sizes): (Vec<_>, &[u32]) = match args.quick {
        true => (vec![Entry::fixture(), Entry::marschner_lobb(64)], &[256]),
        false => (entries(args), &[512, 1024]),
    };
    let mut report = Report::new(repeat);
    println!("{}", overview::HEADER);
    for entry in entries.iter().filter(|e| args.only.as_ref().is_none_or(|only| e.name.contains(only))) {
        let rows = entry.visit(overview::Overview { entry, sizes, repeat })??;
        report.overview.extend(rows);
    }
    if report.overview.is_empty() {
        bail!("no volume is named like {:?}", args.only.as_deref().unwrap_or_default());
    }
    report.save(&root().join(&args.json))
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
