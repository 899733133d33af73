//! Parker, Shirley, Livnat, Hansen and Sloan 1998 ("Interactive Ray Tracing for Isosurface Rendering"): Tables 1 to 3. Theirs is the Visible Woman, 512 × 512 × 1734.

use anyhow::{Result, ensure};
use isoray_benches::path;
use isoray_benches::views::View;
use isoray_grid::{BrickedVolume, DenseVolume, GridVolume, Samples, Scalar};
use isoray_render::{Scene, render};
use isoray_trace::{GridTracer, Hit, Trace, Tracer};

use super::{Figure, PARKER_BRICKS, PaperRow, Setting, of_all_rays, print, print_titles};
use crate::bench::scaling::on_threads;
use crate::bench::single::phases;
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};

const HEADER: &str = "\nParker et al. 1998 beside ours: paper, ours, ours over the paper's. Theirs: R10000 at 195 MHz, 512x512, the Visible Woman (512x512x1734, skin at 600.5 and bone at 1224.5).
Frames/s are of 512x512. Of Table 1 theirs are of a processor, the best of what they give; Table 3's times are of all processors together, and ours of it without shading.
Of the efficiency of 128 processors the text says 91 and 80 %; of macrocells of three levels that they take less than 0.5 % of the data.";

/// Table 1: traversal, intersection and shading, in %, and frames a second on 64 processors.
const PHASES: [(&str, [f64; 4]); 2] =
    [("skin", [55.0, 22.0, 23.0, 15.0]), ("bone", [66.0, 21.0, 13.0, 15.0])];

/// Table 2: processors; frames a second and how many times as fast as one, of two views of the bone.
const PROCESSORS: [(usize, [[f64; 2]; 2]); 12] = [
    (1, [[0.18, 1.0], [0.39, 1.0]]),
    (2, [[0.36, 2.0], [0.79, 2.0]]),
    (4, [[0.72, 4.0], [1.58, 4.1]]),
    (8, [[1.44, 8.0], [3.16, 8.1]]),
    (12, [[2.17, 12.1], [4.73, 12.1]]),
    (16, [[2.89, 16.1], [6.31, 16.2]]),
    (24, [[4.33, 24.1], [9.47, 24.3]]),
    (32, [[5.55, 30.8], [11.34, 29.1]]),
    (48, [[8.50, 47.2], [16.96, 43.5]]),
    (64, [[10.40, 57.8], [22.14, 56.8]]),
    (96, [[16.10, 89.4], [33.34, 85.5]]),
    (128, [[20.49, 113.8], [39.98, 102.5]]),
];

/// Table 3: seconds on 16 processors, of the array, of bricks, and of bricks with a hierarchy. Which surface, and from where: along the last axis for the feet.
const OPTIMIZATIONS: [(&str, usize, [f64; 3], [f64; 3]); 4] = [
    ("skin: front", 0, [1.1, 0.9, 1.3], [1.41, 1.27, 0.53]),
    ("bone: front", 1, [1.1, 0.9, 1.3], [2.35, 2.07, 0.52]),
    ("bone: close", 1, [0.25, 0.2, 0.3], [3.61, 3.52, 0.76]),
    ("bone: from feet", 1, [0.05, 0.08, 1.3], [26.1, 5.8, 0.62]),
];
const PROCESSORS_OF_TABLE_3: f64 = 16.0;

/// Runs on a scan of a chest, or on the bundled one, each with a surface between air and soft matter and one of what is hard.
pub(super) fn run(setting: Setting<'_>) -> Result<Vec<PaperRow>> {
    let entry = setting.real("chest CT").unwrap_or_else(Entry::fixture);
    if !setting.has(&entry) {
        return Ok(Vec::new());
    }
    println!("{HEADER}");
    entry.visit(Scan { entry: &entry, setting })?
}

struct Scan<'a> {
    entry: &'a Entry,
    setting: Setting<'a>,
}

impl DenseVisitor for Scan<'_> {
    type Output = Result<Vec<PaperRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let mut rows = self.phases(volume)?;
        rows.extend(self.threads(volume)?);
        rows.extend(self.optimizations(volume)?);
        Ok(rows)
    }
}

impl Scan<'_> {
    /// Table 1, by their structure and by ours.
    fn phases<T: Scalar>(&self, volume: &Dense<T>) -> Result<Vec<PaperRow>> {
        let size = if self.setting.quick { 128 } else { 512 };
        let octree = volume.octree()?;
        let octree = octree.view();
        let grid = GridVolume::new(DenseVolume::new(volume.dims, &volume.samples)?);
        let view = View::far(volume.dims, size, size);
        let repeat = self.setting.repeat;
        print_titles(
            "structure",
            &["traversal, %", "intersection, %", "shading, %", "frames/s, one processor"],
        );
        let mut rows = Vec::new();
        for ((scene, paper), isovalue) in PHASES.into_iter().zip(self.isovalues()) {
            let of_grid = phases(&mut GridTracer::new(&grid), &view, isovalue, repeat)?;
            let of_octree = phases(&mut Tracer::new(&octree), &view, isovalue, repeat)?;
            let [in_grid, in_octree] = [of_grid.1, of_octree.1];
            ensure!(
                in_grid.hits > 0 && in_grid == in_octree,
                "{scene}: {in_grid:?} in the grid, {in_octree:?} in the octree"
            );
            let measured = [("grid of three levels, array", of_grid.0), ("octree, octree data", of_octree.0)];
            for (variant, [traversal, intersection, shading, seconds]) in measured {
                let figure = |what, paper, ours| Figure { what, paper, ours };
                let figures = vec![
                    figure("traversal, %", paper[0], 100.0 * traversal),
                    figure("intersection, %", paper[1], 100.0 * intersection),
                    figure("shading, %", paper[2], 100.0 * shading),
                    figure("frames/s, one processor", paper[3] / 64.0, 1.0 / of_all_rays(seconds, size)),
                ];
                let variant = variant.to_owned();
                let row =
                    PaperRow { variant, figures, isovalue, ..self.row("1998, Table 1", scene, "far", size) };
                print(&row);
                rows.push(row);
            }
        }
        Ok(rows)
    }

    /// Table 2, for as many threads as there are cores.
    fn threads<T: Scalar>(&self, volume: &Dense<T>) -> Result<Vec<PaperRow>> {
        let size = if self.setting.quick { 256 } else { 512 };
        let grid = GridVolume::new(DenseVolume::new(volume.dims, &volume.samples)?);
        let isovalue = self.isovalues()[1];
        let scene = Scene::of(isovalue);
        print_titles("processors; ours: threads", &["frames/s", "x one"]);
        let mut rows = Vec::new();
        for (n, place) in [Place::Far, Place::Close].into_iter().enumerate() {
            let camera = volume.camera(place, size)?;
            let counts = PROCESSORS.map(|line| line.0);
            let frame = || render(&grid, volume.index_to_world, &camera, &scene);
            let seconds = on_threads(&counts, self.setting.repeat, frame)?;
            for ((_, paper), (threads, time)) in PROCESSORS.into_iter().zip(&seconds) {
                let [rate, times_one] = paper[n];
                let figures = vec![
                    Figure { what: "frames/s", paper: rate, ours: 1.0 / of_all_rays(*time, size) },
                    Figure { what: "x one", paper: times_one, ours: seconds[0].1 / time },
                ];
                let scene = ["bone, view 1", "bone, view 2"][n];
                let row = self.row("1998, Table 2", scene, place.name(), size);
                let row = PaperRow { variant: threads.to_string(), figures, isovalue, ..row };
                print(&row);
                rows.push(row);
            }
        }
        Ok(rows)
    }

    /// Table 3: all cells of an array, all cells in bricks, and what macrocells leave of these. First hits are found and kept by all three, and shaded by none.
    fn optimizations<T: Scalar>(&self, volume: &Dense<T>) -> Result<Vec<PaperRow>> {
        let size = if self.setting.quick { 64 } else { 256 };
        let mut array = DenseVolume::new(volume.dims, &volume.samples)?;
        let bricks = BrickedVolume::new(&mut array, PARKER_BRICKS)?;
        let grid = GridVolume::new(&bricks);
        print_titles(
            "",
            &["s, all processors: array", "bricks", "and hierarchy", "array : bricks", "bricks : hierarchy"],
        );
        let mut rows = Vec::new();
        for (scene, surface, eye, paper) in OPTIMIZATIONS {
            let isovalue = self.isovalues()[surface];
            let view = View::new(volume.dims, eye, size, size);
            let mut tracer = GridTracer::new(&grid);
            let (seconds, hits) = interleave_kept(
                self.setting.repeat.min(3),
                &mut [
                    &mut || every_cell(&array, &view, isovalue),
                    &mut || every_cell(&bricks, &view, isovalue),
                    &mut || first_hits(&mut tracer, &view, isovalue),
                ],
            );
            ensure!(hits[0].iter().any(Option::is_some), "{scene}: nothing is hit");
            ensure!(hits[1] == hits[0], "{scene}: other hits in bricks than in the array");
            ensure!(hits[2] == hits[0], "{scene}: other hits with macrocells than in the array");
            let figure = |what, paper, ours| Figure { what, paper, ours };
            let time = |what, n: usize| {
                figure(what, PROCESSORS_OF_TABLE_3 * paper[n], of_all_rays(seconds[n], size))
            };
            let figures = vec![
                time("s, all processors: array", 0),
                time("bricks", 1),
                time("and hierarchy", 2),
                figure("array : bricks", paper[0] / paper[1], seconds[0] / seconds[1]),
                figure("bricks : hierarchy", paper[1] / paper[2], seconds[1] / seconds[2]),
            ];
            let row = PaperRow { figures, isovalue, ..self.row("1998, Table 3", scene, "", size) };
            print(&row);
            rows.push(row);
        }
        Ok(rows)
    }

    /// Of skin and of bone.
    fn isovalues(&self) -> [f32; 2] {
        std::array::from_fn(|n| self.entry.isovalues[n.min(self.entry.isovalues.len() - 1)])
    }

    fn row(&self, place: &'static str, scene: &'static str, view: &'static str, size: u32) -> PaperRow {
        PaperRow {
            place,
            hardware: "R10000 at 195 MHz, 512x512",
            scene,
            volume: self.entry.name.clone(),
            isovalue: f32::NAN,
            view,
            size,
            variant: String::new(),
            figures: Vec::new(),
        }
    }
}

#[inline(never)]
fn every_cell(samples: &impl Samples, view: &View, isovalue: f32) -> Vec<Option<Hit>> {
    let hit = |&direction: &[f32; 3]| path::first_hit(samples, &view.ray(direction), isovalue, &mut ());
    view.directions.iter().map(hit).collect()
}

#[inline(never)]
fn first_hits(tracer: &mut impl Trace, view: &View, isovalue: f32) -> Vec<Option<Hit>> {
    view.directions.iter().map(|&direction| tracer.first_hit(&view.ray(direction), isovalue)).collect()
}
