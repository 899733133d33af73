//! One cell and a stretch of a ray in it: the exact cubic, and a verdict on what an intersector found.

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
/// In `f64`, from the definition. With `M` the largest magnitude of a sample less the isovalue, its coefficients and values are
/// within `24·2⁻⁵³·M` of the exact ones: at most 9 roundings of a difference and three interpolations, 3 of a mean, 12 of
/// de Casteljau's algorithm. That is `2⁻²⁹` of what `f32` can do.
#[derive(Clone, Copy, Debug)]
pub struct SegmentCubic {
    /// The coefficients, ascending.
    pub bernstein: [f64; 4],
    /// The largest magnitude of a corner value less the isovalue.
    pub magnitude: f64,
}

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

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

fn trilinear(c: &[f64; 8], [x, y, z]: [f64; 3]) -> f64 {
    let along_x = |n: usize| lerp(c[n], c[n + 1], x);
    let along_y = |n: usize| lerp(along_x(n), along_x(n + 2), y);
    lerp(along_y(0), along_y(4), z)
}

impl SegmentCubic {
    /// The trilinear interpolant along the stretch: coefficient `n` is the mean of its values at those corners of the box spanned by the
    /// ends that take `n` coordinates from the exit.
    pub fn new(case: &CellCase) -> Self {
        let corners = case.samples.map(|s| f64::from(s) - f64::from(case.isovalue));
        let mut sums = [0.0; 4];
        for mask in 0..8_usize {
            let from = |axis: usize| if mask >> axis & 1 == 1 { case.exit } else { case.entry };
            sums[mask.count_ones() as usize] +=
                trilinear(&corners, std::array::from_fn(|axis| f64::from(from(axis)[axis])));
        }
        let magnitude = corners.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        Self { bernstein: [sums[0], sums[1] / 3.0, sums[2] / 3.0, sums[3]], magnitude }
    }

    /// The value at `s`, by de Casteljau's algorithm.
    pub fn at(&self, s: f64) -> f64 {
        let [a, b, c, d] = self.bernstein;
        let (ab, bc, cd) = (lerp(a, b, s), lerp(b, c, s), lerp(c, d, s));
        lerp(lerp(ab, bc, s), lerp(bc, cd, s), s)
    }

    /// The least `s` in `[0, 1]` at which the value is at most `level`; `s` is exact to 10⁻¹².
    pub fn first_at_most(&self, level: f64) -> Option<f64> {
        const HALVINGS: u32 = 50;
        let [a, b, c, d] = self.bernstein;
        if a <= level {
            return Some(0.0);
        }
        if a.min(b).min(c).min(d) > level {
            return None;
        }
        // The derivative is 3·(p·s² + 2q·s + r).
        let (p, q, r) = (d - 3.0 * c + 3.0 * b - a, c - 2.0 * b + a, b - a);
        let root = (q * q - p * r).max(0.0).sqrt();
        let stable = -(q + root.copysign(q));
        let mut ends = [0.0, stable / p, r / stable, 1.0]
            .map(|s: f64| if s.is_finite() { s.clamp(0.0, 1.0) } else { 0.0 });
        ends.sort_by(f64::total_cmp);
        let piece = ends.windows(2).find(|w| self.at(w[1]) <= level)?;
        let (mut above, mut below) = (piece[0], piece[1]);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (above + below);
            if self.at(middle) <= level { below = middle } else { above = middle }
        }
        Some(below)
    }

    /// [`judge`](Self::judge) of an `f32` intersector whose values are within `units·2⁻²⁴·M` of the exact ones.
    pub fn judge_f32(&self, found: Option<f32>, units: f32, step: f32) -> CellVerdict {
        const ROUNDOFF: f64 = 1.0 / (1 << 24) as f64;
        self.judge(found.map(f64::from), f64::from(units) * ROUNDOFF * self.magnitude, step.into())
    }

    /// The verdict on `found`, the parameter of the first change between `≥ 0` and `< 0`, from an intersector whose values are within
    /// `bound` of the exact ones and whose parameters have a further error of `step`.
    ///
    /// Whatever errors within the bound do, the root lies between where the exact cubic first comes so near to zero that it can
    /// change side, and where it first is so far beyond that it must have.
    pub fn judge(&self, found: Option<f64>, bound: f64, step: f64) -> CellVerdict {
        let begin = self.bernstein[0];
        if begin.abs() <= bound {
            return CellVerdict::Undecided;
        }
        // From here on the cubic starts above zero.
        let above = Self { bernstein: self.bernstein.map(|b| begin.signum() * b), ..*self };
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
        let cubic = SegmentCubic::new(&case);
        assert!((cubic.first_at_most(0.0).unwrap() - 0.0).abs() < 1e-12, "starts below");
        let above = SegmentCubic { bernstein: cubic.bernstein.map(|b| -b), ..cubic };
        assert!((above.first_at_most(0.0).unwrap() - 0.5).abs() < 1e-12);
    }
}
