//! Pieces in lanes: what they emit and absorb, and what that may be off by.
//!
//! # Roundings
//!
//! Let `u = 2⁻²⁴`. A control point's value `b` is a number of single precision, and so is the reference `r`; `d = r − b` is off by `u·|d|`. With
//! coefficients that are rounded themselves, an extinction `τ(b) + τ′·d` is off by at most `u·(|τ(b)| + 3·|τ′·d| + |τ|)`, the last of them being that of
//! the sum, and a second unit of `|τ|` is that of adding `τ′·(s − r)`.
//! A colour `c(b) + c′·x`, `x = d + (s − r)`, is off by at most `u·(|c(b)| + |c′|·(4·|x| + |d|) + |c|)`, and both colours are at most the interval's
//! brightest. A factor and a covariance on it add `3u` of each product. Bounds are sums of a few products of numbers of single precision without
//! cancellation: what they may be too low by is less than [`BOUND_UNITS`]`·u` of them.

use std::ops::Range;

use isoray_cell::Real;
use wide::{f32x16, f64x8};

use crate::Lighting;
use crate::bounded::Bounded;
use crate::intervals::InLanes;
use crate::leaf::{Leaf, Medium};
use crate::segments::{LANES, Radiance};
use crate::shade::{Lit, Shade};

/// Pieces of which each is taken to lie in one interval of the transfer function.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input {
    /// Coefficients of the value, relative to the reference.
    pub(crate) value: [f32x16; 4],
    pub(crate) lit: Option<Lit<f32x16>>,
    pub(crate) length: f32x16,
    /// Largest magnitude of a corner value, relative as well.
    pub(crate) size: f32x16,
    /// What a value may be off by, in roundings of that.
    pub(crate) units: f32,
    /// And what a coefficient of `g·L` may be off by.
    pub(crate) lit_units: f32,
    pub(crate) reference: [f32; LANES],
    /// Intervals of the transfer function.
    pub(crate) intervals: [u32; LANES],
}

/// What values may be off by at least: where they are denormal numbers, roundings do not shrink with them. More than that, so that products with
/// this are no denormal numbers, which take long.
pub(crate) const LEAST_ROUNDING: f32 = 1e-30;

/// Roundings of a bound, with some to spare.
const BOUND_UNITS: f32 = 64.0;

/// Added to what is multiplied on the way to a bound, so that no product is a denormal number.
const NEXT_TO_NOTHING: f32 = 1e-15;

/// What pieces emit and absorb.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pieces {
    alpha: [f32; LANES],
    /// Linear RGB, premultiplied.
    color: [[f32; LANES]; 3],
    /// What a piece may move a pixel by that sees all of it.
    error: [f32; LANES],
}

impl Pieces {
    #[inline(always)]
    pub(crate) fn new(scheme: &Bounded, input: &Input, lighting: Option<&Lighting>) -> Self {
        let unit = f32x16::splat(0.5 * f32::EPSILON);
        let interval = scheme.intervals().in_lanes(&input.intervals);
        let from_base = f32x16::new(input.reference) - interval.base;
        let along = interval.slope * from_base;
        let extinction = Real::fma(interval.slope, from_base, interval.extinction);
        let [two, three] = [2.0, 3.0].map(f32x16::splat);
        let magnitudes = interval.extinction + three * along.abs() + two * extinction.abs();
        let rounding = f32x16::splat(0.5 * f32::EPSILON * input.units) * input.size;
        let rounding = Real::max(rounding, f32x16::splat(LEAST_ROUNDING));
        let medium = Medium {
            extinction,
            extinction_error: unit * magnitudes,
            slope: interval.slope,
            steep: interval.slope_near,
            length: input.length,
            rounding,
        };
        let leaf = Leaf::new(input.value, &medium);
        let shade = input.lit.as_ref().zip(lighting).map(|(lit, lighting)| {
            let lit_rounding = f32x16::splat(0.5 * f32::EPSILON * input.lit_units) * input.size;
            Shade::new(&leaf, lit, lighting, lit_rounding)
        });
        let (color, color_error) =
            Color { interval: &interval, from_base, rounding }.seen(&leaf, shade.as_ref());
        // Four roundings of the opacity itself, and one of several pieces' together.
        let depth_error = leaf.alpha * f32x16::splat(2.5 * f32::EPSILON) + leaf.depth_error;
        let little = f32x16::splat(NEXT_TO_NOTHING);
        let brightest = f32x16::splat(scheme.brightest() as f32);
        let error = Real::fma(leaf.alpha + little, color_error + little, brightest * depth_error);
        let bound = f32x16::splat(1.0 + 0.5 * BOUND_UNITS * f32::EPSILON) * error;
        Self {
            alpha: leaf.alpha.to_array(),
            // An error may make it negative, which only adds to the error.
            color: color.map(|c| (leaf.alpha * c.fast_max(f32x16::ZERO)).to_array()),
            error: bound.to_array(),
        }
    }

    /// Adds the first `count` pieces, front to back, to what there is, and their errors.
    #[inline(always)]
    pub(crate) fn add(&self, count: usize, into: &mut Radiance) {
        // Only transmittance goes from piece to piece; the rest is summed up in lanes.
        let through = self.alpha.map(|alpha| 1.0 - f64::from(alpha));
        let mut before = [0.0; LANES];
        for n in 0..count.min(LANES) {
            before[n] = into.transmittance;
            into.transmittance *= through[n];
        }
        into.error += sum(&before, &self.error, count);
        for (color, of_pieces) in into.color.iter_mut().zip(&self.color) {
            *color += sum(&before, of_pieces, count);
        }
        into.pieces += count as u32;
    }

    /// Makes all pieces of `other` in `lanes` into that of lane `n`, of which nothing is known if there are none.
    pub(crate) fn join(&mut self, n: usize, other: &Self, lanes: Range<usize>) {
        if lanes.is_empty() {
            self.error[n] = f32::INFINITY;
            return;
        }
        let (mut transmittance, mut color, mut error) = (1.0, [0.0; 3], 0.0);
        for k in lanes {
            error += transmittance * f64::from(other.error[k]);
            for (sum, of_pieces) in color.iter_mut().zip(&other.color) {
                *sum += transmittance * f64::from(of_pieces[k]);
            }
            transmittance -= transmittance * f64::from(other.alpha[k]);
        }
        self.alpha[n] = (1.0 - transmittance) as f32;
        self.error[n] = error as f32;
        (0..3).for_each(|k| self.color[k][n] = color[k] as f32);
    }

    /// Adds the piece in lane `n`.
    #[inline(always)]
    pub(crate) fn add_one(&self, n: usize, into: &mut Radiance) {
        into.error += into.transmittance * f64::from(self.error[n]);
        into.add_premultiplied(self.alpha[n].into(), [0, 1, 2].map(|k| self.color[k][n]));
    }
}

/// The sum of the first `count` products.
#[inline(always)]
fn sum(weights: &[f64; LANES], of: &[f32; LANES], count: usize) -> f64 {
    const NUMBERS: [f64; LANES] = [0., 1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 13., 14., 15.];
    let count = f64x8::splat(count as f64);
    let of = of.map(f64::from);
    let [low, high] = [0, LANES / 2].map(|half| {
        let lanes = |of: &[f64; LANES]| f64x8::from(&of[half..half + LANES / 2]);
        // What is in lanes that are not in use may be no number.
        (lanes(weights) * lanes(&of)) & lanes(&NUMBERS).simd_lt(count)
    });
    (low + high).reduce_add()
}

/// How colours are told of pieces in an interval.
struct Color<'i> {
    interval: &'i InLanes,
    /// From where the interval begins to the reference.
    from_base: f32x16,
    /// What a value may be off by.
    rounding: f32x16,
}

impl Color<'_> {
    /// The mean colour of a piece, weighted by what is seen, and a bound of its error.
    #[inline(always)]
    fn seen(&self, leaf: &Leaf<f32x16>, shade: Option<&Shade<f32x16>>) -> ([f32x16; 3], f32x16) {
        let Self { interval, from_base, rounding } = self;
        let unit = f32x16::splat(0.5 * f32::EPSILON);
        let at = *from_base + leaf.value;
        let color = |k: usize| Real::fma(interval.color_slope[k], at, interval.color[k]);
        let [two, three, four] = [2.0, 3.0, 4.0].map(f32x16::splat);
        let spread = Real::fma(four, at.abs(), from_base.abs());
        let roundings = unit * Real::fma(interval.steepest, spread, two * interval.brightest);
        let error = interval.steepest * leaf.value_error + interval.steepest_near * *rounding + roundings;
        let Some(Shade { factor, factor_error, covariance, covariance_error }) = shade else {
            return ([0, 1, 2].map(color), error);
        };
        let lit = |k: usize| Real::fma(color(k), *factor, interval.color_slope[k] * *covariance);
        let products = interval.brightest * *factor + interval.steepest * covariance.abs();
        let error = interval.brightest * *factor_error
            + *factor * error
            + interval.steepest * *covariance_error
            + three * unit * products;
        ([0, 1, 2].map(lit), error)
    }
}
