//! Segments integrated with a bounded error, against the oracle.

mod linear;
mod pixel;
mod scene;

use std::ops::Range;

use anyhow::{Result, bail};
use isoray_oracle::TransferPoints;
use isoray_preint::{Bounded, LinearPieces, Radiance};
use serde::{Deserialize, Serialize};

use self::linear::{Linear, LinearTally};
use self::pixel::{Pixel, difference};
use self::scene::Scene;
use super::shard;
use crate::for_oracle;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Tally {
    segments: u64,
    pixels: u64,
    shaded: u64,
    pieces: u64,
    /// Segments that the oracle has integrated too.
    compared: u64,
    /// Pixels with an alpha between 1/100 and 99/100, of those compared.
    translucent: u64,
    undecided: u64,
    /// Not finite, negative, or an alpha beyond 1.
    invalid: u64,
    /// The bound that was found exceeds ε.
    unbounded: u64,
    /// Off by more than ε.
    off: u64,
    /// Off by more than the bound that was found, and what is spent on the transfer function.
    understated: u64,
    worst_share: f64,
    worst_of_bound: f64,
    worst: String,
    linear: LinearTally,
    offending: shard::Offending,
}

impl shard::Tally for Tally {
    fn merge(&mut self, other: Self) {
        self.segments += other.segments;
        self.pixels += other.pixels;
        self.shaded += other.shaded;
        self.pieces += other.pieces;
        self.compared += other.compared;
        self.translucent += other.translucent;
        self.undecided += other.undecided;
        self.invalid += other.invalid;
        self.unbounded += other.unbounded;
        self.off += other.off;
        self.understated += other.understated;
        self.worst_of_bound = self.worst_of_bound.max(other.worst_of_bound);
        if other.worst_share > self.worst_share {
            (self.worst_share, self.worst) = (other.worst_share, other.worst);
        }
        self.linear.merge(other.linear);
        self.offending.merge(other.offending);
    }
}

/// Control points move by up to this in units of the largest value in a cell, 16 roundings of double precision: if the exact color changes by
/// more than a tenth of ε then, or by half of what a bound is exceeded by, the pixel is undecided.
const MOVED: f64 = 16.0 * f64::EPSILON;

/// What every other control point, and those between, move by: all by that much, and by eleven times an eighth of the one before, up and
/// down, together and against each other. Then in steps of a hundredth, together: a shell may be narrow, and far from the value.
fn moves() -> impl Iterator<Item = [f64; 2]> {
    const COARSE: i32 = 12;
    const FINE: i32 = 2300;
    let coarse = (0..COARSE).flat_map(|n| {
        let by = MOVED * 8_f64.powi(-n);
        [[by, by], [-by, -by], [by, -by], [-by, by]]
    });
    let fine = (0..FINE).flat_map(|n| [1.0, -1.0].map(|sign| [sign * MOVED * 1.01_f64.powi(-n); 2]));
    coarse.chain(fine)
}

/// The function with its control points moved by that, times `largest`.
fn moved(points: &TransferPoints, by: [f64; 2], largest: f64) -> TransferPoints {
    let mut points = points.clone();
    let mut least = f64::NEG_INFINITY;
    for (n, point) in points.0.iter_mut().enumerate() {
        least = least.max(point.value + by[n % 2] * largest);
        point.value = least;
    }
    points
}

/// What the oracle, and the sums in double precision, may be off by, as a share of the largest colour.
const EXACT: f64 = 1e-10;

/// And what roundings of double precision, which bounds do not count, may come to, as a share of ε: where the field touches a control point
/// they move the place by their square root.
const UNCOUNTED: f64 = 1e-3;

impl Tally {
    fn violations(&self) -> u64 {
        self.invalid + self.unbounded + self.off + self.understated + self.linear.violations()
    }

    /// Takes what was seen of a pixel.
    fn take(&mut self, pixel: &Pixel, found: &Radiance) {
        self.segments += pixel.stretches.len() as u64;
        self.pixels += 1;
        self.shaded += u64::from(pixel.lighting.is_some());
        self.pieces += u64::from(found.pieces);
        let is_valid = found.color.iter().all(|c| c.is_finite() && *c >= 0.0)
            && (0.0..=1.0).contains(&found.alpha())
            && found.error.is_finite();
        if !is_valid {
            self.invalid += 1;
            self.offending.keep(&format!("invalid: {found:?}"), pixel);
        }
        if found.error > pixel.epsilon {
            self.unbounded += 1;
            self.offending.keep(&format!("a bound of {} ε", found.error / pixel.epsilon), pixel);
        }
    }

    /// Compares it with the oracle.
    fn compare(&mut self, pixel: &Pixel, points: &TransferPoints, found: &Radiance) {
        self.compared += pixel.stretches.len() as u64;
        let exact = pixel.exact(points, [0.0; 2]);
        self.translucent += u64::from((0.01..0.99).contains(&exact.alpha()));
        let error = difference((found.color, found.alpha()), &exact);
        let for_transfer = if points.0.len() > 2 { pixel.epsilon / 8.0 } else { 0.0 };
        let uncounted = UNCOUNTED * pixel.epsilon + EXACT * f64::from(pixel.lit.max(1.0));
        let bound = found.error + for_transfer + uncounted;
        let (is_off, is_understated) = (error > pixel.epsilon, error > bound);
        if is_off || is_understated {
            let limit = if is_off { 0.1 * pixel.epsilon } else { 0.5 * (error - bound) };
            let change = |by| difference((exact.color, exact.alpha()), &pixel.exact(points, by));
            if moves().map(change).any(|change| change > limit) {
                self.undecided += 1;
                return;
            }
            self.off += u64::from(is_off);
            self.understated += u64::from(!is_off);
            let what = format!("off by {} ε, bound {} ε", error / pixel.epsilon, bound / pixel.epsilon);
            self.offending.keep(&format!("{what}: {found:?} {exact:?}"), pixel);
        }
        // Of a ray that has ended, what may lie behind is all of the bound, and often all of the error.
        if !found.is_done {
            self.worst_of_bound = self.worst_of_bound.max(error / bound);
        }
        if error / pixel.epsilon > self.worst_share {
            (self.worst_share, self.worst) = (error / pixel.epsilon, format!("{pixel:?}"));
        }
    }
}

/// Segments under one transfer function.
const GROUP: u64 = 256;

pub(crate) fn run(args: &shard::Args) -> Result<()> {
    let tally = args.run("integrate", |inputs| block(inputs, args.seed))?;
    print(&tally);
    match tally.violations() {
        0 => Ok(()),
        n => bail!("{n} violations; offending inputs:\n{}", tally.offending),
    }
}

/// As [`run`], a few of them.
pub(super) fn few(count: u64, seed: u64) -> shard::Outcome {
    let tally = shard::few(count, GROUP, |inputs| block(inputs, seed));
    shard::Outcome {
        cases: tally.segments,
        doubtful: Some(tally.undecided),
        failures: tally.violations(),
        offending: tally.offending,
    }
}

fn block(inputs: Range<u64>, seed: u64) -> Tally {
    let mut tally = Tally::default();
    for start in inputs.clone().step_by(GROUP as usize) {
        let count = GROUP.min(inputs.end - start) as usize;
        let scene = Scene::new(start.wrapping_add(seed << 40), count);
        try_scene(&scene, &mut tally);
    }
    tally
}

/// What the oracle may cost on average for a segment, in pieces that it cuts a segment into. Pixels wait until there is as much left for them.
const PIECES_PER_SEGMENT: usize = 4;

fn try_scene(scene: &Scene, tally: &mut Tally) {
    let points = for_oracle::transfer(scene.transfer.points());
    let linear = LinearPieces::new(&scene.transfer);
    let mut scheme = None;
    let mut left = 0;
    for pixel in scene.pixels() {
        let scheme = scheme.get_or_insert_with(|| Bounded::new(&scene.transfer, pixel.epsilon, pixel.lit));
        let found = pixel.integrate(scheme);
        tally.take(&pixel, &found);
        left += PIECES_PER_SEGMENT * pixel.stretches.len();
        let cost = pixel.oracle_pieces();
        let is_affordable = cost <= left;
        if is_affordable {
            left -= cost;
            tally.compare(&pixel, &points, &found);
        }
        let piece = Linear::of(&pixel);
        tally.linear.take(&piece, &linear, is_affordable.then_some(&points), &mut tally.offending);
    }
}

fn print(tally: &Tally) {
    println!(
        "{} segments of {} pixels, {} of them shaded, in {} pieces; {} segments compared with the oracle",
        tally.segments, tally.pixels, tally.shaded, tally.pieces, tally.compared
    );
    println!(
        "invalid {}, bounds beyond ε {}, off by more than ε {}, by more than the bound {}; undecided {}, translucent {}",
        tally.invalid, tally.unbounded, tally.off, tally.understated, tally.undecided, tally.translucent
    );
    println!(
        "largest error {:.3} of its bound where the ray has not ended, {:.3} of ε: {}",
        tally.worst_of_bound, tally.worst_share, tally.worst
    );
    println!("{}", tally.linear);
}

#[cfg(test)]
mod tests {
    use isoray_preint::{ControlPoint, TransferFunction};

    use super::pixel::Stretch;
    use super::*;

    #[test]
    fn what_an_integrator_does_wrong_is_counted() {
        let point = |value| ControlPoint { value, color: [1.0, 0.5, 0.0], extinction: value };
        let stretch = Stretch { corners: [0.25; 8], entry: [0.0; 3], exit: [1.0, 0.0, 0.0], length: 1.0 };
        let pixel = Pixel {
            points: &[point(0.0), point(1.0)],
            epsilon: 1e-3,
            lit: 1.0,
            lighting: None,
            stretches: &[stretch, stretch],
            batch: 16,
        };
        let transfer = TransferFunction::new(pixel.points.to_vec()).unwrap();
        let right = pixel.integrate(&Bounded::new(&transfer, pixel.epsilon, pixel.lit));
        let judged = |found: Radiance| {
            let mut tally = Tally::default();
            tally.take(&pixel, &found);
            tally.compare(&pixel, &for_oracle::transfer(pixel.points), &found);
            tally
        };
        let tally = judged(right);
        assert_eq!((tally.violations(), tally.undecided, tally.compared, tally.translucent), (0, 0, 2, 1));
        let mut wrong = right;
        wrong.color[1] += 2e-3;
        assert_eq!((judged(wrong).off, judged(wrong).understated), (1, 0));
        wrong.color[1] = right.color[1] + 0.3e-3;
        assert_eq!((judged(wrong).off, judged(wrong).understated), (0, 1));
        assert_eq!(judged(Radiance { error: 2e-3, ..right }).unbounded, 1);
        let negative = judged(Radiance { color: [1.0, -1e-9, 0.0], ..right });
        assert_eq!(negative.invalid, 1);
        assert!(negative.offending.to_string().contains("epsilon: 0.001"));
    }
}
