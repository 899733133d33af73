//! Knoll, Wald, Parker and Hansen 2006 ("Interactive Isosurface Ray Tracing of Large Octree Volumes"): Tables 1 to 4, Figure 9, and the figures of the text. With Table 1 of Knoll, Wald and Hansen 2009, which is theirs with a femur.
//!
//! Of their data only the heptane fire can be had, at one time step, and a head of the same kind; a mixing layer stands in for the Richtmyer-Meshkov instability (LLNL, 2048 × 2048 × 1920).

mod frames;
mod sizes;

use anyhow::Result;

use super::{Figure, PaperRow, Setting, print, print_titles};
use crate::bench::single::Structures;
use crate::catalog::Entry;

const HEADER: &str = "\nKnoll, Wald, Parker and Hansen 2006 beside ours: paper, ours, ours over the paper's. Theirs: Core Duo 2.16 GHz (2 cores), 16 cores of Opteron 2.4 GHz (NUMA).
Frames/s are of as many rays as their pictures have, on one core. Single rays are their method; the tracer chooses packets where they are faster; the recursion of 2006 is theirs, on its own nodes, as published.
Sizes are in % of the samples alone: of the whole file, and of the nodes of 2006. Table 1 of 2009 has those of 2006 once more, and the Visible Female's femur, of which bone alone too;
in its place stands a head of a like scan, or the bundled tooth.";

/// A scene of theirs, and what stands in for it.
struct Step {
    scene: &'static str,
    entry: Entry,
}

/// Table 3: frames a second far and close; of 512² on the Core Duo and on the Opteron, of 1024² on the latter.
const LLNL: [(&str, f64, [[f64; 3]; 2]); 3] = [
    ("RM 50", 50.0 / 270.0, [[3.6, 25.8, 7.4], [2.1, 15.4, 4.3]]),
    ("RM 150", 150.0 / 270.0, [[2.8, 20.0, 5.7], [1.8, 14.2, 3.6]]),
    ("RM 270", 1.0, [[2.4, 17.5, 4.7], [1.7, 13.6, 3.5]]),
];
/// The isovalue of the fire, and of what stands in for it.
const FIRE: f32 = 42.0;
/// Table 4, of one view of each time step of the fire.
const HEPTANE: [(&str, f64, [f64; 3]); 6] = [
    ("HEP 25", 25.0 / 150.0, [17.0, 87.1, 29.2]),
    ("HEP 50", 50.0 / 150.0, [11.1, 60.3, 18.0]),
    ("HEP 75", 75.0 / 150.0, [5.7, 36.7, 9.6]),
    ("HEP 100", 100.0 / 150.0, [4.1, 26.6, 6.6]),
    ("HEP 125", 125.0 / 150.0, [3.5, 28.0, 7.1]),
    ("HEP 150", 1.0, [3.2, 23.1, 6.3]),
];
/// Table 2: frames a second, and the structures of ours that are of the same kind, or the very same.
const STRUCTURES: [(&str, f64); 5] = [
    ("grid of five levels, array", 18.9),
    ("grid of five levels, octree data", 8.0),
    ("2006 octree, array", 15.7),
    ("2006 octree, its own data", 17.5),
    ("octree, octree data", 17.5),
];

pub(super) fn run(setting: Setting<'_>) -> Result<Vec<PaperRow>> {
    println!("{HEADER}");
    let [edge, fire_edge] = if setting.quick { [64, 64] } else { [512, 302] };
    let llnl: Vec<(Step, [[f64; 3]; 2])> = LLNL
        .iter()
        .map(|&(scene, time, paper)| (Step { scene, entry: Entry::mixing(edge, time, 20.0) }, paper))
        .collect();
    // The fire itself, which is one of the last steps, after what stands in for all of them.
    let heptane = setting.heptane().map(|entry| (Step { scene: HEPTANE[5].0, entry }, HEPTANE[5].2));
    let fire: Vec<(Step, [f64; 3])> = HEPTANE
        .iter()
        .map(|&(scene, time, paper)| (Step { scene, entry: Entry::mixing(fire_edge, time, FIRE) }, paper))
        .chain(heptane)
        .collect();
    let has = |step: &Step| setting.has(&step.entry);
    let mut rows = sizes::run(setting, llnl.iter().map(|(step, _)| step), fire_edge)?;
    let last = &llnl[llnl.len() - 1].0;
    if has(last) {
        rows.extend(structures(setting, last)?);
    }
    print_titles("theirs on", &["single rays", "as the tracer chooses", "recursion of 2006"]);
    for (step, paper) in llnl.iter().filter(|(step, _)| has(step)) {
        rows.extend(frames::rates(setting, "2006, Table 3", step, paper)?);
    }
    for (step, paper) in fire.iter().filter(|(step, _)| has(step)) {
        rows.extend(frames::rates(setting, "2006, Table 4", step, &[*paper])?);
    }
    if has(last) {
        rows.extend(frames::efficiency(setting, last)?);
    }
    Ok(rows)
}

/// Table 2.
fn structures(setting: Setting<'_>, step: &Step) -> Result<Vec<PaperRow>> {
    let size = if setting.quick { 64 } else { 512 };
    let measured = step.entry.visit(Structures { entry: &step.entry, size, repeat: setting.repeat })??;
    print_titles("structure, data", &["frames/s a core", "x grid, array"]);
    let far = |structure: &str| {
        let found = measured.iter().find(|row| row.view == "far" && row.structure == structure);
        found.map_or(f64::NAN, |row| 1e9 / (row.ns_per_ray * 512.0 * 512.0))
    };
    let (reference, paper_reference) = STRUCTURES[0];
    let of = |(structure, paper): (&str, f64)| {
        let figures = vec![
            figure("frames/s a core", paper / 16.0, far(structure)),
            figure("x grid, array", paper / paper_reference, far(structure) / far(reference)),
        ];
        let row =
            PaperRow { variant: structure.to_owned(), figures, ..row("2006, Table 2", step, "far", size) };
        print(&row);
        row
    };
    Ok(STRUCTURES.into_iter().map(of).collect())
}

fn figure(what: &'static str, paper: f64, ours: f64) -> Figure {
    Figure { what, paper, ours }
}

fn row(place: &'static str, step: &Step, view: &'static str, size: u32) -> PaperRow {
    PaperRow {
        place,
        hardware: "Core Duo 2.16 GHz; Opteron 2.4 GHz",
        scene: step.scene,
        volume: step.entry.name.clone(),
        isovalue: step.entry.isovalues[0],
        view,
        size,
        variant: String::new(),
        figures: Vec::new(),
    }
}
