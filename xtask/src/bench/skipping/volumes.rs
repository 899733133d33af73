//! Emission and absorption: what the transfer function hides, what is behind what hides it, and light that nobody asked for.

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_preint::{Bounded, ControlPoint, TransferFunction, Visibility};
use isoray_render::{
    Image, VolumeScene, VolumeShading, VolumeStatistics, render_volume, render_volume_counted,
};

use super::{Setting, SkippingRow};
use crate::bench::timer::interleave;
use crate::catalog::{Dense, DenseVisitor, Place};
use crate::shells::Subject;

pub(super) struct Volumes<'a>(pub(super) Setting<'a>);

/// The bound of the frames compared.
const EPSILON: f64 = 1.0 / 510.0;

/// Light that changes nothing: its factor is 1 everywhere, but gradients are found for it.
const NO_CHANGE: VolumeShading = VolumeShading {
    ambient: 1.0,
    diffuse: 0.0,
    specular: 0.0,
    exponent: 1.0,
    gradient_scale: 1.0,
    light: Some(glam::DVec3::Z),
};

const SCENE: &str = "shells far";
/// What is left out, and the scenes with that and without.
const PAIRS: [(&str, [usize; 2]); 4] = [
    ("ranges that are hidden", [0, 1]),
    ("what is behind what hides it", [0, 2]),
    ("both", [0, 3]),
    ("light not asked for", [0, 4]),
];

impl DenseVisitor for Volumes<'_> {
    type Output = Result<Vec<SkippingRow>>;

    fn visit<T: Scalar + Into<f64>>(self, dense: &Dense<T>) -> Self::Output {
        let Self(setting) = self;
        let subject = Subject::new(setting.entry, dense, false, Place::Far, setting.size(48, 256))?;
        // As if every value could be seen.
        let point = ControlPoint { value: 0.0, color: [1.0; 3], extinction: 1.0 };
        let everything = Visibility::new(&TransferFunction::new(vec![point])?);
        let ending = Bounded::new(&subject.transfer, EPSILON, 1.0);
        let unending = ending.clone().without_ending();
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
        let view = subject.view();
        let scene = |visible, scheme, shading| VolumeScene { visible, scheme, shading, clip: None };
        let scenes = [
            scene(&subject.visible, &ending, None),
            scene(&everything, &ending, None),
            scene(&subject.visible, &unending, None),
            scene(&everything, &unending, None),
            scene(&subject.visible, &ending, Some(NO_CHANGE)),
        ];
        let counted = scenes
            .each_ref()
            .map(|scene| render_volume_counted(&view, subject.index_to_world, &subject.camera, scene));
        for ((image, _), n) in counted.iter().zip(0..) {
            let differ = difference(image, &counted[0].0);
            // Each is within the bound of what is right.
            let name = PAIRS.iter().find(|(_, [_, without])| *without == n).map_or("", |(name, _)| name);
            ensure!(
                differ <= 2.0 * EPSILON,
                "{}: without {name:?} pixels differ by {differ}",
                setting.entry.name
            );
        }
        let mut frames = scenes.each_ref().map(|scene| {
            let (one, view, subject) = (&one, &view, &subject);
            move || {
                let image = one.install(|| {
                    render_volume(view, subject.index_to_world, &subject.camera, scene, |_, _| {})
                });
                drop(std::hint::black_box(image));
            }
        });
        let mut variants: Vec<&mut dyn FnMut()> = frames.iter_mut().map(|frame| frame as _).collect();
        let times = interleave(setting.repeat, &mut variants);
        let rows = PAIRS.map(|(skip, pair)| {
            let per_ray = |of: fn(&VolumeStatistics) -> u64| {
                pair.map(|n| of(&counted[n].1) as f64 / counted[n].1.rays as f64)
            };
            let ns = pair.map(|n| times[n] * 1e9 / counted[n].1.rays as f64);
            let counts = [
                ("nodes", per_ray(|s| s.work.nodes)),
                ("cells", per_ray(|s| s.work.cells)),
                ("pieces", per_ray(|s| s.pieces)),
                ("rays ended", per_ray(|s| s.ended)),
            ];
            setting.row(SCENE, skip, ns, &counts)
        });
        Ok(rows.into())
    }
}

/// The largest of any channel of any pixel.
fn difference(a: &Image, b: &Image) -> f64 {
    let pixels = a.pixels().iter().zip(b.pixels());
    pixels.map(|(a, b)| f64::from((a.color - b.color).abs().max_element())).fold(0.0, f64::max)
}
