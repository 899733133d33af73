//! Levels of detail: how far coarse surfaces are from the finest, and to which side.
//!
//! A volume's coarse arrays are traced as volumes of their own, scaled so that samples stand where they stood, and depths compared ray by
//! ray. Bias shows in the mean of *signed* differences of one view; over opposite views a displacement cancels out.

mod judge;

use std::path::Path;

use anyhow::{Context, Result};
use glam::{DAffine3, DVec3};
use isoray_build::{FileOptions, build, build_with};
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_octree::{Coarse, OctreeVolume, coarse_dims, coarse_position};
use isoray_trace::{Ray, Tracer};
use plotters::prelude::*;
use rayon::prelude::*;
use serde::Serialize;

use super::chart;
use crate::catalog::{Dense, DenseVisitor, Entry};
use crate::root;

const KINDS: [Coarse; 3] = [Coarse::Mean, Coarse::Injected, Coarse::Filtered];
const LEVELS: std::ops::RangeInclusive<u32> = 1..=4;
/// Hits that are farther apart, in coarse voxels, are on different sheets of a surface: the paper's placement displaces it by less than 0.87, and so a hit by less than
/// this unless the ray is within 13° of the surface.
const SAME: f64 = 4.0;

/// One kind at one level.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LodRow {
    volume: String,
    kind: &'static str,
    level: u32,
    /// The whole file, in % of that with injection.
    percent: f64,
    views: Vec<LodView>,
}

/// One direction.
#[derive(Clone, Debug, Serialize)]
struct LodView {
    /// Signs of the components along x, y and z; all of one size.
    direction: [i32; 3],
    /// Differences of depths from those of the volume itself along rays that hit the same place in both, in fine voxels; positive is farther.
    mean: f64,
    rms: f64,
    /// Rays that hit in one only, and those whose hits are more than [`SAME`] coarse voxels apart, in % of those that hit at all.
    one_only: f64,
    elsewhere: f64,
    /// The mean of the latter's differences too.
    mean_of_all: f64,
    /// Rays that hit the volume itself, and those of them that hit the same place in both.
    hits: u64,
    common: u64,
}

/// What is measured, in the end.
struct Subject<'a> {
    name: &'a str,
    isovalue: f32,
    /// Rays along each side of a view.
    rays: u32,
    /// Change of a linear volume's values by voxel along each axis.
    slope: Option<[f64; 3]>,
    /// Whether rays of a direction can hit in one place only.
    is_single: fn([i32; 3]) -> bool,
    /// The last levels whose bias is to be a tenth of the paper's, at most: in each direction, and in that where it is largest; 0: none is.
    kept: [u32; 2],
}

/// What makes a subject and measures it.
type Measured<'m> = &'m dyn Fn(&Subject<'_>) -> Result<Vec<LodRow>>;

/// Of subjects that are held to something else, or to nothing.
const NONE_KEPT: [u32; 2] = [0; 2];

pub(crate) fn run(quick: bool, docs: bool, data: &Path, only: Option<&str>) -> Result<Vec<LodRow>> {
    println!(
        "\nLevels of detail: mean signed depth error in fine voxels by direction of view, and the largest of \
         all: mean, root mean square, % of rays that hit in one only, that hit elsewhere\n{:<22} {:<9} {:>5} {:>6}  {}",
        "volume",
        "kind",
        "level",
        "size %",
        directions().iter().map(|d| format!("{:>8}", name(*d))).collect::<String>()
    );
    let rays = if quick { 64 } else { 384 };
    let mut rows = Vec::new();
    let mut add = |name: &str, isovalue, slope, is_single, kept, volume: Measured<'_>| {
        if only.is_none_or(|only| name.contains(only)) {
            let subject = Subject { name, isovalue, rays, slope, is_single, kept };
            let found = volume(&subject)?;
            judge::judge(&subject, &found)?;
            rows.extend(found);
        }
        anyhow::Ok(())
    };
    let always: fn([i32; 3]) -> bool = |_| true;
    let n = if quick { 65 } else { 129 };
    let size = f64::from(n);
    // No two of the sums of components, with any signs, are near zero: no view is along the surface.
    let slope = [0.3, 0.6, 1.2];
    let value = |p: [f64; 3]| (p[0] * slope[0] + p[1] * slope[1] + p[2] * slope[2]) as f32;
    add("ramp f32", value([size / 2.0; 3]), Some(slope), always, NONE_KEPT, &|s| {
        measure(s, &generated([n; 3], value)?)
    })?;
    let slope = [1.0, 2.0, 4.0];
    let value = |p: [f64; 3]| 1000 + p[0] as u16 + 2 * p[1] as u16 + 4 * p[2] as u16;
    let middle = f32::from(value([f64::from(n / 2); 3])) + 0.5;
    add("ramp u16", middle, Some(slope), always, NONE_KEPT, &|s| measure(s, &generated([n; 3], value)?))?;

    // An interpolant of a convex field lies above it: a cell of edge h moves the sphere inwards by h²/6r on average, and depths by twice that. At level
    // 4 that is a tenth of what the paper's placement does to the diagonals where it does least, 15/2√3, if r is 14 coarse voxels. In short runs r is
    // that at level 1, half of it at level 2, and what is asked is a tenth of what is done to the diagonals where it is most, three times that.
    let kept = if quick { [0, 2] } else { [4, 4] };
    let n = if quick { 65 } else { 513 };
    let (radius, centre) = (0.45 * f64::from(n), DVec3::splat(f64::from(n - 1) / 2.0));
    let value = |p: [f64; 3]| (DVec3::from_array(p).distance(centre) - radius) as f32;
    add(&format!("sphere {n}"), 0.0, None, always, kept, &|s| measure(s, &generated([n; 3], value)?))?;
    // Its ripples are 2/18.8 wide where they are narrowest: 108 voxels of this part of a lattice of 2049³, and seven samples of level 4. On a lattice
    // of 513³ they would be 27, fewer than two samples of level 4, which no kind of sample can show.
    let dims = if quick { [65, 65, 97] } else { [257, 257, 385] };
    let step = if quick { 1.0 / 256.0 } else { 1.0 / 1024.0 };
    let value = |p: [f64; 3]| marschner_lobb([0.4 + step * p[0], 0.3 + step * p[1], step * p[2] - 0.1875]);
    // Along z it is a graph.
    let along_z = |d: [i32; 3]| d[0] == 0 && d[1] == 0;
    add("Marschner-Lobb", 0.5, None, along_z, kept, &|s| measure(s, &generated(dims, value)?))?;
    let real = if quick { vec![Entry::fixture()] } else { Entry::all(&[], data) };
    for entry in real.iter().filter(|e| quick || e.name == "heptane") {
        let isovalue = entry.isovalues.first().copied().unwrap_or_default();
        add(&entry.name, isovalue, None, |_| false, NONE_KEPT, &|s| entry.visit(Real(s))?)?;
    }
    if docs && !quick {
        draw(&rows, &root().join("docs/pictures/lod.svg"))?;
    }
    Ok(rows)
}

/// The signal of Marschner and Lobb (1994), from 0 to 1.
fn marschner_lobb([x, y, z]: [f64; 3]) -> f32 {
    use std::f64::consts::PI;
    let ring = (2.0 * PI * 6.0 * (PI * x.hypot(y) / 2.0).cos()).cos();
    ((1.0 - (PI * z / 2.0).sin() + 0.25 * (1.0 + ring)) / 2.5) as f32
}

fn generated<T: Scalar>(n: [u32; 3], value: impl Fn([f64; 3]) -> T + Sync) -> Result<Dense<T>> {
    let dims = Dims::new(n)?;
    let mut samples = vec![T::default(); dims.samples()];
    samples.par_chunks_mut(dims.layer()).enumerate().for_each(|(z, layer)| {
        for (i, sample) in layer.iter_mut().enumerate() {
            let [x, y] = [i % n[0] as usize, i / n[0] as usize];
            *sample = value([x, y, z].map(|c| c as f64));
        }
    });
    Ok(Dense { dims, samples, index_to_world: DAffine3::IDENTITY })
}

struct Real<'a>(&'a Subject<'a>);

impl DenseVisitor for Real<'_> {
    type Output = Result<Vec<LodRow>>;

    /// Measures as much of the volume as makes whole cells of the coarsest level.
    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let [nx, ny, _] = volume.dims.axes().map(|n| n as usize);
        let n = volume.dims.axes().map(|n| ((n - 1) & !((1 << LEVELS.end()) - 1)) + 1);
        let part = generated(n, |p| {
            let [x, y, z] = p.map(|c| c as usize);
            volume.samples[(z * ny + y) * nx + x]
        })?;
        measure(self.0, &part)
    }
}

fn measure<T: Scalar>(subject: &Subject<'_>, volume: &Dense<T>) -> Result<Vec<LodRow>> {
    let mut rows = Vec::new();
    let mut exact: Vec<Vec<f64>> = Vec::new();
    let mut bytes = None;
    // Injection first: it is what the others are compared with.
    for kind in [Coarse::Injected, Coarse::Mean, Coarse::Filtered] {
        let mut source = DenseVolume::new(volume.dims, &volume.samples)?;
        let options = FileOptions { coarse: kind, ..FileOptions::default() };
        let octree = build_with(&mut source, &options, |_| {}).context("cannot build")?;
        let injected = *bytes.get_or_insert(octree.file_bytes());
        if exact.is_empty() {
            let of = |&d: &[i32; 3]| depths(&octree, volume.dims, d, 0, subject);
            exact = directions().iter().map(of).collect();
        }
        for level in LEVELS {
            let coarse = extract(&octree, level)?;
            let view = |(&direction, exact): (&[i32; 3], &Vec<f64>)| {
                let same =
                    if (subject.is_single)(direction) { f64::INFINITY } else { SAME * f64::from(1 << level) };
                compare(direction, exact, &depths(&coarse, volume.dims, direction, level, subject), same)
            };
            rows.push(LodRow {
                volume: subject.name.to_owned(),
                kind: kind.name(),
                level,
                percent: 100.0 * octree.file_bytes() as f64 / injected as f64,
                views: directions().iter().zip(&exact).map(view).collect(),
            });
        }
    }
    let kind = |row: &LodRow| KINDS.iter().position(|kind| kind.name() == row.kind);
    rows.sort_by_key(|row| (row.level, kind(row)));
    rows.iter().for_each(print);
    Ok(rows)
}

/// The coarse samples of a level as a volume of its own.
fn extract<T: Scalar>(octree: &OctreeVolume<T>, level: u32) -> Result<OctreeVolume<T>> {
    let (view, kind) = (octree.view(), octree.meta().coarse);
    let dims = Dims::new(coarse_dims(view.dims(), level))?;
    let [nx, _, _] = dims.axes();
    let mut samples = vec![T::default(); dims.samples()];
    samples.par_chunks_mut(dims.layer()).enumerate().for_each(|(z, layer)| {
        for (sample, i) in layer.iter_mut().zip(0u32..) {
            let p = coarse_position(view.dims(), level, [i % nx, i / nx, z as u32]);
            *sample = view.coarse_sample(level, p, kind).unwrap_or_default();
        }
    });
    build(&mut DenseVolume::new(dims, &samples)?, DAffine3::IDENTITY, |_| {}).context("cannot build")
}

/// Three axes and four diagonals, both ways.
fn directions() -> Vec<[i32; 3]> {
    let sign = |bit: u32| if bit == 0 { -1 } else { 1 };
    let axes = (0..6u32).map(|n| std::array::from_fn(|a| if n as usize / 2 == a { sign(n % 2) } else { 0 }));
    axes.chain((0..8u32).map(|n| std::array::from_fn(|a| sign(n >> a & 1)))).collect()
}

fn name(direction: [i32; 3]) -> String {
    let part = |(&sign, axis): (&i32, char)| match sign {
        0 => String::new(),
        1 => format!("+{axis}"),
        _ => format!("-{axis}"),
    };
    direction.iter().zip("xyz".chars()).map(part).collect()
}

/// Depths of an orthographic view of a volume of `dims`, in its voxels, infinite where nothing is hit; `volume` is that of `level`.
fn depths<T: Scalar>(
    volume: &OctreeVolume<T>,
    dims: Dims,
    direction: [i32; 3],
    level: u32,
    subject: &Subject<'_>,
) -> Vec<f64> {
    let last = DVec3::from_array(dims.axes().map(|n| f64::from(n - 1)));
    let forward = DVec3::from_array(direction.map(f64::from)).normalize();
    let (right, up) = forward.any_orthonormal_pair();
    let (radius, rays) = (last.length() / 2.0, subject.rays);
    // A power of two, so that rays are the same to the bit at each level.
    let scale = f64::from(1 << level).recip();
    let structure = volume.view();
    let depth = |tracer: &mut Tracer<'_, T>, n: u32| {
        let place = |n: u32| radius * (2.0 * (f64::from(n) + 0.5) / f64::from(rays) - 1.0);
        let origin = last / 2.0 + place(n % rays) * right + place(n / rays) * up - radius * forward;
        let ray = Ray {
            origin: origin.to_array().map(|c| c as f32 * scale as f32),
            direction: forward.to_array().map(|c| c as f32 * scale as f32),
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        tracer.first_hit(&ray, subject.isovalue).map_or(f64::INFINITY, |hit| hit.t.into())
    };
    (0..rays * rays).into_par_iter().map_init(|| Tracer::new(&structure), depth).collect()
}

fn compare(direction: [i32; 3], exact: &[f64], coarse: &[f64], same: f64) -> LodView {
    let pairs = || exact.iter().zip(coarse);
    let both = || pairs().filter(|(a, b)| a.is_finite() && b.is_finite()).map(|(a, b)| b - a);
    let hits = pairs().filter(|(a, b)| a.is_finite() || b.is_finite()).count().max(1) as f64;
    let near = || both().filter(|d| d.abs() <= same);
    let (count, there) = (both().count() as f64, near().count() as f64);
    LodView {
        direction,
        mean: near().sum::<f64>() / there.max(1.0),
        rms: (near().map(|d| d * d).sum::<f64>() / there.max(1.0)).sqrt(),
        one_only: 100.0 * (hits - count) / hits,
        elsewhere: 100.0 * (count - there) / hits,
        mean_of_all: both().sum::<f64>() / count.max(1.0),
        hits: exact.iter().filter(|t| t.is_finite()).count() as u64,
        common: near().count() as u64,
    }
}

impl LodRow {
    /// The largest of all directions, in size.
    fn worst(&self, of: impl Fn(&LodView) -> f64) -> f64 {
        self.views.iter().map(|view| of(view).abs()).fold(0.0, f64::max)
    }
}

fn print(row: &LodRow) {
    println!(
        "{:<22} {:<9} {:>5} {:>6.1}  {} | {:>8.4} {:>7.3} {:>6.2} {:>6.2}",
        row.volume,
        row.kind,
        row.level,
        row.percent,
        row.views.iter().map(|v| format!("{:>8.4}", v.mean)).collect::<String>(),
        row.worst(|v| v.mean),
        row.worst(|v| v.rms),
        row.worst(|v| v.one_only),
        row.worst(|v| v.elsewhere)
    );
}

/// Bias by level, that of the direction in which it is largest.
fn draw(rows: &[LodRow], file: &Path) -> Result<()> {
    let mut lines: Vec<(&str, &str)> = Vec::new();
    for row in rows.iter().filter(|row| !row.volume.starts_with("ramp")) {
        if !lines.contains(&(&row.volume, row.kind)) {
            lines.push((&row.volume, row.kind));
        }
    }
    chart::save(file, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption("Mean signed depth error in the direction where it is largest", ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(70)
            // Room for the legend above.
            .build_cartesian_2d(0.8..4.2, (1e-4..1e4).log_scale())?;
        chart.configure_mesh().x_desc("level").y_desc("fine voxels").x_labels(4).draw()?;
        for (n, (volume, kind)) in lines.iter().enumerate() {
            let colour = Palette99::pick(n).to_rgba();
            let points: Vec<(f64, f64)> = rows
                .iter()
                .filter(|r| r.volume == *volume && r.kind == *kind)
                .map(|r| (f64::from(r.level), r.worst(|v| v.mean)))
                .collect();
            chart
                .draw_series(LineSeries::new(points.clone(), colour))?
                .label(format!("{volume}: {kind}"))
                .legend(move |(x, y)| Circle::new((x + 6, y), 4, colour.filled()));
            chart.draw_series(points.into_iter().map(|p| Circle::new(p, 4, colour.filled())))?;
        }
        chart::legend(&mut chart)
    })
}
