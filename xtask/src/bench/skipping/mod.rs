//! What a picture does not need is not done: the same picture with every skip, and with the work done whose result nobody needs.
//!
//! There are no switches for this: where the renderer cannot do without a skip, what it leaves out is done here beside it. Every pair is checked to come to the same, bit for bit, and
//! so is what comes of the runs that are timed. Two kinds of pairs differ, within limits that are checked: pictures of volume rendering with a bound, which are within the bound of what is right and
//! so within twice the bound of each other ([`volumes`]), and a few points that a ray finds lit behind the surface that they lie on ([`shadows`]).
//! What a mesh leaves out of sight is in the tables of [`amr`](super::amr).

mod detail;
mod pages;
mod shadows;
mod surfaces;
mod volumes;

use anyhow::{Result, ensure};
use isoray_grid::Scalar;
use isoray_octree::OctreeVolume;
use isoray_render::Scene;
use serde::Serialize;

use super::papers::knoll2009::slices;
use super::picture::{Pictures, hits};
use crate::catalog::{Dense, DenseVisitor, Entry, Place};

/// One skip in one scene, on one thread.
#[derive(Debug, Serialize)]
pub(crate) struct SkippingRow {
    volume: String,
    scene: &'static str,
    /// What is left out.
    skip: &'static str,
    /// What times, and counts unless they tell otherwise, are of.
    per: Per,
    /// Time with the skip and without: of a frame, over its rays or points.
    ns: [f64; 2],
    /// Time without over time with it.
    gain: f64,
    counts: Vec<Counted>,
}

/// By what the time of a frame is divided.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
enum Per {
    Ray,
    /// A point of a surface, which is lit or not.
    Point,
}

/// Work that is counted.
#[derive(Clone, Copy, Debug, Serialize)]
struct Counted {
    what: &'static str,
    /// With the skip and without: for each ray or point, unless `what` tells otherwise.
    counts: [f64; 2],
}

/// Titles of the columns.
const HEADER: &str = "\nWhat is not needed is not done: time with each skip, and with that work done, one thread; the same pictures.
volume               scene                  left out                                |      ns  without   gain | of a ray or point; counts with and without";

/// What every part measures with.
#[derive(Clone, Copy, Debug)]
struct Setting<'a> {
    entry: &'a Entry,
    quick: bool,
    repeat: usize,
}

/// Volumes that are measured unless others are asked for.
const CHOSEN: [&str; 4] = ["tooth (fixture)", "turbulence 512", "heptane", "CT head"];

/// # Errors
/// Anything left out that changes a picture.
pub(crate) fn run(
    quick: bool,
    entries: &[Entry],
    only: Option<&str>,
    repeat: usize,
) -> Result<Vec<SkippingRow>> {
    println!("{HEADER}");
    let is_chosen = |entry: &&Entry| quick || only.is_some() || CHOSEN.contains(&entry.name.as_str());
    let mut rows = Vec::new();
    for entry in entries.iter().filter(is_chosen) {
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
        let octree = &volume.octree()?;
        let mut rows = surfaces::measure(setting, volume, octree)?;
        rows.extend(clipping(setting, volume, octree)?);
        rows.extend(shadows::measure(setting, volume, octree)?);
        rows.extend(volumes::measure(setting, volume)?);
        rows.extend(detail::measure(setting, volume, octree)?);
        rows.extend(pages::measure(setting, volume, octree)?);
        Ok(rows)
    }
}

impl Setting<'_> {
    /// Pixels along each side of a picture.
    fn size(&self, quick: u32, long: u32) -> u32 {
        if self.quick { quick } else { long }
    }

    /// The row of one skip: `what` is the scene and what is left out.
    fn row(
        &self,
        what: [&'static str; 2],
        per: Per,
        ns: [f64; 2],
        counts: &[(&'static str, [f64; 2])],
    ) -> SkippingRow {
        let [scene, skip] = what;
        let row = SkippingRow {
            volume: self.entry.name.clone(),
            scene,
            skip,
            per,
            ns,
            gain: ns[1] / ns[0],
            counts: counts.iter().map(|&(what, counts)| Counted { what, counts }).collect(),
        };
        let counted =
            row.counts.iter().map(|c| format!(" {} {:.2} {:.2};", c.what, c.counts[0], c.counts[1]));
        println!(
            "{:<20} {scene:<22} {skip:<39} | {:>7.1} {:>8.1} {:>6.2} |{}",
            row.volume,
            ns[0],
            ns[1],
            row.gain,
            counted.collect::<String>()
        );
        row
    }
}

impl SkippingRow {
    /// The same, if the first of its counts, which tells that something is left out, is smaller with the skip.
    fn spared(self) -> Result<Self> {
        let Self { volume, scene, skip, counts, .. } = &self;
        let is_less = counts.first().is_some_and(|Counted { counts: [with, without], .. }| with < without);
        ensure!(is_less, "{volume}, {scene}, {skip}: as much is done with it as without");
        Ok(self)
    }
}

/// Slices and cells that no ray of a packet needs (2009, sections 5.2 and 5.3), as measured beside that paper's Table 2.
fn clipping<T: Scalar + Into<f64>>(
    setting: Setting<'_>,
    volume: &Dense<T>,
    octree: &OctreeVolume<T>,
) -> Result<Vec<SkippingRow>> {
    let size = setting.size(64, 512);
    let (entry, repeat) = (setting.entry, setting.repeat);
    let isovalue = entry.isovalues[0];
    // That all show the picture of single rays is checked where they are measured.
    let picture = Pictures::new(octree).exact(&volume.camera(Place::Far, size)?, &Scene::of(isovalue));
    ensure!(hits(&picture) > 0, "{}, slabs: no ray hits", entry.name);
    let measure = slices::Measure { isovalue, size, repeat, lines: &slices::CLIPPING };
    let [without, slices, cells] = measure.visit(volume)?[..] else { anyhow::bail!("other lines") };
    let rays = f64::from(size).powi(2);
    let row = |skip, with: [f64; 3], without: [f64; 3]| {
        let of = |n: usize, unit: f64| [with[n], without[n]].map(|value| value / rays * unit);
        let counts = [("cells looked up", of(0, 1.0)), ("cells intersected", of(1, 1.0))];
        setting.row(["surface far, slabs", skip], Per::Ray, of(2, 1e9), &counts).spared()
    };
    Ok(vec![
        row("slices: blocks without surface", slices, without)?,
        row("cells: outside of active rays", cells, slices)?,
    ])
}
