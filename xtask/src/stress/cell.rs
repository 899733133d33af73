//! Ray-cell pairs against the oracle.

use std::ops::Range;

use anyhow::{Result, bail};
use isoray_cell::root::{BernsteinNewton, FirstRoot};
use isoray_cell::{EXCURSION_UNITS, Mask, ROOT_STEP, Real, Segment, relative};
use isoray_oracle::{CellCase, CellVerdict, SegmentCubic, adversarial_case};
use serde::{Deserialize, Serialize};
use wide::f32x16;

use super::shard;

/// Magnitudes at which neither sums of three values overflow nor products with a step fall among denormal numbers: the bounds hold
/// here. Elsewhere different ends must still give a root.
const MAGNITUDES: Range<f64> = 1e-35..1e37;

/// `2⁻²⁴`.
const U: f64 = 1.0 / (1 << 24) as f64;

/// Offending inputs that are kept.
const KEPT: usize = 10;

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
    offending: Vec<String>,
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
        self.offending.extend(other.offending);
        self.offending.truncate(KEPT);
    }
}

impl Tally {
    fn violations(&self) -> u64 {
        self.missed + self.false_roots + self.misplaced + self.without_root + self.differing
    }

    fn offend(&mut self, what: &str, case: &CellCase) {
        if self.offending.len() < KEPT {
            self.offending.push(format!("// {what}\n{case:?}"));
        }
    }

    /// Takes a case, with the scalar result.
    fn take(&mut self, case: &CellCase, found: Option<f32>) {
        self.tried += 1;
        let exact = SegmentCubic::new(case);
        if !MAGNITUDES.contains(&exact.magnitude) {
            self.extreme += 1;
            return;
        }
        let bound = f64::from(EXCURSION_UNITS) * U * exact.magnitude;
        match exact.judge(found.map(f64::from), bound, 2.0 * f64::from(ROOT_STEP)) {
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
                self.offend("missed", case);
            }
            CellVerdict::False => {
                self.false_roots += 1;
                self.offend("false", case);
            }
            CellVerdict::Misplaced(error) => {
                self.misplaced += 1;
                self.offend(&format!("misplaced by {error:e}"), case);
            }
        }
    }

    /// Different ends give a root, whatever the magnitudes.
    fn check_ends(&mut self, case: &CellCase, found: Option<f32>) {
        let cubic = isoray_cell::Cubic::along(&corners(case), &segment(case));
        let differ = cubic.starts_inside() != cubic.ends_inside();
        let is_number = cubic.0.iter().all(|b| b.is_finite());
        if found.is_some_and(|s| !(0.0..=1.0).contains(&s)) || (differ && is_number && found.is_none()) {
            self.without_root += 1;
            self.offend("no root between ends that differ", case);
        }
    }
}

fn corners(case: &CellCase) -> [f32; 8] {
    relative(&case.samples, case.isovalue)
}

fn segment(case: &CellCase) -> Segment {
    Segment { entry: case.entry, exit: case.exit }
}

/// All lanes at once.
fn in_lanes(cases: &[CellCase]) -> [Option<f32>; f32x16::LANES] {
    let case = |n: usize| &cases[n.min(cases.len() - 1)];
    let samples = std::array::from_fn(|c| f32x16::from_lanes(|n| case(n).samples[c]));
    let isovalue = f32x16::from_lanes(|n| case(n).isovalue);
    let segment = Segment {
        entry: std::array::from_fn(|a| f32x16::from_lanes(|n| case(n).entry[a])),
        exit: std::array::from_fn(|a| f32x16::from_lanes(|n| case(n).exit[a])),
    };
    let root = BernsteinNewton::first_root(&relative(&samples, isovalue), &segment);
    std::array::from_fn(|n| (root.found.bits() >> n & 1 == 1).then(|| root.s.lane(n)))
}

pub(crate) fn run(args: &shard::Args) -> Result<()> {
    let tally = args.run("cell", |inputs| {
        let mut tally = Tally::default();
        let cases: Vec<_> = inputs.map(|n| adversarial_case(n.wrapping_add(args.seed << 40))).collect();
        for cases in cases.chunks(f32x16::LANES) {
            let lanes = in_lanes(cases);
            for (case, lane) in cases.iter().zip(lanes) {
                let found = BernsteinNewton::first_root(&corners(case), &segment(case)).get();
                if lane.map(f32::to_bits) != found.map(f32::to_bits) {
                    tally.differing += 1;
                    tally.offend(&format!("{lane:?} in lanes, {found:?} alone"), case);
                }
                tally.take(case, found);
                tally.check_ends(case, found);
            }
        }
        tally
    })?;
    print(&tally);
    match tally.violations() {
        0 => Ok(()),
        n => bail!("{n} violations; offending inputs:\n{}", tally.offending.join("\n")),
    }
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
            tally.check_ends(&case, found);
            tally
        };
        assert_eq!(judged(Some(0.25)).violations(), 0);
        assert_eq!((judged(None).missed, judged(None).without_root), (1, 1));
        assert_eq!(judged(Some(0.251)).misplaced, 1);
        let beyond = CellCase { isovalue: 2.0, ..case };
        let mut tally = Tally::default();
        tally.take(&beyond, Some(0.5));
        assert_eq!(tally.false_roots, 1);
        assert!(tally.offending[0].contains("isovalue: 2.0"));
    }
}
