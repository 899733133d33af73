//! Crossings of a ray that starts on the surface.

use super::several::Roots;
use crate::Cubic;

/// The field along a segment that starts on the surface, less the root at its start.
///
/// What is left of zero at the start is rounding, and taken as zero: the cubic with Bernstein coefficients `0, b1, b2, b3` is
/// `s` times the quadratic with the coefficients `3·b1, 3/2·b2, b3`, whose sign is the side of the surface that the ray is on. It changes
/// nothing at the end of the segment, where the next cell sees the same value; so with this cell's crossings and the sides that the ray leaves
/// the start to and the segment by, no change of side is lost. A field without any slope along the segment, zero all along, is inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departing([f32; 3]);

impl Departing {
    pub(crate) fn new(cubic: &Cubic) -> Self {
        let [_, b1, b2, b3] = cubic.0;
        Self([3.0 * b1, 1.5 * b2, b3])
    }

    /// Whether the ray leaves the start to the inside.
    #[inline]
    pub fn leaves_inside(&self) -> bool {
        self.0.iter().find(|&&q| q != 0.0).is_none_or(|&q| q > 0.0)
    }

    /// Whether the ray crosses the surface again.
    #[inline]
    pub fn crosses(&self) -> bool {
        self.count() > 0
    }

    /// Where it does: none, one or two crossings in `(0, 1]`, ascending, each off by some ulp.
    pub fn crossings(&self) -> Roots {
        let [q0, q1, q2] = self.0.map(f64::from);
        // a·s² + 2h·s + q0; the roots in the form that does not cancel.
        let (a, h) = ((q0 - q1) - (q1 - q2), q1 - q0);
        let w = -(h + self.discriminant().max(0.0).sqrt().copysign(h));
        let [first, second] = if w / a < q0 / w { [w / a, q0 / w] } else { [q0 / w, w / a] };
        let on_segment = |s: f64| s.clamp(0.0, 1.0) as f32;
        match self.count() {
            0 => Roots::default(),
            // Of the two, the one that is not the start itself, or beyond an end.
            1 if q0 == 0.0 => Roots::new(&[on_segment(2.0 * q1 / (2.0 * q1 - q2))]),
            1 => {
                let beyond = |s: f64| if s.is_nan() { f64::INFINITY } else { (s - 0.5).abs() };
                let root = if beyond(first) <= beyond(second) { first } else { second };
                Roots::new(&[on_segment(root)])
            }
            _ => Roots::new(&[on_segment(first), on_segment(second)]),
        }
    }

    /// A quarter of it: exact products, and one rounding.
    fn discriminant(&self) -> f64 {
        let [q0, q1, q2] = self.0.map(f64::from);
        q1 * q1 - q0 * q2
    }

    fn count(&self) -> usize {
        let [q0, q1, q2] = self.0;
        let leaves_inside = self.leaves_inside();
        // The side of the end as the next cell has it.
        if leaves_inside != (q2 >= 0.0) {
            return 1;
        }
        // Both ends on one side: to the other and back, if the middle coefficient is there and the extremum reaches beyond zero. Touching it
        // has no length.
        let is_beyond = if leaves_inside { q1 < 0.0 } else { q1 > 0.0 };
        if is_beyond && q0 != 0.0 && self.discriminant() > 0.0 { 2 } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use isoray_oracle::SplitMix64;

    use super::*;

    /// Sides on (0, 1], by many samples in `f64`.
    fn changes(q: [f32; 3]) -> (bool, Vec<f64>) {
        let [q0, q1, q2] = q.map(f64::from);
        let at = |s: f64| q0 * (1.0 - s) * (1.0 - s) + 2.0 * q1 * s * (1.0 - s) + q2 * s * s;
        const N: usize = 20_000;
        let sides = (1..=N).map(|n| at(n as f64 / N as f64) >= 0.0);
        let sides: Vec<bool> = std::iter::once(at(1e-12) >= 0.0).chain(sides).collect();
        let changed = (1..=N).filter(|&n| sides[n] != sides[n - 1]).map(|n| (n as f64 - 0.5) / N as f64);
        (sides[0], changed.collect())
    }

    #[test]
    fn crossings_are_the_changes_of_side_behind_the_start() {
        let mut random = SplitMix64::new(5);
        let mut counts = [0; 3];
        for n in 0..2000 {
            let mut some = || match random.below(6) {
                0 => 0.0,
                _ => random.range(-1.0, 1.0) as f32,
            };
            let cubic = Cubic([1e-7, some(), some(), some()]);
            let departing = Departing::new(&cubic);
            let (inside, expected) = changes(departing.0);
            let found = departing.crossings();
            // Pairs closer than the samples of the check, and a last change at the very end.
            let is_fine = departing.discriminant().abs() < 1e-4 || departing.0[2].abs() < 1e-3;
            if is_fine {
                continue;
            }
            assert_eq!(departing.leaves_inside(), inside, "{n}: {cubic:?}");
            assert_eq!(found.len(), expected.len(), "{n}: {cubic:?}, {found:?}, {expected:?}");
            assert_eq!(departing.crosses(), !found.is_empty());
            for (s, expected) in found.iter().zip(&expected) {
                assert!((f64::from(*s) - expected).abs() < 1e-3, "{n}: {cubic:?}, {found:?}, {expected:?}");
            }
            counts[found.len()] += 1;
        }
        println!("{counts:?}");
        assert!(counts.iter().all(|&count| count > 100));
    }

    #[test]
    fn sides_without_slope() {
        let of = |q: [f32; 4]| Departing::new(&Cubic(q));
        assert!(of([-1e-9, 0.0, 0.0, 0.0]).leaves_inside() && !of([1e-9, 0.0, 0.0, 0.0]).crosses());
        assert!(!of([1e-9, 0.0, -1.0, -1.0]).leaves_inside());
        // It ends in the surface, coming from outside: that is inside.
        assert_eq!(of([0.0, -1.0, -1.0, 0.0]).crossings()[..], [1.0]);
        assert!(!of([0.0, 1.0, 1.0, 0.0]).crosses());
    }
}
