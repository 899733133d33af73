//! What culling and ending rays early gain: the same frame with and without.

use anyhow::{Context, Result};
use isoray_grid::Scalar;
use isoray_preint::{Bounded, ControlPoint, TransferFunction, Visibility};
use isoray_render::{VolumeScene, render_volume, render_volume_counted};
use serde::Serialize;

use crate::bench::timer::interleave;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};
use crate::shells::Subject;

/// One frame.
#[derive(Debug, Serialize)]
pub(crate) struct SkippingRow {
    pub(crate) volume: String,
    pub(crate) is_culled: bool,
    pub(crate) ends_rays: bool,
    pub(crate) ns_per_ray: f64,
    pub(crate) nodes_per_ray: f64,
    pub(crate) cells_per_ray: f64,
    pub(crate) pieces_per_ray: f64,
    /// Share of the rays that ended early.
    pub(crate) ended: f64,
}

pub(crate) struct Measure<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) quick: bool,
    pub(crate) repeat: usize,
}

/// The bound of the frames compared.
const EPSILON: f64 = 1.0 / 510.0;

impl DenseVisitor for Measure<'_> {
    type Output = Result<Vec<SkippingRow>>;

    fn visit<T: Scalar + Into<f64>>(self, dense: &Dense<T>) -> Result<Vec<SkippingRow>> {
        let subject = Subject::new(self.entry, dense, false, Place::Far, if self.quick { 48 } else { 256 })?;
        // As if every value could be seen.
        let point = ControlPoint { value: 0.0, color: [1.0; 3], extinction: 1.0 };
        let everything = Visibility::new(&TransferFunction::new(vec![point])?);
        let ending = Bounded::new(&subject.transfer, EPSILON, 1.0);
        let unending = ending.clone().without_ending();
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
        let view = subject.view();
        let cases = [(true, true), (true, false), (false, true), (false, false)];
        let scene = |(is_culled, ends_rays): (bool, bool)| VolumeScene {
            visible: if is_culled { &subject.visible } else { &everything },
            scheme: if ends_rays { &ending } else { &unending },
            shading: None,
            clip: None,
        };
        let frame = |case| {
            one.install(|| {
                render_volume(&view, subject.index_to_world, &subject.camera, &scene(case), |_, _| {})
            })
        };
        let [a, b, c, d] = cases;
        let times = interleave(
            self.repeat,
            &mut [&mut || drop(frame(a)), &mut || drop(frame(b)), &mut || drop(frame(c)), &mut || {
                drop(frame(d))
            }],
        );
        let row = |(case, seconds): ((bool, bool), f64)| {
            let (_, statistics) =
                render_volume_counted(&view, subject.index_to_world, &subject.camera, &scene(case));
            let per_ray = |n: u64| n as f64 / statistics.rays as f64;
            SkippingRow {
                volume: self.entry.name.clone(),
                is_culled: case.0,
                ends_rays: case.1,
                ns_per_ray: seconds * 1e9 / statistics.rays as f64,
                nodes_per_ray: per_ray(statistics.work.nodes),
                cells_per_ray: per_ray(statistics.work.cells),
                pieces_per_ray: per_ray(statistics.pieces),
                ended: per_ray(statistics.ended),
            }
        };
        Ok(cases.into_iter().zip(times).map(row).collect())
    }
}
