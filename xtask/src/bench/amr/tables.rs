//! Frames of meshes.

use anyhow::{Context, Result, ensure};
use isoray_amr::Mesh;
use isoray_io::{TransferOptions, read_transfer_function};
use isoray_preint::{
    Bounded, ControlPoint, Cuts, Integrate, LinearPieces, Linearised, TransferFunction, Visibility,
};
use isoray_render::{
    Camera, Image, VolumeScene, VolumeShading, gradient_scale, render_volume, render_volume_counted,
};
use serde::Serialize;

use crate::bench::timer::{interleave_kept, median};
use crate::catalog::Place;
use crate::root;
use crate::shells::Errors;

/// Titles of the columns.
pub(super) const HEADER: &str = "\nFrames of the far view, on as many threads as said; theirs on a GeForce 8800 GTX and one core of a Xeon E5345, with a mesh of their own. Errors: of linear RGBA, largest and root mean square, against a bound of 10⁻⁶.\nplace    mesh                   what                                         size threads | ms a frame  Mrays/s  frames/s (theirs) | largest error       rms | cells/ray pieces/ray, median alpha";

/// One line.
#[derive(Debug, Serialize)]
pub(crate) struct TableRow {
    place: &'static str,
    mesh: String,
    what: String,
    size: u32,
    threads: usize,
    ms: f64,
    mrays_per_s: f64,
    frames_per_s: f64,
    /// NaN where the paper has none; null in JSON.
    paper_frames_per_s: f64,
    largest_error: Option<f64>,
    rms_error: Option<f64>,
    cells_per_ray: f64,
    pieces_per_ray: f64,
    /// Of the pixels that show anything, the median.
    alpha: f64,
}

/// A mesh as it is seen.
pub(crate) struct Scene<'m> {
    mesh: &'m Mesh,
    pub(crate) camera: Camera,
    pub(crate) transfer: TransferFunction,
    pub(crate) visible: Visibility,
    pub(crate) shading: VolumeShading,
}

/// Values that the transfer function's file is for.
const FILE_RANGE: [f32; 2] = [0.0, 1.05];

/// Transmittance at which rays of schemes without a bound end.
const TERMINATE: f64 = 1e-3;

impl<'m> Scene<'m> {
    /// The view of the volumes' benchmarks, and the transfer function of the fixtures, spread over the values and the size.
    pub(crate) fn new(mesh: &'m Mesh, size: u32) -> Result<Self> {
        let to_world = mesh.index_to_world();
        let axes = to_world.matrix3;
        let sides = [axes.x_axis, axes.y_axis, axes.z_axis].into_iter().zip(mesh.dims().axes());
        let longest = sides.map(|(axis, n)| axis.length() * f64::from(n - 1)).fold(0.0, f64::max);
        let file = root().join("fixtures/transfer/clumps.toml");
        let read = read_transfer_function(&file, &TransferOptions::default())?;
        let [least, most] = mesh.range().context("the mesh has no values")?;
        let spread =
            |value: f32| least + (value - FILE_RANGE[0]) / (FILE_RANGE[1] - FILE_RANGE[0]) * (most - least);
        let points = read.points().iter().map(|p| ControlPoint {
            value: spread(p.value),
            extinction: p.extinction / longest as f32,
            ..*p
        });
        let transfer = TransferFunction::new(points.collect())?;
        Ok(Self {
            mesh,
            camera: Camera::new(&Place::Far.view(mesh.dims(), &to_world), [size; 2])?,
            visible: Visibility::new(&transfer),
            transfer,
            shading: VolumeShading {
                ambient: 0.6,
                diffuse: 0.9,
                specular: 0.0,
                exponent: 1.0,
                gradient_scale: gradient_scale(mesh, to_world),
                light: None,
            },
        })
    }

    pub(crate) fn scene<'s, I>(
        &'s self,
        scheme: &'s I,
        visible: &'s Visibility,
        is_shaded: bool,
    ) -> VolumeScene<'s, I> {
        VolumeScene { visible, scheme, shading: is_shaded.then_some(self.shading), clip: None }
    }

    pub(crate) fn bounded(&self, epsilon: f64, is_shaded: bool) -> Bounded {
        let [low, high] = self.mesh.range().unwrap_or_default().map(f64::from);
        let brightest = self.shading.brightest(&self.mesh.index_to_world(), high - low);
        Bounded::new(&self.transfer, epsilon, if is_shaded { brightest } else { 1.0 })
    }

    /// Boxes and bricks that a ray meets.
    pub(super) fn met_per_ray(&self) -> f64 {
        let scheme = self.bounded(EPSILON, false);
        let scene = self.scene(&scheme, &self.visible, false);
        let (_, counted) = render_volume_counted(self.mesh, self.mesh.index_to_world(), &self.camera, &scene);
        counted.work.nodes as f64 / counted.rays as f64
    }
}

/// Half a step of eight bits.
pub(super) const EPSILON: f64 = 1.0 / 510.0;

/// A frame that is measured.
struct Variant {
    place: &'static str,
    what: String,
    paper: f64,
    threads: usize,
    is_shaded: bool,
    is_culled: bool,
    scheme: Box<dyn Integrate>,
}

/// All of them for one size.
fn variants(scene: &Scene<'_>, size: u32, quick: bool) -> Vec<Variant> {
    let all = rayon::current_num_threads();
    let new = |place, what: &str, paper, scheme| Variant {
        place,
        what: what.to_owned(),
        paper,
        threads: all,
        is_shaded: true,
        is_culled: true,
        scheme,
    };
    let bounded = |is_shaded| -> Box<dyn Integrate> { Box::new(scene.bounded(EPSILON, is_shaded)) };
    let linearised = |cuts| -> Box<dyn Integrate> {
        Box::new(Linearised { cuts, pieces: LinearPieces::new(&scene.transfer), terminate: TERMINATE })
    };
    let mut variants = Vec::new();
    if size == 512 || quick {
        for threads in [1, all] {
            let what = format!("bounded, unlit, {threads} thread(s)");
            variants.push(Variant { threads, is_shaded: false, ..new("-", &what, f64::NAN, bounded(false)) });
        }
    }
    if size == 1024 || quick {
        let whole =
            Variant { is_culled: false, ..new("Table 1", "without look-up table", 0.76, bounded(true)) };
        let one =
            Variant { threads: 1, ..new("Table 1", "with look-up table, one thread", 3.48, bounded(true)) };
        variants.extend([
            whole,
            one,
            new("Table 1", "the same, all threads (theirs: CPU and GPU)", 3.62, bounded(true)),
        ]);
        for (n, paper) in [(4, 3.32), (3, 3.51), (2, 3.64), (1, 3.76)] {
            variants.push(new(
                "Table 3",
                &format!("{n} intervals a cell"),
                paper,
                linearised(Cuts::Fixed(n)),
            ));
        }
        let adaptive = |shading| linearised(Cuts::Adaptive { inflection: false, shading });
        variants.push(new("Table 3", "adaptive", 3.62, adaptive(true)));
        variants.push(new("Table 3", "adaptive without extrema of shading", 3.65, adaptive(false)));
        variants.push(new("Table 3", "ours: bounded 1/510", f64::NAN, bounded(true)));
    }
    let papers = [(256, 3.95), (512, 3.83), (1024, 3.62), (2048, 3.50)];
    if let Some(&(_, paper)) = papers.iter().find(|(of, _)| *of == size) {
        variants.push(new("Table 2", "with shading, bounded 1/510", paper, bounded(true)));
    }
    variants
}

pub(super) fn rows(name: &str, mesh: &Mesh, quick: bool, repeat: usize) -> Result<Vec<TableRow>> {
    let sizes: &[u32] = if quick { &[128] } else { &[256, 512, 1024, 2048] };
    let mut rows = Vec::new();
    for &size in sizes {
        let scene = Scene::new(mesh, size)?;
        let variants = variants(&scene, size, quick);
        // What hides nothing.
        let everything = ControlPoint { value: 0.0, color: [1.0; 3], extinction: 1.0 };
        let everything = Visibility::new(&TransferFunction::new(vec![everything])?);
        let visible = |variant: &Variant| if variant.is_culled { &scene.visible } else { &everything };
        let pools = [1, rayon::current_num_threads()].map(|threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("cannot start threads")
        });
        let [one, all] = pools;
        let (one, all) = (one?, all?);
        let to_world = mesh.index_to_world();
        // All but those of the largest are compared, each with its own kind.
        let is_compared = size != 2048;
        let mut frames: Vec<Box<dyn FnMut() -> Option<Image>>> = Vec::new();
        for variant in &variants {
            let pool = if variant.threads == 1 { &one } else { &all };
            let seen = scene.scene(&variant.scheme, visible(variant), variant.is_shaded);
            let camera = &scene.camera;
            frames.push(Box::new(move || {
                let image = pool.install(|| render_volume(mesh, to_world, camera, &seen, |_, _| {}));
                is_compared.then_some(image)
            }));
        }
        let mut timed_in_turn: Vec<&mut dyn FnMut() -> Option<Image>> =
            frames.iter_mut().map(|frame| &mut **frame as _).collect();
        let (seconds, timed) = interleave_kept(repeat, &mut timed_in_turn);
        let reference = |is_shaded| {
            let exact = scene.bounded(1e-6, is_shaded);
            let seen = scene.scene(&exact, &scene.visible, is_shaded);
            let image = render_volume(mesh, to_world, &scene.camera, &seen, |_, _| {});
            image.pixels().iter().map(|pixel| pixel.color.to_array().map(f64::from)).collect::<Vec<_>>()
        };
        let references = is_compared.then(|| [reference(false), reference(true)]);
        for ((variant, seconds), timed) in variants.iter().zip(seconds).zip(timed) {
            let seen = scene.scene(&variant.scheme, visible(variant), variant.is_shaded);
            let (image, counted) = render_volume_counted(mesh, to_world, &scene.camera, &seen);
            ensure!(
                timed.is_none_or(|timed| timed == image),
                "{name}, {}: timed is another picture",
                variant.what
            );
            let errors =
                references.as_ref().map(|of| Errors::of(&image, &of[usize::from(variant.is_shaded)], None));
            let rays = counted.rays as f64;
            let row = TableRow {
                place: variant.place,
                mesh: name.to_owned(),
                what: variant.what.clone(),
                size,
                threads: variant.threads,
                ms: seconds * 1e3,
                mrays_per_s: rays / seconds / 1e6,
                frames_per_s: 1.0 / seconds,
                paper_frames_per_s: variant.paper,
                largest_error: errors.as_ref().map(|e| e.max),
                rms_error: errors.as_ref().map(|e| e.rms),
                cells_per_ray: counted.work.cells as f64 / rays,
                pieces_per_ray: counted.pieces as f64 / rays,
                alpha: median_alpha(&image),
            };
            print(&row);
            rows.push(row);
        }
    }
    Ok(rows)
}

fn print(row: &TableRow) {
    let error = |e: Option<f64>| e.map_or("-".to_owned(), |e| format!("{e:.2e}"));
    let of_paper = row.paper_frames_per_s;
    let of_paper = if of_paper.is_nan() { "-".to_owned() } else { format!("{of_paper:.2}") };
    println!(
        "{:<8} {:<22} {:<44} {:>4} {:>7} | {:>10.1} {:>8.3} {:>9.2} {:>8} | {:>13} {:>9} | {:>9.2} {:>10.2} {:>6.3}",
        row.place,
        row.mesh,
        row.what,
        row.size,
        row.threads,
        row.ms,
        row.mrays_per_s,
        row.frames_per_s,
        of_paper,
        error(row.largest_error),
        error(row.rms_error),
        row.cells_per_ray,
        row.pieces_per_ray,
        row.alpha,
    );
}

/// Of the pixels that show anything.
fn median_alpha(image: &Image) -> f64 {
    let alphas = image.pixels().iter().map(|pixel| f64::from(pixel.color.w));
    median(alphas.filter(|alpha| *alpha > 0.0).collect())
}
