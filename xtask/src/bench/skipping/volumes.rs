//! Emission and absorption: what the transfer function hides, what is behind what hides it, and light that nobody asked for.

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_preint::{Bounded, ControlPoint, TransferFunction, Visibility};
use isoray_render::{
    Image, VolumeScene, VolumeShading, VolumeStatistics, render_volume, render_volume_counted,
};

use super::{Per, Setting, SkippingRow};
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, Place};
use crate::shells::Subject;

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
struct Pair {
    skip: &'static str,
    scenes: [usize; 2],
}

const fn pair(skip: &'static str, without: usize) -> Pair {
    Pair { skip, scenes: [0, without] }
}

const PAIRS: [Pair; 4] = [
    pair("ranges that are hidden", 1),
    pair("what is behind what hides it", 2),
    pair("both", 3),
    pair(LIGHT, 4),
];
const LIGHT: &str = "light not asked for";

pub(super) fn measure<T: Scalar + Into<f64>>(
    setting: Setting<'_>,
    volume: &Dense<T>,
) -> Result<Vec<SkippingRow>> {
    let name = &setting.entry.name;
    let subject = Subject::new(setting.entry, volume, false, Place::Far, setting.size(48, 256))?;
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
    let (images, statistics): (Vec<Image>, Vec<VolumeStatistics>) = scenes
        .iter()
        .map(|scene| render_volume_counted(&view, subject.index_to_world, &subject.camera, scene))
        .unzip();
    ensure!(statistics[0].lit > 0, "{name}: nothing is visible");
    for Pair { skip, scenes: [with, without] } in PAIRS {
        let differ = difference(&images[with], &images[without]);
        // Each is within the bound of what is right. Light that changes nothing still rounds, and can have a piece halved that is whole without it.
        ensure!(differ <= 2.0 * EPSILON, "{name}: without {skip:?} pixels differ by {differ}");
    }
    let lit = scenes.each_ref().map(|scene| scene.shading.is_some());
    let mut frames = scenes.each_ref().map(|scene| {
        let (one, view, subject) = (&one, &view, &subject);
        move || one.install(|| render_volume(view, subject.index_to_world, &subject.camera, scene, |_, _| {}))
    });
    let mut variants: Vec<&mut dyn FnMut() -> Image> = frames.iter_mut().map(|frame| frame as _).collect();
    let (times, timed) = interleave_kept(setting.repeat, &mut variants);
    ensure!(timed == images, "{name}: other pictures when timed");
    PAIRS.iter().map(|pair| row(setting, pair, &times, lit, &statistics)).collect()
}

fn row(
    setting: Setting<'_>,
    pair: &Pair,
    times: &[f64],
    lit: [bool; 5],
    statistics: &[VolumeStatistics],
) -> Result<SkippingRow> {
    let per_ray = |of: &dyn Fn(usize) -> f64| pair.scenes.map(|n| of(n) / statistics[n].rays as f64);
    let count = |of: fn(&VolumeStatistics) -> u64| per_ray(&|n| of(&statistics[n]) as f64);
    let mut counts = vec![
        ("cells", count(|s| s.work.cells)),
        ("nodes", count(|s| s.work.nodes)),
        ("pieces", count(|s| s.pieces)),
        ("rays ended", count(|s| s.ended)),
    ];
    if pair.skip == LIGHT {
        let lit = per_ray(&|n| if lit[n] { statistics[n].pieces as f64 } else { 0.0 });
        counts.insert(0, ("pieces that are lit", lit));
    }
    setting.row([SCENE, pair.skip], Per::Ray, per_ray(&|n| times[n] * 1e9), &counts).spared()
}

/// The largest of any channel of any pixel; infinite if one is not a number.
fn difference(a: &Image, b: &Image) -> f64 {
    let pixels = a.pixels().iter().zip(b.pixels());
    let channels = pixels.flat_map(|(a, b)| (a.color - b.color).abs().to_array());
    largest(channels.map(f64::from))
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| if value.is_nan() { f64::INFINITY } else { most.max(value) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_differs_most() {
        assert_eq!(largest([0.25, 0.5, 0.125].into_iter()), 0.5);
        assert_eq!(largest([0.25, f64::NAN, 0.125].into_iter()), f64::INFINITY);
    }
}
