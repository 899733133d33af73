//! Sums of errors, their bounds and their printed form.

use std::collections::BTreeSet;

use crate::for_oracle::DEGREES_99;

/// How a pixel compares with the oracle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Error {
    /// Both miss.
    None,
    /// The oracle's own answer is not stable.
    Grazing { hit: bool },
    /// A hit where there is none.
    False,
    /// No hit where there is one.
    Missed,
    /// Both hit: error of depth, and of either normal in degrees.
    Hit { ulps: f64, voxels: f64, forward: f64, central: f64 },
}

/// The bounds of DESIGN section 4 and of the issue: 99 % of the depths within 4 ulp, 99.9 % within 12, all within
/// a hundredth of a voxel.
const ULPS_99: f64 = 4.0;
const ULPS_999: f64 = 12.0;
pub(super) const VOXELS: f64 = 1e-2;
/// Share of grazing rays over which the test itself is doubtful, in a generic view at an isovalue off the samples.
const GRAZING_SHARE: f64 = 1e-3;

/// Errors of a view.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    rays: u64,
    hits: u64,
    /// The pixels of these.
    grazing: BTreeSet<[u32; 2]>,
    grazing_hits: u64,
    false_hits: u64,
    missed: u64,
    /// The first pixels of these.
    first_false: Option<[u32; 2]>,
    first_missed: Option<[u32; 2]>,
    ulps: Vec<f64>,
    /// The largest, and where.
    voxels: (f64, [u32; 2]),
    forward: Vec<f64>,
    central: Vec<f64>,
}

impl Tally {
    /// Names of the columns of [`row`](Self::row).
    pub(crate) const HEADER: &str = "scene                                             rays    hits  grazing  false missed | depth: ulp 99%  99.9%    max  voxels max | normal error, degrees: 99%      max  central 99%      max";

    /// Adds a pixel.
    pub(crate) fn add(&mut self, error: Error, pixel: [u32; 2]) {
        self.rays += 1;
        match error {
            Error::None => {}
            Error::Grazing { hit } => {
                self.grazing.insert(pixel);
                self.grazing_hits += u64::from(hit);
            }
            Error::False => {
                self.false_hits += 1;
                self.first_false.get_or_insert(pixel);
            }
            Error::Missed => {
                self.missed += 1;
                self.first_missed.get_or_insert(pixel);
            }
            Error::Hit { ulps, voxels, forward, central } => {
                self.hits += 1;
                self.ulps.push(ulps);
                self.voxels = larger(self.voxels, (voxels, pixel));
                self.forward.push(forward);
                self.central.push(central);
            }
        }
    }

    pub(crate) fn join(mut self, other: Self) -> Self {
        self.rays += other.rays;
        self.hits += other.hits;
        self.grazing.extend(other.grazing);
        self.grazing_hits += other.grazing_hits;
        self.false_hits += other.false_hits;
        self.missed += other.missed;
        self.first_false = self.first_false.or(other.first_false);
        self.first_missed = self.first_missed.or(other.first_missed);
        self.ulps.extend(other.ulps);
        self.voxels = larger(self.voxels, other.voxels);
        self.forward.extend(other.forward);
        self.central.extend(other.central);
        self
    }

    /// Whether the ray of a pixel grazes, be it that it hit or not.
    pub(crate) fn is_grazing(&self, pixel: [u32; 2]) -> bool {
        self.grazing.contains(&pixel)
    }

    pub(crate) fn row(&self, name: &str) -> String {
        format!(
            "{name:<45} {:>8} {:>7} {:>8} {:>6} {:>6} | {:>14.2} {:>6.2} {:>6.2} {:>11.1e} | {:>26.4} {:>8.4} {:>12.4} {:>8.4}",
            self.rays,
            self.hits,
            self.grazing.len(),
            self.false_hits,
            self.missed,
            quantile(&self.ulps, 0.99),
            quantile(&self.ulps, 0.999),
            quantile(&self.ulps, 1.0),
            self.voxels.0,
            quantile(&self.forward, 0.99),
            quantile(&self.forward, 1.0),
            quantile(&self.central, 0.99),
            quantile(&self.central, 1.0),
        )
    }

    /// The bounds that are broken. Only of a generic scene is it expected that few rays graze; of others the share is printed.
    pub(crate) fn failures(&self, is_generic: bool) -> Vec<String> {
        let mut failures = Vec::new();
        let mut check = |ok: bool, what: String| {
            if !ok {
                failures.push(what);
            }
        };
        let told = |n: u64, what: &str, first: Option<[u32; 2]>| {
            format!("{n} {what} hits, the first at {:?}", first.unwrap_or_default())
        };
        check(self.false_hits == 0, told(self.false_hits, "false", self.first_false));
        check(self.missed == 0, told(self.missed, "missed", self.first_missed));
        let (q99, q999) = (quantile(&self.ulps, 0.99), quantile(&self.ulps, 0.999));
        check(q99 <= ULPS_99, format!("99 % of depths within {q99} ulp, expected {ULPS_99}"));
        check(q999 <= ULPS_999, format!("99.9 % of depths within {q999} ulp, expected {ULPS_999}"));
        let (voxels, place) = self.voxels;
        check(
            voxels <= VOXELS,
            format!("a depth off by {voxels} voxels at {place:?}, expected at most {VOXELS}"),
        );
        for (kind, angles) in [("forward", &self.forward), ("central", &self.central)] {
            let q = quantile(angles, 0.99);
            check(
                q <= DEGREES_99,
                format!("99 % of {kind} normals within {q} degrees, expected {DEGREES_99}"),
            );
            let none = angles.iter().filter(|a| !a.is_finite()).count();
            check(none == 0, format!("{none} {kind} normals that are no numbers"));
        }
        let share = self.grazing.len() as f64 / self.rays.max(1) as f64;
        check(
            !is_generic || share <= GRAZING_SHARE,
            format!("{:.3} % of the rays graze: the isovalue makes a poor test", 100.0 * share),
        );
        failures
    }
}

fn larger(a: (f64, [u32; 2]), b: (f64, [u32; 2])) -> (f64, [u32; 2]) {
    // What is no number is the largest.
    if b.0 <= a.0 { a } else { b }
}

/// The smallest value that a share `q` of `values` does not exceed; zero for none.
pub(super) fn quantile(values: &[f64], q: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (q * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_definition() {
        let values: Vec<f64> = (1..=1000).rev().map(f64::from).collect();
        assert_eq!(quantile(&values, 0.99), 990.0);
        assert_eq!(quantile(&values, 1.0), 1000.0);
        assert_eq!(quantile(&[], 0.99), 0.0);
    }

    #[test]
    fn broken_bounds_are_told() {
        let mut tally = Tally::default();
        (0..10_000).for_each(|n| tally.add(Error::None, [n, 0]));
        assert!(tally.failures(true).is_empty());
        tally.add(Error::False, [3, 4]);
        tally.add(Error::Missed, [1, 2]);
        tally.add(Error::Missed, [5, 6]);
        tally.add(Error::Hit { ulps: 20.0, voxels: 0.1, forward: 5.0, central: 0.0 }, [7, 8]);
        let failures = tally.failures(true);
        assert_eq!(failures.len(), 6, "{failures:?}");
        assert_eq!(
            failures[..2],
            ["1 false hits, the first at [3, 4]", "2 missed hits, the first at [1, 2]"]
        );
        assert!(failures[4].contains("at [7, 8]"), "{failures:?}");
    }
}
