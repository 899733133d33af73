//! A transfer function in a form to integrate with: the intervals between its control points.

use wide::{f32x16, i32x16};

use crate::segments::LANES;
use crate::{ControlPoint, TransferFunction};

/// Values between two neighbouring control points, along which colour and extinction are linear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    /// Where the next two hold.
    base: f64,
    /// Up to the next control point; infinite where nothing changes.
    width: f64,
    extinction: f64,
    color: [f64; 3],
    /// Change per unit of value.
    pub(crate) slope: f64,
    color_slope: [f64; 3],
    /// The largest magnitude of those.
    pub(crate) steepest: f32,
    /// Magnitudes of both changes, with those of the neighbouring intervals added.
    pub(crate) slope_near: f32,
    pub(crate) steepest_near: f32,
    /// How far beyond its ends those are all there is: the lesser width of the neighbours.
    pub(crate) reach: f32,
    /// The largest component of any colour in the interval.
    pub(crate) brightest: f32,
}

impl Interval {
    fn constant(at: &ControlPoint) -> Self {
        Self::between(at, at)
    }

    fn between(a: &ControlPoint, b: &ControlPoint) -> Self {
        let width = f64::from(b.value) - f64::from(a.value);
        let per_value =
            |a: f32, b: f32| if width > 0.0 { (f64::from(b) - f64::from(a)) / width } else { 0.0 };
        let color_slope = std::array::from_fn(|n| per_value(a.color[n], b.color[n]));
        Self {
            base: a.value.into(),
            width: if width > 0.0 { width } else { f64::INFINITY },
            extinction: a.extinction.into(),
            color: a.color.map(f64::from),
            slope: per_value(a.extinction, b.extinction),
            color_slope,
            steepest: color_slope.iter().fold(0.0, |m: f64, k| m.max(k.abs())) as f32,
            slope_near: 0.0,
            steepest_near: 0.0,
            reach: 0.0,
            brightest: a.color.into_iter().chain(b.color).fold(0.0, f32::max),
        }
    }

    /// Extinction at `value`.
    #[inline(always)]
    pub(crate) fn extinction(&self, value: f64) -> f64 {
        self.extinction + self.slope * (value - self.base)
    }

    /// Colour at `value`.
    #[inline(always)]
    pub(crate) fn color(&self, value: f64) -> [f64; 3] {
        self.color_from_base(value - self.base)
    }

    /// In single precision.
    fn row(&self) -> Row {
        let [r, g, b] = self.color.map(|c| c as f32);
        let [dr, dg, db] = self.color_slope.map(|c| c as f32);
        let of_extinction = [self.extinction, self.slope].map(|e| e as f32);
        let of_errors = [self.slope_near, self.steepest, self.steepest_near, self.brightest];
        let mut row = [self.base as f32; ROW];
        let rest = of_extinction.into_iter().chain([r, g, b, dr, dg, db]).chain(of_errors);
        row[1..].iter_mut().zip(rest).for_each(|(to, from)| *to = from);
        row
    }

    /// A value, relative to `reference`, relative to where the interval begins instead. What is beyond an end by a rounding is put there, which
    /// matters where control points are closer to each other than that.
    #[inline(always)]
    pub(crate) fn inside(&self, value: f64, reference: f64) -> f64 {
        let from_base = value - (self.base - reference);
        if self.width < f64::INFINITY { from_base.clamp(0.0, self.width) } else { from_base }
    }

    /// Extinction where the interval begins.
    #[inline(always)]
    pub(crate) fn extinction_at_base(&self) -> f64 {
        self.extinction
    }

    /// Colour at a value that is relative to where the interval begins.
    #[inline(always)]
    pub(crate) fn color_from_base(&self, x: f64) -> [f64; 3] {
        std::array::from_fn(|n| self.color[n] + self.color_slope[n] * x)
    }

    /// Change of colour per unit of value.
    #[inline(always)]
    pub(crate) fn color_slope(&self) -> [f64; 3] {
        self.color_slope
    }
}

/// What an [`Interval`] has for [`InLanes`], in the order of its fields.
type Row = [f32; ROW];

const ROW: usize = 13;

/// Intervals in single precision, one a lane. What a value is off by in them is told by `pieces.rs`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InLanes {
    /// Where the next hold.
    pub(crate) base: f32x16,
    pub(crate) extinction: f32x16,
    /// Change of it per unit of value.
    pub(crate) slope: f32x16,
    pub(crate) color: [f32x16; 3],
    pub(crate) color_slope: [f32x16; 3],
    /// As those of an interval.
    pub(crate) slope_near: f32x16,
    pub(crate) steepest: f32x16,
    pub(crate) steepest_near: f32x16,
    pub(crate) brightest: f32x16,
}

/// Up to as many intervals beyond the lowest of the lanes are chosen from by comparing; of more, each lane fetches its own.
const MOST_CHOICES: u32 = 6;

/// The intervals of a transfer function.
#[derive(Clone, Debug)]
pub(crate) struct Intervals {
    /// Where one interval ends and the next begins, which holds there.
    breaks: Vec<f32>,
    /// How many of the breaks before each are steps.
    steps: Vec<u32>,
    /// One more than breaks; the first and the last are constant.
    intervals: Vec<Interval>,
    rows: Vec<Row>,
    /// By bin of values from the first break on: an interval that does not lie above the bin's values.
    starts: Vec<u32>,
    bins_per_value: f32,
}

/// Bins of values, in which a break is then looked for one by one.
const BINS: usize = 1024;

/// Up to as many breaks are compared with all lanes; of more, those near each lane's values are searched for.
const FEW: usize = 16;

/// How far an extinction may lie beside a line and be taken for its point, as a share of it: two roundings of a number that was computed to lie
/// on the line.
const COLLINEAR: f64 = 2.0 * f32::EPSILON as f64;

impl Intervals {
    /// Of a function whose colours are within `tolerance` of those of `transfer` wherever there is extinction, and whose extinction is
    /// the same, but for a rounding: control points that make no difference beyond that are left out.
    pub(crate) fn new(transfer: &TransferFunction, tolerance: f64) -> Self {
        let points = simplified(transfer.points(), tolerance);
        let (mut breaks, mut intervals) = (Vec::new(), Vec::new());
        if let Some(first) = points.first() {
            intervals.push(Interval::constant(first));
        }
        let mut steps = vec![0];
        for (n, b) in points.iter().enumerate() {
            let before = n.checked_sub(1).map(|n| &points[n]);
            if let Some(a) = before.filter(|a| a.value < b.value) {
                intervals.push(Interval::between(a, b));
            }
            if breaks.last() == Some(&b.value) {
                steps.last_mut().into_iter().for_each(|count| *count += 1);
            } else {
                breaks.push(b.value);
                steps.push(steps.last().copied().unwrap_or(0));
            }
        }
        if let Some(last) = points.last() {
            intervals.push(Interval::constant(last));
        }
        for n in 0..intervals.len() {
            let near = &intervals[n.saturating_sub(1)..intervals.len().min(n + 2)];
            let slope_near = near.iter().map(|i| i.slope.abs() as f32).sum();
            let steepest_near = near.iter().map(|i| i.steepest).sum();
            let beside =
                [n.checked_sub(1), Some(n + 1)].into_iter().flatten().filter_map(|n| intervals.get(n));
            let reach = beside.fold(f64::INFINITY, |m, i| m.min(i.width)) as f32;
            (intervals[n].slope_near, intervals[n].steepest_near) = (slope_near, steepest_near);
            intervals[n].reach = reach;
        }
        let (first, last) = (breaks.first().copied().unwrap_or(0.0), breaks.last().copied().unwrap_or(0.0));
        let bins_per_value = BINS as f32 / (last - first).max(f32::MIN_POSITIVE);
        let rows = intervals.iter().map(Interval::row).collect();
        let mut this = Self { breaks, steps, intervals, rows, starts: Vec::new(), bins_per_value };
        // Of the bin before: rounding may put a value into the next one.
        let start = |n: usize| first + n.saturating_sub(1) as f32 / bins_per_value;
        this.starts = (0..=BINS).map(|n| this.breaks.partition_point(|&b| b < start(n)) as u32).collect();
        this
    }

    #[inline(always)]
    pub(crate) fn get(&self, n: usize) -> &Interval {
        &self.intervals[n]
    }

    /// The interval of each lane.
    #[inline(always)]
    pub(crate) fn in_lanes(&self, of: &[u32; LANES]) -> InLanes {
        let least = of.iter().fold(u32::MAX, |least, &n| least.min(n));
        let most = of.iter().fold(0, |most, &n| most.max(n));
        let rows: [f32x16; ROW] = if most - least <= MOST_CHOICES {
            let lanes = f32x16::from_i32x16(i32x16::new(of.map(|n| n as i32)));
            let mut rows = self.rows[least as usize].map(f32x16::splat);
            for n in least + 1..=most {
                let is_beyond = lanes.simd_ge(f32x16::splat(n as f32));
                for (row, &next) in rows.iter_mut().zip(&self.rows[n as usize]) {
                    *row = is_beyond.select(f32x16::splat(next), *row);
                }
            }
            rows
        } else {
            std::array::from_fn(|k| f32x16::new(of.map(|n| self.rows[n as usize][k])))
        };
        let [base, extinction, slope, r, g, b, dr, dg, db, slope_near, steepest, steepest_near, brightest] =
            rows;
        let (color, color_slope) = ([r, g, b], [dr, dg, db]);
        InLanes {
            base,
            extinction,
            slope,
            color,
            color_slope,
            slope_near,
            steepest,
            steepest_near,
            brightest,
        }
    }

    /// Where interval `n` ends and the next begins.
    #[inline(always)]
    pub(crate) fn break_after(&self, n: usize) -> f64 {
        self.breaks[n].into()
    }

    /// Whether there is a step between two intervals.
    #[inline(always)]
    pub(crate) fn has_step(&self, [first, last]: [usize; 2]) -> bool {
        self.steps[first] != self.steps[last]
    }

    /// The interval that `value` lies in.
    #[inline(always)]
    pub(crate) fn at(&self, value: f32) -> usize {
        self.search(value, |b| b <= value)
    }

    /// The interval just below `value`.
    #[inline(always)]
    pub(crate) fn below(&self, value: f32) -> usize {
        self.search(value, |b| b < value)
    }

    #[inline(always)]
    fn search(&self, value: f32, is_passed: impl Fn(f32) -> bool) -> usize {
        let bin = ((value - self.breaks[0]) * self.bins_per_value) as usize;
        let mut n = self.starts[bin.min(BINS)] as usize;
        while self.breaks.get(n).is_some_and(|&b| is_passed(b)) {
            n += 1;
        }
        n
    }

    /// The intervals that a field meets whose values run from `low` to `high`: the first and the last. The one that begins at `high` counts if
    /// there is a step: a plateau, or a ray in the face of a cell, may have that value for longer than a point.
    #[inline(always)]
    pub(crate) fn of_range(&self, low: f32, high: f32) -> [usize; 2] {
        let first = self.at(low);
        if low >= high {
            return [first, first];
        }
        let below = self.below(high).max(first);
        let begins_there = self.breaks.get(below) == Some(&high) && self.has_step([below, below + 1]);
        [first, below + usize::from(begins_there)]
    }

    /// [`of_range`](Self::of_range) of the first `count` lanes; of the others any interval.
    #[inline(always)]
    pub(crate) fn of_ranges(&self, low: f32x16, high: f32x16, count: usize) -> [[u32; LANES]; 2] {
        let has_steps = self.steps.last().is_some_and(|&steps| steps > 0);
        if has_steps || self.breaks.len() > FEW {
            let (low, high) = (low.to_array(), high.to_array());
            let mut met = [[0; LANES]; 2];
            for n in 0..count {
                let [first, last] = self.of_range(low[n], high[n]);
                (met[0][n], met[1][n]) = (first as u32, last as u32);
            }
            return met;
        }
        // The breaks that are passed are counted.
        let one = f32x16::splat(1.0);
        let (mut first, mut last) = (f32x16::ZERO, f32x16::ZERO);
        for &b in &self.breaks {
            let b = f32x16::splat(b);
            first += b.simd_le(low) & one;
            last += b.simd_lt(high) & one;
        }
        [first, last.fast_max(first)]
            .map(|counts| counts.fast_trunc_int().to_array().map(|count| count as u32))
    }
}

/// Fewer points: from each as far on as a straight line represents all between.
fn simplified(points: &[ControlPoint], tolerance: f64) -> Vec<ControlPoint> {
    let mut kept: Vec<ControlPoint> = points.first().copied().into_iter().collect();
    let mut from = 0;
    while from + 1 < points.len() {
        let mut to = from + 1;
        while to + 1 < points.len() && is_represented(&points[from..=to + 1], tolerance) {
            to += 1;
        }
        kept.push(points[to]);
        from = to;
    }
    kept
}

/// Whether the line between the first and the last point represents those between.
fn is_represented(points: &[ControlPoint], tolerance: f64) -> bool {
    let (Some(a), Some(b)) = (points.first(), points.last()) else { return true };
    if points.iter().all(|p| p.extinction == 0.0) {
        return true;
    }
    let width = f64::from(b.value) - f64::from(a.value);
    points.iter().all(|p| {
        let x = (f64::from(p.value) - f64::from(a.value)) / width;
        let off = |a: f32, b: f32, p: f32| (f64::from(a) * (1.0 - x) + f64::from(b) * x - f64::from(p)).abs();
        // False for steps, of no width.
        off(a.extinction, b.extinction, p.extinction) <= COLLINEAR * f64::from(p.extinction)
            && (0..3).all(|n| off(a.color[n], b.color[n], p.color[n]) <= tolerance)
    })
}

#[cfg(test)]
mod tests {
    use isoray_oracle::SplitMix64;

    use super::*;

    #[test]
    fn intervals_are_the_transfer_function() {
        let mut random = SplitMix64::new(5);
        for round in 0..300 {
            let mut value = -3.0;
            let mut points = Vec::new();
            for _ in 0..1 + random.below(40) {
                let color = std::array::from_fn(|_| random.unit() as f32);
                let extinction = if random.below(3) == 0 { 0.0 } else { random.unit() as f32 };
                points.push(ControlPoint { value, color, extinction });
                let is_step =
                    random.below(4) == 0 && points.len() > 1 && points[points.len() - 2].value != value;
                value += if is_step { 0.0 } else { random.unit().powi(4).max(1e-4) as f32 };
            }
            let tolerance = if round % 2 == 0 { 0.0 } else { 0.05 };
            let transfer = TransferFunction::new(points.clone()).unwrap();
            let intervals = Intervals::new(&transfer, tolerance);
            let tried = (0..400).map(|_| random.range(-4.0, f64::from(value) + 1.0) as f32);
            for v in
                tried.chain(points.iter().flat_map(|p| [p.value.next_down(), p.value, p.value.next_up()]))
            {
                let interval = intervals.get(intervals.at(v));
                let expected = transfer.at(v);
                assert!(
                    (interval.extinction(v.into()) - f64::from(expected.extinction)).abs() < 1e-6,
                    "{v} {points:?}"
                );
                if expected.extinction > 0.0 {
                    for (found, expected) in interval.color(v.into()).into_iter().zip(expected.color) {
                        assert!((found - f64::from(expected)).abs() < tolerance + 1e-6, "{v} {points:?}");
                    }
                }
                let [first, last] = intervals.of_range(v, v.next_up());
                let is_step = intervals.has_step([first, last]) && last == intervals.at(v.next_up());
                assert!(first == intervals.at(v) && (last == first || is_step), "{v}");
            }
        }
    }

    #[test]
    fn lanes_meet_the_intervals_that_each_meets() {
        let mut random = SplitMix64::new(6);
        for _ in 0..3000 {
            let mut value = -3.0;
            let mut points = Vec::new();
            for _ in 0..1 + random.below(FEW as u32 + 4) {
                let extinction = random.unit() as f32;
                points.push(ControlPoint { value, color: [extinction; 3], extinction });
                value += if random.below(12) == 0 { 0.0 } else { 1.0 + random.below(3) as f32 };
            }
            let Ok(transfer) = TransferFunction::new(points) else { continue };
            let intervals = Intervals::new(&transfer, 0.0);
            // Whole numbers, so that many are control points.
            let low: [f32; LANES] = std::array::from_fn(|_| random.below(30) as f32 - 5.0);
            let high = low.map(|low| low + [0.0, 0.5, 1.0, 9.0][random.below(4) as usize]);
            let count = 1 + random.below(LANES as u32) as usize;
            let found = intervals.of_ranges(f32x16::new(low), f32x16::new(high), count);
            for n in 0..count {
                let found = found.map(|of_lane| of_lane[n] as usize);
                assert_eq!(found, intervals.of_range(low[n], high[n]), "{low:?} {high:?} {intervals:?}");
            }
            assert!(found.iter().flatten().all(|&n| (n as usize) < intervals.intervals.len()));
        }
    }

    #[test]
    fn points_that_make_no_difference_are_left_out() {
        let point = |n: u32| {
            let x = n as f32 / 255.0;
            ControlPoint { value: x, color: [x, x * x, 0.5], extinction: 3.0 * x }
        };
        let transfer = TransferFunction::new((0..256).map(point).collect()).unwrap();
        assert_eq!(Intervals::new(&transfer, 0.0).breaks.len(), 256);
        // A parabola deviates from its chord by a quarter of the squared half-width.
        let breaks = Intervals::new(&transfer, 1e-3).breaks.len();
        assert!((16..=20).contains(&breaks), "{breaks}");
    }
}
