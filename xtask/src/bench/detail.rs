//! Levels of detail in pictures: time against error over the ratio, by kind of coarse sample and by what the level depends on.

use anyhow::{Context, Result, ensure};
use isoray_build::{FileOptions, build_with};
use isoray_grid::{DenseVolume, Scalar};
use isoray_octree::lod::{Detail, DetailRequest, DetailView, DistanceMeasure};
use isoray_octree::{Coarse, OctreeVolume};
use isoray_render::{Camera, Image, Scene, Traversal, render, render_counted};
use serde::Serialize;

use super::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};

/// Titles of the columns.
pub(crate) const HEADER: &str = "\nLevels of detail, one thread: how many times as fast as the exact picture, with packets as the tracer chooses and with single rays; root mean square difference of depths, in fine voxels,\nwhere both hit nearer to each other than 8 coarsest voxels; pixels of the silhouette and those that hit elsewhere, in % of the exact hits; root mean square difference of linear colour.\nvolume                 iso    view   size ratio variant          | levels | ×auto ×single | depth  silhouette elsewhere  colour | lookups/ray";

const RATIOS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// What is varied.
struct Variant {
    name: &'static str,
    coarse: Coarse,
    blend: f64,
    by_slices: bool,
}

const VARIANTS: [Variant; 6] = [
    Variant { name: "injected", coarse: Coarse::Injected, blend: 0.0, by_slices: false },
    Variant { name: "filtered", coarse: Coarse::Filtered, blend: 0.0, by_slices: false },
    Variant { name: "mean", coarse: Coarse::Mean, blend: 0.0, by_slices: false },
    Variant { name: "injected, slices", coarse: Coarse::Injected, blend: 0.0, by_slices: true },
    Variant { name: "injected, ½ band", coarse: Coarse::Injected, blend: 0.5, by_slices: false },
    Variant { name: "filtered, ½ band", coarse: Coarse::Filtered, blend: 0.5, by_slices: false },
];

/// One picture against the exact one.
#[derive(Debug, Serialize)]
pub(crate) struct DetailRow {
    volume: String,
    isovalue: f32,
    view: &'static str,
    size: u32,
    ratio: f64,
    variant: &'static str,
    /// The finest and the coarsest that may be drawn.
    levels: [u32; 2],
    times_exact: f64,
    times_exact_single: f64,
    #[serde(flatten)]
    error: PictureError,
    lookups_per_ray: f64,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct PictureError {
    depth_rms_voxels: f64,
    silhouette_percent: f64,
    elsewhere_percent: f64,
    color_rms: f64,
}

pub(crate) struct Details<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) sizes: &'a [u32],
    pub(crate) repeat: usize,
}

impl DenseVisitor for Details<'_> {
    type Output = Result<Vec<DetailRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("no thread")?;
        let volumes = [Coarse::Injected, Coarse::Filtered, Coarse::Mean].map(|coarse| {
            let options =
                FileOptions { index_to_world: volume.index_to_world, coarse, ..FileOptions::default() };
            let mut source = DenseVolume::new(volume.dims, &volume.samples)?;
            anyhow::Ok((coarse, build_with(&mut source, &options, |_| {})?))
        });
        let volumes = volumes.into_iter().collect::<Result<Vec<_>>>()?;
        let mut rows = Vec::new();
        for &size in self.sizes {
            for place in [Place::Far, Place::Close] {
                let camera = volume.camera(place, size)?;
                for variant in &VARIANTS {
                    let Some((_, octree)) = volumes.iter().find(|v| v.0 == variant.coarse) else { continue };
                    for ratio in RATIOS {
                        let found = pool.install(|| self.row(octree, &camera, place, ratio, variant))?;
                        if let Some(row) = found {
                            println!("{}", line(&row));
                            rows.push(row);
                        }
                    }
                }
            }
        }
        Ok(rows)
    }
}

impl Details<'_> {
    /// `None` if all is drawn at the finest level.
    fn row<T: Scalar>(
        &self,
        volume: &OctreeVolume<T>,
        camera: &Camera,
        place: Place,
        ratio: f64,
        variant: &Variant,
    ) -> Result<Option<DetailRow>> {
        let meta = volume.meta();
        let isovalue = self.entry.isovalues[0];
        let measure = match variant.by_slices {
            true => DistanceMeasure::Slices(camera.forward()),
            false => DistanceMeasure::True,
        };
        let request = DetailRequest { pixel: camera.pixel_width(), ratio, measure, blend: variant.blend };
        let detail = Detail::new(meta.dims, &meta.index_to_world, &request);
        let levels = [*detail.levels().start(), *detail.levels().end()];
        if levels[1] == 0 {
            return Ok(None);
        }
        let octree = volume.view();
        let view = DetailView::new(&octree, variant.coarse, detail);
        let scene = Scene::of(isovalue);
        let single = Scene { traversal: Traversal::Single, ..scene.clone() };
        let to_world = meta.index_to_world;
        let exact = render(&octree, to_world, camera, &scene);
        let (found, statistics) = render_counted(&view, to_world, camera, &scene);
        let alone = render(&view, to_world, camera, &single);
        ensure!(
            found.pixels().iter().zip(alone.pixels()).all(|(a, b)| a.depth.to_bits() == b.depth.to_bits()),
            "{}: packets and single rays differ",
            self.entry.name
        );
        let (times, timed) = interleave_kept(
            self.repeat,
            &mut [
                &mut || render(&octree, to_world, camera, &scene),
                &mut || render(&view, to_world, camera, &scene),
                &mut || render(&octree, to_world, camera, &single),
                &mut || render(&view, to_world, camera, &single),
            ],
        );
        ensure!(
            timed.iter().eq([&exact, &found, &exact, &alone]),
            "{}: timed are other pictures",
            self.entry.name
        );
        let voxel = to_world.matrix3.x_axis.length();
        Ok(Some(DetailRow {
            volume: self.entry.name.clone(),
            isovalue,
            view: place.name(),
            size: camera.size()[0],
            ratio,
            variant: variant.name,
            levels,
            times_exact: times[0] / times[1],
            times_exact_single: times[2] / times[3],
            error: compare(&exact, &found, voxel, 8.0 * voxel * f64::from(1u32 << levels[1])),
            lookups_per_ray: statistics.work.lookups as f64 / statistics.rays as f64,
        }))
    }
}

/// Depths nearer to each other than `same` are of one sheet of a surface.
fn compare(exact: &Image, found: &Image, voxel: f64, same: f64) -> PictureError {
    let (mut hits, mut silhouette, mut elsewhere, mut squares, mut color) = (0u64, 0u64, 0u64, 0.0, 0.0);
    for (a, b) in exact.pixels().iter().zip(found.pixels()) {
        hits += u64::from(a.depth.is_finite());
        color += f64::from((a.color - b.color).length_squared());
        let difference = f64::from(b.depth) - f64::from(a.depth);
        match (a.depth.is_finite(), b.depth.is_finite()) {
            (true, true) if difference.abs() < same => squares += (difference / voxel).powi(2),
            (true, true) => elsewhere += 1,
            (false, false) => {}
            _ => silhouette += 1,
        }
    }
    let percent = |n: u64| 100.0 * n as f64 / hits.max(1) as f64;
    PictureError {
        depth_rms_voxels: (squares / hits.max(1) as f64).sqrt(),
        silhouette_percent: percent(silhouette),
        elsewhere_percent: percent(elsewhere),
        color_rms: (color / exact.pixels().len() as f64).sqrt(),
    }
}

fn line(row: &DetailRow) -> String {
    let PictureError { depth_rms_voxels, silhouette_percent, elsewhere_percent, color_rms } = row.error;
    format!(
        "{:<20} {:>6} {:>7} {:>6} {:>5} {:<16} | {:>3}-{:<2} | {:>5.2} {:>7.2} | {depth_rms_voxels:>6.3} {silhouette_percent:>9.3} {elsewhere_percent:>9.3} {color_rms:>8.5} | {:>11.2}",
        row.volume,
        row.isovalue,
        row.view,
        row.size,
        row.ratio,
        row.variant,
        row.levels[0],
        row.levels[1],
        row.times_exact,
        row.times_exact_single,
        row.lookups_per_ray,
    )
}
