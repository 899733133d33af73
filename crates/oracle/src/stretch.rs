//! The states along a segment of a cell: an alternation of stretches inside and outside.

use crate::cell::{Corners, gradient, trilinear};

/// A stretch of positive length in one state, from `start` to the start of the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stretch {
    /// Fraction of the segment, 0 at its entry and 1 at its exit.
    pub(crate) start: f64,
    pub(crate) inside: bool,
}

/// A cubic has at most three monotone pieces, and each at most two states.
const MAX_STRETCHES: usize = 6;

/// The stretches of one segment in order, neighbours in opposite states.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stretches {
    items: [Stretch; MAX_STRETCHES],
    len: usize,
}

impl Stretches {
    pub(crate) fn as_slice(&self) -> &[Stretch] {
        &self.items[..self.len]
    }

    fn push(&mut self, start: f64, inside: bool) {
        let continues = self.as_slice().last().is_some_and(|s| s.inside == inside);
        if !continues && self.len < MAX_STRETCHES {
            self.items[self.len] = Stretch { start, inside };
            self.len += 1;
        }
    }
}

/// The field minus the isovalue along a straight segment between two cell-local points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Profile {
    /// Corner values with the isovalue subtracted, so that a plateau at the isovalue is exactly zero.
    pub(crate) corners: Corners,
    pub(crate) entry: [f64; 3],
    pub(crate) exit: [f64; 3],
}

impl Profile {
    /// Cuts the segment into its stretches.
    ///
    /// A monotone piece is outside if it ends at zero coming from below, or starts at zero going down:
    /// its single point at zero has no length. It is inside if neither end is negative, a piece that is
    /// zero throughout included.
    pub(crate) fn stretches(&self) -> Stretches {
        let mut stretches = Stretches::default();
        let mut from = 0.0;
        let mut value_from = self.value(from);
        for to in self.extrema().into_iter().chain([1.0]) {
            if to <= from {
                continue;
            }
            let value_to = self.value(to);
            if value_from < 0.0 && value_to > 0.0 || value_from > 0.0 && value_to < 0.0 {
                stretches.push(from, value_from > 0.0);
                stretches.push(self.bisect(from, to), value_to > 0.0);
            } else {
                stretches.push(from, value_from >= 0.0 && value_to >= 0.0);
            }
            (from, value_from) = (to, value_to);
        }
        stretches
    }

    /// The field minus the isovalue at a fraction of the segment, by the definition.
    fn value(&self, u: f64) -> f64 {
        trilinear(&self.corners, self.point(u))
    }

    fn point(&self, u: f64) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let (a, b) = (self.entry[axis], self.exit[axis]);
            if a == b { a } else { a * (1.0 - u) + b * u }
        })
    }

    /// The derivative along the segment, per unit of `u`: a quadratic.
    fn slope(&self, u: f64) -> f64 {
        let g = gradient(&self.corners, self.point(u));
        (0..3).map(|axis| g[axis] * (self.exit[axis] - self.entry[axis])).sum()
    }

    /// Fractions in ascending order that contain the cubic's extrema; 0 stands for none.
    ///
    /// The quadratic is fitted to the derivative at both ends and the middle. An error in a fraction
    /// changes the value there by its square only, and a superfluous one changes nothing.
    fn extrema(&self) -> [f64; 2] {
        let (start, middle, end) = (self.slope(0.0), self.slope(0.5), self.slope(1.0));
        let a = 2.0 * (start - 2.0 * middle + end);
        let b = -3.0 * start + 4.0 * middle - end;
        let roots = quadratic_roots(a, b, start);
        let [r, s] = roots.map(|u| if u > 0.0 && u < 1.0 { u } else { 0.0 });
        if r <= s { [r, s] } else { [s, r] }
    }

    /// The change of state between two fractions whose values have opposite signs.
    fn bisect(&self, mut low: f64, mut high: f64) -> f64 {
        let rising = self.value(high) > 0.0;
        for _ in 0..MAX_HALVINGS {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if (self.value(middle) >= 0.0) == rising {
                high = middle;
            } else {
                low = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// Halvings of a segment: enough for a fraction of 2⁻⁶⁴ of a cell, far below the spacing of `t`.
const MAX_HALVINGS: u32 = 64;

/// The real roots of `a u² + b u + c`, in the form that subtracts no nearly equal numbers; NaN or
/// infinite where there are fewer than two.
fn quadratic_roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let scale = a.abs().max(b.abs()).max(c.abs());
    if !(scale > 0.0 && scale.is_finite()) {
        return [f64::NAN; 2];
    }
    let (a, b, c) = (a / scale, b / scale, c / scale);
    // A slightly negative discriminant may be a rounded double root: its vertex is harmless as a split.
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let q = -0.5 * (b + root.copysign(b));
    [q / a, c / q]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along_diagonal(corners: Corners) -> Profile {
        Profile { corners, entry: [0.0; 3], exit: [1.0; 3] }
    }

    /// Corners of `(x - a)(y - b)(z - c)`.
    fn product(a: f64, b: f64, c: f64) -> Corners {
        std::array::from_fn(|k| {
            let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(|bit| bit as f64);
            (x - a) * (y - b) * (z - c)
        })
    }

    #[test]
    fn three_planted_roots_are_found_in_order() {
        let stretches = along_diagonal(product(0.75, 0.25, 0.5)).stretches();
        let starts: Vec<f64> = stretches.as_slice().iter().map(|s| s.start).collect();
        assert_eq!(starts.len(), 4);
        for (found, planted) in starts.iter().zip([0.0, 0.25, 0.5, 0.75]) {
            assert!((found - planted).abs() < 1e-15, "{found} for {planted}");
        }
        assert!(!stretches.as_slice()[0].inside);
        assert!(stretches.as_slice()[3].inside);
    }

    #[test]
    fn a_double_root_is_no_change_and_a_triple_root_is_one() {
        let double = along_diagonal(product(0.5, 0.5, 2.0)).stretches();
        assert_eq!(double.as_slice(), [Stretch { start: 0.0, inside: false }]);
        let triple = along_diagonal(product(0.5, 0.5, 0.5)).stretches();
        assert_eq!(triple.as_slice().len(), 2);
        assert!((triple.as_slice()[1].start - 0.5).abs() < 1e-15);
    }

    #[test]
    fn zero_at_the_ends_belongs_to_the_side_that_has_length() {
        let ramp = |a: f64, b: f64| along_diagonal(std::array::from_fn(|k| if k & 1 == 0 { a } else { b }));
        let only = |p: Profile| {
            let s = p.stretches();
            assert_eq!(s.as_slice().len(), 1);
            s.as_slice()[0].inside
        };
        assert!(!only(ramp(0.0, -1.0)));
        assert!(!only(ramp(-1.0, 0.0)));
        assert!(only(ramp(0.0, 1.0)));
        assert!(only(ramp(1.0, 0.0)));
        assert!(only(ramp(0.0, 0.0)));
    }

    #[test]
    fn quadratic_keeps_small_roots_beside_large_ones() {
        let [large, small] = quadratic_roots(1.0, -1e10, 1.0);
        assert!((large - 1e10).abs() < 1e-5 && (small - 1e-10).abs() < 1e-25);
    }
}
