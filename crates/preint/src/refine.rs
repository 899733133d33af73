//! A segment cut into pieces until what they may be off by is allowed.

use isoray_cell::Cubic;

use crate::Lighting;
use crate::bounded::Bounded;
use crate::leaf::{Leaf, Medium};
use crate::segments::{Radiance, Segments};
use crate::shade::{Lit, Shade};

/// A part of a segment.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Coefficients of the value, relative to the reference, and of `g·L` and `g·H`.
    value: [f64; 4],
    lit: Lit<f64>,
    /// Share of the segment's length.
    share: f64,
    /// Of the transfer function, that the value may meet.
    first: usize,
    last: usize,
}

/// The least share of a segment that is cut once more. Its error would be below that of double precision.
const LEAST_SHARE: f64 = 1e-13;

/// Pieces that can wait; one for which there is no room is not cut. Each cut leaves one waiting: 43 halvings come to the least share, and
/// three cuts at each of the control points that a search among `n` of them looks at, `log₂ n`.
const ROOM: usize = 128;

/// What stays the same for all pieces of a segment.
pub(crate) struct Refinement<'a> {
    scheme: &'a Bounded,
    lighting: Option<&'a Lighting>,
    whole: Piece,
    reference: f64,
    length: f64,
    size: f64,
}

impl<'a> Refinement<'a> {
    pub(crate) fn new(
        scheme: &'a Bounded,
        segments: &Segments,
        n: usize,
        [first, last]: [usize; 2],
        lighting: Option<&'a Lighting>,
    ) -> Self {
        let (corners, ends) = segments.alone(n);
        let zero = Lit { light: [0.0; 3], half: [0.0; 3] };
        let lit = lighting.map_or(zero, |lighting| Lit::along(&corners, &ends, lighting));
        let value = Cubic::along(&corners, &ends).0;
        Self {
            scheme,
            lighting,
            whole: Piece { value, lit, share: 1.0, first, last },
            reference: segments.reference_of(n),
            length: segments.length_of(n),
            size: corners.iter().fold(0.0, |m, c| m.max(c.abs())),
        }
    }

    /// Adds all pieces, front to back.
    pub(crate) fn add_to(&self, into: &mut Radiance) {
        let mut waiting = [self.whole; ROOM];
        let mut count = 1;
        while count > 0 && !into.is_done {
            count -= 1;
            let piece = waiting[count];
            let is_last = piece.share <= LEAST_SHARE || count + 2 > ROOM;
            let cut = if piece.first < piece.last {
                self.separate(&piece, is_last)
            } else {
                self.try_add(&piece, is_last, into)
            };
            match cut {
                Cut::Into([near, far]) => {
                    (waiting[count], waiting[count + 1]) = (far, near);
                    count += 2;
                }
                Cut::Narrowed(whole) => {
                    waiting[count] = whole;
                    count += 1;
                }
                Cut::Added => {}
            }
        }
    }

    /// Cuts a piece where its value passes the middle one of the control points that it may meet, or finds that it does not.
    fn separate(&self, piece: &Piece, is_last: bool) -> Cut {
        let middle = (piece.first + piece.last) / 2;
        let at = self.scheme.intervals().break_after(middle) - self.reference;
        let above = Cut::Narrowed(Piece { first: middle + 1, ..*piece });
        let below = Cut::Narrowed(Piece { last: middle, ..*piece });
        let off = piece.value.map(|b| b - at);
        if off.iter().all(|&b| b >= 0.0) {
            return above;
        }
        if off.iter().all(|&b| b <= 0.0) {
            return below;
        }
        if is_last {
            return if Cubic(off).at(0.5) >= 0.0 { above } else { below };
        }
        let root = Cubic(off).first_root().get().unwrap_or(0.0);
        // A root at an end separates nothing: the polygon crosses where the curve does not.
        let is_inside = root > 0.0 && root < 1.0;
        let mut halves = piece.cut(if is_inside { root } else { 0.5 });
        if is_inside {
            (halves[0].value[3], halves[1].value[0]) = (at, at);
        }
        Cut::Into(halves)
    }

    /// Adds a piece that lies in one interval, if its error is allowed.
    fn try_add(&self, piece: &Piece, is_last: bool, into: &mut Radiance) -> Cut {
        let interval = self.scheme.intervals().get(piece.first);
        let medium = Medium {
            extinction: interval.extinction(self.reference),
            slope: interval.slope,
            length: self.length * piece.share,
            size: self.size,
        };
        let leaf = Leaf::new(piece.value, &medium);
        let steepest = f64::from(interval.steepest);
        let mut color = interval.color(self.reference + leaf.value);
        let mut color_error = steepest * leaf.value_error;
        if let Some(lighting) = self.lighting {
            let shade = Shade::new(&leaf, &piece.lit, lighting, self.size);
            let slope = interval.color_slope();
            color = std::array::from_fn(|k| color[k] * shade.factor + slope[k] * shade.covariance);
            color_error = f64::from(interval.brightest) * shade.factor_error
                + shade.factor * color_error
                + steepest * shade.covariance_error;
        }
        let error = leaf.alpha * color_error + self.scheme.brightest() * leaf.depth_error;
        if self.scheme.allows(into, leaf.alpha, error) || is_last {
            self.scheme.add(into, leaf.alpha, color, error);
            return Cut::Added;
        }
        Cut::Into(piece.cut(0.5))
    }
}

/// What became of a piece.
enum Cut {
    Added,
    /// It meets fewer intervals than it might have.
    Narrowed(Piece),
    /// Front and back.
    Into([Piece; 2]),
}

impl Piece {
    /// The parts before and after parameter `x` (de Casteljau).
    fn cut(&self, x: f64) -> [Self; 2] {
        let value = split(self.value, x);
        let (light, half) = (split(self.lit.light, x), split(self.lit.half, x));
        let share = [self.share * x, self.share * (1.0 - x)];
        std::array::from_fn(|n| Self {
            value: value[n],
            lit: Lit { light: light[n], half: half[n] },
            share: share[n],
            ..*self
        })
    }
}

/// Bernstein coefficients of a polynomial on `[0, x]` and on `[x, 1]`.
fn split<const N: usize>(mut b: [f64; N], x: f64) -> [[f64; N]; 2] {
    let (mut near, mut far) = (b, b);
    for level in 1..N {
        for n in (level..N).rev() {
            b[n] = isoray_cell::lerp(b[n - 1], b[n], x);
        }
        near[level] = b[level];
        far[N - 1 - level] = b[N - 1];
    }
    [near, far]
}
