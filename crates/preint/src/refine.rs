//! A segment cut into pieces until what they may be off by is allowed, in double precision.

use isoray_cell::Cubic;

use crate::Lighting;
use crate::bounded::Bounded;
use crate::fragment::{Fragment, Separated};
use crate::leaf::{Leaf, Medium};
use crate::segments::{Radiance, Segments};
use crate::shade::{Lit, Shade};

/// The least share of a segment that is cut once more. Its error would be below that of double precision.
const LEAST_SHARE: f64 = 1e-13;

/// Cuts within cuts. 43 halvings come to the least share, between two of which there are up to two cuts beside an end, and three at each of the
/// control points that a search among `n` of them looks at, `log₂ n`.
const MOST_CUTS: u32 = 200;

/// Pieces of one segment after which no more are made: more than any error bound of double precision asks for.
const MOST_PIECES: u32 = 1 << 16;

/// What stays the same for all pieces of a segment.
pub(crate) struct Refinement<'a> {
    scheme: &'a Bounded,
    lighting: Option<&'a Lighting>,
    whole: Fragment<f64>,
    reference: f64,
    length: f64,
    /// Number of pieces after which none is cut any more.
    most_pieces: u32,
}

impl<'a> Refinement<'a> {
    /// Of segment `n`, which may meet the transfer function's `intervals`, the first to the last.
    pub(crate) fn new(
        scheme: &'a Bounded,
        segments: &Segments,
        n: usize,
        intervals: [usize; 2],
        lighting: Option<&'a Lighting>,
        into: &Radiance,
    ) -> Self {
        let (corners, ends) = segments.alone(n);
        let lit = lighting.map(|lighting| Lit::along(&corners, &ends, segments.slope_of(n), lighting));
        let value = Cubic::along(&corners, &ends).0;
        Self {
            scheme,
            lighting,
            whole: Fragment { value, lit, share: 1.0, intervals, cuts: 0 },
            reference: segments.reference_of(n),
            length: segments.length_of(n),
            most_pieces: into.pieces.saturating_add(MOST_PIECES),
        }
    }

    /// Adds all pieces, front to back.
    pub(crate) fn add_to(&self, into: &mut Radiance) {
        self.add(self.whole, into);
    }

    fn add(&self, mut piece: Fragment<f64>, into: &mut Radiance) {
        let is_last =
            piece.share <= LEAST_SHARE || piece.cuts == MOST_CUTS || into.pieces >= self.most_pieces;
        while piece.intervals[0] < piece.intervals[1] {
            match piece.separate(self.scheme.intervals(), self.reference, is_last) {
                Separated::Narrowed(narrowed) => piece = narrowed,
                Separated::Into(parts) => return self.add_both(parts, into),
            }
        }
        if !self.try_add(&piece, is_last, into) {
            self.add_both(piece.cut(0.5), into);
        }
    }

    fn add_both(&self, parts: [Fragment<f64>; 2], into: &mut Radiance) {
        for part in parts {
            if !into.is_done {
                self.add(part, into);
            }
        }
    }

    /// Adds a piece that lies in one interval, if its error is allowed or it `is_last`.
    fn try_add(&self, piece: &Fragment<f64>, is_last: bool, into: &mut Radiance) -> bool {
        let interval = self.scheme.intervals().get(piece.intervals[0]);
        let medium = Medium {
            extinction: interval.extinction_at_base(),
            slope: interval.slope,
            length: self.length * piece.share,
            // Of double precision, it is not counted.
            extinction_error: 0.0,
            steep: 0.0,
            rounding: 0.0,
        };
        let leaf = Leaf::new(piece.value.map(|b| interval.inside(b, self.reference)), &medium);
        let slope = interval.color_slope();
        // Not that in single precision, which is infinite where control points are denormal numbers apart.
        let steepest = slope.iter().fold(0.0, |m: f64, k| m.max(k.abs()));
        let mut color = interval.color_from_base(leaf.value);
        let mut color_error = steepest * leaf.value_error;
        if let Some((lit, lighting)) = piece.lit.as_ref().zip(self.lighting) {
            let shade = Shade::new(&leaf, lit, lighting, 0.0);
            color = std::array::from_fn(|k| color[k] * shade.factor + slope[k] * shade.covariance);
            color_error = f64::from(interval.brightest) * shade.factor_error
                + shade.factor * color_error
                + steepest * shade.covariance_error;
        }
        let error = leaf.alpha * color_error + self.scheme.brightest() * leaf.depth_error;
        let is_allowed = is_last || self.scheme.allows(into, leaf.alpha, error);
        if is_allowed {
            self.scheme.add(into, leaf.alpha, color, error);
        }
        is_allowed
    }
}
