//! Shadows and the sky through coarser levels than the picture: time against error over the ratio.

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_octree::lod::DetailView;
use isoray_octree::{Coarse, OctreeVolume};
use isoray_render::{Camera, FarShadowed, Image, Light, Pixel, Scene, Traversal, render};
use serde::Serialize;

use super::picture::{LAMP, Pictures};
use super::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};

/// Titles of the columns.
pub(crate) const HEADER: &str = "\nShadows of a lamp, and 16 rays to the sky, through coarser levels of an exact picture, one thread: what they add to a frame, exactly and so, in ns a hit; how many times as fast the frame is;
pixels that are darker and lighter by more than 1/64 in linear colour, in % of the hits; what the colour differs on average, in % of what they change in all.
volume                 iso    view   size ratio what    | levels | ns exact   ns far ×frame | darker  lighter  mean error";

const RATIOS: [f64; 3] = [2.0, 4.0, 8.0];
const SKY_SAMPLES: u32 = 16;

/// One picture against that with exact shadows.
#[derive(Debug, Serialize)]
pub(crate) struct ShadowRow {
    volume: String,
    isovalue: f32,
    view: &'static str,
    size: u32,
    ratio: f64,
    what: &'static str,
    levels: [u32; 2],
    exact_ns_per_hit: f64,
    far_ns_per_hit: f64,
    times_exact_frame: f64,
    darker_percent: f64,
    lighter_percent: f64,
    mean_error_percent: f64,
}

pub(crate) struct FarShadows<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) size: u32,
    pub(crate) repeat: usize,
}

impl DenseVisitor for FarShadows<'_> {
    type Output = Result<Vec<ShadowRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("no thread")?;
        let octree = volume.octree()?;
        let mut rows = Vec::new();
        for place in [Place::Far, Place::Close] {
            let camera = volume.camera(place, self.size)?;
            for what in ["shadows", "sky"] {
                for ratio in RATIOS {
                    let found = pool.install(|| self.row(&octree, &camera, place, what, ratio))?;
                    if let Some(row) = found {
                        println!("{}", line(&row));
                        rows.push(row);
                    }
                }
            }
        }
        Ok(rows)
    }
}

impl FarShadows<'_> {
    /// `None` if everything is at the finest level.
    fn row<T: Scalar>(
        &self,
        volume: &OctreeVolume<T>,
        camera: &Camera,
        place: Place,
        what: &'static str,
        ratio: f64,
    ) -> Result<Option<ShadowRow>> {
        let detail = Pictures::new(volume).detail(camera, ratio);
        let levels = [*detail.levels().start(), *detail.levels().end()];
        if levels[1] == 0 {
            return Ok(None);
        }
        let octree = volume.view();
        let view = DetailView::new(&octree, Coarse::Injected, detail);
        let far = FarShadowed { picture: &octree, far: &view };
        let isovalue = self.entry.isovalues[0];
        let without = Scene { lights: vec![Light::Direction(LAMP)], ambient: 0.4, ..Scene::of(isovalue) };
        let with = match what {
            "sky" => Scene { sky_samples: SKY_SAMPLES, ..without.clone() },
            _ => Scene { shadows: true, ..without.clone() },
        };
        let single = Scene { traversal: Traversal::Single, ..with.clone() };
        let to_world = volume.meta().index_to_world;
        let [plain, exact] = [&without, &with].map(|scene| render(&octree, to_world, camera, scene));
        let found = render(&far, to_world, camera, &with);
        ensure!(
            found == render(&far, to_world, camera, &single),
            "{}: packets and single rays differ",
            self.entry.name
        );
        let (seconds, timed) = interleave_kept(
            self.repeat,
            &mut [
                &mut || render(&octree, to_world, camera, &without),
                &mut || render(&octree, to_world, camera, &with),
                &mut || render(&far, to_world, camera, &with),
            ],
        );
        ensure!(timed.iter().eq([&plain, &exact, &found]), "{}: timed are other pictures", self.entry.name);
        let hits = exact.pixels().iter().filter(|pixel| pixel.depth.is_finite()).count() as f64;
        let [darker, lighter, error] = compare(&plain, &exact, &found);
        Ok(Some(ShadowRow {
            volume: self.entry.name.clone(),
            isovalue,
            view: place.name(),
            size: self.size,
            ratio,
            what,
            levels,
            exact_ns_per_hit: (seconds[1] - seconds[0]) / hits * 1e9,
            far_ns_per_hit: (seconds[2] - seconds[0]) / hits * 1e9,
            times_exact_frame: seconds[1] / seconds[2],
            darker_percent: 100.0 * darker / hits,
            lighter_percent: 100.0 * lighter / hits,
            mean_error_percent: 100.0 * error,
        }))
    }
}

/// How many pixels are darker and lighter than exactly, and the sum of all differences by that which shadows make.
fn compare(plain: &Image, exact: &Image, found: &Image) -> [f64; 3] {
    const SEEN: f32 = 1.0 / 64.0;
    let light = |pixel: &Pixel| pixel.color.element_sum() / 3.0;
    let (mut darker, mut lighter, mut error, mut change) = (0.0, 0.0, 0.0, 0.0);
    for ((plain, exact), found) in plain.pixels().iter().zip(exact.pixels()).zip(found.pixels()) {
        let difference = light(found) - light(exact);
        darker += f64::from(u8::from(difference < -SEEN));
        lighter += f64::from(u8::from(difference > SEEN));
        error += f64::from(difference.abs());
        change += f64::from((light(plain) - light(exact)).abs());
    }
    [darker, lighter, if change > 0.0 { error / change } else { f64::NAN }]
}

fn line(row: &ShadowRow) -> String {
    format!(
        "{:<20} {:>6} {:>7} {:>6} {:>5} {:<7} | {:>3}-{:<2} | {:>8.1} {:>8.1} {:>6.2} | {:>6.2} {:>8.2} {:>11.1}",
        row.volume,
        row.isovalue,
        row.view,
        row.size,
        row.ratio,
        row.what,
        row.levels[0],
        row.levels[1],
        row.exact_ns_per_hit,
        row.far_ns_per_hit,
        row.times_exact_frame,
        row.darker_percent,
        row.lighter_percent,
        row.mean_error_percent,
    )
}
