//! Segments on which integrators usually fail, a few hundred under one transfer function.

use std::ops::Range;

use isoray_oracle::{SplitMix64, StretchKind, TransferPoint, adversarial_transfer};
use isoray_preint::{ControlPoint, Lighting, TransferFunction};

use super::pixel::{Pixel, Stretch};

/// What pixels have in common.
#[derive(Debug)]
pub(super) struct Scene {
    pub(super) transfer: TransferFunction,
    epsilon: f64,
    lighting: Option<Lighting>,
    /// Bound of the factor of the shading.
    lit: f32,
    stretches: Vec<Stretch>,
    /// The stretches of each pixel.
    pixels: Vec<Range<usize>>,
    /// How many stretches of each are integrated at a time.
    batch: usize,
}

const EPSILONS: [f64; 5] = [1e-2, 1.0 / 255.0, 1e-3, 1e-4, 1e-5];
const EXPONENTS: [f32; 5] = [1.0, 1.5, 2.0, 10.5, 50.0];

impl Scene {
    /// Of `count` segments, made from `seed`.
    pub(super) fn new(seed: u64, count: usize) -> Self {
        let mut rng = SplitMix64::new(SplitMix64::new(seed).next_u64());
        let rng = &mut rng;
        let (stretches, range) = if rng.coin() { cells(rng, count) } else { walk(rng, count) };
        let points = points(rng, range);
        let transfer = to_visible(rng, &points, &stretches);
        let steepest = stretches.iter().map(Stretch::steepest).fold(0.0, f32::max);
        let lighting = rng.coin().then(|| lighting(rng, steepest));
        let pixels = pixels(rng, count);
        Self {
            transfer,
            epsilon: EPSILONS[rng.below(5) as usize],
            lit: lighting.map_or(1.0, |lighting| lighting.brightest(steepest)),
            lighting,
            stretches,
            pixels,
            batch: if rng.below(4) == 0 { 1 + rng.below(16) as usize } else { 16 },
        }
    }

    pub(super) fn pixels(&self) -> impl Iterator<Item = Pixel<'_>> {
        self.pixels.iter().map(|range| Pixel {
            points: self.transfer.points(),
            epsilon: self.epsilon,
            lit: self.lit,
            lighting: self.lighting,
            stretches: &self.stretches[range.clone()],
            batch: self.batch,
        })
    }
}

/// One of four scenes has pixels of one segment; in the others there are up to 16, or 40.
fn pixels(rng: &mut SplitMix64, count: usize) -> Vec<Range<usize>> {
    let is_single = rng.below(4) == 0;
    let mut pixels = Vec::new();
    let mut next = 0;
    while next < count {
        let most = match rng.below(8) {
            _ if is_single => 1,
            0 => 40,
            _ => 16,
        };
        let end = count.min(next + 1 + rng.below(most) as usize);
        pixels.push(next..end);
        next = end;
    }
    pixels
}

/// Adversarial stretches of one kind, and the values of one of them.
fn cells(rng: &mut SplitMix64, count: usize) -> (Vec<Stretch>, [f32; 2]) {
    let kind = StretchKind::ALL[rng.below(StretchKind::ALL.len() as u32) as usize];
    let stretches: Vec<Stretch> = (0..count).map(|_| Stretch::from(&kind.generate(rng.next_u64()))).collect();
    let range = stretches.first().map_or([0.0, 1.0], Stretch::range);
    (stretches, range)
}

/// A way through cells that share faces, whose values wander between two ends; some cells are constant.
fn walk(rng: &mut SplitMix64, count: usize) -> (Vec<Stretch>, [f32; 2]) {
    let offset = [0.0, 0.0, -0.5, 1.0, 300.0][rng.below(5) as usize];
    let scale = [1.0, 255.0, 1e-20, 1e20][rng.below(4) as usize];
    let step = 10_f64.powf(rng.range(-6.0, 0.3));
    let levels = [0.0, 0.0, 0.0, 255.0, 8.0][rng.below(5) as usize];
    let spacing = 10_f64.powf(rng.range(-2.0, 1.0));
    let mut at = rng.unit();
    let sample = |rng: &mut SplitMix64, at: f64| {
        let x = (at + step * rng.range(-0.5, 0.5)).clamp(0.0, 1.0);
        ((offset + if levels > 0.0 { (x * levels).round() / levels } else { x }) * scale) as f32
    };
    let mut face = [(); 4].map(|()| sample(rng, at));
    let mut exit = [rng.unit() as f32, rng.unit() as f32];
    let mut stretches = Vec::with_capacity(count);
    for _ in 0..count {
        at = (at + step * rng.range(-1.0, 1.0)).clamp(0.0, 1.0);
        let next = if rng.below(8) == 0 { [face[0]; 4] } else { [(); 4].map(|()| sample(rng, at)) };
        let corners = std::array::from_fn(|c| if c & 1 == 0 { face[c >> 1] } else { next[c >> 1] });
        let entry = exit;
        exit = entry.map(|c| (f64::from(c) + rng.range(-0.2, 0.2)).clamp(0.0, 1.0) as f32);
        let [along, across] = [0, 1].map(|n| f64::from(exit[n]) - f64::from(entry[n]));
        let length = (spacing * (1.0 + along * along + across * across).sqrt()) as f32;
        let (entry, exit) = ([0.0, entry[0], entry[1]], [1.0, exit[0], exit[1]]);
        stretches.push(Stretch { corners, entry, exit, length });
        face = next;
    }
    (stretches, [offset * scale, (offset + 1.0) * scale].map(|v| v as f32))
}

/// Control points: adversarial ones, a ramp, or clusters of points that are units in the last place apart.
fn points(rng: &mut SplitMix64, range: [f32; 2]) -> Vec<ControlPoint> {
    let [low, high] = range.map(f64::from);
    let point = |rng: &mut SplitMix64, value: f32| ControlPoint {
        value,
        color: std::array::from_fn(|_| rng.unit() as f32),
        extinction: if rng.below(3) == 0 { 0.0 } else { rng.unit() as f32 },
    };
    match rng.below(8) {
        // Too few to leave any out: the bound is that of the integration alone.
        0 | 1 => [low, high].map(|value| point(rng, value as f32)).to_vec(),
        2 => {
            let mut points = Vec::new();
            let mut value = low as f32;
            for _ in 0..8 {
                for _ in 0..1 + rng.below(4) {
                    points.push(point(rng, value));
                    value = value.next_up();
                }
                value = value.max((f64::from(value) + rng.unit() * 0.3 * (high - low)) as f32);
            }
            points
        }
        _ => adversarial_transfer(rng.next_u64(), range).0.iter().map(from_oracle).collect(),
    }
}

fn from_oracle(point: &TransferPoint) -> ControlPoint {
    ControlPoint {
        value: point.value as f32,
        color: point.color.map(|c| c as f32),
        extinction: point.extinction as f32,
    }
}

/// Three of four are scaled to an optical depth that shows: the largest extinction times the longest stretch becomes 10⁻³ to 10³.
fn to_visible(rng: &mut SplitMix64, points: &[ControlPoint], stretches: &[Stretch]) -> TransferFunction {
    let longest = stretches.iter().fold(0.0, |m: f32, s| m.max(s.length));
    let largest = points.iter().fold(0.0, |m: f32, p| m.max(p.extinction));
    let wanted = 10_f64.powf(rng.range(-3.0, 3.0));
    let factor = (wanted / f64::from(longest) / f64::from(largest)) as f32;
    let is_scaled = rng.below(4) != 0 && factor.is_finite();
    let scaled = |p: &ControlPoint| ControlPoint { extinction: p.extinction * factor, ..*p };
    let points: Vec<_> = if is_scaled { points.iter().map(scaled).collect() } else { points.to_vec() };
    // Adversarial values are all in order and in range; none at all would only make the run shorter.
    let nothing = ControlPoint { value: 0.0, color: [0.0; 3], extinction: 0.0 };
    TransferFunction::new(points)
        .or_else(|_| TransferFunction::new(vec![nothing]))
        .expect("one point is a transfer function")
}

fn lighting(rng: &mut SplitMix64, steepest: f32) -> Lighting {
    let scale = f64::from(steepest.max(1e-25)) * 10_f64.powf(rng.range(-1.0, 0.7));
    let mut direction = || -> [f32; 3] {
        let v: [f64; 3] = std::array::from_fn(|_| rng.range(-1.0, 1.0));
        let norm = v.iter().map(|c| c * c).sum::<f64>().sqrt().max(1e-3);
        v.map(|c| (c / norm / scale) as f32)
    };
    let [light, half] = [direction(), direction()];
    Lighting {
        ambient: 0.2,
        diffuse: 0.7,
        specular: if rng.coin() { 0.5 } else { 0.0 },
        exponent: EXPONENTS[rng.below(5) as usize],
        light,
        half,
    }
}
