//! `isoray render`.

use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

use anyhow::{Context, Result};
use glam::Vec3;
use isoray_grid::Scalar;
use isoray_io::{ExrChannel, PixelData, write_exr, write_png};
use isoray_octree::{Meta, OctreeVolume, VolumeVisitor};
use isoray_render::{
    Camera, FrameStatistics, Image, Light, Normals, Scene, render_counted, render_with_progress as frame,
};

use super::stats::Stats;
use super::use_threads;
use super::view::{camera, check_camera};
use crate::cli::{LightArg, NormalsArg, RenderArgs};
use crate::failure::{usage, warn};
use crate::isovalue::propose;
use crate::load::{Loaded, load};
use crate::output::{check_output, to_stdout, write_file};
use crate::progress::Progress;

pub(crate) fn run(args: &RenderArgs) -> Result<()> {
    let stats = render(args)?;
    to_stdout(|out| {
        let [width, height] = args.size;
        let output = args.output.display();
        writeln!(out, "{output}: {width} x {height} pixels, isovalue {}", stats.isovalue)
    })?;
    match &args.stats {
        Some(None) => to_stdout(|out| stats.print(out)),
        Some(Some(file)) => write_json(file, &stats),
        None => Ok(()),
    }
}

/// Renders to the output file and tells what it took; prints nothing but warnings and a proposed isovalue.
pub(crate) fn render(args: &RenderArgs) -> Result<Stats> {
    let format = Format::of(&args.output)?;
    let isovalue = args.isovalue.map(checked_isovalue).transpose()?;
    check_camera(args)?;
    check_outputs(args)?;
    use_threads(args.threads)?;

    let loaded = load(&args.file, &args.source)?;
    let meta = loaded.volume.meta();
    let isovalue = match isovalue {
        Some(v) => v,
        None => proposed_isovalue(meta)?,
    };
    warn_out_of_range(meta, isovalue);
    let camera = camera(args, meta.dims, &meta.index_to_world)?;
    let scene = scene(args, isovalue);
    let frames = loaded.volume.visit(Frames { camera: &camera, scene: &scene, args });
    let begin = Instant::now();
    write(&args.output, format, &frames.image, args)?;
    Ok(stats(args, isovalue, &loaded, &frames, begin.elapsed().as_secs_f64()))
}

fn check_outputs(args: &RenderArgs) -> Result<()> {
    check_output(&args.output, &[&args.file])?;
    match &args.stats {
        Some(Some(file)) if *file == args.output => {
            Err(usage(format!("{}: given as the picture and as the --stats file", file.display())))
        }
        Some(Some(file)) => check_output(file, &[&args.file]),
        Some(None) | None => Ok(()),
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Png,
    Exr,
}

impl Format {
    fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => {
                Err(usage(format!("--output {}: expected a name that ends in .png or .exr", path.display())))
            }
        }
    }
}

/// The isovalue in the precision of all comparisons.
fn checked_isovalue(v: f64) -> Result<f32> {
    let rounded = v as f32;
    if rounded.is_finite() {
        Ok(rounded)
    } else {
        Err(usage(format!("--isovalue {v}: expected a finite number, of at most {:e}", f32::MAX)))
    }
}

fn proposed_isovalue(meta: &Meta) -> Result<f32> {
    let proposed = meta.range.and_then(|range| propose(&*meta.histogram, range).map(|v| (v, range)));
    // One value, or none: no isovalue has a surface, and the warning about the range will say so.
    let Some((v, [low, high])) = proposed else { return Ok(0.0) };
    to_stdout(|out| {
        writeln!(
            out,
            "isovalue {v}, proposed by Otsu's method: it best parts the values {low} to {high} in two (choose with --isovalue)"
        )
    })?;
    Ok(v)
}

fn warn_out_of_range(meta: &Meta, isovalue: f32) {
    match meta.range {
        Some([low, high]) if f64::from(isovalue) <= low || f64::from(isovalue) > high => {
            warn(format!("no surface at isovalue {isovalue}: the values range from {low} to {high}"));
        }
        Some(_) => {}
        None => warn("no surface: no sample is finite"),
    }
}

fn scene(args: &RenderArgs, isovalue: f32) -> Scene {
    Scene {
        isovalue,
        normals: match args.normals {
            NormalsArg::Forward => Normals::Forward,
            NormalsArg::Central => Normals::Central,
        },
        light: match args.light {
            LightArg::Headlight => Light::Headlight,
            LightArg::Point(at) => Light::Point(at),
        },
        ..Scene::default()
    }
}

/// The rendered frames.
struct Rendered {
    image: Image,
    /// Seconds of each frame.
    times: Vec<f64>,
    statistics: FrameStatistics,
    structure_bytes: u64,
    raw_bytes: u64,
}

struct Frames<'a> {
    camera: &'a Camera,
    scene: &'a Scene,
    args: &'a RenderArgs,
}

impl VolumeVisitor for Frames<'_> {
    type Output = Rendered;

    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Rendered {
        let octree = volume.view();
        let placement = volume.meta().index_to_world;
        let bar = Mutex::new(Progress::new("rendering"));
        let mut times = Vec::new();
        let mut timed = |n: u32| {
            let begin = Instant::now();
            let image = frame(&octree, placement, self.camera, self.scene, |tiles, of| {
                // A thread that finds the bar in use leaves it to the next tile.
                if let Ok(mut bar) = bar.try_lock() {
                    let (tiles, of) = (u64::from(tiles), u64::from(of));
                    bar.update(u64::from(n) * of + tiles, u64::from(self.args.repeat) * of);
                }
            });
            times.push(begin.elapsed().as_secs_f64());
            image
        };
        let mut image = timed(0);
        for n in 1..self.args.repeat {
            image = timed(n);
        }
        // Counting costs time, so it is a frame of its own, and only where somebody asks.
        let statistics = match self.args.stats {
            Some(_) => render_counted(&octree, placement, self.camera, self.scene).1,
            None => FrameStatistics::default(),
        };
        Rendered {
            image,
            times,
            statistics,
            structure_bytes: volume.structure_bytes() as u64,
            raw_bytes: volume.raw_bytes() as u64,
        }
    }
}

fn stats(args: &RenderArgs, isovalue: f32, loaded: &Loaded, frames: &Rendered, write_s: f64) -> Stats {
    let mut times = frames.times.clone();
    times.sort_by(f64::total_cmp);
    let render_s = times.get(times.len() / 2).copied().unwrap_or(f64::NAN);
    let [width, height] = args.size;
    let rays = u64::from(width) * u64::from(height);
    let per_ray = |n: u64| n as f64 / rays as f64;
    Stats {
        isovalue,
        width,
        height,
        open_s: loaded.open_s,
        build_s: loaded.build_s,
        render_s,
        write_s,
        repeat: args.repeat,
        threads: rayon::current_num_threads(),
        rays,
        hits: frames.statistics.hits,
        flat_hits: frames.statistics.flat,
        mrays_per_s: rays as f64 / render_s / 1e6,
        nodes_per_ray: per_ray(frames.statistics.work.nodes),
        lookups_per_ray: per_ray(frames.statistics.work.lookups),
        cells_per_ray: per_ray(frames.statistics.work.cells),
        structure_bytes: frames.structure_bytes,
        raw_bytes: frames.raw_bytes,
        traversal: "single",
    }
}

fn write(path: &Path, format: Format, image: &Image, args: &RenderArgs) -> Result<()> {
    let [width, height] = image.size();
    match format {
        Format::Png if args.transparent => {
            write_png(path, width, height, PixelData::Rgba8(&image.to_rgba8()))?;
        }
        Format::Png => {
            let background: Vec3 = args.background.as_vec3();
            write_png(path, width, height, PixelData::Rgb8(&image.to_rgb8(background)))?;
        }
        Format::Exr => {
            let channels = [
                ("R", image.channel(|p| p.color.x)),
                ("G", image.channel(|p| p.color.y)),
                ("B", image.channel(|p| p.color.z)),
                ("A", image.channel(|p| p.color.w)),
                ("Z", image.channel(|p| p.depth)),
                ("N.X", image.channel(|p| p.normal.x)),
                ("N.Y", image.channel(|p| p.normal.y)),
                ("N.Z", image.channel(|p| p.normal.z)),
            ];
            let channels: Vec<_> = channels.iter().map(|(name, data)| ExrChannel { name, data }).collect();
            write_exr(path, width, height, &channels)?;
        }
    }
    Ok(())
}

fn write_json(path: &Path, stats: &Stats) -> Result<()> {
    let json = serde_json::to_vec_pretty(stats)?;
    write_file(path, &json).with_context(|| format!("{}: cannot write the statistics", path.display()))
}
