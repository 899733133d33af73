//! The first table: build, size, throughput, beside the recursion and the nodes of Knoll 2006.

use std::hint::black_box;
use std::time::Instant;

use anyhow::{Result, ensure};
use isoray_benches::knoll2006::PaperOctree;
use isoray_benches::views::View;
use isoray_grid::Scalar;
use isoray_octree::OctreeVolume;
use isoray_trace::{FirstHit, Tracer, Work};

use super::recorded::{Found, Recorded, finish};
use super::report::{ViewRow, VolumeRow};
use super::timer::{interleave_kept, median};
use crate::catalog::{Dense, DenseVisitor, Entry};

/// Titles of the columns.
pub(crate) const HEADER: &str = "One thread; normals and Lambert shading included. 2006: recursion and nodes of that paper, same run. Floor: the time over that of intersecting, from a packed list, the cells that must be, and shading.\nvolume                 iso    view   size | size % (2006)    build Mvox/s | Mrays/s ns/ray  2006 ns/ray  ratio  floor | nodes/ray lookups/ray cells/ray";

/// Share of hits on which the two systems may differ: the paper's root finder misses some, and misplaces its cells' borders.
const HITS_DIFFER: f64 = 0.02;
/// Fewer hits than this tell nothing of a share.
const FEW_HITS: u64 = 100;
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
    let mut counted = Found::default();
    for &direction in &view.directions {
        let mut first = FirstHit::default();
        tracer.trace(&view.ray(direction), isovalue, &mut first, &mut work);
        if let Some(hit) = first.0 {
            counted.add(hit.t);
        }
    }
    let recorded = Recorded::new(&mut tracer, view, isovalue);
    let (times, found) = interleave_kept(
        repeat,
        &mut [
            &mut || single_frame::<true, _>(&mut tracer, view, isovalue),
            &mut || paper_frame::<true, _>(paper, view, isovalue),
            &mut || recorded.intersect(view),
        ],
    );
    let [single, recursion, floor] = [found[0], found[1], found[2]];
    ensure!(floor == counted, "in the recorded cells was found {floor:?}, by the counted frame {counted:?}");
    ensure!(single == counted, "the timed frame found {single:?}, the counted one {counted:?}");
    compare_recursion(single, recursion)?;
    let rays = view.directions.len() as f64;
    Ok(ViewRow {
        isovalue,
        view: "",
        size: 0,
        hits: counted.hits,
        nodes_per_ray: work.nodes as f64 / rays,
        lookups_per_ray: work.lookups as f64 / rays,
        cells_per_ray: work.cells as f64 / rays,
        single_ns_per_ray: times[0] / rays * 1e9,
        knoll2006_ns_per_ray: times[1] / rays * 1e9,
        floor_ns_per_ray: times[2] / rays * 1e9,
    })
}

/// Makes sure that the recursion of 2006 hits about as often as our traversal.
pub(crate) fn compare_recursion(ours: Found, recursion: Found) -> Result<()> {
    let difference = ours.hits.abs_diff(recursion.hits);
    ensure!(
        difference < FEW_HITS || difference as f64 <= HITS_DIFFER * ours.hits as f64,
        "{} hits by the 2006 recursion, {} by ours: more than {HITS_DIFFER} of them differ",
        recursion.hits,
        ours.hits
    );
    Ok(())
}

// Each loop on its own, as in a program: inlined beside others it is up to a tenth slower, and not always.
#[inline(never)]
pub(crate) fn single_frame<const SHADED: bool, T: Scalar>(
    tracer: &mut Tracer<'_, T>,
    view: &View,
    isovalue: f32,
) -> Found {
    let mut found = Found::default();
    for &direction in &view.directions {
        if let Some(hit) = tracer.first_hit(&view.ray(direction), isovalue) {
            found.add(hit.t);
            finish::<SHADED>(hit.t, || hit.gradient(), direction);
        }
    }
    found
}

#[inline(never)]
pub(crate) fn paper_frame<const SHADED: bool, T: Scalar>(
    paper: &PaperOctree<T>,
    view: &View,
    isovalue: f32,
) -> Found {
    let mut found = Found::default();
    for &direction in &view.directions {
        if let Some(hit) = paper.first_hit(view.origin, direction, isovalue) {
            found.add(hit.t);
            finish::<SHADED>(hit.t, || hit.gradient, direction);
        }
    }
    found
}
