//! What a series is.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};
use isoray_octree::Series;
use serde::Serialize;

use crate::cli::InfoArgs;
use crate::commands::bytes;
use crate::commands::info::{plain, world_bounds};
use crate::failure::usage;
use crate::output::to_stdout;

/// Everything that is printed, and the JSON form of it.
#[derive(Debug, Serialize)]
struct SeriesInfo {
    file: String,
    format: &'static str,
    dims: [u32; 3],
    #[serde(rename = "type")]
    scalar: &'static str,
    /// Three axes and the translation: world = x·i + y·j + z·k + t.
    index_to_world: [[f64; 3]; 4],
    world_bounds: [[f64; 3]; 2],
    /// Of all steps together.
    range: Option<[f64; 2]>,
    octree_bytes: u64,
    raw_bytes: u64,
    percent_of_raw: f64,
    steps: Vec<StepInfo>,
}

#[derive(Debug, Serialize)]
struct StepInfo {
    file: String,
    range: Option<[f64; 2]>,
    non_finite: u64,
    /// Whether the samples are what they were.
    lossless: bool,
    octree_bytes: u64,
}

/// Prints a summary of a series from the headers of its steps.
pub(crate) fn info(file: &Path, args: &InfoArgs) -> Result<()> {
    if !args.source.is_empty() {
        return Err(usage(format!("{}: a series needs no flags that describe an input", file.display())));
    }
    let info = SeriesInfo::of(&Series::open(file)?)?;
    let json = if args.json { Some(serde_json::to_string_pretty(&info)?) } else { None };
    to_stdout(|out| match json {
        Some(json) => writeln!(out, "{json}"),
        None => info.print(out),
    })
}

impl SeriesInfo {
    fn of(series: &Series) -> Result<Self> {
        let mut steps = Vec::new();
        for (n, file) in series.files().iter().enumerate() {
            let volume = series.step(n)?;
            let meta = volume.meta();
            let length = fs::metadata(file).with_context(|| format!("{}: cannot be opened", file.display()));
            steps.push(StepInfo {
                file: series.name(n),
                range: meta.range,
                non_finite: meta.non_finite,
                lossless: meta.fidelity.is_lossless(),
                octree_bytes: length?.len(),
            });
        }
        let shape = series.shape();
        let affine = shape.index_to_world;
        let raw_bytes = (shape.dims.samples() * shape.scalar.size()) as u64 * steps.len() as u64;
        let octree_bytes = steps.iter().map(|step| step.octree_bytes).sum();
        let union = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
        Ok(Self {
            file: series.path().display().to_string(),
            format: "series of octree volumes",
            dims: shape.dims.axes(),
            scalar: shape.scalar.name(),
            index_to_world: [affine.x_axis, affine.y_axis, affine.z_axis, affine.w_axis].map(plain),
            world_bounds: world_bounds(shape.dims, &affine).map(plain),
            range: steps.iter().filter_map(|step| step.range).reduce(union),
            octree_bytes,
            raw_bytes,
            percent_of_raw: 100.0 * octree_bytes as f64 / raw_bytes as f64,
            steps,
        })
    }

    fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        let vector = |v: [f64; 3]| format!("{}, {}, {}", v[0], v[1], v[2]);
        let [x, y, z, t] = self.index_to_world;
        writeln!(out, "{}: {}", self.file, self.format)?;
        writeln!(out, "  steps         {}", self.steps.len())?;
        writeln!(out, "  dimensions    {} x {} x {}", self.dims[0], self.dims[1], self.dims[2])?;
        writeln!(out, "  type          {}", self.scalar)?;
        writeln!(out, "  index to world")?;
        writeln!(out, "    x axis      {}", vector(x))?;
        writeln!(out, "    y axis      {}", vector(y))?;
        writeln!(out, "    z axis      {}", vector(z))?;
        writeln!(out, "    origin      {}", vector(t))?;
        let [low, high] = self.world_bounds.map(vector);
        writeln!(out, "  world bounds  {low}  to  {high}")?;
        writeln!(out, "  values        {}", values(self.range))?;
        let raw = self.raw_bytes / self.steps.len() as u64;
        for (n, step) in self.steps.iter().enumerate() {
            let percent = 100.0 * step.octree_bytes as f64 / raw as f64;
            write!(out, "  step {n:<8} {:>12} {percent:>6.1} %  {}", bytes(step.octree_bytes), step.file)?;
            write!(out, ": {}", values(step.range))?;
            if step.non_finite > 0 {
                write!(out, ", {} not finite", step.non_finite)?;
            }
            writeln!(out, "{}", if step.lossless { "" } else { ", with loss" })?;
        }
        let (size, raw) = (bytes(self.octree_bytes), bytes(self.raw_bytes));
        writeln!(out, "  size          {size} of {raw} raw: {:.1} %", self.percent_of_raw)
    }
}

fn values(range: Option<[f64; 2]>) -> String {
    match range {
        Some([low, high]) => format!("{low} to {high}"),
        None => "none is finite".to_owned(),
    }
}
