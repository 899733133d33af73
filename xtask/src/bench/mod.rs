//! `cargo xtask bench`: measured figures, in ratios of one run.

mod amr;
mod baseline;
mod cell;
mod chart;
mod detail;
mod hashing;
mod kernels;
mod layout;
mod lod;
mod lossy;
mod normals;
mod orbit;
mod overview;
mod packet;
mod page;
mod papers;
mod picture;
mod recorded;
mod report;
mod robustness;
mod scaling;
mod shadows;
mod single;
mod skipping;
mod timer;
mod volume;

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::catalog::Entry;
use crate::root;
use baseline::Baseline;
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
    /// With scaling, a volume of 2048³ too: 9 GB of samples, 7 GB of memory; one more for the smaller ones beside it
    #[arg(long, conflicts_with = "quick")]
    large: bool,
    /// Only volumes whose name contains this
    #[arg(long)]
    only: Option<String>,
    /// Timed repetitions of each variant [default: 9, with --quick 3]
    #[arg(long)]
    repeat: Option<usize>,
    /// Replace the table of first-root finders in the documentation, and its chart, by what is measured
    #[arg(long)]
    docs: bool,
    /// Compare kernels with those of an earlier report, as `--save-baseline` keeps it; fails if one is slower beyond the noise, or finds something else
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Keep the report, and this program, for `--baseline` to compare with
    #[arg(long, value_name = "DIR", num_args = 0..=1, default_missing_value = "target/bench/baseline")]
    save_baseline: Option<PathBuf>,
    /// Where the JSON goes; the page for readers goes beside it, as .html
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
    /// Normals: time against error
    Normals,
    /// Volume rendering: time against error of every scheme, and what is missed
    Volume,
    /// Lossy compression: size against the displacement of surfaces
    Lossy,
    /// Levels of detail: to which side coarse surfaces are displaced, and how far
    Lod,
    /// Sizes in other layouts of nodes and caps
    Layout,
    /// Single rays: octree against grid, bricks and macrocells
    Single,
    /// Packets of rays against single ones
    Packet,
    /// Levels of detail in pictures: time against error
    Detail,
    /// Shadows and the sky through coarser levels: time against error
    Shadows,
    /// Frame times round a volume, at the finest level and at levels of detail
    Orbit,
    /// The papers' tables, and the figures of their texts, beside ours; with those of meshes
    Tables,
    /// Time against error, of everything that has both: all suites with charts
    TimeAgainstError,
    /// Adaptive meshes, and the tables of Marchesin and Colin de Verdière 2009
    Amr,
    /// Adaptive meshes against the oracle: hits, and time against error of every scheme
    AmrErrors,
    /// Finding samples in an octree, and their neighbours: the ways of the papers against ours
    Hashing,
    /// What a picture does not need, done and not done
    Skipping,
    /// How time grows with threads, pixels, samples and the cells of a surface
    Scaling,
    /// Adversarial inputs of every kind, a few
    Robustness,
    /// Short pieces of work, one for each part of the renderer, by which builds are compared
    Kernels,
}

impl Suite {
    /// What it stands for, besides itself.
    fn group(&self) -> &'static [Self] {
        match self {
            Self::Tables => &[Self::Amr],
            Self::TimeAgainstError => &[
                Self::Cell,
                Self::Normals,
                Self::Volume,
                Self::Lossy,
                Self::Detail,
                Self::Shadows,
                Self::AmrErrors,
            ],
            _ => &[],
        }
    }

    /// Whether it has volumes of its own that the others do not.
    fn has_volumes(&self) -> bool {
        matches!(
            self,
            Self::Volume
                | Self::Lossy
                | Self::Lod
                | Self::Layout
                | Self::Tables
                | Self::TimeAgainstError
                | Self::Amr
                | Self::AmrErrors
                | Self::Scaling
        )
    }
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let repeat = args.repeat.unwrap_or(if args.quick { 3 } else { 9 });
    let baseline = args.baseline.as_deref().map(|path| Baseline::open(&root().join(path))).transpose()?;
    let generated = [Entry::marschner_lobb(256), Entry::turbulence(512), Entry::mixing(512, 1.0, 125.0)];
    let (entries, sizes): (Vec<_>, &[u32]) = match args.quick {
        true => (vec![Entry::fixture(), Entry::marschner_lobb(64)], &[256]),
        false => (Entry::all(&generated, &root().join(&args.data)), &[512, 1024]),
    };
    let entries = match args.only.as_deref() {
        // Of those suites that choose volumes themselves.
        Some(only) if args.suites.iter().all(Suite::has_volumes) && !args.suites.is_empty() => {
            entries.into_iter().filter(|entry| entry.name.contains(only)).collect()
        }
        only => Entry::named_like(entries, only)?,
    };
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
    if args.runs(Suite::Normals) {
        report.normals = normals::run(args.quick, &entries, repeat)?;
    }
    if args.runs(Suite::Volume) {
        report.volume =
            volume::run(args.quick, args.docs, &root().join(&args.data), args.only.as_deref(), repeat)?;
    }
    if args.runs(Suite::Lossy) {
        report.lossy = lossy::run(args.quick, args.docs, &root().join(&args.data), args.only.as_deref())?;
    }
    if args.runs(Suite::Lod) {
        report.lod = lod::run(args.quick, args.docs, &root().join(&args.data), args.only.as_deref())?;
    }
    if args.runs(Suite::Layout) {
        report.layout = layout::run(args.quick, &entries, args.only.as_deref())?;
    }
    if args.runs(Suite::Single) {
        report.single = single::run(args.quick, &entries, repeat)?;
    }
    if args.runs(Suite::Packet) {
        println!("{}", packet::HEADER);
        for entry in &entries {
            report.packet.extend(entry.visit(packet::Packets { entry, sizes, repeat })??);
        }
    }
    if args.runs(Suite::Detail) {
        println!("{}", detail::HEADER);
        for entry in coarsened(args, &entries) {
            report.detail.extend(entry.visit(detail::Details { entry, sizes: &sizes[..1], repeat })??);
        }
    }
    if args.runs(Suite::Shadows) {
        println!("{}", shadows::HEADER);
        for entry in coarsened(args, &entries) {
            let size = sizes[0];
            report.shadows.extend(entry.visit(shadows::FarShadows { entry, size, repeat })??);
        }
    }
    if args.runs(Suite::Orbit) {
        println!("{}", orbit::HEADER);
        let frames = if args.quick { 36 } else { 360 };
        for entry in &entries {
            report.orbit.extend(entry.visit(orbit::Orbit { entry, size: sizes[0], frames })??);
        }
    }
    if args.runs(Suite::Tables) {
        let data = &root().join(&args.data);
        let only = args.only.as_deref();
        report.papers = papers::run(papers::Setting { data, quick: args.quick, only, repeat })?;
    }
    if args.runs(Suite::Amr) || args.runs(Suite::AmrErrors) {
        let sources = amr::sources(args.quick, &root().join(&args.data), args.only.as_deref());
        if args.runs(Suite::Amr) {
            amr::run(&mut report.amr, &sources, args.quick, repeat)?;
        }
        if args.runs(Suite::AmrErrors) {
            amr::errors(&mut report.amr, &sources, args.quick, repeat)?;
        }
    }
    if args.runs(Suite::Hashing) {
        report.hashing = hashing::run(args.quick, &entries, repeat)?;
    }
    if args.runs(Suite::Skipping) {
        report.skipping = skipping::run(args.quick, &entries, args.only.as_deref(), repeat)?;
    }
    if args.runs(Suite::Scaling) {
        let extent = scaling::Extent { quick: args.quick, is_large: args.large, repeat };
        report.scaling = scaling::run(extent, &entries, args.only.as_deref())?;
    }
    if args.runs(Suite::Robustness) {
        report.robustness = robustness::run(args.quick)?;
    }
    if args.runs(Suite::Kernels) || args.save_baseline.is_some() || baseline.is_some() {
        report.kernels = kernels::run(repeat)?;
    }
    if let Some(baseline) = baseline {
        report.comparison = baseline.compare(&report.kernels, args.quick)?;
    }
    report.save(&json)?;
    page::save(&json, &serde_json::to_value(&report).context("the report is no JSON")?)?;
    if let Some(folder) = &args.save_baseline {
        baseline::save(&json, &root().join(folder))?;
    }
    if let Some(set) = report.cell.first().map(|row| row.set.clone()) {
        let rows: Vec<_> = report.cell.iter().filter(|row| row.set == set).collect();
        let chart = json.with_file_name("cell.svg");
        cell::chart(&rows, &chart)?;
        if args.docs {
            fs::copy(&chart, root().join("docs/pictures/cell.svg")).context("cannot replace the chart")?;
            fs::write(root().join("crates/cell/methods.md"), cell::markdown(&report.cell, &report.machine()))
                .context("cannot replace the table")?;
        }
    }
    robustness::judge(&report.robustness)?;
    baseline::judge(&report.comparison)
}

impl Args {
    fn runs(&self, suite: Suite) -> bool {
        self.suites.is_empty()
            || self.suites.iter().any(|chosen| *chosen == suite || chosen.group().contains(&suite))
    }
}

/// Cells of two volumes, the first real ones there are, and random ones; with `--quick` those of one.
/// What suites of levels of detail look at, unless one volume is asked for: each takes them some minutes.
fn coarsened<'e>(args: &Args, entries: &'e [Entry]) -> impl Iterator<Item = &'e Entry> {
    const NAMES: [&str; 4] = ["tooth (fixture)", "turbulence 512", "heptane", "CT head"];
    let is_all = args.quick || args.only.is_some();
    entries.iter().filter(move |entry| is_all || NAMES.contains(&entry.name.as_str()))
}

fn cell_suite(args: &Args, entries: &[Entry], repeat: usize) -> Result<Vec<cell::CellRow>> {
    let real = entries.iter().filter(|e| e.is_real()).take(if args.quick { 1 } else { 2 });
    let mut sets = Vec::new();
    for entry in real {
        sets.extend(entry.visit(cell::Collect(entry))??);
    }
    sets.extend(cell::random_sets()?);
    println!("\n{}", cell::HEADER);
    let mut rows = Vec::new();
    for set in &sets {
        rows.extend(cell::measure(set, repeat)?);
    }
    Ok(rows)
}
