//! Which ranges of values a transfer function shows.

use crate::TransferFunction;

/// The values that have extinction, as disjoint closed ranges of `f32`: a region whose values lie between `min` and `max` contributes
/// nothing if no range meets it.
///
/// This answers what the two-dimensional look-up table over (min, max) of Krüger and Westermann (2003; Marchesin 2009, section 5) does,
/// for values of any precision: a bit of that table is whether the first range that does not end before `min` begins before `max`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Visibility {
    ranges: Vec<[f32; 2]>,
}

impl Visibility {
    /// Of everything that `transfer` gives an extinction.
    pub fn new(transfer: &TransferFunction) -> Self {
        let points = transfer.points();
        let mut visible = Self::default();
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return visible };
        if first.extinction > 0.0 {
            visible.add([f32::NEG_INFINITY, first.value.next_down()]);
        }
        for pair in points.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            // The later of two points of equal value holds at it, so the end that has no extinction is no part of the range; nor is the
            // upper one if it is followed by another, which then begins with its own.
            let low = if a.extinction > 0.0 { a.value } else { a.value.next_up() };
            if a.value < b.value && (a.extinction > 0.0 || b.extinction > 0.0) {
                visible.add([low, b.value.next_down()]);
            }
        }
        if last.extinction > 0.0 {
            visible.add([last.value, f32::INFINITY]);
        }
        visible
    }

    /// Joins a range that begins after all others.
    fn add(&mut self, [low, high]: [f32; 2]) {
        match self.ranges.last_mut() {
            _ if low > high => {}
            Some(last) if last[1].next_up() >= low => last[1] = high,
            _ => self.ranges.push([low, high]),
        }
    }

    /// The ranges, in order.
    pub fn ranges(&self) -> &[[f32; 2]] {
        &self.ranges
    }

    /// Whether a field that takes the values from `min` to `max` shows anything.
    #[inline]
    pub fn is_visible(&self, min: f32, max: f32) -> bool {
        let n = self.ranges.partition_point(|r| r[1] < min);
        self.ranges.get(n).is_some_and(|r| r[0] <= max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ControlPoint;

    fn transfer(points: &[(f32, f32)]) -> TransferFunction {
        let point = |&(value, extinction): &(f32, f32)| ControlPoint { value, color: [1.0; 3], extinction };
        TransferFunction::new(points.iter().map(point).collect()).unwrap()
    }

    #[test]
    fn ranges_end_where_extinction_does() {
        let shells = transfer(&[
            (10.0, 0.0),
            (11.0, 2.0),
            (12.0, 0.0),
            (20.0, 0.0),
            (20.0, 3.0),
            (30.0, 3.0),
            (30.0, 0.0),
        ]);
        let visible = Visibility::new(&shells);
        let [a, b, c, d] = [10f32.next_up(), 12f32.next_down(), 20.0, 30f32.next_down()];
        assert_eq!(visible.ranges(), [[a, b], [c, d]]);
        assert!(
            !visible.is_visible(0.0, 10.0)
                && !visible.is_visible(12.0, 19.0)
                && !visible.is_visible(30.0, 99.0)
        );
        assert!(
            visible.is_visible(0.0, 10.5) && visible.is_visible(11.0, 11.0) && visible.is_visible(15.0, 20.0)
        );
        assert!(visible.is_visible(0.0, 99.0));
    }

    #[test]
    fn beyond_the_points_the_ends_hold() {
        let visible = Visibility::new(&transfer(&[(0.0, 1.0), (1.0, 0.0), (2.0, 0.5)]));
        assert_eq!(
            visible.ranges(),
            [[f32::NEG_INFINITY, 1f32.next_down()], [1f32.next_up(), f32::INFINITY]]
        );
        assert_eq!(Visibility::new(&transfer(&[(0.0, 0.0)])).ranges(), [[0.0; 2]; 0]);
        assert_eq!(Visibility::new(&transfer(&[(0.0, 1.0)])).ranges(), [[f32::NEG_INFINITY, f32::INFINITY]]);
    }
}
