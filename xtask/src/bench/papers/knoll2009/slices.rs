//! Table 2: what a traversal by slabs gains from each of its optimisations.

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_render::{Camera, Scene, Slicing, Traversal};
use isoray_trace::Work;

use crate::bench::papers::{Figure, PaperRow, Setting, print, print_titles};
use crate::bench::picture::Pictures;
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};

/// A line of the table, or one beside it: look-ups and intersections of a cell, by a ray or a packet, for each ray; frames a second.
pub(in crate::bench) struct Line {
    variant: &'static str,
    paper: [f64; 3],
    traversal: Traversal,
    /// Of levels of detail; zero: exact.
    ratio: f64,
}

const NONE: [f64; 3] = [f64::NAN; 3];
const fn line(variant: &'static str, paper: [f64; 3], traversal: Traversal, ratio: f64) -> Line {
    Line { variant, paper, traversal, ratio }
}

#[rustfmt::skip]
const LINES: [Line; 10] = [
    line("single", [1.2, 0.64, 2.3], Traversal::Single, 0.0),
    line("packet: 8x8, extents of slices", [4.5, 1.8, 0.78], Traversal::Coherent(Slicing::Extents), 0.0),
    line("+ slice: samples kept", [4.5, 1.8, 2.2], Traversal::Coherent(Slicing::Kept), 0.0),
    line("+ mcell: blocks without surface", [2.14, 0.47, 3.9], Traversal::Coherent(Slicing::Macrocells), 0.0),
    line("+ cell: extents of active rays", [1.0, 0.47, 4.6], Traversal::Coherent(Slicing::Active), 0.0),
    line("+ ours: blocks compared as a whole", NONE, Traversal::Coherent(Slicing::Mixed), 0.0),
    line("+ mulres: LOD 1", [0.37, 0.17, 7.6], Traversal::Coherent(Slicing::Mixed), 1.0),
    line("ours: masked", NONE, Traversal::Masked, 0.0),
    line("ours: masked, LOD 1", NONE, Traversal::Masked, 1.0),
    line("ours: as the tracer chooses", NONE, Traversal::Auto, 0.0),
];

/// Before and after slices are clipped, and after cells are.
#[rustfmt::skip]
pub(in crate::bench) const CLIPPING: [Line; 3] = [
    line("samples kept", NONE, Traversal::Coherent(Slicing::Kept), 0.0),
    line("blocks without surface", NONE, Traversal::Coherent(Slicing::Macrocells), 0.0),
    line("extents of active rays", NONE, Traversal::Coherent(Slicing::Active), 0.0),
];

/// On the scene of the paper if it is there.
pub(super) fn run(setting: Setting<'_>) -> Result<Vec<PaperRow>> {
    let size = if setting.quick { 64 } else { 512 };
    let instead = if setting.quick { Entry::fixture() } else { Entry::marschner_lobb(256) };
    let entry = setting.heptane().unwrap_or(instead);
    if !setting.has(&entry) {
        return Ok(Vec::new());
    }
    print_titles("traversal", &["look-ups/ray", "intersections/ray", "frames/s", "Mrays/s"]);
    let isovalue = entry.isovalues[0];
    let measured = entry.visit(Measure { isovalue, size, repeat: setting.repeat, lines: &LINES })??;
    let rows = LINES.iter().zip(measured).map(|(line, measured)| {
        let rays = f64::from(size).powi(2);
        let [lookups, cells, seconds] = measured;
        let rate = 512.0 * 512.0 / 1e6;
        let figure = |what, paper, ours| Figure { what, paper, ours };
        let row = PaperRow {
            place: "2009, Table 2",
            hardware: "Core Duo 2.16 GHz, 1 core, 512x512",
            scene: "HEP302",
            volume: entry.name.clone(),
            isovalue,
            view: "far",
            size,
            variant: line.variant.to_owned(),
            figures: vec![
                figure("look-ups/ray", line.paper[0], lookups / rays),
                figure("intersections/ray", line.paper[1], cells / rays),
                figure("frames/s", line.paper[2], rays / (512.0 * 512.0) / seconds),
                figure("Mrays/s", line.paper[2] * rate, rays / seconds / 1e6),
            ],
        };
        print(&row);
        row
    });
    Ok(rows.collect())
}

/// Measures some lines, which show the same picture, on one thread.
pub(in crate::bench) struct Measure {
    pub(in crate::bench) isovalue: f32,
    pub(in crate::bench) size: u32,
    pub(in crate::bench) repeat: usize,
    pub(in crate::bench) lines: &'static [Line],
}

impl DenseVisitor for Measure {
    /// By line: cells looked up, cells intersected, seconds.
    type Output = Result<Vec<[f64; 3]>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let pictures = Pictures::new(&octree);
        let camera = volume.camera(Place::Far, self.size)?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("no thread")?;
        pool.install(|| self.lines(&pictures, &camera))
    }
}

impl Measure {
    fn lines<T: Scalar>(&self, pictures: &Pictures<'_, T>, camera: &Camera) -> Result<Vec<[f64; 3]>> {
        let scene = |traversal| Scene { traversal, ..Scene::of(self.isovalue) };
        let (mut cells, mut counted) = (Vec::new(), Vec::new());
        for Line { variant, traversal, ratio, .. } in self.lines {
            let (image, work) = pictures.counted(camera, &scene(*traversal), *ratio);
            let (alone, _) = pictures.frame(camera, &scene(Traversal::Single), *ratio);
            ensure!(image == alone, "{variant}: not the picture of single rays");
            let Work { lookups, packet_cells, cells: ray_cells, .. } = work;
            // Of rays that go alone, cells are intersected ray by ray.
            let intersected = if *traversal == Traversal::Single { ray_cells } else { packet_cells };
            cells.push([lookups / 8, intersected].map(|n| n as f64));
            counted.push(image);
        }
        let frame = |line: &'static Line| {
            let scene = scene(line.traversal);
            move || pictures.frame(camera, &scene, line.ratio).0
        };
        let mut frames: Vec<_> = self.lines.iter().map(frame).collect();
        let mut variants: Vec<&mut dyn FnMut() -> _> = frames.iter_mut().map(|frame| frame as _).collect();
        let (seconds, timed) = interleave_kept(self.repeat, &mut variants);
        ensure!(timed == counted, "timed are other pictures");
        Ok(cells.iter().zip(seconds).map(|(&[lookups, cells], seconds)| [lookups, cells, seconds]).collect())
    }
}
