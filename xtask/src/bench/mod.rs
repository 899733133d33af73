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
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::builder::RangedU64ValueParser;

use crate::catalog::{Entry, data_folder};
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
    /// Folder of real volumes; of the ones that are known those that are there are measured, and the others named [default: ../shared/data, if there is one]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// With scaling, a volume of 2048³ too: 9 GB of samples, 7 GB of memory; one more for the smaller ones beside it
    #[arg(long, conflicts_with = "quick")]
    large: bool,
    /// Only volumes whose name contains this
    #[arg(long)]
    only: Option<String>,
    /// Timed repetitions of each variant, at least one [default: 9, with --quick 3]
    #[arg(long, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    repeat: Option<usize>,
    /// Replace charts of the documentation, and the table of first-root finders, by what is measured: by cell, volume, lossy and lod
    #[arg(long, conflicts_with_all = ["quick", "only"])]
    docs: bool,
    /// Compare kernels with those of an earlier report, as `--save-baseline` keeps it; fails if one is slower beyond the noise, or finds something else
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Keep the report, and this program, for `--baseline` to compare with [default: target/bench/baseline]
    #[arg(long, value_name = "DIR", num_args = 0..=1, require_equals = true, default_missing_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/bench/baseline"))]
    save_baseline: Option<PathBuf>,
    /// Where the JSON goes; the page for readers goes beside it, as .html [default: target/bench/report.json]
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
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
    ensure!(
        !args.large || args.runs(Suite::Scaling),
        "--large: expected scaling among the suites, found others"
    );
    let baseline = args.baseline.as_deref().map(Baseline::open).transpose()?;
    let asked = Asked::new(args)?;
    let mut report = Report::new(asked.repeat);
    // What was measured before a suite fails is kept; where that is nothing, so is the report that there was.
    let mut measured = surfaces(&asked, &mut report).and_then(|()| scenes(&asked, &mut report));
    if measured.is_ok() && (args.runs(Suite::Kernels) || args.save_baseline.is_some() || baseline.is_some()) {
        measured = kernels::run(asked.repeat).map(|rows| report.kernels = rows);
    }
    if let (Some(baseline), Ok(())) = (baseline, &measured) {
        measured = baseline.compare(&report.kernels, args.quick).map(|compared| report.comparison = compared);
    }
    let json = args.json.clone().unwrap_or_else(|| root().join("target/bench/report.json"));
    let value = serde_json::to_value(&report).context("the report is no JSON")?;
    if let Some(only) = args.only.as_deref().filter(|_| measured.is_ok() && args.is_of_volumes()) {
        ensure!(report::has_volumes(&value), "--only {only:?}: no volume of these suites is named like that");
    }
    if report::has_rows(&value) {
        report.save(&json)?;
        page::save(&json, &value)?;
    }
    measured?;
    if let Some(folder) = &args.save_baseline {
        baseline::save(&json, folder)?;
    }
    chart_of_cells(args, &report, &json)?;
    robustness::judge(&report.robustness)?;
    baseline::judge(&report.comparison)
}

/// What is asked for, and the volumes that it is asked of.
struct Asked<'a> {
    args: &'a Args,
    data: PathBuf,
    entries: Vec<Entry>,
    /// Pixels along each side.
    sizes: &'static [u32],
    repeat: usize,
}

impl<'a> Asked<'a> {
    fn new(args: &'a Args) -> Result<Self> {
        let repeat = args.repeat.unwrap_or(if args.quick { 3 } else { 9 });
        let data = data_folder(args.data.as_deref())?;
        let generated = [Entry::marschner_lobb(256), Entry::turbulence(512), Entry::mixing(512, 1.0, 125.0)];
        let (entries, sizes): (Vec<_>, &[u32]) = match args.quick {
            true => (vec![Entry::fixture(), Entry::marschner_lobb(64)], &[256]),
            false => {
                Entry::tell_missing(&data);
                (Entry::all(&generated, &data), &[512, 1024])
            }
        };
        let entries = match args.only.as_deref() {
            // Of those suites that choose volumes themselves.
            Some(only) if args.is_of_volumes() => {
                entries.into_iter().filter(|entry| entry.name.contains(only)).collect()
            }
            only => Entry::named_like(entries, only)?,
        };
        Ok(Self { args, data, entries, sizes, repeat })
    }

    fn only(&self) -> Option<&'a str> {
        self.args.only.as_deref()
    }

    /// What suites of levels of detail look at, unless one volume is asked for: each takes them some minutes.
    fn coarsened(&self) -> impl Iterator<Item = &Entry> {
        const NAMES: [&str; 4] = ["tooth (fixture)", "turbulence 512", "heptane", "CT head"];
        let is_all = self.args.quick || self.args.only.is_some();
        self.entries.iter().filter(move |entry| is_all || NAMES.contains(&entry.name.as_str()))
    }
}

/// Suites of cells, sizes, single isosurfaces and integration.
fn surfaces(asked: &Asked<'_>, report: &mut Report) -> Result<()> {
    let Asked { args, data, entries, sizes, repeat } = asked;
    let (quick, sizes, repeat) = (args.quick, *sizes, *repeat);
    if args.runs(Suite::Overview) {
        println!("{}", overview::HEADER);
        for entry in entries {
            report.overview.extend(entry.visit(overview::Overview { entry, sizes, repeat })??);
        }
    }
    if args.runs(Suite::Cell) {
        report.cell = cell_suite(asked)?;
    }
    if args.runs(Suite::Normals) {
        report.normals = normals::run(quick, entries, repeat)?;
    }
    if args.runs(Suite::Volume) {
        report.volume = volume::run(quick, args.docs, data, asked.only(), repeat)?;
    }
    if args.runs(Suite::Lossy) {
        report.lossy = lossy::run(quick, args.docs, data, asked.only())?;
    }
    if args.runs(Suite::Lod) {
        report.lod = lod::run(quick, args.docs, data, asked.only())?;
    }
    if args.runs(Suite::Layout) {
        report.layout = layout::run(quick, entries, asked.only())?;
    }
    if args.runs(Suite::Single) {
        report.single = single::run(quick, entries, repeat)?;
    }
    if args.runs(Suite::Packet) {
        println!("{}", packet::HEADER);
        for entry in entries {
            report.packet.extend(entry.visit(packet::Packets { entry, sizes, repeat })??);
        }
    }
    Ok(())
}

/// Suites of levels of detail, of the papers, of meshes, and of what is not done.
fn scenes(asked: &Asked<'_>, report: &mut Report) -> Result<()> {
    let Asked { args, data, entries, sizes, repeat } = asked;
    let (quick, sizes, repeat) = (args.quick, *sizes, *repeat);
    if args.runs(Suite::Detail) {
        println!("{}", detail::HEADER);
        for entry in asked.coarsened() {
            report.detail.extend(entry.visit(detail::Details { entry, sizes: &sizes[..1], repeat })??);
        }
    }
    if args.runs(Suite::Shadows) {
        println!("{}", shadows::HEADER);
        for entry in asked.coarsened() {
            report.shadows.extend(entry.visit(shadows::FarShadows { entry, size: sizes[0], repeat })??);
        }
    }
    if args.runs(Suite::Orbit) {
        println!("{}", orbit::HEADER);
        let frames = if quick { 36 } else { 360 };
        for entry in entries {
            report.orbit.extend(entry.visit(orbit::Orbit { entry, size: sizes[0], frames })??);
        }
    }
    if args.runs(Suite::Tables) {
        report.papers = papers::run(papers::Setting { data, quick, only: asked.only(), repeat })?;
    }
    if args.runs(Suite::Amr) || args.runs(Suite::AmrErrors) {
        let sources = amr::sources(quick, data, asked.only());
        if args.runs(Suite::Amr) {
            amr::run(&mut report.amr, &sources, quick, repeat)?;
        }
        if args.runs(Suite::AmrErrors) {
            amr::errors(&mut report.amr, &sources, quick, repeat)?;
        }
    }
    if args.runs(Suite::Hashing) {
        report.hashing = hashing::run(quick, entries, repeat)?;
    }
    if args.runs(Suite::Skipping) {
        report.skipping = skipping::run(quick, entries, asked.only(), repeat)?;
    }
    if args.runs(Suite::Scaling) {
        let extent = scaling::Extent { quick, is_large: args.large, repeat };
        report.scaling = scaling::run(extent, entries, asked.only())?;
    }
    if args.runs(Suite::Robustness) {
        report.robustness = robustness::run(quick)?;
    }
    Ok(())
}

/// That of the first set of cells, beside the report and, if asked for, in the documentation with the table of all.
fn chart_of_cells(args: &Args, report: &Report, json: &Path) -> Result<()> {
    let Some(first) = report.cell.first() else { return Ok(()) };
    let rows: Vec<_> = report.cell.iter().filter(|row| row.set == first.set).collect();
    let chart = json.with_file_name("cell.svg");
    cell::chart(&rows, &chart)?;
    if args.docs {
        fs::copy(&chart, root().join("docs/pictures/cell.svg")).context("cannot replace the chart")?;
        fs::write(root().join("crates/cell/methods.md"), cell::markdown(&report.cell, &report.machine()))
            .context("cannot replace the table")?;
    }
    Ok(())
}

impl Args {
    /// Whether suites are chosen that all have volumes of their own.
    fn is_of_volumes(&self) -> bool {
        !self.suites.is_empty() && self.suites.iter().all(Suite::has_volumes)
    }

    fn runs(&self, suite: Suite) -> bool {
        self.suites.is_empty()
            || self.suites.iter().any(|chosen| *chosen == suite || chosen.group().contains(&suite))
    }
}

/// Cells of two volumes, the first real ones there are, and random ones; with `--quick` those of one.
fn cell_suite(asked: &Asked<'_>) -> Result<Vec<cell::CellRow>> {
    let real = asked.entries.iter().filter(|e| e.is_real()).take(if asked.args.quick { 1 } else { 2 });
    let mut sets = Vec::new();
    for entry in real {
        sets.extend(entry.visit(cell::Collect(entry))??);
    }
    sets.extend(cell::random_sets()?);
    println!("\n{}", cell::HEADER);
    let mut rows = Vec::new();
    for set in &sets {
        rows.extend(cell::measure(set, asked.repeat)?);
    }
    Ok(rows)
}
