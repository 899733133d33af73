//! Integration by pieces on which the value is taken to be linear.

use isoray_cell::Cubic;
use wide::f32x16;

use crate::cubic_pieces::CubicPieces;
use crate::fragment::split;
use crate::segments::{LANES, Radiance, Segments};
use crate::shade::{Lit, power};
use crate::{Entry, Integrate, Lighting, LinearPieces, Piece, PreintegrationTable};

/// Where segments are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cuts {
    /// Into as many pieces of equal length; at least one.
    Fixed(u32),
    /// At the extrema of the value along the segment, so that no value is missed (Marchesin 2009, section 3.1), and at more places if asked for.
    Adaptive {
        /// At its inflection point, which brings the linear form closer (see [`distortion`](crate::distortion)).
        inflection: bool,
        /// At the extremum of `g·L` (section 3.2).
        shading: bool,
    },
}

/// A way to integrate one piece.
pub trait IntegratePiece: Sync {
    /// Whether the inner coefficients of the value matter.
    const USES_INNER: bool;

    /// Of the piece of world length `length` on which the value has the Bernstein coefficients `value`.
    fn integrate_piece(&self, value: [f64; 4], length: f64) -> Piece;
}

impl IntegratePiece for LinearPieces {
    const USES_INNER: bool = false;

    fn integrate_piece(&self, [first, _, _, last]: [f64; 4], length: f64) -> Piece {
        self.sums(first, last, length).piece()
    }
}

impl<E: Entry + Sync> IntegratePiece for PreintegrationTable<E> {
    const USES_INNER: bool = false;

    fn integrate_piece(&self, [first, _, _, last]: [f64; 4], length: f64) -> Piece {
        self.look_up(first as f32, last as f32, length as f32)
    }
}

impl IntegratePiece for CubicPieces {
    const USES_INNER: bool = true;

    fn integrate_piece(&self, value: [f64; 4], length: f64) -> Piece {
        self.integrate(value, length)
    }
}

/// Pieces whose opacity is that of the cubic, exactly, and whose mean colour is that which `pieces` give: where linearising misplaces values, it
/// then misstates the colour only.
#[derive(Clone, Debug)]
pub struct ExactDepth<P> {
    /// Where the colour comes from: a table, or quadrature.
    pub pieces: P,
    /// Where the opacity comes from.
    pub depth: CubicPieces,
}

impl<P: IntegratePiece> IntegratePiece for ExactDepth<P> {
    const USES_INNER: bool = true;

    fn integrate_piece(&self, value: [f64; 4], length: f64) -> Piece {
        let exact = self.depth.integrate(value, length);
        let piece = self.pieces.integrate_piece(value, length);
        if piece.alpha == 0.0 {
            return exact;
        }
        let scaled = |color: [f32; 3]| color.map(|c| c * (exact.alpha / piece.alpha));
        Piece { alpha: exact.alpha, front: scaled(piece.front), back: scaled(piece.back) }
    }
}

/// Integrates pieces between fixed or adaptive cuts, and interpolates shading between their ends. The error has no bound: that of
/// [`Bounded`](crate::Bounded) has.
#[derive(Clone, Debug)]
pub struct Linearised<P> {
    /// Where segments are cut.
    pub cuts: Cuts,
    /// How pieces are integrated.
    pub pieces: P,
    /// Transmittance at which a ray ends; 0: never before its end.
    pub terminate: f64,
}

/// The polynomials along one segment, in double precision.
struct Along {
    /// Value less the reference.
    value: [f64; 4],
    lit: Lit<f64>,
    reference: f64,
    length: f64,
}

impl<P: IntegratePiece> Integrate for Linearised<P> {
    fn integrate(&self, segments: &Segments, lighting: Option<&Lighting>, into: &mut Radiance) {
        let (corners, ends) = (segments.relative(), segments.ends());
        let value = Cubic::along(&corners, &ends).0.map(|b| b.to_array());
        let lit = lighting.map(|lighting| {
            let Lit { light, half } = Lit::<f32x16>::along(&corners, &ends, segments.slopes(), lighting);
            (light.map(|q| q.to_array()), half.map(|q| q.to_array()))
        });
        let lane = |lanes: &[f32; LANES], n: usize| f64::from(lanes[n]);
        for n in 0..segments.count() {
            let along = Along {
                value: value.each_ref().map(|b| lane(b, n)),
                lit: lit.as_ref().map_or(Lit { light: [0.0; 3], half: [0.0; 3] }, |(light, half)| Lit {
                    light: light.each_ref().map(|q| lane(q, n)),
                    half: half.each_ref().map(|q| lane(q, n)),
                }),
                reference: segments.reference_of(n),
                length: segments.length_of(n),
            };
            self.add(&along, lighting, into);
            if into.transmittance <= self.terminate {
                into.is_done = true;
                return;
            }
        }
    }
}

impl<P: IntegratePiece> Linearised<P> {
    #[inline(always)]
    fn add(&self, along: &Along, lighting: Option<&Lighting>, into: &mut Radiance) {
        match self.cuts {
            Cuts::Fixed(count) => {
                let count = count.max(1);
                let cut = |n: u32| f64::from(n) / f64::from(count);
                self.add_pieces(along, (1..=count).map(cut), lighting, into);
            }
            Cuts::Adaptive { inflection, shading } => {
                let (cuts, count) = along.cuts(inflection, shading && lighting.is_some());
                self.add_pieces(along, cuts.into_iter().take(count).chain([1.0]), lighting, into);
            }
        }
    }

    /// The pieces from 0 to the first of `cuts`, from there to the next, and so on.
    #[inline(always)]
    fn add_pieces(
        &self,
        along: &Along,
        cuts: impl Iterator<Item = f64>,
        lighting: Option<&Lighting>,
        into: &mut Radiance,
    ) {
        let mut from = (0.0, along.value[0], lighting.map(|lighting| along.factor(0.0, lighting)));
        for cut in cuts {
            let to = (cut, along.at(cut), lighting.map(|lighting| along.factor(cut, lighting)));
            let value = if P::USES_INNER { along.between(from.0, to.0) } else { [from.1, 0.0, 0.0, to.1] };
            let piece = self
                .pieces
                .integrate_piece(value.map(|b| b + along.reference), along.length * (to.0 - from.0));
            let color = match (from.2, to.2) {
                (Some(front), Some(back)) => piece.shaded(front as f32, back as f32),
                _ => piece.color(),
            };
            into.add_premultiplied(piece.alpha.into(), color);
            from = to;
        }
    }
}

impl Along {
    fn at(&self, x: f64) -> f64 {
        Cubic(self.value).at(x)
    }

    /// Coefficients between two parameters.
    fn between(&self, from: f64, to: f64) -> [f64; 4] {
        let [front, _] = split(self.value, to);
        let [_, back] = split(front, if to > 0.0 { from / to } else { 0.0 });
        back
    }

    /// The shading factor at a parameter.
    fn factor(&self, x: f64, lighting: &Lighting) -> f64 {
        let at = |[q0, q1, q2]: [f64; 3]| {
            let y = 1.0 - x;
            (y * y * q0 + 2.0 * x * y * q1 + x * x * q2).abs()
        };
        let lit = f64::from(lighting.ambient) + f64::from(lighting.diffuse) * at(self.lit.light);
        if lighting.specular > 0.0 {
            lit + f64::from(lighting.specular) * power(at(self.lit.half).min(1.0), lighting.exponent)
        } else {
            lit
        }
    }

    /// Where the value has its extrema, and if asked for its inflection point and the extremum of `g·L`: in order, and how many.
    fn cuts(&self, inflection: bool, shading: bool) -> ([f64; 4], usize) {
        let (mut cuts, mut count) = ([1.0; 4], 0);
        let mut add = |x: f64| {
            // What is no number is no cut.
            if x > 0.0 && x < 1.0 {
                cuts[count] = x;
                count += 1;
            }
        };
        let [b0, b1, b2, b3] = self.value;
        // A third of the derivative has these Bernstein coefficients: a·x² + 2h·x + d0.
        let [d0, d1, d2] = [b1 - b0, b2 - b1, b3 - b2];
        let (a, h) = ((d0 - d1) - (d1 - d2), d1 - d0);
        let discriminant = d1 * d1 - d0 * d2;
        if discriminant > 0.0 {
            let q = -(h + discriminant.sqrt().copysign(h));
            add(q / a);
            add(d0 / q);
        }
        if inflection {
            add(-h / a);
        }
        if shading {
            let [q0, q1, q2] = self.lit.light;
            add((q0 - q1) / ((q0 - q1) - (q1 - q2)));
        }
        cuts[..count].sort_unstable_by(f64::total_cmp);
        (cuts, count)
    }
}
