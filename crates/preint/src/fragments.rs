//! Segments cut at control points, in lanes.

use std::ops::Range;

use wide::f32x16;

use crate::Lighting;
use crate::bounded::Bounded;
use crate::fragment::{Fragment, Separated};
use crate::leaf::VALUE_UNITS;
use crate::pieces::{Input, Pieces};
use crate::segments::LANES;
use crate::shade::{LIT_UNITS, LIT_UNITS_OF_A_CUT, Lit};
use crate::whole::Whole;

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
    intervals: [u32; LANES],
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
            let intervals = whole.intervals(n);
            let before = this.count;
            if intervals[0] < intervals[1] && !scheme.intervals().has_step(intervals) {
                let lit = lit.as_ref().map(|(light, half)| Lit {
                    light: std::array::from_fn(|k| light[k][n]),
                    half: std::array::from_fn(|k| half[k][n]),
                });
                let value = std::array::from_fn(|k| value[k][n]);
                let fragment = Fragment { value, lit, share: 1.0f32, intervals, cuts: 0 };
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
        if let Some(lit) = fragment.lit {
            for k in 0..3 {
                (self.light[k][n], self.half[k][n]) = (lit.light[k], lit.half[k]);
            }
        }
        (self.length[n], self.size[n]) = (common.length * fragment.share, common.size);
        (self.reference[n], self.intervals[n]) = (common.reference, fragment.intervals[0] as u32);
        self.count += 1;
        true
    }

    /// What they emit and absorb.
    #[inline(never)]
    pub(crate) fn integrate(&self, scheme: &Bounded, lighting: Option<&Lighting>) -> Pieces {
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
        Pieces::new(scheme, &input, lighting)
    }

    /// The segments that have been looked at, at least one.
    pub(crate) fn segments(&self) -> Range<usize> {
        self.segments[0]..self.segments[1]
    }

    /// The fragments of segment `n`; none if there is no room, or a step in it.
    pub(crate) fn of(&self, n: usize) -> Range<usize> {
        let [begin, end] = self.ranges[n];
        begin..end
    }
}

/// What the fragments of a segment have in common.
struct Common {
    reference: f32,
    length: f32,
    size: f32,
}
