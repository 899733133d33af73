//! Ray-cell pairs against the oracle.

use std::ops::Range;

use anyhow::{Result, bail};
use isoray_benches::cells::{Pair, pack};
use isoray_cell::{Cubic, EXCURSION_UNITS, MAGNITUDES, Mask, ROOT_STEP, Real, Segment, relative};
use isoray_oracle::{CellCase, CellVerdict, adversarial_case};
use serde::{Deserialize, Serialize};
use wide::f32x16;

use super::shard;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Tally {
    tried: u64,
    found: u64,
    nothing: u64,
    undecided: u64,
    /// Values too large or too small for the bounds.
    extreme: u64,
    missed: u64,
    false_roots: u64,
    misplaced: u64,
    /// Ends differ in side, but no root in `[0, 1]` was given.
    without_root: u64,
    /// Lanes that differ from the scalar form.
    differing: u64,
    error_sum: f64,
    worst_error: f64,
    worst: String,
    offending: shard::Offending,
}

impl shard::Tally for Tally {
    fn merge(&mut self, other: Self) {
        self.tried += other.tried;
        self.found += other.found;
        self.nothing += other.nothing;
        self.undecided += other.undecided;
        self.extreme += other.extreme;
        self.missed += other.missed;
        self.false_roots += other.false_roots;
        self.misplaced += other.misplaced;
        self.without_root += other.without_root;
        self.differing += other.differing;
        self.error_sum += other.error_sum;
        if other.worst_error > self.worst_error {
            (self.worst_error, self.worst) = (other.worst_error, other.worst);
        }
        self.offending.merge(other.offending);
    }
}

impl Tally {
    fn violations(&self) -> u64 {
        self.missed + self.false_roots + self.misplaced + self.without_root + self.differing
    }

    /// Takes a case, with the scalar result.
    fn take(&mut self, case: &CellCase, found: Option<f32>) {
        self.tried += 1;
        if !MAGNITUDES.contains(&case.magnitude()) {
            self.extreme += 1;
            return;
        }
        match case.judge(found, EXCURSION_UNITS, 2.0 * ROOT_STEP) {
            CellVerdict::Found(error) => {
                self.found += 1;
                self.error_sum += error;
                if error > self.worst_error {
                    (self.worst_error, self.worst) = (error, format!("{case:?}"));
                }
            }
            CellVerdict::Nothing => self.nothing += 1,
            CellVerdict::Undecided => self.undecided += 1,
            CellVerdict::Missed => {
                self.missed += 1;
                self.offending.keep("missed", case);
            }
            CellVerdict::False => {
                self.false_roots += 1;
                self.offending.keep("false", case);
            }
            CellVerdict::Misplaced(error) => {
                self.misplaced += 1;
                self.offending.keep(&format!("misplaced by {error:e}"), case);
            }
        }
    }

    /// Different ends give a root, whatever the magnitudes.
    fn check_ends(&mut self, case: &CellCase, cubic: &Cubic, found: Option<f32>) {
        let differ = cubic.starts_inside() != cubic.ends_inside();
        let is_number = cubic.0.iter().all(|b| b.is_finite());
        if found.is_some_and(|s| !(0.0..=1.0).contains(&s)) || (differ && is_number && found.is_none()) {
            self.without_root += 1;
            self.offending.keep("no root between ends that differ", case);
        }
    }
}

fn pair(case: &CellCase) -> Pair {
    let segment = Segment { entry: case.entry, exit: case.exit };
    Pair { corners: relative(&case.samples, case.isovalue), segment }
}

pub(crate) fn run(args: &shard::Args) -> Result<()> {
    let tally = args.run("cell", |inputs| block(inputs, args.seed))?;
    print(&tally);
    match tally.violations() {
        0 => Ok(()),
        n => bail!("{n} violations; offending inputs:\n{}", tally.offending),
    }
}

/// As [`run`], a few of them.
pub(super) fn few(count: u64, seed: u64) -> shard::Outcome {
    let tally = shard::few(count, 1 << 12, |inputs| block(inputs, seed));
    shard::Outcome {
        cases: tally.tried,
        doubtful: Some(tally.undecided + tally.extreme),
        failures: tally.violations(),
        offending: tally.offending,
    }
}

fn block(inputs: Range<u64>, seed: u64) -> Tally {
    let mut tally = Tally::default();
    let cases: Vec<_> = inputs.map(|n| adversarial_case(n.wrapping_add(seed << 40))).collect();
    for cases in cases.chunks(f32x16::LANES) {
        let pairs: Vec<Pair> = cases.iter().map(pair).collect();
        let (corners, segment) = pack::<f32x16>(&pairs);
        let root = Cubic::along(&corners, &segment).first_root();
        for (n, (case, Pair { corners, segment })) in cases.iter().zip(&pairs).enumerate() {
            let lane = (root.found.bits() >> n & 1 == 1).then(|| root.s.lane(n));
            let cubic = Cubic::along(corners, segment);
            let found = cubic.first_root().get();
            if lane.map(f32::to_bits) != found.map(f32::to_bits) {
                tally.differing += 1;
                tally.offending.keep(&format!("{lane:?} in lanes, {found:?} alone"), case);
            }
            tally.take(case, found);
            tally.check_ends(case, &cubic, found);
        }
    }
    tally
}

fn print(tally: &Tally) {
    let in_ulps = |error: f64| error / f64::from(f32::EPSILON);
    println!(
        "{} ray-cell pairs: {} roots, {} without, {} undecided, {} of extreme magnitude",
        tally.tried, tally.found, tally.nothing, tally.undecided, tally.extreme
    );
    println!(
        "missed {}, false {}, misplaced {}, ends without root {}, lanes that differ {}",
        tally.missed, tally.false_roots, tally.misplaced, tally.without_root, tally.differing
    );
    println!(
        "error of the root, in ulp of 1: mean {:.2}, worst {:.0} (within the bound, which grows as the slope falls): {}",
        in_ulps(tally.error_sum / tally.found.max(1) as f64),
        in_ulps(tally.worst_error),
        tally.worst
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_intersector_does_wrong_is_counted() {
        // s = x along x at ¼.
        let case = CellCase {
            samples: [0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0],
            isovalue: 0.25,
            entry: [0.0, 0.5, 0.5],
            exit: [1.0, 0.5, 0.5],
        };
        let judged = |found| {
            let mut tally = Tally::default();
            tally.take(&case, found);
            let Pair { corners, segment } = pair(&case);
            tally.check_ends(&case, &Cubic::along(&corners, &segment), found);
            tally
        };
        assert_eq!(judged(Some(0.25)).violations(), 0);
        assert_eq!((judged(None).missed, judged(None).without_root), (1, 1));
        assert_eq!(judged(Some(0.251)).misplaced, 1);
        let beyond = CellCase { isovalue: 2.0, ..case };
        let mut tally = Tally::default();
        tally.take(&beyond, Some(0.5));
        assert_eq!(tally.false_roots, 1);
        assert!(tally.offending.to_string().contains("isovalue: 2.0"));
    }
}
