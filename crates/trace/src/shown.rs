//! Culling by what a transfer function shows.

use isoray_grid::{Scalar, Threshold, ValueRange};
use isoray_octree::Node;
use isoray_preint::Visibility;

/// The visible ranges of values in a form that compares with samples.
#[derive(Clone, Debug)]
pub(crate) struct Shown<T> {
    ranges: Vec<ShownRange<T>>,
}

#[derive(Clone, Copy, Debug)]
struct ShownRange<T> {
    /// The least value in the range, and the least above it, if there is one.
    least: T,
    above: Option<T>,
}

impl<T: Scalar> Shown<T> {
    pub(crate) fn new(visible: &Visibility) -> Self {
        Self { ranges: visible.ranges().iter().filter_map(ShownRange::new).collect() }
    }

    /// The children of `node` whose values meet a visible range, as a bit mask.
    #[inline(always)]
    pub(crate) fn children(&self, node: &Node<T::Stored>) -> u32 {
        let both = std::array::from_fn(|n| if n < 8 { node.mins[n] } else { node.maxs[n - 8] });
        self.ranges.iter().fold(0, |shown, range| {
            let reaching = T::at_least_16(&both, range.least) >> 8;
            let beyond = range.above.map_or(0, |above| T::at_least_16(&both, above));
            shown | reaching & !beyond & 0xff
        })
    }

    /// Whether values from `min` to `max` meet a visible range.
    #[inline(always)]
    pub(crate) fn meets(&self, &ValueRange { min, max }: &ValueRange<T>) -> bool {
        self.ranges.iter().any(|r| max >= r.least && !r.above.is_some_and(|above| min >= above))
    }

    /// Whether `value` is visible.
    #[inline(always)]
    pub(crate) fn has(&self, value: T) -> bool {
        self.ranges.iter().any(|r| value >= r.least && !r.above.is_some_and(|above| value >= above))
    }
}

impl<T: Scalar> ShownRange<T> {
    /// `None` if no value of the type lies in the range.
    fn new(&[low, high]: &[f32; 2]) -> Option<Self> {
        let at_least = |v: f32| match T::threshold(v) {
            Threshold::AtLeast(least) => Some(least),
            Threshold::NoSurface => None,
        };
        if low > T::HIGHEST.to_f32() || high < T::LOWEST.to_f32() {
            return None;
        }
        let least = if low <= T::LOWEST.to_f32() { T::LOWEST } else { at_least(low)? };
        let above = if high >= T::HIGHEST.to_f32() { None } else { Some(at_least(high.next_up())?) };
        Some(Self { least, above })
    }
}

#[cfg(test)]
mod tests {
    use isoray_oracle::SplitMix64;
    use isoray_preint::{ControlPoint, TransferFunction};

    use super::*;

    #[test]
    fn children_are_those_that_the_ranges_meet() {
        let mut random = SplitMix64::new(2);
        for _ in 0..2000 {
            let mut value = -20.0;
            let points = (0..1 + random.below(8)).map(|_| {
                value += 0.5 + f64::from(random.below(80)) * 0.5;
                let extinction = random.below(2) as f32;
                ControlPoint { value: value as f32, color: [1.0; 3], extinction }
            });
            let visible = Visibility::new(&TransferFunction::new(points.collect()).unwrap());
            let shown = Shown::<u8>::new(&visible);
            let mins: [u8; 8] = std::array::from_fn(|_| random.below(256) as u8);
            let maxs = mins.map(|m| m.saturating_add(random.below(100) as u8));
            let node = Node { mins, maxs, values: mins, first: 0.into(), mask: 0 };
            let children = shown.children(&node);
            for n in 0..8 {
                let expected = visible.is_visible(mins[n].into(), maxs[n].into());
                assert_eq!(children >> n & 1 == 1, expected, "{} to {} of {visible:?}", mins[n], maxs[n]);
                let range = ValueRange { min: mins[n], max: maxs[n] };
                assert_eq!(shown.meets(&range), expected, "{range:?} of {visible:?}");
                assert_eq!(shown.has(mins[n]), visible.is_visible(mins[n].into(), mins[n].into()));
            }
        }
    }
}
