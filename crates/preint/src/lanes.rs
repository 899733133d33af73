//! Pieces in lanes.

use std::ops::Range;

use isoray_cell::{Cubic, Real};
use wide::f32x16;

use crate::Lighting;
use crate::bounded::Bounded;
use crate::fragment::{Fragment, Separated};
use crate::leaf::{Leaf, Medium, VALUE_UNITS};
use crate::segments::{LANES, Segments};
use crate::shade::{LIT_UNITS, LIT_UNITS_OF_A_CUT, Lit, Shade};

/// Pieces of which each is taken to lie in one interval of the transfer function.
#[derive(Clone, Copy, Debug)]
struct Input {
    /// Coefficients of the value, relative to the reference.
    value: [f32x16; 4],
    lit: Option<Lit<f32x16>>,
    length: f32x16,
    /// Largest magnitude of a corner value, relative as well.
    size: f32x16,
    /// What a value may be off by, in roundings of that.
    units: f32,
    /// And what a coefficient of `g·L` may be off by.
    lit_units: f32,
    reference: [f32; LANES],
    /// Intervals of the transfer function.
    intervals: [usize; LANES],
}

/// What values may be off by at least: where they are denormal numbers, roundings do not shrink with them. More than that, so that products with
/// this are no denormal numbers, which take long.
const LEAST_ROUNDING: f32 = 1e-30;

/// What they emit and absorb.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lanes {
    reference: [f32; LANES],
    alpha: [f32; LANES],
    value: [f32; LANES],
    value_error: [f32; LANES],
    rounding: [f32; LANES],
    depth_error: [f32; LANES],
    shade: Option<[[f32; LANES]; 4]>,
}

/// Opacity, colour and error of a piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) alpha: f64,
    pub(crate) color: [f64; 3],
    /// What it may move a pixel by that sees all of it.
    pub(crate) error: f64,
}

impl Lanes {
    #[inline(always)]
    fn new(scheme: &Bounded, input: &Input, lighting: Option<&Lighting>) -> Self {
        let (mut extinction, mut slope, mut steep) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for n in 0..LANES {
            let interval = scheme.intervals().get(input.intervals[n]);
            extinction[n] = interval.extinction(input.reference[n].into()) as f32;
            slope[n] = interval.slope as f32;
            steep[n] = interval.slope_near;
        }
        let rounding = f32x16::splat(0.5 * f32::EPSILON * input.units) * input.size;
        let rounding = Real::max(rounding, f32x16::splat(LEAST_ROUNDING));
        let medium = Medium {
            extinction: f32x16::new(extinction),
            slope: f32x16::new(slope),
            steep: f32x16::new(steep),
            length: input.length,
            rounding,
        };
        let leaf = Leaf::new(input.value, &medium);
        let shade = input.lit.as_ref().zip(lighting).map(|(lit, lighting)| {
            let Shade { factor, factor_error, covariance, covariance_error } = Shade::new(
                &leaf,
                lit,
                lighting,
                f32x16::splat(0.5 * f32::EPSILON * input.lit_units) * input.size,
            );
            [factor, factor_error, covariance, covariance_error].map(|lanes| lanes.to_array())
        });
        Self {
            reference: input.reference,
            alpha: leaf.alpha.to_array(),
            value: leaf.value.to_array(),
            value_error: leaf.value_error.to_array(),
            rounding: rounding.to_array(),
            depth_error: leaf.depth_error.to_array(),
            shade,
        }
    }

    /// The piece in lane `n`, which lies in `interval`.
    #[inline(always)]
    pub(crate) fn piece(&self, scheme: &Bounded, n: usize, interval: usize) -> Piece {
        let interval = scheme.intervals().get(interval);
        let mut color = interval.color(f64::from(self.reference[n]) + f64::from(self.value[n]));
        let mut color_error =
            interval.steepest * self.value_error[n] + interval.steepest_near * self.rounding[n];
        if let Some([factor, factor_error, covariance, covariance_error]) = &self.shade {
            let slope = interval.color_slope();
            color = std::array::from_fn(|k| {
                color[k] * f64::from(factor[n]) + slope[k] * f64::from(covariance[n])
            });
            color_error = interval.brightest * factor_error[n]
                + factor[n] * color_error
                + interval.steepest * covariance_error[n];
        }
        let alpha = f64::from(self.alpha[n]);
        // Four roundings of the opacity itself.
        let depth_error = f64::from(self.depth_error[n]) + alpha * 2.0 * f64::from(f32::EPSILON);
        Piece { alpha, color, error: alpha * f64::from(color_error) + scheme.brightest() * depth_error }
    }
}

/// Segments as they come, a lane each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whole {
    input: Input,
    intervals: [[usize; 2]; LANES],
    lanes: Lanes,
}

impl Whole {
    #[inline(always)]
    pub(crate) fn new(scheme: &Bounded, segments: &Segments, lighting: Option<&Lighting>) -> Self {
        let corners = segments.relative();
        let ends = segments.ends();
        let cubic = Cubic::along(&corners, &ends);
        let size = corners.into_iter().map(Real::abs).reduce(Real::max).unwrap_or(f32x16::ZERO);
        let intervals = intervals_met(scheme, segments, &cubic, size);
        let input = Input {
            value: cubic.0,
            lit: lighting.map(|lighting| Lit::along(&corners, &ends, segments.slopes(), lighting)),
            length: segments.lengths(),
            size,
            units: VALUE_UNITS as f32,
            lit_units: LIT_UNITS as f32,
            reference: segments.reference().to_array(),
            intervals: intervals.map(|[first, _]| first),
        };
        Self { input, intervals, lanes: Lanes::new(scheme, &input, lighting) }
    }

    /// The first and the last interval of the transfer function that each segment may meet.
    #[inline(always)]
    pub(crate) fn intervals(&self) -> &[[usize; 2]; LANES] {
        &self.intervals
    }

    /// What each emits and absorbs, if it meets one interval only.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> &Lanes {
        &self.lanes
    }
}

/// The intervals that each segment may meet: by the exact range of its cell or, where that tells more than one, by its coefficients.
#[inline(always)]
fn intervals_met(
    scheme: &Bounded,
    segments: &Segments,
    cubic: &Cubic<f32x16>,
    size: f32x16,
) -> [[usize; 2]; LANES] {
    let [low, high] = segments.ranges();
    let [b0, b1, b2, b3] = cubic.0;
    let unit = f32x16::splat(0.5 * f32::EPSILON);
    let reference = segments.reference();
    // What coefficients may be off by, and their sum with the reference.
    let slack = unit * (f32x16::splat(VALUE_UNITS as f32) * size + reference.abs());
    let slack = Real::max(slack, f32x16::splat(LEAST_ROUNDING));
    let tight_low = reference + Real::min(Real::min(b0, b1), Real::min(b2, b3)) - slack;
    let tight_high = reference + Real::max(Real::max(b0, b1), Real::max(b2, b3)) + slack;
    let count = segments.count();
    let mut intervals = scheme.intervals().of_ranges(low, high, count);
    if intervals[..count].iter().all(|[first, last]| first == last) {
        return intervals;
    }
    let tight = scheme.intervals().of_ranges(tight_low, tight_high, count);
    for ([first, last], [tight_first, tight_last]) in intervals.iter_mut().zip(tight) {
        if first < last {
            *first = tight_first.max(*first);
            *last = tight_last.min(*last).max(*first);
        }
    }
    intervals
}

/// Cuts within cuts in single precision: each adds up to nine roundings to a value.
const MOST_CUTS: u32 = 12;

/// Values of which roots are found in single precision: squares of smaller ones are denormal numbers, or zero.
const FAINTEST: f32 = 1e-17;

/// What the values of fragments may be off by: besides [`VALUE_UNITS`] and the cuts, by what a root may be misplaced or missed.
const FRAGMENT_UNITS: f64 = VALUE_UNITS + 9.0 * MOST_CUTS as f64 + isoray_cell::EXCURSION_UNITS as f64;

const FRAGMENT_LIT_UNITS: f64 = LIT_UNITS + LIT_UNITS_OF_A_CUT * MOST_CUTS as f64;

/// Segments that meet several intervals, cut at the control points between them, a lane each fragment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fragments {
    value: [[f32; LANES]; 4],
    light: [[f32; LANES]; 3],
    half: [[f32; LANES]; 3],
    length: [f32; LANES],
    size: [f32; LANES],
    reference: [f32; LANES],
    intervals: [usize; LANES],
    count: usize,
    /// By segment: its first and one past its last fragment.
    ranges: [[usize; 2]; LANES],
    /// The segments that have been looked at.
    segments: [usize; 2],
}

impl Fragments {
    /// Of the segments from `first` on, as many as there is room for; one that makes too many has none.
    #[inline(never)]
    pub(crate) fn new(scheme: &Bounded, whole: &Whole, first: usize, count: usize) -> Self {
        let zero = [0.0; LANES];
        let mut this = Self {
            value: [zero; 4],
            light: [zero; 3],
            half: [zero; 3],
            length: zero,
            size: zero,
            reference: zero,
            intervals: [0; LANES],
            count: 0,
            ranges: [[0; 2]; LANES],
            segments: [first, first],
        };
        let value = whole.input.value.map(|b| b.to_array());
        let lit =
            whole.input.lit.map(|lit| (lit.light.map(|q| q.to_array()), lit.half.map(|q| q.to_array())));
        let (length, size) = (whole.input.length.to_array(), whole.input.size.to_array());
        for n in first..count {
            let intervals = whole.intervals[n];
            let before = this.count;
            if intervals[0] < intervals[1] && !scheme.intervals().has_step(intervals) {
                let zero = Lit { light: [0.0; 3], half: [0.0; 3] };
                let lit = lit.map_or(zero, |(light, half)| Lit {
                    light: light.map(|q| q[n]),
                    half: half.map(|q| q[n]),
                });
                let fragment =
                    Fragment { value: value.map(|b| b[n]), lit, share: 1.0f32, intervals, cuts: 0 };
                let common = Common { reference: whole.input.reference[n], length: length[n], size: size[n] };
                if !this.take(scheme, fragment, &common) {
                    this.count = before;
                    // It may have room in the next lanes, unless it had all of these.
                    if before > 0 {
                        break;
                    }
                }
            }
            this.ranges[n] = [before, this.count];
            this.segments[1] = n + 1;
        }
        this
    }

    /// Cuts a fragment until each part lies in one interval; false if there is no room.
    fn take(&mut self, scheme: &Bounded, mut fragment: Fragment<f32>, common: &Common) -> bool {
        while fragment.intervals[0] < fragment.intervals[1] {
            if fragment.cuts == MOST_CUTS || common.size < FAINTEST {
                return false;
            }
            match fragment.separate(scheme.intervals(), common.reference.into(), false) {
                Separated::Narrowed(narrowed) => fragment = narrowed,
                Separated::Into(parts) => {
                    return parts.into_iter().all(|part| self.take(scheme, part, common));
                }
            }
        }
        // The value may really belong to a neighbour, whose slope counts, but not to what lies behind one.
        let rounding = 0.5 * f32::EPSILON * FRAGMENT_UNITS as f32 * common.size;
        let n = self.count;
        if n == LANES || rounding > scheme.intervals().get(fragment.intervals[0]).reach {
            return false;
        }
        for k in 0..4 {
            self.value[k][n] = fragment.value[k];
        }
        for k in 0..3 {
            (self.light[k][n], self.half[k][n]) = (fragment.lit.light[k], fragment.lit.half[k]);
        }
        (self.length[n], self.size[n]) = (common.length * fragment.share, common.size);
        (self.reference[n], self.intervals[n]) = (common.reference, fragment.intervals[0]);
        self.count += 1;
        true
    }

    /// What they emit and absorb.
    #[inline(never)]
    pub(crate) fn integrate(&self, scheme: &Bounded, lighting: Option<&Lighting>) -> Lanes {
        let lit = Lit { light: self.light.map(f32x16::new), half: self.half.map(f32x16::new) };
        let input = Input {
            value: self.value.map(f32x16::new),
            lit: lighting.map(|_| lit),
            length: f32x16::new(self.length),
            size: f32x16::new(self.size),
            units: FRAGMENT_UNITS as f32,
            lit_units: FRAGMENT_LIT_UNITS as f32,
            reference: self.reference,
            intervals: self.intervals,
        };
        Lanes::new(scheme, &input, lighting)
    }

    /// Whether segment `n` has been looked at.
    #[inline(always)]
    pub(crate) fn has(&self, n: usize) -> bool {
        (self.segments[0]..self.segments[1]).contains(&n)
    }

    /// The fragments of segment `n`.
    #[inline(always)]
    pub(crate) fn of(&self, n: usize) -> Range<usize> {
        let [begin, end] = self.ranges[n];
        begin..end
    }

    /// The interval that fragment `at` lies in.
    #[inline(always)]
    pub(crate) fn interval(&self, at: usize) -> usize {
        self.intervals[at]
    }
}

/// What the fragments of a segment have in common.
struct Common {
    reference: f32,
    length: f32,
    size: f32,
}
