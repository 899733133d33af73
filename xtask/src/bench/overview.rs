//! The first table: build, size, throughput, beside the recursion and the nodes of Knoll 2006.

use std::hint::black_box;
use std::time::Instant;

use anyhow::{Result, ensure};
use isoray_benches::knoll2006::PaperOctree;
use isoray_benches::views::View;
use isoray_grid::Scalar;
use isoray_octree::OctreeVolume;
use isoray_trace::{FirstHit, Tracer, Work};

use super::recorded::{Recorded, finish};
use super::report::{ViewRow, VolumeRow};
use super::timer::{interleave, median};
use crate::catalog::{Dense, DenseVisitor, Entry};

/// Titles of the columns.
pub(crate) const HEADER: &str = "One thread; normals and Lambert shading included. 2006: recursion and nodes of that paper, same run. Floor: the time over that of intersecting, from a packed list, the cells that must be, and shading.\nvolume                 iso    view   size | size % (2006)    build Mvox/s | Mrays/s ns/ray  2006 ns/ray  ratio  floor | nodes/ray lookups/ray cells/ray";

/// Share of hits on which the two systems may differ: the paper's root finder misses some, and misplaces its cells' borders.
const HITS_DIFFER: f64 = 0.02;
/// Times a build is repeated.
const BUILDS: usize = 3;

pub(crate) struct Overview<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) sizes: &'a [u32],
    pub(crate) repeat: usize,
}

impl DenseVisitor for Overview<'_> {
    type Output = Result<Vec<VolumeRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let mut seconds = Vec::new();
        let mut octree = volume.octree()?;
        for _ in 0..BUILDS {
            let begin = Instant::now();
            octree = black_box(volume.octree()?);
            seconds.push(begin.elapsed().as_secs_f64());
        }
        let build_s = median(seconds);
        let paper = PaperOctree::build(volume.dims, &volume.samples);
        let mut row = VolumeRow {
            volume: self.entry.name.clone(),
            dims: volume.dims.axes(),
            scalar: T::TYPE.name(),
            raw_bytes: octree.raw_bytes() as u64,
            octree_bytes: octree.file_bytes() as u64,
            knoll2006_bytes: paper.bytes() as u64,
            build_s,
            voxels_per_s: volume.dims.samples() as f64 / build_s,
            views: Vec::new(),
        };
        for &isovalue in &self.entry.isovalues {
            for &size in self.sizes {
                for (name, view) in [
                    ("far", View::far(volume.dims, size, size)),
                    ("close", View::close(volume.dims, size, size)),
                ] {
                    let measured = measure(&octree, &paper, &view, isovalue, self.repeat)?;
                    let view = ViewRow { isovalue, view: name, size, ..measured };
                    println!("{}", line(&row, &view));
                    row.views.push(view);
                }
            }
        }
        Ok(vec![row])
    }
}

fn line(row: &VolumeRow, view: &ViewRow) -> String {
    let percent = |bytes: u64| 100.0 * bytes as f64 / row.raw_bytes as f64;
    format!(
        "{:<20} {:>6} {:>7} {:>6} | {:>6.1} ({:>5.1}) {:>14.1} | {:>7.2} {:>6.0} {:>12.0} {:>6.2} {:>6.2} | {:>9.2} {:>11.2} {:>9.2}",
        row.volume,
        view.isovalue,
        view.view,
        view.size,
        percent(row.octree_bytes),
        percent(row.knoll2006_bytes),
        row.voxels_per_s / 1e6,
        1e3 / view.single_ns_per_ray,
        view.single_ns_per_ray,
        view.knoll2006_ns_per_ray,
        view.knoll2006_ns_per_ray / view.single_ns_per_ray,
        view.single_ns_per_ray / view.floor_ns_per_ray,
        view.nodes_per_ray,
        view.lookups_per_ray,
        view.cells_per_ray,
    )
}

fn measure<T: Scalar>(
    octree: &OctreeVolume<T>,
    paper: &PaperOctree<T>,
    view: &View,
    isovalue: f32,
    repeat: usize,
) -> Result<ViewRow> {
    let structure = octree.view();
    let mut tracer = Tracer::new(&structure);
    let mut work = Work::default();
    let mut hits = 0u64;
    for &direction in &view.directions {
        let mut first = FirstHit::default();
        tracer.trace(&view.ray(direction), isovalue, &mut first, &mut work);
        hits += u64::from(first.0.is_some());
    }
    let recorded = Recorded::new(&mut tracer, view, isovalue);
    let (mut single_hits, mut paper_hits, mut floor_hits) = (0u64, 0u64, 0u64);
    let times = interleave(
        repeat,
        &mut [
            &mut || single_hits = single_frame::<true, _>(&mut tracer, view, isovalue),
            &mut || paper_hits = paper_frame::<true, _>(paper, view, isovalue),
            &mut || floor_hits = recorded.intersect(view),
        ],
    );
    ensure!(floor_hits == hits, "the recorded cells had {floor_hits} hits, the counted frame {hits}");
    ensure!(single_hits == hits, "the timed frame had {single_hits} hits, the counted one {hits}");
    let difference = single_hits.abs_diff(paper_hits) as f64 / hits.max(1) as f64;
    ensure!(
        difference <= HITS_DIFFER || hits.abs_diff(paper_hits) < 100,
        "{paper_hits} hits by the 2006 recursion, {hits} by ours: more than {HITS_DIFFER} of them differ"
    );
    let rays = view.directions.len() as f64;
    Ok(ViewRow {
        isovalue,
        view: "",
        size: 0,
        hits,
        nodes_per_ray: work.nodes as f64 / rays,
        lookups_per_ray: work.lookups as f64 / rays,
        cells_per_ray: work.cells as f64 / rays,
        single_ns_per_ray: times[0] / rays * 1e9,
        knoll2006_ns_per_ray: times[1] / rays * 1e9,
        floor_ns_per_ray: times[2] / rays * 1e9,
    })
}

// Each loop on its own, as in a program: inlined beside others it is up to a tenth slower, and not always.
#[inline(never)]
pub(crate) fn single_frame<const SHADED: bool, T: Scalar>(
    tracer: &mut Tracer<'_, T>,
    view: &View,
    isovalue: f32,
) -> u64 {
    let mut hits = 0;
    for &direction in &view.directions {
        if let Some(hit) = tracer.first_hit(&view.ray(direction), isovalue) {
            hits += 1;
            finish::<SHADED>(hit.t, || hit.gradient(), direction);
        }
    }
    hits
}

#[inline(never)]
pub(crate) fn paper_frame<const SHADED: bool, T: Scalar>(
    paper: &PaperOctree<T>,
    view: &View,
    isovalue: f32,
) -> u64 {
    let mut hits = 0;
    for &direction in &view.directions {
        if let Some(hit) = paper.first_hit(view.origin, direction, isovalue) {
            hits += 1;
            finish::<SHADED>(hit.t, || hit.gradient, direction);
        }
    }
    hits
}
