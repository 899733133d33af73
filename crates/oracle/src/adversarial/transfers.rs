//! Transfer functions on which integrators usually fail.

use super::SplitMix64;
use crate::{TransferPoint, TransferPoints};

/// The kinds of adversarial transfer functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TransferKind {
    /// 2 to 256 points at random, with random extinction.
    Random,
    /// Up to four spikes, a thousandth of the range wide.
    Spikes,
    /// Steps up and down, at round fractions of the range among others.
    Steps,
    /// Several shells a hundredth of the range wide, with steps as their sides.
    Shells,
    /// Random points, half of the intervals without extinction.
    Gaps,
    /// Points at, and one unit in the last place beside, both ends of the range and zero.
    Beside,
    /// One point: a constant.
    Single,
}

impl TransferKind {
    /// All kinds, in the order in which seeds cycle through them.
    pub const ALL: [Self; 7] =
        [Self::Random, Self::Spikes, Self::Steps, Self::Shells, Self::Gaps, Self::Beside, Self::Single];

    /// A function of this kind; every number in it is an `f32`. Values ascend, at most two of them are equal, and lie in or near
    /// `range`. Colours are at most 1, extinctions 0 or 10⁻³⁰ to 10⁶.
    pub fn generate(self, seed: u64, range: [f32; 2]) -> TransferPoints {
        let mut rng = SplitMix64::new(seed);
        let most = 10_f64.powf(rng.range(-30.0, 6.0));
        let mut maker = Maker { most, range, rng };
        let points = match self {
            Self::Random => maker.random(|_| false),
            Self::Spikes => maker.bumps(1e-3, false),
            Self::Steps => maker.steps(),
            Self::Shells => maker.bumps(1e-2, true),
            Self::Gaps => maker.random(|n| n % 4 < 2),
            Self::Beside => maker.beside(),
            Self::Single => vec![maker.point(range[0])],
        };
        TransferPoints(in_order(points))
    }
}

/// A transfer function of the kind that `seed` comes to in the cycle of [`TransferKind::ALL`], for values in `range`.
pub fn adversarial_transfer(seed: u64, range: [f32; 2]) -> TransferPoints {
    TransferKind::ALL[(seed % TransferKind::ALL.len() as u64) as usize].generate(seed, range)
}

struct Maker {
    /// The largest extinction.
    most: f64,
    range: [f32; 2],
    rng: SplitMix64,
}

impl Maker {
    fn point(&mut self, value: f32) -> TransferPoint {
        let mut unit = || f64::from(self.rng.unit() as f32);
        let color = [unit(), unit(), unit()];
        let extinction = f64::from((self.most * unit()) as f32);
        TransferPoint { value: value.into(), color, extinction }
    }

    fn clear(&mut self, value: f32) -> TransferPoint {
        TransferPoint { extinction: 0.0, ..self.point(value) }
    }

    fn value(&self, fraction: f64) -> f32 {
        let [low, high] = self.range.map(f64::from);
        (low + fraction * (high - low)) as f32
    }

    fn random(&mut self, is_clear: impl Fn(usize) -> bool) -> Vec<TransferPoint> {
        let count = 2_usize << self.rng.below(8);
        let mut fractions: Vec<f64> = (0..count).map(|_| self.rng.range(-0.1, 1.1)).collect();
        fractions.sort_unstable_by(f64::total_cmp);
        let make = |(n, fraction)| {
            let value = self.value(fraction);
            if is_clear(n) { self.clear(value) } else { self.point(value) }
        };
        fractions.into_iter().enumerate().map(make).collect()
    }

    /// Triangles or boxes of a width relative to the range, with nothing between them.
    fn bumps(&mut self, width: f64, is_box: bool) -> Vec<TransferPoint> {
        let count = 1 + self.rng.below(4);
        let mut points = Vec::new();
        for n in 0..count {
            let middle = (f64::from(n) + self.rng.range(0.1, 0.9)) / f64::from(count);
            let [low, high] = [-0.5, 0.5].map(|side| self.value(middle + side * width));
            points.push(self.clear(low));
            if is_box {
                let top = self.point(low);
                points.extend([top, TransferPoint { value: high.into(), ..top }]);
            } else {
                let value = self.value(middle);
                points.push(self.point(value));
            }
            points.push(self.clear(high));
        }
        points
    }

    fn steps(&mut self) -> Vec<TransferPoint> {
        const PARTS: u32 = 8;
        let mut points = Vec::new();
        for n in 0..=PARTS {
            if self.rng.below(3) == 0 {
                continue;
            }
            let off = if self.rng.coin() { 0.0 } else { self.rng.range(-0.4, 0.4) };
            let value = self.value((f64::from(n) + off) / f64::from(PARTS));
            points.push(self.point(value));
            let next = if self.rng.below(3) == 0 { self.clear(value) } else { self.point(value) };
            points.push(next);
        }
        if points.is_empty() {
            let value = self.value(0.5);
            points = vec![self.clear(value), self.point(value)];
        }
        points
    }

    fn beside(&mut self) -> Vec<TransferPoint> {
        let [low, high] = self.range;
        let mut points = Vec::new();
        for value in [low, 0.0, high] {
            for value in [value.next_down(), value, value.next_up()] {
                if self.rng.below(3) != 0 {
                    points.push(if self.rng.coin() { self.point(value) } else { self.clear(value) });
                }
            }
        }
        points.push(self.point(low));
        points
    }
}

/// Sorted by value, of more than two of one value only the first and the last.
fn in_order(mut points: Vec<TransferPoint>) -> Vec<TransferPoint> {
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    let mut kept: Vec<TransferPoint> = Vec::with_capacity(points.len());
    for point in points {
        match kept.as_mut_slice() {
            [.., before, last] if before.value == point.value => *last = point,
            _ => kept.push(point),
        }
    }
    kept
}
