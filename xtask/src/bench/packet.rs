//! Packets against single rays, by view and volume.

use anyhow::{Context, Result, ensure};
use isoray_benches::knoll2006::PaperOctree;
use isoray_benches::views::View;
use isoray_grid::Scalar;
use isoray_packet::{PacketTracer, Slicing, TracePackets, Traversal};
use isoray_trace::{Hit, Ray, Tracer, Work};
use serde::Serialize;

use super::overview::{compare_recursion, paper_frame, single_frame};
use super::recorded::{Found, Recorded, finish};
use super::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry};

/// Titles of the columns.
pub(crate) const HEADER: &str = "\nOne thread, ns a ray; gradients and Lambert shading included. Packets of 4², 8² and 16² rays, of 8² and 16² slab by slab, the tracer's choice for 8², and the work that it does. Hits only: the 2006 recursion and the choice for 8², without gradients and shading.\nFloor: single rays intersecting, from a packed list, the cells that must be, and shading.\nvolume                 iso    view   size |  2006 | single     4²     8²    16² slabs8 slabs16   auto | auto: × single  × 2006  × floor | hits only: 2006   auto  × 2006 | nodes/ray lookups/ray cells/ray";

/// What was measured of one view.
#[derive(Debug, Serialize)]
pub(crate) struct PacketRow {
    volume: String,
    isovalue: f32,
    view: &'static str,
    size: u32,
    knoll2006_ns_per_ray: f64,
    single_ns_per_ray: f64,
    /// By the packet's edge: 4, 8 and 16.
    masked_ns_per_ray: [f64; 3],
    /// By the packet's edge: 8 and 16.
    coherent_ns_per_ray: [f64; 2],
    auto_ns_per_ray: f64,
    floor_ns_per_ray: f64,
    /// Without gradients and shading.
    knoll2006_hits_ns_per_ray: f64,
    auto_hits_ns_per_ray: f64,
    nodes_per_ray: f64,
    lookups_per_ray: f64,
    cells_per_ray: f64,
}

pub(crate) struct Packets<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) sizes: &'a [u32],
    pub(crate) repeat: usize,
}

impl DenseVisitor for Packets<'_> {
    type Output = Result<Vec<PacketRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let octree = octree.view();
        let paper = PaperOctree::build(volume.dims, &volume.samples);
        let isovalue = self.entry.isovalues[0];
        let mut rows = Vec::new();
        for &size in self.sizes {
            for (name, view) in
                [("far", View::far(volume.dims, size, size)), ("close", View::close(volume.dims, size, size))]
            {
                let mut single = Tracer::new(&octree);
                let recorded = Recorded::new(&mut single, &view, isovalue);
                let mut tracer = PacketTracer::new(&octree);
                for edge in [4, 8, 16] {
                    compare(&mut tracer, &mut single, &view, isovalue, edge, Traversal::Masked)?;
                }
                for edge in [8, 16] {
                    compare(&mut tracer, &mut single, &view, isovalue, edge, COHERENT)?;
                }
                let work = compare(&mut tracer, &mut single, &view, isovalue, 8, Traversal::Auto)?;
                let tracer = std::cell::RefCell::new(tracer);
                let frame = |edge, traversal| {
                    packet_frame::<true, _>(&mut *tracer.borrow_mut(), &view, isovalue, edge, traversal)
                };
                let (times, found) = interleave_kept(
                    self.repeat,
                    &mut [
                        &mut || paper_frame::<true, _>(&paper, &view, isovalue),
                        &mut || single_frame::<true, _>(&mut single, &view, isovalue),
                        &mut || frame(4, Traversal::Masked),
                        &mut || frame(8, Traversal::Masked),
                        &mut || frame(16, Traversal::Masked),
                        &mut || frame(8, COHERENT),
                        &mut || frame(16, COHERENT),
                        &mut || frame(8, Traversal::Auto),
                        &mut || recorded.intersect(&view),
                        &mut || paper_frame::<false, _>(&paper, &view, isovalue),
                        &mut || {
                            let tracer = &mut *tracer.borrow_mut();
                            packet_frame::<false, _>(tracer, &view, isovalue, 8, Traversal::Auto)
                        },
                    ],
                );
                compare_timed(&found)
                    .with_context(|| format!("{} at {isovalue}, {name}, {size}²", self.entry.name))?;
                let rays = view.directions.len() as f64;
                let ns = |n: usize| times[n] / rays * 1e9;
                let row = PacketRow {
                    volume: self.entry.name.clone(),
                    isovalue,
                    view: name,
                    size,
                    knoll2006_ns_per_ray: ns(0),
                    single_ns_per_ray: ns(1),
                    masked_ns_per_ray: [ns(2), ns(3), ns(4)],
                    coherent_ns_per_ray: [ns(5), ns(6)],
                    auto_ns_per_ray: ns(7),
                    floor_ns_per_ray: ns(8),
                    knoll2006_hits_ns_per_ray: ns(9),
                    auto_hits_ns_per_ray: ns(10),
                    nodes_per_ray: work.nodes as f64 / rays,
                    lookups_per_ray: work.lookups as f64 / rays,
                    cells_per_ray: work.cells as f64 / rays,
                };
                println!("{}", line(&row));
                rows.push(row);
            }
        }
        Ok(rows)
    }
}

/// Which of the timed frames are of the recursion of 2006, and which is of single rays.
const RECURSIONS: [usize; 2] = [0, 9];
const SINGLE: usize = 1;

/// Makes sure that all timed frames that are ours found the same, and the recursion about as much, shaded or not.
fn compare_timed(found: &[Found]) -> Result<()> {
    let single = found[SINGLE];
    for (n, &found) in found.iter().enumerate().filter(|(n, _)| !RECURSIONS.contains(n)) {
        ensure!(found == single, "timed frame {n} found {found:?}, that of single rays {single:?}");
    }
    let [shaded, hits_only] = RECURSIONS.map(|n| found[n]);
    ensure!(shaded == hits_only, "the 2006 recursion found {shaded:?} with shading, {hits_only:?} without");
    compare_recursion(single, shaded)
}

fn line(row: &PacketRow) -> String {
    let [four, eight, sixteen] = row.masked_ns_per_ray;
    let [slabs_eight, slabs_sixteen] = row.coherent_ns_per_ray;
    let auto = row.auto_ns_per_ray;
    format!(
        "{:<20} {:>6} {:>7} {:>6} | {:>5.0} | {:>6.1} {four:>6.1} {eight:>6.1} {sixteen:>6.1} {slabs_eight:>6.1} {slabs_sixteen:>7.1} {auto:>6.1} | {:>14.2} {:>7.2} {:>8.2} | {:>15.0} {:>6.1} {:>7.2} | {:>9.2} {:>11.2} {:>9.2}",
        row.volume,
        row.isovalue,
        row.view,
        row.size,
        row.knoll2006_ns_per_ray,
        row.single_ns_per_ray,
        row.single_ns_per_ray / auto,
        row.knoll2006_ns_per_ray / auto,
        auto / row.floor_ns_per_ray,
        row.knoll2006_hits_ns_per_ray,
        row.auto_hits_ns_per_ray,
        row.knoll2006_hits_ns_per_ray / row.auto_hits_ns_per_ray,
        row.nodes_per_ray,
        row.lookups_per_ray,
        row.cells_per_ray,
    )
}

const COHERENT: Traversal = Traversal::Coherent(Slicing::Mixed);

/// Room for the largest packet.
const MOST: usize = 256;

/// Makes sure that packets of `edge`² hit what single rays hit, bit for bit. Their work.
pub(crate) fn compare<T: Scalar>(
    tracer: &mut PacketTracer<'_, T>,
    single: &mut Tracer<'_, T>,
    view: &View,
    isovalue: f32,
    edge: u32,
    traversal: Traversal,
) -> Result<Work> {
    let mut work = Work::default();
    let mut hits = [None; MOST];
    for directions in view.packets(edge).chunks((edge * edge) as usize) {
        let rays: Vec<Ray> = directions.iter().map(|&direction| view.ray(direction)).collect();
        let hits = &mut hits[..rays.len()];
        tracer.first_hits(&rays, isovalue, traversal, hits, &mut work);
        for (ray, hit) in rays.iter().zip(hits) {
            let expected = single.first_hit(ray, isovalue);
            ensure!(*hit == expected, "{edge}²: {ray:?} hits {hit:?}, alone {expected:?}");
        }
    }
    Ok(work)
}

// Each loop on its own, as in a program.
#[inline(never)]
pub(crate) fn packet_frame<const SHADED: bool, T: Scalar>(
    tracer: &mut PacketTracer<'_, T>,
    view: &View,
    isovalue: f32,
    edge: u32,
    traversal: Traversal,
) -> Found {
    let directions = view.packets(edge);
    let mut rays = [view.ray([0.0; 3]); MOST];
    let mut hits: [Option<Hit>; MOST] = [None; MOST];
    let mut found = Found::default();
    for directions in directions.chunks((edge * edge) as usize) {
        for (ray, &direction) in rays.iter_mut().zip(directions) {
            ray.direction = direction;
        }
        let hits = &mut hits[..directions.len()];
        tracer.first_hits(&rays[..directions.len()], isovalue, traversal, hits, &mut ());
        for (hit, &direction) in hits.iter().zip(directions) {
            if let Some(hit) = hit {
                found.add(hit.t);
                finish::<SHADED>(hit.t, || hit.gradient(), direction);
            }
        }
    }
    found
}
