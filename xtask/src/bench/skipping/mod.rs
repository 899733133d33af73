//! What a picture does not need is not done: the same picture with every skip, and with the work done whose result nobody needs.
//!
//! There are no switches for this: where the renderer cannot do without a skip, what it leaves out is done here beside it. Every pair is checked to come to the same.
//! What a mesh leaves out of sight is in the tables of [`amr`](super::amr).

mod detail;
mod pages;
mod shadows;
mod surfaces;
mod volumes;

use anyhow::Result;
use isoray_grid::Scalar;
use serde::Serialize;

use super::papers::knoll2009::slices;
use crate::catalog::{Dense, DenseVisitor, Entry};

/// One skip in one scene, on one thread.
#[derive(Debug, Serialize)]
pub(crate) struct SkippingRow {
    volume: String,
    scene: &'static str,
    /// What is left out.
    skip: &'static str,
    /// Time with the skip and without: of a frame over its rays.
    ns_per_ray: [f64; 2],
    /// Time without over time with it.
    gain: f64,
    counts: Vec<Counted>,
}

/// Work that is counted.
#[derive(Clone, Copy, Debug, Serialize)]
struct Counted {
    what: &'static str,
    /// With the skip and without: for each ray, unless `what` tells otherwise.
    counts: [f64; 2],
}

/// Titles of the columns.
const HEADER: &str = "\nWhat is not needed is not done: time with each skip, and with that work done, one thread; the same pictures.
volume               scene                  left out                                |  ns/ray  without   gain | counts with and without";

/// What every part measures with.
#[derive(Clone, Copy, Debug)]
struct Setting<'a> {
    entry: &'a Entry,
    quick: bool,
    repeat: usize,
}

/// Volumes that the longer parts are run on.
const CHOSEN: [&str; 4] = ["tooth (fixture)", "turbulence 512", "heptane", "CT head"];

/// # Errors
/// Anything left out that changes a picture.
pub(crate) fn run(quick: bool, entries: &[Entry], repeat: usize) -> Result<Vec<SkippingRow>> {
    println!("{HEADER}");
    let mut rows = Vec::new();
    for entry in entries.iter().filter(|entry| quick || CHOSEN.contains(&entry.name.as_str())) {
        rows.extend(entry.visit(All(Setting { entry, quick, repeat }))??);
    }
    Ok(rows)
}

/// Every part, on one volume.
struct All<'a>(Setting<'a>);

impl DenseVisitor for All<'_> {
    type Output = Result<Vec<SkippingRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let Self(setting) = self;
        let mut rows = surfaces::Surfaces(setting).visit(volume)?;
        rows.extend(clipping(setting, volume)?);
        rows.extend(shadows::Shadows(setting).visit(volume)?);
        rows.extend(volumes::Volumes(setting).visit(volume)?);
        rows.extend(detail::Levels(setting).visit(volume)?);
        rows.extend(pages::Pages(setting).visit(volume)?);
        Ok(rows)
    }
}

impl Setting<'_> {
    /// Pixels along each side of a picture.
    fn size(&self, quick: u32, long: u32) -> u32 {
        if self.quick { quick } else { long }
    }

    /// The row of one skip.
    fn row(
        &self,
        scene: &'static str,
        skip: &'static str,
        ns_per_ray: [f64; 2],
        counts: &[(&'static str, [f64; 2])],
    ) -> SkippingRow {
        let row = SkippingRow {
            volume: self.entry.name.clone(),
            scene,
            skip,
            ns_per_ray,
            gain: ns_per_ray[1] / ns_per_ray[0],
            counts: counts.iter().map(|&(what, counts)| Counted { what, counts }).collect(),
        };
        let counted =
            row.counts.iter().map(|c| format!(" {} {:.2} {:.2};", c.what, c.counts[0], c.counts[1]));
        println!(
            "{:<20} {scene:<22} {skip:<39} | {:>7.1} {:>8.1} {:>6.2} |{}",
            row.volume,
            ns_per_ray[0],
            ns_per_ray[1],
            row.gain,
            counted.collect::<String>()
        );
        row
    }
}

/// Slices and cells that no ray of a packet needs (2009, sections 5.2 and 5.3), as measured beside that paper's Table 2.
fn clipping<T: Scalar + Into<f64>>(setting: Setting<'_>, volume: &Dense<T>) -> Result<Vec<SkippingRow>> {
    let size = setting.size(64, 512);
    let (entry, repeat) = (setting.entry, setting.repeat);
    let measure = slices::Measure { isovalue: entry.isovalues[0], size, repeat, lines: &slices::CLIPPING };
    let [without, slices, cells] = measure.visit(volume)?[..] else { anyhow::bail!("other lines") };
    let rays = f64::from(size).powi(2);
    let row = |skip, with: [f64; 3], without: [f64; 3]| {
        let of = |n: usize, unit: f64| [with[n], without[n]].map(|value| value / rays * unit);
        let counts = [("cells looked up", of(0, 1.0)), ("cells intersected", of(1, 1.0))];
        setting.row("surface far, slabs", skip, of(2, 1e9), &counts)
    };
    Ok(vec![
        row("slices: blocks without surface", slices, without),
        row("cells: outside of active rays", cells, slices),
    ])
}
