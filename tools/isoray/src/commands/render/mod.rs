//! `isoray render`.

mod clipping;
mod colors;
mod detail;
mod flags;
mod frames;
mod lighting;
mod look;
mod outlines;
mod series;
mod stats;
mod structure;
mod surface;
mod view;
mod volume;
mod write;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use isoray_octree::is_series;
use isoray_render::Camera;

use super::use_threads;
use crate::cli::RenderArgs;
use crate::load::{Data, Loaded};
use crate::mesh;
use crate::output::{to_stdout, write_file};

use frames::Rendered;
use look::{Look, Shown};
use stats::FrameStats;
pub(crate) use stats::Stats;
use write::{Format, write};

pub(crate) fn run(args: &RenderArgs) -> Result<()> {
    if is_series(&args.file) || mesh::is_series(&args.file) {
        return series::run(args);
    }
    series::refuse(args)?;
    let stats = render(args)?;
    tell(args, &args.output, None, &stats)?;
    match &args.stats {
        Some(None) => to_stdout(|out| stats.print(out)),
        Some(Some(file)) => write_json(file, &stats),
        None => Ok(()),
    }
}

/// Renders to the output file and tells what it took; prints nothing but warnings and what was proposed.
pub(crate) fn render(args: &RenderArgs) -> Result<Stats> {
    flags::check(args)?;
    flags::check_outputs(args, &[&args.file], &[&args.output])?;
    use_threads(args.threads)?;
    let loaded = detail::load(&args.file, args, None)?;
    check_data(args, &loaded.volume)?;
    picture(args, &loaded, &Look::new(args, &loaded.volume)?, &args.output)
}

/// Refuses flags that such data does not have.
fn check_data(args: &RenderArgs, volume: &Data) -> Result<()> {
    match volume {
        Data::Mesh(_) => flags::check_mesh(args),
        Data::Octree(_) => flags::check_structured(args),
    }
}

/// Renders a volume as `look` has it, and writes the picture.
fn picture(args: &RenderArgs, loaded: &Loaded, look: &Look, output: &Path) -> Result<Stats> {
    let (volume, Look { camera, shown }) = (&loaded.volume, look);
    let (mut rendered, what) = match shown {
        Shown::Surface(look) => surface::render(args, look, volume, camera)?,
        Shown::Volume(look) => volume::render(args, look, volume, camera)?,
    };
    if let Data::Mesh(mesh) = volume
        && args.mesh.show_patches
    {
        outlines::draw(args, mesh, camera, &mut rendered.image);
    }
    let begin = Instant::now();
    write(output, Format::of(output)?, &rendered.image, args)?;
    let frame = frame_stats(args, loaded, camera, &rendered, begin.elapsed().as_secs_f64());
    Ok(Stats { what, frame })
}

/// Says what was rendered.
fn tell(args: &RenderArgs, output: &Path, step: Option<usize>, stats: &Stats) -> Result<()> {
    let [width, height] = args.size;
    let step = step.map_or(String::new(), |step| format!("step {step}, "));
    to_stdout(|out| writeln!(out, "{}: {step}{width} x {height} pixels, {}", output.display(), stats.what))
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
        mesh_detail: loaded.volume.mesh_detail(),
    }
}

fn write_json<T: serde::Serialize + ?Sized>(path: &Path, stats: &T) -> Result<()> {
    let json = serde_json::to_vec_pretty(stats)?;
    write_file(path, &json).with_context(|| format!("{}: cannot write the statistics", path.display()))
}
