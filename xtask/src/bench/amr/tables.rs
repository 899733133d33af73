//! Frames of meshes.

use anyhow::{Context, Result, ensure};
use isoray_amr::Mesh;
use isoray_io::{TransferOptions, read_transfer_function};
use isoray_preint::{
    Bounded, ControlPoint, Cuts, Integrate, LinearPieces, Linearised, TransferFunction, Visibility,
};
use isoray_render::{
    Camera, Image, VolumeScene, VolumeShading, VolumeStatistics, gradient_scale, render_volume,
    render_volume_counted,
};
use serde::Serialize;

use crate::bench::timer::{interleave_kept, median};
use crate::catalog::Place;
use crate::for_oracle::colors_apart;
use crate::root;
use crate::shells::Errors;

/// Titles of the columns.
pub(super) const HEADER: &str = "\nFrames of the far view, on as many threads as said; theirs on a GeForce 8800 GTX and one core of a Xeon E5345, with a mesh of their own, and what does here what that GPU did; pictures of another size than theirs have nothing of theirs beside them. Errors: of linear RGBA, largest and root mean square, against a bound of 10⁻⁶.\nplace    mesh                   what                                     instead of the GPU                       size threads | ms a frame  Mrays/s  frames/s (theirs) | largest error       rms | cells/ray pieces/ray, median alpha";

/// One line.
#[derive(Debug, Serialize)]
pub(crate) struct TableRow {
    place: &'static str,
    /// Theirs; of rows that are ours alone, nothing.
    hardware: &'static str,
    mesh: String,
    what: String,
    /// What does here what the GPU does there.
    instead: &'static str,
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

    /// The unlit volume within [`EPSILON`], and how many boxes and bricks a ray meets.
    pub(super) fn unlit(&self) -> (Image, f64) {
        let scheme = self.bounded(EPSILON, false);
        let scene = self.scene(&scheme, &self.visible, false);
        let (image, counted) =
            render_volume_counted(self.mesh, self.mesh.index_to_world(), &self.camera, &scene);
        (image, counted.work.nodes as f64 / counted.rays as f64)
    }

    /// RGBA of every pixel, within [`REFERENCE`].
    fn reference(&self, is_shaded: bool) -> Vec<[f64; 4]> {
        let exact = self.bounded(REFERENCE, is_shaded);
        let seen = self.scene(&exact, &self.visible, is_shaded);
        let image = render_volume(self.mesh, self.mesh.index_to_world(), &self.camera, &seen, |_, _| {});
        image.pixels().iter().map(|pixel| pixel.color.to_array().map(f64::from)).collect()
    }
}

/// Half a step of eight bits.
pub(super) const EPSILON: f64 = 1.0 / 510.0;
/// The bound of what the others are compared with.
const REFERENCE: f64 = 1e-6;

/// What theirs ran on.
const HARDWARE: &str = "GeForce 8800 GTX, one core of a Xeon E5345";
/// What does here what that GPU did: cells drawn, all of them or those that a table says are visible, and integrals looked up in another.
const CPU_ALL: &str = "CPU: rays through every cell, bounded";
const CPU: &str = "CPU: rays past what is hidden, bounded";
const CPU_LINEAR: &str = "CPU: such rays, linear pieces integrated";

/// A frame that is measured.
struct Variant {
    place: &'static str,
    what: String,
    instead: &'static str,
    /// Frames a second.
    paper: f64,
    threads: usize,
    is_shaded: bool,
    is_culled: bool,
    /// Its pixels are within [`EPSILON`].
    is_bounded: bool,
    scheme: Box<dyn Integrate>,
}

impl Variant {
    fn visible<'v>(&self, scene: &'v Scene<'_>, everything: &'v Visibility) -> &'v Visibility {
        if self.is_culled { &scene.visible } else { everything }
    }
}

/// All of them for one size.
fn variants(scene: &Scene<'_>, size: u32, quick: bool) -> Vec<Variant> {
    let all = rayon::current_num_threads();
    let bounded = |place, what: &str, paper| Variant {
        place,
        what: what.to_owned(),
        instead: CPU,
        paper,
        threads: all,
        is_shaded: true,
        is_culled: true,
        is_bounded: true,
        scheme: Box::new(scene.bounded(EPSILON, true)),
    };
    let linearised = |what: &str, paper, cuts| {
        let pieces = LinearPieces::new(&scene.transfer);
        let scheme = Box::new(Linearised { cuts, pieces, terminate: TERMINATE });
        Variant { instead: CPU_LINEAR, is_bounded: false, scheme, ..bounded("Table 3", what, paper) }
    };
    let mut variants = Vec::new();
    if size == 512 || quick {
        for threads in [1, all] {
            let what = format!("bounded, unlit, {threads} thread(s)");
            let scheme = Box::new(scene.bounded(EPSILON, false));
            variants.push(Variant { threads, is_shaded: false, scheme, ..bounded("-", &what, f64::NAN) });
        }
    }
    if size == 1024 || quick {
        // Theirs hardly depends on the size (Table 2), so that it cannot be scaled to that of short runs.
        let at_1024 = |paper| if size == 1024 { paper } else { f64::NAN };
        let whole = bounded("Table 1", "without look-up table", at_1024(0.76));
        variants.push(Variant { is_culled: false, instead: CPU_ALL, ..whole });
        let one = bounded("Table 1", "with look-up table, CPU mesh traversal", at_1024(3.48));
        variants.push(Variant { threads: 1, ..one });
        variants.push(bounded("Table 1", "the same, CPU-GPU mesh traversal", at_1024(3.62)));
        for (n, paper) in [(4, 3.32), (3, 3.51), (2, 3.64), (1, 3.76)] {
            let what = format!("{n} intervals a cell");
            variants.push(linearised(&what, at_1024(paper), Cuts::Fixed(n)));
        }
        let adaptive = |shading| Cuts::Adaptive { inflection: false, shading };
        variants.push(linearised("adaptive", at_1024(3.62), adaptive(true)));
        variants.push(linearised("adaptive without extrema of shading", at_1024(3.65), adaptive(false)));
        variants.push(bounded("Table 3", "ours: bounded 1/510", f64::NAN));
    }
    let papers = [(256, 3.95), (512, 3.83), (1024, 3.62), (2048, 3.50)];
    if let Some(&(_, paper)) = papers.iter().find(|(of, _)| *of == size) {
        variants.push(bounded("Table 2", "with shading, bounded 1/510", paper));
    }
    variants
}

/// # Errors
/// A timed picture that is not the one that is compared, or is off by more than its bound.
pub(super) fn rows(name: &str, mesh: &Mesh, quick: bool, repeat: usize) -> Result<Vec<TableRow>> {
    let sizes: &[u32] = if quick { &[128] } else { &[256, 512, 1024, 2048] };
    // What hides nothing.
    let everything = ControlPoint { value: 0.0, color: [1.0; 3], extinction: 1.0 };
    let everything = Visibility::new(&TransferFunction::new(vec![everything])?);
    let mut rows = Vec::new();
    for &size in sizes {
        let scene = Scene::new(mesh, size)?;
        let variants = variants(&scene, size, quick);
        let (seconds, images) = timed(&scene, &variants, &everything, repeat)?;
        culling(&variants, &images).with_context(|| format!("{name}, {size}²"))?;
        // A reference of the largest would take minutes.
        let references = (size != 2048).then(|| [false, true].map(|is_shaded| scene.reference(is_shaded)));
        for ((variant, seconds), timed) in variants.iter().zip(seconds).zip(&images) {
            let seen = scene.scene(&variant.scheme, variant.visible(&scene, &everything), variant.is_shaded);
            let (image, counted) = render_volume_counted(mesh, mesh.index_to_world(), &scene.camera, &seen);
            ensure!(*timed == image, "{name}, {size}², {}: timed is another picture", variant.what);
            let errors =
                references.as_ref().map(|of| Errors::of(&image, &of[usize::from(variant.is_shaded)], None));
            let rays = counted.rays as f64;
            let row = TableRow {
                place: variant.place,
                hardware: if variant.paper.is_nan() { "" } else { HARDWARE },
                mesh: name.to_owned(),
                what: variant.what.clone(),
                instead: variant.instead,
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
            judge(&row, variant, &counted)?;
            rows.push(row);
        }
    }
    Ok(rows)
}

/// Seconds of each variant, and its picture.
fn timed(
    scene: &Scene<'_>,
    variants: &[Variant],
    everything: &Visibility,
    repeat: usize,
) -> Result<(Vec<f64>, Vec<Image>)> {
    let [one, all] = [1, rayon::current_num_threads()].map(|threads| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("cannot start threads")
    });
    let (one, all) = (one?, all?);
    let (mesh, to_world) = (scene.mesh, scene.mesh.index_to_world());
    let mut frames: Vec<Box<dyn FnMut() -> Image + '_>> = Vec::new();
    for variant in variants {
        let pool = if variant.threads == 1 { &one } else { &all };
        let seen = scene.scene(&variant.scheme, variant.visible(scene, everything), variant.is_shaded);
        let camera = &scene.camera;
        frames
            .push(Box::new(move || pool.install(|| render_volume(mesh, to_world, camera, &seen, |_, _| {}))));
    }
    let mut timed_in_turn: Vec<&mut dyn FnMut() -> Image> =
        frames.iter_mut().map(|frame| &mut **frame as _).collect();
    Ok(interleave_kept(repeat, &mut timed_in_turn))
}

/// What is hidden changes nothing: with and without it pictures are each within the bound of what is right.
fn culling(variants: &[Variant], images: &[Image]) -> Result<()> {
    let of = |is_culled| {
        let is_it = |v: &Variant| v.is_bounded && v.is_shaded && v.is_culled == is_culled;
        variants.iter().position(is_it).and_then(|n| images.get(n))
    };
    let (Some(culled), Some(whole)) = (of(true), of(false)) else { return Ok(()) };
    let (by, most) = (difference(culled, whole), 2.0 * EPSILON);
    ensure!(by <= most, "expected pixels with what is hidden to differ by {most} at most, found {by}");
    Ok(())
}

/// The largest of any channel of any pixel; infinite if one is not a number.
pub(super) fn difference(a: &Image, b: &Image) -> f64 {
    let pixels = a.pixels().iter().zip(b.pixels());
    pixels.fold(0.0, |most, (a, b)| f64::max(most, colors_apart(a.color.to_array(), b.color.to_array())))
}

/// Something is seen, and a bounded scheme keeps to its bound: by its own account, and against the reference, which may be off itself.
fn judge(row: &TableRow, variant: &Variant, counted: &VolumeStatistics) -> Result<()> {
    let of = format!("{}, {}², {}", row.mesh, row.size, row.what);
    ensure!(row.alpha > 0.0, "{of}: expected a picture of something, found nothing visible");
    if variant.is_bounded {
        let told = counted.largest_bound;
        ensure!(told <= EPSILON, "{of}: expected errors of at most {EPSILON}, told of {told}");
        let error = row.largest_error.unwrap_or(0.0);
        let most = EPSILON + REFERENCE;
        ensure!(error <= most, "{of}: expected errors of at most {most}, found {error}");
    }
    Ok(())
}

fn print(row: &TableRow) {
    let error = |e: Option<f64>| e.map_or("-".to_owned(), |e| format!("{e:.2e}"));
    let of_paper = row.paper_frames_per_s;
    let of_paper = if of_paper.is_nan() { "-".to_owned() } else { format!("{of_paper:.2}") };
    println!(
        "{:<8} {:<22} {:<40} {:<40} {:>4} {:>7} | {:>10.1} {:>8.3} {:>9.2} {:>8} | {:>13} {:>9} | {:>9.2} {:>10.2} {:>6.3}",
        row.place,
        row.mesh,
        row.what,
        row.instead,
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
