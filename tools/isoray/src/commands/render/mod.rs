//! `isoray render`.

mod flags;
mod frames;
mod lighting;
mod stats;
mod surface;
mod view;
mod volume;
mod write;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use isoray_render::Camera;

use super::use_threads;
use crate::cli::RenderArgs;
use crate::load::{Loaded, load};
use crate::output::{to_stdout, write_file};

use frames::Rendered;
use stats::FrameStats;
pub(crate) use stats::Stats;
use write::{Format, write};

pub(crate) fn run(args: &RenderArgs) -> Result<()> {
    let stats = render(args)?;
    to_stdout(|out| {
        let [width, height] = args.size;
        writeln!(out, "{}: {width} x {height} pixels, {}", args.output.display(), stats.what)
    })?;
    match &args.stats {
        Some(None) => to_stdout(|out| stats.print(out)),
        Some(Some(file)) => write_json(file, &stats),
        None => Ok(()),
    }
}

/// Renders to the output file and tells what it took; prints nothing but warnings and what was proposed.
pub(crate) fn render(args: &RenderArgs) -> Result<Stats> {
    let format = Format::of(&args.output)?;
    flags::check(args)?;
    use_threads(args.threads)?;

    let loaded = load(&args.file, &args.source)?;
    let meta = loaded.volume.meta();
    let camera = view::camera(args, meta.dims, &meta.index_to_world)?;
    let (rendered, what) = match args.volume.volume {
        true => volume::render(args, &loaded, &camera)?,
        false => surface::render(args, &loaded, &camera)?,
    };
    let begin = Instant::now();
    write(&args.output, format, &rendered.image, args)?;
    let frame = frame_stats(args, &loaded, &camera, &rendered, begin.elapsed().as_secs_f64());
    Ok(Stats { what, frame })
}

fn frame_stats(
    args: &RenderArgs,
    loaded: &Loaded,
    camera: &Camera,
    rendered: &Rendered,
    write_s: f64,
) -> FrameStats {
    let mut times = rendered.times.clone();
    times.sort_by(f64::total_cmp);
    let render_s = times.get(times.len() / 2).copied().unwrap_or(f64::NAN);
    let [width, height] = camera.size();
    let rays = u64::from(width) * u64::from(height);
    let per_ray = |n: u64| n as f64 / rays as f64;
    FrameStats {
        width,
        height,
        open_s: loaded.open_s,
        build_s: loaded.build_s,
        render_s,
        write_s,
        repeat: args.repeat,
        threads: rayon::current_num_threads(),
        rays,
        mrays_per_s: rays as f64 / render_s / 1e6,
        nodes_per_ray: per_ray(rendered.work.nodes),
        lookups_per_ray: per_ray(rendered.work.lookups),
        cells_per_ray: per_ray(rendered.work.cells),
        structure_bytes: rendered.structure_bytes,
        raw_bytes: rendered.raw_bytes,
        traversal: "single",
    }
}

fn write_json(path: &Path, stats: &Stats) -> Result<()> {
    let json = serde_json::to_vec_pretty(stats)?;
    write_file(path, &json).with_context(|| format!("{}: cannot write the statistics", path.display()))
}
