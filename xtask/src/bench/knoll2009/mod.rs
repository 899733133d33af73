//! The figures of Knoll, Wald and Hansen 2009 (Coherent Multiresolution Isosurface Ray Tracing) beside ours of the same kind, on one thread.
//!
//! Their machines are long gone and most of their data cannot be had, so that the third number, ours over theirs, says more about twenty years of processors
//! than about methods; how many times as fast one traversal is as another, on one machine, is what can be compared.
//!
//! That no more than 5 to 15 % of the time goes into traversal (section 8.2) is left out too: packets do both in one loop. For single rays `cargo xtask bench single` has it.

mod frames;
mod packets;
pub(super) mod slices;

use std::path::Path;

use anyhow::Result;
use serde::Serialize;

use crate::catalog::Entry;

/// What the paper measured on.
const HEADER: &str = "\nKnoll, Wald and Hansen 2009 beside ours, one thread: paper, ours, ours over the paper's.
Theirs: Core Duo 2.16 GHz (laptop, 2 cores), 8 cores of Xeon 3 GHz. Frames/s are of as many rays as their pictures have, and Table 4's a core.
Scenes: HEP64 and HEP302 are a heptane fire of 64^3 and 302^3, RM the Richtmyer-Meshkov instability, 2048^2 x 1920, at a time step.
Of Figures 11 and 12 the text says that frame rates are 15 to 30 % lower with central normals and 20 to 30 % with shadows, theirs through a coarser level than the picture, ours exact.
Of 1024x1024 for 512x512 it says twice as long or better, with packets; in Table 4 it is 2.8 to 5.6 times.";

/// A figure of the paper's, and ours.
#[derive(Clone, Copy, Debug, Serialize)]
struct Figure {
    what: &'static str,
    /// NaN where the paper has none; null in JSON.
    paper: f64,
    ours: f64,
}

/// Figures that belong together.
#[derive(Debug, Serialize)]
pub(crate) struct PaperRow {
    /// Where they stand in the paper.
    place: &'static str,
    hardware: &'static str,
    scene: &'static str,
    /// What stands in for the scene.
    volume: String,
    isovalue: f32,
    view: &'static str,
    /// Pixels along each side, of ours.
    size: u32,
    variant: &'static str,
    figures: Vec<Figure>,
}

/// Where measurements are made.
#[derive(Clone, Copy)]
struct Setting<'a> {
    data: &'a Path,
    quick: bool,
    repeat: usize,
}

pub(crate) fn run(quick: bool, data: &Path, only: Option<&str>, repeat: usize) -> Result<Vec<PaperRow>> {
    let setting = Setting { data, quick, repeat };
    let is_chosen = |entry: &Entry| only.is_none_or(|only| entry.name.contains(only));
    println!("{HEADER}");
    let mut rows = slices::run(setting, is_chosen)?;
    rows.extend(packets::run(setting, is_chosen)?);
    rows.extend(frames::run(setting, is_chosen)?);
    Ok(rows)
}

impl Setting<'_> {
    /// The heptane fire, one of the paper's own scenes, if it is there and there is time for it.
    fn heptane(&self) -> Option<Entry> {
        let is_there = !self.quick && self.data.is_dir();
        let mut real = if is_there { Entry::real(self.data) } else { Vec::new() }.into_iter();
        real.find(|entry| entry.name == "heptane")
    }
}

/// Titles of columns.
fn print_titles(variants: &str, figures: &[&str]) {
    let titles: String = figures.iter().map(|what| format!(" | {what:<23}")).collect();
    println!(
        "\n{:<9} {:<6} {:<22} {:<5} {:>4} {variants:<36}{titles}",
        "paper", "scene", "ours", "view", "size"
    );
}

fn print(row: &PaperRow) {
    let figures = row.figures.iter().map(|figure| {
        let Figure { paper, ours, .. } = figure;
        format!(" | {paper:>7.3} {ours:>7.3} {:>7.2}", ours / paper)
    });
    let figures: String = figures.collect();
    println!(
        "{:<9} {:<6} {:<22} {:<5} {:>4} {:<36}{figures}",
        row.place, row.scene, row.volume, row.view, row.size, row.variant
    );
}
