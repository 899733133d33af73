//! Tables 3 and 4, and Figure 9: frames.

use anyhow::{Context, Result, ensure};
use isoray_benches::knoll2006::PaperOctree;
use isoray_benches::views::View;
use isoray_grid::{Branching, DenseVolume, GridVolume, Scalar};
use isoray_packet::{PacketTracer, Traversal};
use isoray_render::{Scene, Traversal as Way, render};
use isoray_trace::Tracer;

use super::{PaperRow, Setting, Step, figure, print, print_titles, row};
use crate::bench::overview::{compare_recursion, paper_frame, single_frame};
use crate::bench::packet::{compare, packet_frame};
use crate::bench::recorded::Found;
use crate::bench::scaling::on_threads;
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Place};

/// Columns of both tables: on what, how many cores, which of the two sizes.
const COLUMNS: [(&str, f64, usize); 3] = [
    ("Core Duo, 2 cores, 512x512", 2.0, 0),
    ("Opteron, 16 cores, 512x512", 16.0, 0),
    ("Opteron, 16 cores, 1024x1024", 16.0, 1),
];
/// Pixels along each side of theirs.
const SIZES: [f64; 2] = [512.0, 1024.0];
/// Edge of a packet.
const PACKET: u32 = 8;
/// On how many threads Figure 9 has its efficiency, and which.
const FIGURE_9: (usize, f64) = (16, 91.0);

/// Rows of one scene: far, and close if there are figures for it.
pub(super) fn rates(
    setting: Setting<'_>,
    place: &'static str,
    step: &Step,
    paper: &[[f64; 3]],
) -> Result<Vec<PaperRow>> {
    step.entry.visit(Rates { setting, place, step, paper })?
}

struct Rates<'a> {
    setting: Setting<'a>,
    place: &'static str,
    step: &'a Step,
    paper: &'a [[f64; 3]],
}

impl DenseVisitor for Rates<'_> {
    type Output = Result<Vec<PaperRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let octree = octree.view();
        let recursion = PaperOctree::build(volume.dims, &volume.samples);
        let (mut single, mut packet) = (Tracer::new(&octree), PacketTracer::new(&octree));
        let isovalue = self.step.entry.isovalues[0];
        let sizes = if self.setting.quick { [64, 128] } else { [512, 1024] };
        let mut rows = Vec::new();
        for (name, paper) in ["far", "close"].into_iter().zip(self.paper) {
            let views = sizes.map(|size| match name {
                "far" => View::far(volume.dims, size, size),
                _ => View::close(volume.dims, size, size),
            });
            let mut seconds = Vec::new();
            for view in &views {
                compare(&mut packet, &mut single, view, isovalue, PACKET, Traversal::Auto)?;
                let (times, found) = interleave_kept(
                    self.setting.repeat,
                    &mut [
                        &mut || single_frame::<true, _>(&mut single, view, isovalue),
                        &mut || packet_frame::<true, _>(&mut packet, view, isovalue, PACKET, Traversal::Auto),
                        &mut || paper_frame::<true, _>(&recursion, view, isovalue),
                    ],
                );
                compare_timed(&found).with_context(|| format!("{}, {name}", self.step.entry.name))?;
                seconds.push(times);
            }
            for ((variant, cores, size), paper) in COLUMNS.into_iter().zip(paper) {
                let share = (f64::from(sizes[size]) / SIZES[size]).powi(2);
                let whats = ["single rays", "as the tracer chooses", "recursion of 2006"];
                let figures = whats.into_iter().zip(&seconds[size]);
                let figures =
                    figures.map(|(what, seconds)| figure(what, paper / cores, share / seconds)).collect();
                let row = PaperRow {
                    variant: variant.to_owned(),
                    figures,
                    ..row(self.place, self.step, name, sizes[size])
                };
                print(&row);
                rows.push(row);
            }
        }
        Ok(rows)
    }
}

/// Makes sure that single rays and packets found the same, and the recursion about as much.
fn compare_timed(found: &[Found]) -> Result<()> {
    let [single, packets, recursion] = [found[0], found[1], found[2]];
    ensure!(single.hits > 0, "nothing is hit");
    ensure!(packets == single, "packets found {packets:?}, single rays {single:?}");
    compare_recursion(single, recursion)
}

/// Figure 9: what is left of every thread's rate where all cores have one, of octree and of grid.
pub(super) fn efficiency(setting: Setting<'_>, step: &Step) -> Result<Vec<PaperRow>> {
    step.entry.visit(Efficiency { setting, step })?
}

struct Efficiency<'a> {
    setting: Setting<'a>,
    step: &'a Step,
}

impl DenseVisitor for Efficiency<'_> {
    type Output = Result<Vec<PaperRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let size = if self.setting.quick { 256 } else { 512 };
        let octree = volume.octree()?;
        let octree = octree.view();
        let branching = Branching::new(&[4, 2, 2, 2, 2])?;
        let grid = GridVolume::with_branching(DenseVolume::new(volume.dims, &volume.samples)?, &branching);
        let camera = volume.camera(Place::Far, size)?;
        let scene = Scene { traversal: Way::Single, ..Scene::of(self.step.entry.isovalues[0]) };
        let cores = rayon::current_num_threads();
        let counts = [1, cores];
        let to_world = volume.index_to_world;
        let repeat = self.setting.repeat;
        let measured = [
            ("octree", on_threads(&counts, repeat, || render(&octree, to_world, &camera, &scene))?),
            (
                "grid over the array",
                on_threads(&counts, repeat, || render(&grid, to_world, &camera, &scene))?,
            ),
        ];
        print_titles("structure; threads", &["efficiency, % (paper's: 16)"]);
        let of = |(structure, seconds): (&str, Vec<(usize, f64)>)| {
            let percent = 100.0 * seconds[0].1 / seconds[1].1 / cores as f64;
            // The text says of the grid that it behaves similarly.
            let figures = vec![figure("efficiency, %", FIGURE_9.1, percent)];
            let variant = format!("{structure}; {} threads, ours {cores}", FIGURE_9.0);
            let row = PaperRow { variant, figures, ..row("2006, Figure 9", self.step, "far", size) };
            print(&row);
            row
        };
        Ok(measured.into_iter().map(of).collect())
    }
}
