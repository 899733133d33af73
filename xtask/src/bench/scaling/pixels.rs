//! One scene in pictures of all sizes.

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_octree::OctreeView;
use isoray_render::{Camera, Image, Scene, Traversal, render, render_counted};
use isoray_trace::Work;
use serde::Serialize;

use super::fit::Fit;
use super::{ScalingSuite, groups};
use crate::bench::picture::hits;
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};

/// A frame of one size, on one thread.
#[derive(Debug, Serialize)]
pub(crate) struct PixelRow {
    volume: String,
    isovalue: f32,
    view: &'static str,
    /// Pixels along each side.
    size: u32,
    ms: f64,
    ns_per_ray: f64,
    nodes_per_ray: f64,
    hits: u64,
}

pub(super) struct Pixels<'a> {
    pub(super) entry: &'a Entry,
    pub(super) quick: bool,
    pub(super) repeat: usize,
}

/// Pixels along each side, and in a short run.
const SIZES: [&[u32]; 2] = [&[256, 512, 1024, 2048, 4096], &[64, 128, 256]];
/// By how much the share of rays that hit may change from size to size: outlines are a part of a picture that shrinks with its pixels.
const HITS_DIFFER: f64 = 0.02;

impl DenseVisitor for Pixels<'_> {
    type Output = Result<Vec<PixelRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let octree = octree.view();
        let mut rows = Vec::new();
        for place in [Place::Far, Place::Close] {
            rows.extend(self.sizes(volume, &octree, place)?);
        }
        Ok(rows)
    }
}

/// A picture that has been compared, and what it took.
struct Checked {
    camera: Camera,
    image: Image,
    work: Work,
}

impl Pixels<'_> {
    /// Pictures of all sizes in turn: time by size then tells of sizes alone, if the machine's speed drifts.
    fn sizes<T: Scalar + Into<f64>>(
        &self,
        volume: &Dense<T>,
        octree: &OctreeView<'_, T>,
        place: Place,
    ) -> Result<Vec<PixelRow>> {
        let sizes = SIZES[usize::from(self.quick)];
        let checked: Vec<Checked> =
            sizes.iter().map(|&size| self.checked(volume, octree, place, size)).collect::<Result<_>>()?;
        let shares =
            checked.iter().zip(sizes).map(|(c, &size)| hits(&c.image) as f64 / f64::from(size).powi(2));
        let shares: Vec<f64> = shares.collect();
        for (share, size) in shares.windows(2).zip(&sizes[1..]) {
            ensure!(
                share[0] > 0.0 && (share[1] - share[0]).abs() <= HITS_DIFFER,
                "{}, {size}²: {} of the rays hit, in half the size {}",
                self.entry.name,
                share[1],
                share[0]
            );
        }
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
        let scene = self.scene();
        let frames = checked.iter().map(|Checked { camera, .. }| {
            || one.install(|| render(octree, volume.index_to_world, camera, &scene))
        });
        let mut frames: Vec<_> = frames.collect();
        let mut variants: Vec<&mut dyn FnMut() -> Image> =
            frames.iter_mut().map(|frame| frame as _).collect();
        let (times, timed) = interleave_kept(self.repeat, &mut variants);
        let mut rows = Vec::new();
        for (n, (checked, image)) in checked.iter().zip(timed).enumerate() {
            ensure!(image == checked.image, "{}, {}²: another picture when timed", self.entry.name, sizes[n]);
            let row = self.row(place, sizes[n], times[n], checked);
            println!(
                "{:<20} {:>6} {:>6} {:>9.2} {:>8.1} {:>10.2} {:>8.2}",
                row.volume,
                row.view,
                row.size,
                row.ms,
                row.ns_per_ray,
                row.nodes_per_ray,
                100.0 * shares[n]
            );
            rows.push(row);
        }
        Ok(rows)
    }

    fn scene(&self) -> Scene<'static> {
        Scene::of(self.entry.isovalues[0])
    }

    /// A picture, compared with that of single rays.
    fn checked<T: Scalar + Into<f64>>(
        &self,
        volume: &Dense<T>,
        octree: &OctreeView<'_, T>,
        place: Place,
        size: u32,
    ) -> Result<Checked> {
        let camera = volume.camera(place, size)?;
        let (image, statistics) = render_counted(octree, volume.index_to_world, &camera, &self.scene());
        let singly = Scene { traversal: Traversal::Single, ..self.scene() };
        ensure!(
            image == render(octree, volume.index_to_world, &camera, &singly),
            "{}, {size}²: not the picture of single rays",
            self.entry.name
        );
        Ok(Checked { camera, image, work: statistics.work })
    }

    fn row(&self, place: Place, size: u32, seconds: f64, checked: &Checked) -> PixelRow {
        let rays = f64::from(size).powi(2);
        PixelRow {
            volume: self.entry.name.clone(),
            isovalue: self.entry.isovalues[0],
            view: place.name(),
            size,
            ms: 1e3 * seconds,
            ns_per_ray: 1e9 * seconds / rays,
            nodes_per_ray: checked.work.nodes as f64 / rays,
            hits: hits(&checked.image),
        }
    }
}

/// Time by pixels.
pub(super) fn fits(suite: &ScalingSuite) -> Vec<Fit> {
    let of = |rows: &[PixelRow]| {
        let points = rows.iter().map(|row| [f64::from(row.size).powi(2), row.ms]);
        Fit::new(["time of a frame by pixels", rows[0].view], &rows[0].volume, points)
    };
    groups(&suite.pixels, |row| (row.volume.clone(), row.view)).filter_map(of).collect()
}
