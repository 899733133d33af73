//! `isoray render`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use glam::{DVec3, Vec3};
use isoray_grid::Scalar;
use isoray_io::{ExrChannel, PixelData, write_exr, write_png};
use isoray_octree::{Meta, OctreeVolume, VolumeVisitor};
use isoray_render::{
    Camera, CameraError, FrameStatistics, Image, Light, Normals, Projection, Scene, View, frame_all,
    render as frame, render_counted,
};

use super::stats::Stats;
use super::{check_folder, use_threads};
use crate::cli::{LightArg, NormalsArg, RenderArgs};
use crate::failure::{UsageError, usage, warn};
use crate::isovalue::propose;
use crate::load::{Loaded, load};
use crate::progress::Progress;

pub(crate) fn run(args: &RenderArgs) -> Result<()> {
    let stats = render(args)?;
    match &args.stats {
        Some(None) => stats.print(),
        Some(Some(file)) => write_json(file, &stats)?,
        None => {}
    }
    Ok(())
}

/// Renders to the output file and tells what it took; prints nothing but warnings and a proposed isovalue.
pub(crate) fn render(args: &RenderArgs) -> Result<Stats> {
    let format = Format::of(&args.output)?;
    let isovalue = args.isovalue.map(checked_isovalue).transpose()?;
    // With a stand-in for the volume, so that senseless flags are refused before it is read.
    let stand_in = isoray_grid::Dims::new([2; 3])?;
    Camera::new(&view(args, stand_in, &glam::DAffine3::IDENTITY), args.size)
        .map_err(|e| usage(e.to_string()))?;
    check_folder(&args.output)?;
    if let Some(Some(file)) = &args.stats {
        check_folder(file)?;
    }
    use_threads(args.threads)?;

    let loaded = load(&args.file, &args.source)?;
    let meta = loaded.volume.meta();
    let isovalue = match isovalue {
        Some(v) => v,
        None => proposed_isovalue(meta),
    };
    warn_out_of_range(meta, isovalue);
    let camera =
        Camera::new(&view(args, meta.dims, &meta.index_to_world), args.size).map_err(camera_failure)?;
    let scene = scene(args, isovalue);
    let frames = loaded.volume.visit(Frames { camera: &camera, scene: &scene, args });
    let begin = Instant::now();
    write(&args.output, format, &frames.image, args)?;
    Ok(stats(args, isovalue, &loaded, &frames, begin.elapsed().as_secs_f64()))
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
            _ => Err(usage(format!("{}: expected an output name that ends in .png or .exr", path.display()))),
        }
    }
}

/// The isovalue in the precision of all comparisons.
fn checked_isovalue(v: f64) -> Result<f32> {
    let rounded = v as f32;
    if rounded.is_finite() {
        Ok(rounded)
    } else {
        Err(usage(format!("--isovalue {v}: expected a number that is finite in single precision")))
    }
}

fn proposed_isovalue(meta: &Meta) -> f32 {
    let proposed = meta.range.and_then(|range| propose(&*meta.histogram, range).map(|v| (v, range)));
    match proposed {
        Some((v, [low, high])) => {
            println!(
                "isovalue {v}, proposed by Otsu's method: it best parts the values {low} to {high} in two (choose with --isovalue)"
            );
            v
        }
        // One value, or none: no isovalue has a surface, and the warning about the range will say so.
        None => 0.0,
    }
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

/// Where the default camera looks from: somewhat from the side and above, at what is the front in the usual orientation of medical data.
const DEFAULT_DIRECTION: DVec3 = DVec3::new(0.5, 0.8, -0.35);

/// The camera that the flags describe; what they leave open is chosen to show the whole volume.
fn view(args: &RenderArgs, dims: isoray_grid::Dims, index_to_world: &glam::DAffine3) -> View {
    let flags = &args.camera;
    let last = DVec3::from_array(dims.axes().map(|n| f64::from(n - 1)));
    let centre = index_to_world.transform_point3(last / 2.0);
    let projection = match flags.ortho_height {
        Some(height) => Projection::Orthographic { height },
        None => Projection::Perspective { fov: flags.fov },
    };
    let look_at = flags.look_at.unwrap_or(centre);
    let default = View { eye: look_at - DEFAULT_DIRECTION, look_at, up: flags.up, projection };
    match flags.eye {
        Some(eye) => View { eye, ..default },
        None => {
            let framed = frame_all(&default, args.size, dims, index_to_world);
            // A look-at point of the user's own is kept: the camera moves along with it.
            View { eye: framed.eye + (look_at - framed.look_at), look_at, up: flags.up, projection }
        }
    }
}

fn camera_failure(error: CameraError) -> anyhow::Error {
    UsageError(error.to_string()).into()
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
        let mut bar = Progress::new("rendering");
        let mut times = Vec::new();
        let mut timed = || {
            let begin = Instant::now();
            let image = frame(&octree, placement, self.camera, self.scene);
            times.push(begin.elapsed().as_secs_f64());
            image
        };
        let mut image = timed();
        for n in 1..self.args.repeat {
            image = timed();
            bar.update(u64::from(n) + 1, self.args.repeat.into());
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

fn write_json(path: &PathBuf, stats: &Stats) -> Result<()> {
    let folder = path.parent().filter(|f| *f != Path::new("")).unwrap_or(Path::new("."));
    let save = || -> Result<()> {
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        serde_json::to_writer_pretty(&mut file, stats)?;
        file.persist(path)?;
        Ok(())
    };
    save().with_context(|| format!("{}: cannot write the statistics", path.display()))
}
