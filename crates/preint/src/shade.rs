//! The shading factor along a piece.

use isoray_cell::{Real, Segment, gradient};

use crate::Lighting;
use crate::leaf::Leaf;
use crate::moments::QuadraticMoments;

/// Bernstein coefficients, along a segment, of `g·L` and `g·H`: quadratics (Marchesin 2009, equation 12).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lit<R> {
    pub(crate) light: [R; 3],
    pub(crate) half: [R; 3],
}

impl<R: Real> Lit<R> {
    /// Of the field with the given corners, along `segment`; gradients are to be multiplied by `slope`.
    #[inline(always)]
    pub(crate) fn along(corners: &[R; 8], segment: &Segment<R>, slope: R, lighting: &Lighting) -> Self {
        let ends = [segment.entry, segment.at(R::splat(0.5)), segment.exit].map(|p| gradient(corners, p));
        let quadratic = |v: [f32; 3]| {
            let v = v.map(|c| R::splat(c.into()));
            let [first, middle, last] = ends.map(|g| v[0].fma(g[0], v[1].fma(g[1], v[2] * g[2])));
            // The value in the middle is a quarter of the outer coefficients and half of the inner one.
            let inner = R::splat(2.0).fma(middle, R::splat(-0.5) * (first + last));
            [first * slope, inner * slope, last * slope]
        };
        Self { light: quadratic(lighting.light), half: quadratic(lighting.half) }
    }
}

/// Bound of the rounding errors of a coefficient of `g·L`, in units of `2⁻²⁴` times the largest corner and the sum of the light's
/// components: 14 of a gradient's component and 6 of its product with the light; from three such values, less than 2 each, comes
/// the inner coefficient, less than 6, with thrice that and 8 of its own.
pub(crate) const LIT_UNITS: f64 = 68.0;

/// What a cut adds to that: three roundings at each of two levels.
pub(crate) const LIT_UNITS_OF_A_CUT: f64 = 36.0;

/// What a piece is lit by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shade<R> {
    /// Mean factor, weighted by what is seen.
    pub(crate) factor: R,
    pub(crate) factor_error: R,
    /// Covariance of the factor with the value.
    pub(crate) covariance: R,
    pub(crate) covariance_error: R,
}

impl<R: Real> Shade<R> {
    /// Of a piece with the coefficients `lit`, which may be off by `rounding` times the sum of the light's components.
    #[inline(always)]
    pub(crate) fn new(leaf: &Leaf<R>, lit: &Lit<R>, lighting: &Lighting, rounding: R) -> Self {
        let [ambient, diffuse] = [lighting.ambient, lighting.diffuse].map(|k| R::splat(k.into()));
        let [low, high] = leaf.hull();
        let width = high - low;
        let term = diffuse_term(leaf, lit.light, width);
        let of_light = rounding * R::splat(sum(lighting.light));
        let mut shade = Self {
            factor: diffuse.fma(term.factor, ambient),
            factor_error: diffuse * (term.factor_error + of_light),
            covariance: diffuse * term.covariance,
            covariance_error: diffuse * of_light.fma(width, term.covariance_error),
        };
        if lighting.specular > 0.0 {
            let of_half = rounding * R::splat(sum(lighting.half));
            let [value, error, range] = highlight(leaf, lit.half, lighting, of_half);
            shade.factor = shade.factor + value;
            shade.factor_error = shade.factor_error + error;
            shade.covariance_error = (R::splat(0.25) * width).fma(range, shade.covariance_error);
        }
        shade
    }
}

fn sum(v: [f32; 3]) -> f64 {
    v.iter().map(|c| f64::from(c.abs())).sum()
}

/// Least and greatest of three.
#[inline(always)]
fn range<R: Real>([a, b, c]: [R; 3]) -> [R; 2] {
    [a.min(b.min(c)), a.max(b.max(c))]
}

/// The mean of `|g·L|` and its covariance with the value. Where the coefficients differ in sign it is only known to lie between 0 and the
/// largest: of a piece that is halved until it does not matter.
#[inline(always)]
fn diffuse_term<R: Real>(leaf: &Leaf<R>, q: [R; 3], width: R) -> Shade<R> {
    let zero = R::splat(0.0);
    let [low, high] = range(q);
    let moments = QuadraticMoments::new(q);
    let [mean, error] = leaf.mean_of(&moments, high - low);
    let [covariance, covariance_error] = leaf.covariance_with(&moments, [mean, error], high - low);
    let largest = low.abs().max(high.abs());
    let half = R::splat(0.5) * largest;
    let is_smooth = low.ge(zero) | high.le(zero);
    Shade {
        factor: R::select(is_smooth, mean.abs(), half),
        factor_error: R::select(is_smooth, error, half),
        covariance: R::select(is_smooth, R::select(low.ge(zero), covariance, -covariance), zero),
        // Grüss (1935): at most a quarter of the product of the ranges.
        covariance_error: R::select(is_smooth, covariance_error, R::splat(0.5) * half * width),
    }
}

/// The mean of the highlight, a bound of its error, and its range.
///
/// `F(h) = k·min(1, |h|)ⁿ` lies between its values at the least and the greatest `|h|`. Where `F` is smooth, the mean also differs from `F` at
/// the mean of `h` by at most `½·max|F″|·Var(h) + max|F′|·error`, with `Var(h)` at most a quarter of the squared range (Popoviciu 1935).
fn highlight<R: Real>(leaf: &Leaf<R>, h: [R; 3], lighting: &Lighting, rounding: R) -> [R; 3] {
    let [zero, half, one] = [0.0, 0.5, 1.0].map(R::splat);
    let k = R::splat(lighting.specular.into());
    let n = lighting.exponent;
    let [low, high] = range(h);
    let is_smooth = low.ge(zero) | high.le(zero);
    let [a, b] = [low.abs(), high.abs()];
    let (least, greatest) = (R::select(is_smooth, a.min(b), zero), a.max(b) + rounding);
    let least = (least - rounding).max(zero);
    let of = |x: R| k * power(x.min(one), n);
    let [from, to] = [of(least), of(greatest)];
    let middle = half * (from + to);
    let spread = half * (to - from);
    let width = greatest - least;
    let [mean, error] = leaf.mean_of(&QuadraticMoments::new(h), high - low);
    let slope = k * R::splat(n.into()) * power(greatest.min(one), n - 1.0);
    // The second derivative rises with h from an exponent of 2 on, and falls below.
    let bent = if n >= 2.0 { greatest.min(one) } else { least };
    let bend =
        if n == 1.0 { zero } else { k * R::splat(f64::from(n) * f64::from(n - 1.0)) * power(bent, n - 2.0) };
    let smooth_error = (R::splat(0.125) * bend * width).fma(width, slope * (error + rounding));
    let is_close = is_smooth & greatest.le(one) & smooth_error.lt(spread);
    let roundings = to * R::splat(f64::from(n + 4.0) * R::EPSILON);
    let error = R::select(is_close, smooth_error, spread) + roundings;
    [R::select(is_close, of(mean.abs()), middle), error, to - from + roundings]
}

/// The largest whole exponent whose power is a product.
const LARGEST_PRODUCT: f32 = 1024.0;

/// Powers less than this are as good as zero; without a floor, products fall among denormal numbers, which take long.
const LEAST_POWER_OF_TEN: f32 = -30.0;

/// `x` from 0 to 1 to a power of at least 0, to `exponent + 2` roundings and 10⁻³⁰; a whole one by repeated squaring, in a fraction of the time
/// that any other takes.
#[inline(always)]
pub(crate) fn power<R: Real>(x: R, exponent: f32) -> R {
    if exponent.fract() != 0.0 || !(0.0..=LARGEST_PRODUCT).contains(&exponent) {
        return x.powf(exponent);
    }
    let floor = if exponent > 0.0 { 10f32.powf(LEAST_POWER_OF_TEN / exponent) } else { 0.0 };
    let (mut left, mut square, mut product) = (exponent as u32, x.max(R::splat(floor.into())), R::splat(1.0));
    while left > 0 {
        if left & 1 == 1 {
            product = product * square;
        }
        square = square * square;
        left >>= 1;
    }
    product
}
