//! The figures of papers beside ours of the same kind.
//!
//! Their machines are long gone and most of their data cannot be had, so that the third number, ours over theirs, says more about twenty years of processors
//! than about methods; how many times as fast one way is as another, on one machine, is what can be compared.

mod knoll2006;
pub(super) mod knoll2009;
mod parker1998;

use std::path::Path;

use anyhow::Result;
use isoray_grid::BrickSizes;
use serde::Serialize;

use crate::catalog::Entry;

/// The bricks of 1998: 4³ samples of two bytes are a cache line, 5³ of them a page.
const PARKER_BRICKS: BrickSizes = BrickSizes { brick: 4, macrobrick: 5 };

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
    /// Where they stand: the year, and the table, figure or section.
    place: &'static str,
    hardware: &'static str,
    scene: &'static str,
    /// What stands in for the scene.
    volume: String,
    isovalue: f32,
    view: &'static str,
    /// Pixels along each side, of ours; 0 where there is no picture.
    size: u32,
    variant: String,
    figures: Vec<Figure>,
}

/// Where measurements are made.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a> {
    pub(super) data: &'a Path,
    pub(super) quick: bool,
    pub(super) only: Option<&'a str>,
    pub(super) repeat: usize,
}

/// # Errors
/// Anything that is timed and finds something else than it must.
pub(super) fn run(setting: Setting<'_>) -> Result<Vec<PaperRow>> {
    let mut rows = parker1998::run(setting)?;
    rows.extend(knoll2006::run(setting)?);
    rows.extend(knoll2009::run(setting)?);
    Ok(rows)
}

impl Setting<'_> {
    fn has(&self, entry: &Entry) -> bool {
        self.only.is_none_or(|only| entry.name.contains(only))
    }

    /// A real volume, if it is there and there is time for it.
    fn real(&self, name: &str) -> Option<Entry> {
        let is_there = !self.quick && self.data.is_dir();
        let mut real = if is_there { Entry::real(self.data) } else { Vec::new() }.into_iter();
        real.find(|entry| entry.name == name)
    }

    /// The heptane fire, one of the papers' own scenes.
    fn heptane(&self) -> Option<Entry> {
        self.real("heptane")
    }
}

/// The time of a picture with as many rays as those of the papers, 512 × 512, of that of one of ours.
fn of_all_rays(seconds: f64, size: u32) -> f64 {
    seconds * (512.0 / f64::from(size)).powi(2)
}

/// Titles of columns.
fn print_titles(variants: &str, figures: &[&str]) {
    let titles: String = figures.iter().map(|what| format!(" | {what:<23}")).collect();
    println!(
        "\n{:<15} {:<15} {:<22} {:<5} {:>4} {variants:<36}{titles}",
        "paper", "scene", "ours", "view", "size"
    );
}

fn print(row: &PaperRow) {
    let figures = row.figures.iter().map(|figure| {
        let Figure { paper, ours, .. } = figure;
        // The paper has no such figure.
        let [of_paper, times] = match paper.is_nan() {
            true => ["-".to_owned(), "-".to_owned()],
            false => [format!("{paper:.3}"), format!("{:.2}", ours / paper)],
        };
        format!(" | {of_paper:>7} {ours:>7.3} {times:>7}")
    });
    let figures: String = figures.collect();
    println!(
        "{:<15} {:<15} {:<22} {:<5} {:>4} {:<36}{figures}",
        row.place, row.scene, row.volume, row.view, row.size, row.variant
    );
}
