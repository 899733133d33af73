//! Table 3: frame rates and intersections by the size of packets, without levels of detail.

use std::cell::RefCell;

use anyhow::{Result, ensure};
use glam::DAffine3;
use isoray_benches::views::View;
use isoray_grid::{Dims, Scalar};
use isoray_packet::{PacketTracer, Slicing, Traversal};
use isoray_trace::Tracer;

use crate::bench::overview::single_frame;
use crate::bench::packet::{compare, packet_frame};
use crate::bench::papers::{Figure, PaperRow, Setting, print, print_titles};
use crate::bench::recorded::Found;
use crate::bench::single::count;
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry};

const PLACE: &str = "2009, Table 3";
const HARDWARE: &str = "Core Duo 2.16 GHz, 1 core, 512x512";
/// Rays of their pictures.
const RAYS: f64 = 512.0 * 512.0;

/// Ways to trace, and which line of the table tells of it.
const VARIANTS: [(&str, Traversal, u32, usize); 10] = [
    ("single", Traversal::Single, 1, 0),
    ("2x2", Traversal::Masked, 2, 1),
    ("4x4", Traversal::Masked, 4, 2),
    ("8x8", Traversal::Masked, 8, 3),
    ("16x16", Traversal::Masked, 16, 4),
    ("2x2, by slabs", Traversal::Coherent(Slicing::Mixed), 2, 1),
    ("4x4, by slabs", Traversal::Coherent(Slicing::Mixed), 4, 2),
    ("8x8, by slabs", Traversal::Coherent(Slicing::Mixed), 8, 3),
    ("16x16, by slabs", Traversal::Coherent(Slicing::Mixed), 16, 4),
    ("8x8; ours: as the tracer chooses", Traversal::Auto, 8, 3),
];

/// Columns of the table: intersections a ray and frames a second, of single rays and packets from 2x2 to 16x16.
struct Scene {
    name: &'static str,
    cells: [f64; 5],
    rate: [f64; 5],
}

const HEP64: Scene =
    Scene { name: "HEP64", cells: [0.70, 0.26, 0.11, 0.058, 0.041], rate: [1.9, 4.3, 9.7, 14.4, 14.5] };
const HEP302: Scene =
    Scene { name: "HEP302", cells: [0.64, 0.5, 0.45, 0.47, 0.50], rate: [2.3, 2.84, 4.54, 4.6, 2.81] };
const RM: Scene =
    Scene { name: "RM", cells: [3.58, 5.65, 7.94, 12.4, 20.5], rate: [0.57, 0.38, 0.33, 0.22, 0.08] };

/// A scene, and what stands in for it: a volume, thinned out to so many samples a side, in a picture of some size.
struct Pair {
    scene: &'static Scene,
    entry: Entry,
    edge: Option<u32>,
    size: u32,
}

pub(super) fn run(setting: Setting<'_>) -> Result<Vec<PaperRow>> {
    let size = if setting.quick { 128 } else { 512 };
    let pair = |scene, entry, size| Pair { scene, entry, edge: None, size };
    let large = Entry::turbulence(if setting.quick { 128 } else { 512 });
    let [small, medium] = match setting.heptane() {
        Some(heptane) => {
            [Pair { edge: Some(64), ..pair(&HEP64, heptane.clone(), size) }, pair(&HEP302, heptane, size)]
        }
        None => {
            let medium = if setting.quick { Entry::fixture() } else { Entry::marschner_lobb(256) };
            [pair(&HEP64, Entry::marschner_lobb(64), size), pair(&HEP302, medium, size)]
        }
    };
    // The second of the large ones with rays as many voxels apart as theirs, of whose volume ours has a quarter of the side.
    let pairs = [small, medium, pair(&RM, large.clone(), size), pair(&RM, large, size / 4)];
    print_titles("packets", &["frames/s", "x single", "intersections/ray"]);
    let mut rows = Vec::new();
    for pair in pairs.iter().filter(|pair| setting.has(&pair.entry)) {
        rows.extend(pair.entry.visit(Measure { pair, repeat: setting.repeat })??);
    }
    Ok(rows)
}

struct Measure<'a> {
    pair: &'a Pair,
    repeat: usize,
}

impl DenseVisitor for Measure<'_> {
    type Output = Result<Vec<PaperRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        match self.pair.edge {
            Some(edge) => self.rows(&thinned(volume, edge)?),
            None => self.rows(volume),
        }
    }
}

impl Measure<'_> {
    fn rows<T: Scalar + Into<f64>>(&self, volume: &Dense<T>) -> Result<Vec<PaperRow>> {
        let octree = volume.octree()?;
        let octree = octree.view();
        let view = View::far(volume.dims, self.pair.size, self.pair.size);
        let isovalue = self.pair.entry.isovalues[0];
        let (mut single, mut tracer) = (Tracer::new(&octree), PacketTracer::new(&octree));
        let mut cells = Vec::new();
        for (_, traversal, edge, _) in VARIANTS {
            // Theirs are intersections of a cell with a packet, whatever its size.
            cells.push(match traversal {
                Traversal::Single => count(&mut single, &view, isovalue).cells,
                _ => compare(&mut tracer, &mut single, &view, isovalue, edge, traversal)?.packet_cells,
            });
        }
        let (single, tracer) = (RefCell::new(single), RefCell::new(tracer));
        let mut frames = VARIANTS.map(|(_, traversal, edge, _)| {
            let (single, tracer, view) = (&single, &tracer, &view);
            move || match traversal {
                Traversal::Single => single_frame::<true, _>(&mut single.borrow_mut(), view, isovalue),
                _ => packet_frame::<true, _>(&mut tracer.borrow_mut(), view, isovalue, edge, traversal),
            }
        });
        let mut variants: Vec<&mut dyn FnMut() -> Found> =
            frames.iter_mut().map(|frame| frame as _).collect();
        let (seconds, found) = interleave_kept(self.repeat, &mut variants);
        let single = found[0];
        for ((variant, ..), found) in VARIANTS.iter().zip(&found) {
            let name = &self.pair.entry.name;
            ensure!(*found == single, "{name}, {variant}: {found:?}, of single rays {single:?}");
        }
        let rays = view.directions.len() as f64;
        let measured = |n: usize| [rays / RAYS / seconds[n], seconds[0] / seconds[n], cells[n] as f64 / rays];
        Ok((0..VARIANTS.len()).map(|n| self.row(VARIANTS[n], measured(n), volume.dims)).collect())
    }

    fn row(
        &self,
        (variant, _, _, line): (&'static str, Traversal, u32, usize),
        [rate, times_single, cells]: [f64; 3],
        dims: Dims,
    ) -> PaperRow {
        let Pair { scene, entry, edge, size } = self.pair;
        let thinned = edge.map_or(String::new(), |_| format!(", {} wide", dims.axes()[0]));
        let paper = scene.rate[line];
        let row = PaperRow {
            place: PLACE,
            hardware: HARDWARE,
            scene: scene.name,
            volume: entry.name.clone() + &thinned,
            isovalue: entry.isovalues[0],
            view: "far",
            size: *size,
            variant: variant.to_owned(),
            figures: vec![
                Figure { what: "frames/s", paper, ours: rate },
                Figure { what: "x single", paper: paper / scene.rate[0], ours: times_single },
                Figure { what: "intersections/ray", paper: scene.cells[line], ours: cells },
            ],
        };
        print(&row);
        row
    }
}

/// Of the samples, `edge` along each axis, as evenly as they come. Where the volume lies is lost.
fn thinned<T: Scalar>(volume: &Dense<T>, edge: u32) -> Result<Dense<T>> {
    let axes = volume.dims.axes().map(|n| n as usize);
    let last = edge as usize - 1;
    let at = |a: usize, i: u32| (i as usize * (axes[a] - 1) + last / 2) / last;
    let all = (0..edge.pow(3)).map(|n| [n % edge, n / edge % edge, n / edge.pow(2)]);
    let index = |[i, j, k]: [u32; 3]| at(0, i) + axes[0] * (at(1, j) + axes[1] * at(2, k));
    let samples = all.map(|p| volume.samples[index(p)]).collect();
    Ok(Dense { dims: Dims::new([edge; 3])?, samples, index_to_world: DAffine3::IDENTITY })
}
