//! One cell and a stretch of a ray in it: the exact cubic, and a verdict on what an intersector found.

use crate::double_double::{DoubleDouble, Number};

/// What a cell intersector is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellCase {
    /// Samples at the corners; corner `c` lies at `x = c & 1`, `y = c >> 1 & 1`, `z = c >> 2`.
    pub samples: [f32; 8],
    /// The isovalue.
    pub isovalue: f32,
    /// Where the stretch begins, cell-local.
    pub entry: [f32; 3],
    /// Where it ends.
    pub exit: [f32; 3],
}

/// The field along the stretch, less the isovalue, by Bernstein coefficients on `[0, 1]`.
///
/// From the definition. With `M` the largest magnitude of a sample less the isovalue, its coefficients and values are within
/// `24·u·M` of the exact ones, `u` the [roundoff](Number::ROUNDOFF) of the number: `2⁻²⁹` of what `f32` can do in `f64`,
/// `2⁻⁷⁸` in [`DoubleDouble`].
#[derive(Clone, Copy, Debug)]
pub struct SegmentCubic<N = f64> {
    /// The coefficients, ascending.
    pub bernstein: [N; 4],
    /// The largest magnitude of a corner value less the isovalue.
    pub magnitude: f64,
}

/// At most 9 roundings of a difference and three interpolations, 3 of a mean, 12 of de Casteljau's algorithm.
const ERROR_ROUNDOFFS: f64 = 24.0;

/// What is to be said about a root that was found, or not found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CellVerdict {
    /// There is a crossing, and it was found; the distance from where the exact cubic first vanishes, on the segment.
    Found(f64),
    /// There is none, and none was found.
    Nothing,
    /// The cubic comes so near to zero that an error within the bound decides.
    Undecided,
    /// There is a crossing, and none was found.
    Missed,
    /// There is none where one was found.
    False,
    /// There is one, but further from where it was found than the bound allows.
    Misplaced(f64),
}

impl CellVerdict {
    /// Whether an intersector must not come to this.
    pub fn is_violation(&self) -> bool {
        matches!(self, Self::Missed | Self::False | Self::Misplaced(_))
    }
}

fn lerp<N: Number>(a: N, b: N, t: N) -> N {
    a * (N::from(1.0) - t) + b * t
}

fn trilinear<N: Number>(c: &[N; 8], [x, y, z]: [N; 3]) -> N {
    let along_x = |n: usize| lerp(c[n], c[n + 1], x);
    let along_y = |n: usize| lerp(along_x(n), along_x(n + 2), y);
    lerp(along_y(0), along_y(4), z)
}

impl CellCase {
    /// The largest magnitude of a sample less the isovalue.
    pub fn magnitude(&self) -> f64 {
        let isovalue = f64::from(self.isovalue);
        self.samples.iter().fold(0.0, |m: f64, &s| m.max((f64::from(s) - isovalue).abs()))
    }

    /// The verdict on `found`, of an `f32` intersector whose values are within `units·2⁻²⁴·M` of the exact ones and whose parameters have a
    /// further error of `step`. [`DoubleDouble`] decides where the rounding errors of `f64` could.
    pub fn judge(&self, found: Option<f32>, units: f32, step: f32) -> CellVerdict {
        const ROUNDOFF: f64 = 1.0 / (1 << 24) as f64;
        let found = found.map(f64::from);
        let cubic = SegmentCubic::<f64>::new(self);
        let bound = f64::from(units) * ROUNDOFF * cubic.magnitude;
        // What is right by a bound that is narrower by the error of `f64` is right by the bound itself.
        let narrower = bound - cubic.error();
        let verdict = (narrower >= 0.0).then(|| cubic.judge(found, narrower, step.into()));
        verdict
            .filter(|verdict| !verdict.is_violation())
            .unwrap_or_else(|| SegmentCubic::<DoubleDouble>::new(self).judge(found, bound, step.into()))
    }
}

impl<N: Number> SegmentCubic<N> {
    /// The trilinear interpolant along the stretch: coefficient `n` is the mean of its values at those corners of the box spanned by the
    /// ends that take `n` coordinates from the exit.
    pub fn new(case: &CellCase) -> Self {
        let from_f32 = |x: f32| N::from(f64::from(x));
        let corners = case.samples.map(|s| from_f32(s) - from_f32(case.isovalue));
        let mut sums = [N::from(0.0); 4];
        for mask in 0..8_usize {
            let from = |axis: usize| if mask >> axis & 1 == 1 { case.exit } else { case.entry };
            let n = mask.count_ones() as usize;
            sums[n] = sums[n] + trilinear(&corners, std::array::from_fn(|axis| from_f32(from(axis)[axis])));
        }
        let three = N::from(3.0);
        let bernstein = [sums[0], sums[1] / three, sums[2] / three, sums[3]];
        Self { bernstein, magnitude: case.magnitude() }
    }

    /// Bound of the error of a coefficient or value.
    pub fn error(&self) -> f64 {
        ERROR_ROUNDOFFS * N::ROUNDOFF * self.magnitude
    }

    /// The cubic times `factor`, which is 1 or −1.
    pub fn times(&self, factor: f64) -> Self {
        Self { bernstein: self.bernstein.map(|b| N::from(factor) * b), ..*self }
    }

    /// The value at `s`, by de Casteljau's algorithm.
    pub fn at(&self, s: N) -> N {
        let [a, b, c, d] = self.bernstein;
        let (ab, bc, cd) = (lerp(a, b, s), lerp(b, c, s), lerp(c, d, s));
        lerp(lerp(ab, bc, s), lerp(bc, cd, s), s)
    }

    /// The least `s` in `[0, 1]` at which the value is at most `level`; `s` is exact to 10⁻¹².
    pub fn first_at_most(&self, level: f64) -> Option<f64> {
        const HALVINGS: u32 = 50;
        let [zero, one, level] = [0.0, 1.0, level].map(N::from);
        let [a, b, c, d] = self.bernstein;
        if a <= level {
            return Some(0.0);
        }
        if [b, c, d].iter().all(|&coefficient| coefficient > level) {
            return None;
        }
        // The derivative is 3·(p·s² + 2q·s + r).
        let three = N::from(3.0);
        let (p, q, r) = (d - three * c + three * b - a, c - N::from(2.0) * b + a, b - a);
        let discriminant = q * q - p * r;
        let root = if discriminant > zero { discriminant.sqrt() } else { zero };
        let stable = -(q + if q < zero { -root } else { root });
        let within = |s: N| if s > zero && s < one { s } else { zero };
        let extrema = [within(stable / p), within(r / stable)];
        let [e0, e1] = if extrema[0] <= extrema[1] { extrema } else { [extrema[1], extrema[0]] };
        let ends = [zero, e0, e1, one];
        let piece = ends.windows(2).find(|w| self.at(w[1]) <= level)?;
        let (mut above, mut below) = (piece[0], piece[1]);
        for _ in 0..HALVINGS {
            let middle = N::from(0.5) * (above + below);
            if self.at(middle) <= level { below = middle } else { above = middle }
        }
        Some(below.to_f64())
    }

    /// The verdict on `found`, the parameter of the first change between `≥ 0` and `< 0`, from an intersector whose values are within
    /// `bound` of the exact ones and whose parameters have a further error of `step`.
    ///
    /// Whatever errors within the bound do, the root lies between where the exact cubic first comes so near to zero that it can
    /// change side, and where it first is so far beyond that it must have.
    pub fn judge(&self, found: Option<f64>, bound: f64, step: f64) -> CellVerdict {
        let begin = self.bernstein[0].to_f64();
        if begin.abs() <= bound {
            return CellVerdict::Undecided;
        }
        // From here on the cubic starts above zero.
        let above = self.times(begin.signum());
        let Some(can) = above.first_at_most(bound) else {
            return if found.is_none() { CellVerdict::Nothing } else { CellVerdict::False };
        };
        match (above.first_at_most(-bound), found) {
            (Some(_), None) => CellVerdict::Missed,
            (Some(must), Some(s)) => {
                let error = above.first_at_most(0.0).map_or(f64::INFINITY, |exact| (s - exact).abs());
                let is_near = s >= can - step && s <= must + step;
                if is_near { CellVerdict::Found(error) } else { CellVerdict::Misplaced(error) }
            }
            (None, Some(s)) if s < can - step => CellVerdict::False,
            (None, _) => CellVerdict::Undecided,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `(s − ¼)·(s − ½)·(s − ¾)` along the cell's diagonal.
    fn three_roots() -> SegmentCubic {
        SegmentCubic { bernstein: [-0.09375, 13.0 / 96.0, -13.0 / 96.0, 0.09375], magnitude: 0.14 }
    }

    #[test]
    fn a_cubic_is_judged_by_its_first_root() {
        let cubic = three_roots();
        assert!((cubic.at(0.25)).abs() < 1e-15 && cubic.at(0.3) > 0.0 && cubic.at(0.6) < 0.0);
        let judge = |found| cubic.judge(found, 1e-6, 1e-9);
        assert!(matches!(judge(Some(0.25)), CellVerdict::Found(error) if error < 1e-12));
        assert!(matches!(judge(Some(0.5)), CellVerdict::Misplaced(error) if (error - 0.25).abs() < 1e-12));
        assert_eq!(judge(None), CellVerdict::Missed);
        let lifted = SegmentCubic { bernstein: cubic.bernstein.map(|b| b + 0.2), ..cubic };
        assert_eq!(lifted.judge(None, 1e-6, 1e-9), CellVerdict::Nothing);
        assert_eq!(lifted.judge(Some(0.5), 1e-6, 1e-9), CellVerdict::False);
        // (s − ½)² − 0.005: how much of an excursion may be missed?
        let pair = SegmentCubic { bernstein: [0.245, 0.245 - 1.0 / 3.0, 0.245 - 1.0 / 3.0, 0.245], ..cubic };
        assert_eq!(pair.judge(None, 0.006, 1e-9), CellVerdict::Undecided);
        assert_eq!(pair.judge(None, 0.004, 1e-9), CellVerdict::Missed);
    }

    #[test]
    fn a_cell_gives_its_cubic() {
        // s = x·y·z along the diagonal is s³.
        let case = CellCase {
            samples: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            isovalue: 0.125,
            entry: [0.0; 3],
            exit: [1.0; 3],
        };
        let cubic = SegmentCubic::<f64>::new(&case);
        assert!((cubic.first_at_most(0.0).unwrap() - 0.0).abs() < 1e-12, "starts below");
        assert!((cubic.times(-1.0).first_at_most(0.0).unwrap() - 0.5).abs() < 1e-12);
    }

    /// A dip to `−2⁻⁶⁰`, or to as much above zero, between corners of 1 and −1.
    #[test]
    fn what_f64_cannot_decide_is_decided() {
        let tiny = 1.0 / (1_u64 << 60) as f32;
        let saddle = |isovalue: f32| CellCase {
            samples: [1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0],
            isovalue,
            entry: [0.0, 0.0, 0.5],
            exit: [1.0, 1.0, 0.5],
        };
        let exact = SegmentCubic::<DoubleDouble>::new(&saddle(tiny)).at(0.5.into()).to_f64();
        assert!((exact + f64::from(tiny)).abs() < 1e-31, "{exact}");
        let double = SegmentCubic::<f64>::new(&saddle(tiny));
        assert!(double.at(0.5) >= 0.0 && double.error() > f64::from(tiny), "f64 sees no dip: {double:?}");
        // A bound of 2⁻⁷⁰.
        let judge = |isovalue, found| saddle(isovalue).judge(found, 1.0 / (1_u64 << 46) as f32, 0.0);
        assert_eq!(judge(0.0, None), CellVerdict::Undecided);
        assert_eq!(judge(tiny, None), CellVerdict::Missed);
        assert_eq!(judge(-tiny, None), CellVerdict::Nothing);
        assert_eq!(judge(-tiny, Some(0.5)), CellVerdict::False);
    }
}
