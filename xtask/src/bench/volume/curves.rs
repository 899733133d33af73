//! Time against error of every scheme on one volume.

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_render::{Image, render_volume, render_volume_counted};
use serde::Serialize;

use super::schemes::{self, Scheme};
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};
use crate::shells::{Errors, Subject};

/// All schemes on one volume.
#[derive(Debug, Serialize)]
pub(crate) struct Curve {
    pub(crate) volume: String,
    pub(crate) is_shaded: bool,
    /// Pixels along each side.
    pub(crate) size: u32,
    /// Root mean square of a channel of the reference: what a picture of nothing is off by.
    pub(crate) reference_rms: f64,
    pub(crate) rows: Vec<Row>,
}

/// One scheme.
#[derive(Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) scheme: String,
    pub(crate) family: &'static str,
    pub(crate) epsilon: Option<f64>,
    /// On one thread.
    pub(crate) ns_per_ray: f64,
    pub(crate) cells_per_ray: f64,
    pub(crate) pieces_per_ray: f64,
    /// Of a premultiplied linear RGBA channel.
    pub(crate) max_error: f64,
    pub(crate) rms_error: f64,
    /// Pixels off by more than ε.
    pub(crate) over: u64,
    /// Of schemes that differ in their tables, what these change: root mean square of the difference from the picture without a table.
    pub(crate) table_rms: Option<f64>,
}

pub(crate) struct Measure<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) is_shaded: bool,
    pub(crate) quick: bool,
    pub(crate) repeat: usize,
}

impl DenseVisitor for Measure<'_> {
    type Output = Result<Curve>;

    fn visit<T: Scalar + Into<f64>>(self, dense: &Dense<T>) -> Result<Curve> {
        let size = if self.quick { 48 } else { 256 };
        let subject = Subject::new(self.entry, dense, self.is_shaded, Place::Far, size)?;
        let [low, high] = subject.volume.meta().range.unwrap_or([0.0, 1.0]).map(|v| v as f32);
        let axes = dense.index_to_world.matrix3;
        // A cell's diagonal, and then some.
        let longest = (axes.x_axis.length() + axes.y_axis.length() + axes.z_axis.length()) as f32;
        let schemes = schemes::all(&subject.transfer, subject.brightest, [low, high], longest, self.quick)?;
        let reference = subject.reference(dense)?;
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
        let view = subject.view();
        let frame = |scheme| {
            let scene = subject.scene(scheme);
            let (one, view, subject) = (&one, &view, &subject);
            move || {
                one.install(|| {
                    render_volume(view, subject.index_to_world, &subject.camera, &scene, |_, _| {})
                })
            }
        };
        let mut frames: Vec<_> = schemes.iter().map(frame).collect();
        let mut variants: Vec<&mut dyn FnMut() -> Image> =
            frames.iter_mut().map(|frame| frame as _).collect();
        let (times, timed) = interleave_kept(self.repeat, &mut variants);
        let without_table = schemes.iter().position(|scheme| scheme.name == schemes::WITHOUT_TABLE);
        let without_table = without_table.map(|n| exactly(&timed[n]));
        let row = |((scheme, seconds), image): ((&Scheme, f64), Image)| {
            let (counted, statistics) =
                render_volume_counted(&view, subject.index_to_world, &subject.camera, &subject.scene(scheme));
            ensure!(image == counted, "{}: timed is another picture", scheme.name);
            let per_ray = |n: u64| n as f64 / statistics.rays as f64;
            let errors = Errors::of(&image, &reference, scheme.epsilon);
            Ok(Row {
                scheme: scheme.name.clone(),
                family: scheme.family,
                epsilon: scheme.epsilon,
                ns_per_ray: seconds * 1e9 / statistics.rays as f64,
                cells_per_ray: per_ray(statistics.work.cells),
                pieces_per_ray: per_ray(statistics.pieces),
                max_error: errors.max,
                rms_error: errors.rms,
                over: errors.over,
                table_rms: without_table
                    .as_ref()
                    .filter(|_| scheme.family == schemes::TABLES)
                    .map(|without| Errors::of(&image, without, None).rms),
            })
        };
        let rows = schemes.iter().zip(times).zip(timed).map(row).collect::<Result<_>>()?;
        let square: f64 = reference.iter().flatten().map(|channel| channel * channel).sum();
        let reference_rms = (square / (4 * reference.len()) as f64).sqrt();
        let volume = self.entry.name.clone();
        Ok(Curve { volume, is_shaded: self.is_shaded, size, reference_rms, rows })
    }
}

/// Its pixels in double precision.
fn exactly(image: &Image) -> Vec<[f64; 4]> {
    image.pixels().iter().map(|pixel| pixel.color.to_array().map(f64::from)).collect()
}

/// Schemes without a bound may be off by this share of the reference, both root mean squares: it is to tell a rough picture from one of something else.
const ROUGH: f64 = 0.25;

/// # Errors
/// A pixel off by more than its scheme's bound, or a scheme without one whose picture is of something else.
pub(crate) fn judge(curve: &Curve) -> Result<()> {
    for row in &curve.rows {
        let what = || format!("{}, {}", curve.volume, row.scheme);
        ensure!(
            row.over == 0,
            "{}: expected no pixel off by more than the bound, found {}",
            what(),
            row.over
        );
        let most = ROUGH * curve.reference_rms;
        ensure!(
            row.epsilon.is_some() || row.rms_error <= most,
            "{}: expected pixels off by at most {most:.1e} in the mean, found {:.1e}",
            what(),
            row.rms_error
        );
    }
    Ok(())
}
