//! `isoray info`.

use std::io::{self, Write};

use anyhow::Result;
use glam::DVec3;
use isoray_grid::{Dims, Scalar};
use isoray_io::AmrDataset;
use isoray_octree::{
    Fidelity, HISTOGRAM_BINS, LevelStatistics, OctreeVolume, SurfaceFidelity, VolumeVisitor, is_series,
};
use serde::Serialize;

use super::build::Sizes;
use super::{bytes, cpu, mesh_info};
use crate::cli::InfoArgs;
use crate::load::load;
use crate::output::to_stdout;
use crate::series;

/// Everything that is printed, and the JSON form of it.
#[derive(Debug, Serialize)]
struct Info {
    file: String,
    format: String,
    dims: [u32; 3],
    #[serde(rename = "type")]
    scalar: &'static str,
    /// Three axes and the translation: world = x·i + y·j + z·k + t.
    index_to_world: [[f64; 3]; 4],
    world_bounds: [[f64; 3]; 2],
    range: Option<[f64; 2]>,
    non_finite: u64,
    /// What is guaranteed of the samples of a lossy volume.
    loss: Option<String>,
    /// What the samples of the levels of detail are.
    levels_of_detail: &'static str,
    histogram: Vec<u64>,
    levels: Vec<Level>,
    octree_bytes: u64,
    raw_bytes: u64,
    percent_of_raw: f64,
}

#[derive(Debug, Serialize)]
struct Level {
    edge: u32,
    count: usize,
    bytes: usize,
}

pub(crate) fn run(args: &InfoArgs) -> Result<()> {
    // Only --cpu goes without a file.
    let Some(file) = args.file.as_deref() else { return cpu::run(args.json) };
    if is_series(file) {
        return series::info(file, args);
    }
    if AmrDataset::recognises(file) {
        return mesh_info::run(file, args);
    }
    let loaded = load(file, &args.source)?;
    let volume = loaded.volume.octree(file)?;
    let meta = volume.meta();
    let (raw_bytes, octree_bytes) = volume.visit(Sizes);
    let affine = meta.index_to_world;
    let info = Info {
        file: file.display().to_string(),
        format: loaded.format,
        dims: meta.dims.axes(),
        scalar: volume.scalar().name(),
        index_to_world: [affine.x_axis, affine.y_axis, affine.z_axis, affine.w_axis].map(plain),
        world_bounds: world_bounds(meta.dims, &affine).map(plain),
        range: meta.range,
        non_finite: meta.non_finite,
        loss: (!meta.fidelity.is_lossless()).then(|| bounds(&meta.fidelity)),
        levels_of_detail: meta.coarse.name(),
        histogram: meta.histogram.to_vec(),
        levels: volume.visit(Levels),
        octree_bytes,
        raw_bytes,
        percent_of_raw: 100.0 * octree_bytes as f64 / raw_bytes as f64,
    };
    let json = if args.json { Some(serde_json::to_string_pretty(&info)?) } else { None };
    to_stdout(|out| match json {
        Some(json) => writeln!(out, "{json}"),
        None => print(&info, out),
    })
}

/// The bounds of a loss, in words.
fn bounds(Fidelity { tolerance, surface, range }: &Fidelity) -> String {
    let mut bounds = Vec::new();
    if tolerance.is_finite() {
        bounds.push(format!("samples within {tolerance} of the original"));
    }
    if let Some(SurfaceFidelity { displacement, isovalues: [low, high], is_range }) = surface {
        let which = if *is_range { "all isovalues" } else { "the isovalues listed" };
        bounds.push(format!("isosurfaces of {which} from {low} to {high} within {displacement} voxels"));
    }
    if let Some([low, high]) = range {
        bounds.push(format!("samples and isosurfaces from {low} to {high} exact"));
    }
    bounds.join("; ")
}

/// The components, without negative zeros.
pub(crate) fn plain(v: DVec3) -> [f64; 3] {
    (v + DVec3::ZERO).to_array()
}

struct Levels;

impl VolumeVisitor for Levels {
    type Output = Vec<Level>;
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Vec<Level> {
        let level = |LevelStatistics { edge, count, bytes }| Level { edge, count, bytes };
        volume.statistics().into_iter().map(level).collect()
    }
}

/// The smallest box along the world's axes that holds the domain.
pub(crate) fn world_bounds(dims: Dims, affine: &glam::DAffine3) -> [DVec3; 2] {
    let last = dims.axes().map(|n| f64::from(n - 1));
    let corner =
        |n: usize| DVec3::from_array(std::array::from_fn(|a| if n >> a & 1 == 1 { last[a] } else { 0.0 }));
    let corners = (0..8).map(|n| affine.transform_point3(corner(n)));
    corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)])
}

fn print(info: &Info, out: &mut dyn Write) -> io::Result<()> {
    let vector = |v: [f64; 3]| format!("{}, {}, {}", v[0], v[1], v[2]);
    let [x, y, z, t] = info.index_to_world;
    writeln!(out, "{}: {}", info.file, info.format)?;
    writeln!(out, "  dimensions    {} x {} x {}", info.dims[0], info.dims[1], info.dims[2])?;
    writeln!(out, "  type          {}", info.scalar)?;
    writeln!(out, "  index to world")?;
    writeln!(out, "    x axis      {}", vector(x))?;
    writeln!(out, "    y axis      {}", vector(y))?;
    writeln!(out, "    z axis      {}", vector(z))?;
    writeln!(out, "    origin      {}", vector(t))?;
    writeln!(out, "  world bounds  {}  to  {}", vector(info.world_bounds[0]), vector(info.world_bounds[1]))?;
    match info.range {
        Some([low, high]) => writeln!(out, "  values        {low} to {high}")?,
        None => writeln!(out, "  values        none is finite")?,
    }
    if info.non_finite > 0 {
        writeln!(out, "  not finite    {} samples", info.non_finite)?;
    }
    writeln!(out, "  fidelity      {}", info.loss.as_deref().unwrap_or("lossless"))?;
    writeln!(out, "  coarse levels {}", info.levels_of_detail)?;
    print_histogram(info, out)?;
    writeln!(out, "  octree        {} levels; the caps are 4 samples wide", info.levels.len())?;
    writeln!(out, "    {:>8}  {:>12}  {:>12}", "edge", "elements", "size")?;
    for level in &info.levels {
        writeln!(out, "    {:>8}  {:>12}  {:>12}", level.edge, level.count, bytes(level.bytes as u64))?;
    }
    writeln!(
        out,
        "  size          {} of {} raw: {:.1} %",
        bytes(info.octree_bytes),
        bytes(info.raw_bytes),
        info.percent_of_raw
    )
}

/// Rows of the histogram as text.
const ROWS: usize = 16;
/// Characters of the longest bar.
const BAR: f64 = 50.0;

/// Bars of logarithmic length: the air around a scan would make all others vanish.
fn print_histogram(info: &Info, out: &mut dyn Write) -> io::Result<()> {
    let Some([low, high]) = info.range else { return Ok(()) };
    let rows: Vec<u64> = info.histogram.chunks(HISTOGRAM_BINS / ROWS).map(|bins| bins.iter().sum()).collect();
    let longest = rows.iter().map(|&n| (n as f64 + 1.0).ln()).fold(f64::MIN_POSITIVE, f64::max);
    writeln!(out, "  histogram     (bars are logarithmic)")?;
    for (row, &n) in rows.iter().enumerate() {
        let from = low + (high - low) * row as f64 / ROWS as f64;
        let bar = "#".repeat(((n as f64 + 1.0).ln() / longest * BAR).round() as usize);
        writeln!(out, "    {from:>12.5}  {n:>12}  {bar}")?;
    }
    Ok(())
}
