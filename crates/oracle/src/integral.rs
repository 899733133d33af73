//! Emission and absorption along a ray: the volume rendering integral, to 10⁻⁹ of full colour.
//!
//! The radiance that leaves a stretch of length `L` towards the viewer is `I = ∫ τ(s)·c(s)·f·e^(−D) dt`, with `D(t) = ∫₀ᵗ τ(s)` the optical
//! depth in front of `t`, and `f` the factor of the shading. Along a straight line through a cell the field `s` is a cubic. It is cut
//! into *pieces* between its extrema and where it crosses control points of the transfer function; on each of them `τ(s)` is a cubic as
//! well, `D` a quartic that is integrated exactly, and the integrand smooth. Gauss-Legendre quadrature does the rest, on panels whose optical
//! depth is at most 1.
//!
//! What makes a stretch hard is a step, or an interval that is thin compared with the variation of the field in the cell: rounding errors
//! move the places where they are crossed, by much where the cubic is flat. The pieces are found in `f64`, an error bound is evaluated along
//! the way, and where it is not small enough they are found anew in [`DoubleDouble`](crate::DoubleDouble).

mod cubic;
mod pieces;
mod quadrature;
mod shading;
mod transfer;

pub use shading::OracleShading;
pub use transfer::{TransferPoint, TransferPoints};

use crate::cell::{Corners, corners};
use crate::path::Path;
use crate::{DoubleDouble, Lattice, OracleRay};
use cubic::Cubic;
use pieces::Pieces;
use quadrature::Light;
use shading::FactorAlong;

/// Optical depth behind which nothing is seen: a ray ends where its transmittance is below 10⁻¹⁴.
const OPAQUE: f64 = 32.3;

/// What a stretch of a ray emits towards its start, and how much it absorbs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OracleRadiance {
    /// Linear RGB, premultiplied: not to be multiplied with alpha again.
    pub color: [f64; 3],
    /// `∫τ`, without a unit.
    pub optical_depth: f64,
}

impl OracleRadiance {
    /// `1 − e^(−∫τ)`, to a few roundings of itself however small it is.
    pub fn alpha(&self) -> f64 {
        -(-self.optical_depth).exp_m1()
    }

    /// This in front of `behind`.
    pub fn over(&self, behind: &Self) -> Self {
        let transmittance = (-self.optical_depth).exp();
        Self {
            color: std::array::from_fn(|n| self.color[n] + transmittance * behind.color[n]),
            optical_depth: self.optical_depth + behind.optical_depth,
        }
    }
}

/// A stretch of a ray in one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OracleStretch {
    /// Samples at the corners; corner `c` lies at `x = c & 1`, `y = c >> 1 & 1`, `z = c >> 2`.
    pub corners: [f64; 8],
    /// Where the ray enters, cell-local.
    pub entry: [f64; 3],
    /// Where it leaves, cell-local.
    pub exit: [f64; 3],
    /// Distance from entry to exit in world units; nothing is there if it is zero, negative or NaN.
    pub length: f64,
}

/// What a stretch emits and absorbs; nothing if a corner is not finite.
///
/// Entry and exit are taken as exact, as are corners, control points and lengths. With `F` the largest product of colour and shading factor,
/// a channel of the colour is within `10⁻¹¹·F·min(1, D)` of the truth, `D` the optical depth, whose own error
/// is below `10⁻¹¹·min(1, D) + 10⁻¹³·D`; typical are 10⁻¹⁵. Where an extremum ties with a
/// step, precision ends at 10⁻³⁰ of the variation of the field: to both errors adds what 10⁻¹⁵ of the length can hold, and a field that stays
/// closer to the step than that, for coordinates of 10⁻³⁸ for example, is on either side of it.
/// Numbers are expected to be zero or between 10⁻⁴⁵ and 10³⁵ in magnitude, as those of `f32` are.
pub fn integrate_stretch(
    stretch: &OracleStretch,
    transfer: &TransferPoints,
    shading: Option<&OracleShading>,
) -> OracleRadiance {
    let mut light = Light::default();
    if stretch.length > 0.0 && is_visible(&stretch.corners, transfer) {
        add(&mut light, stretch, transfer, shading);
    }
    light.radiance
}

/// What a ray sees of a volume, front to back over its cells, against black; a cell with a corner that is not finite is empty.
///
/// `world_per_t` is the length in world units of one unit of the ray's parameter. The errors are those of [`integrate_stretch`] for
/// each cell, and of where cells are entered: half a unit in the last place of `t`. Together below 10⁻⁹ where optical depths of up to 10⁶ per
/// voxel are met within 1000 voxels of the origin. The ray ends where its transmittance is below 10⁻¹⁴: the optical
/// depth then is that up to there.
pub fn integrate_ray(
    lattice: &impl Lattice,
    ray: &OracleRay,
    world_per_t: f64,
    transfer: &TransferPoints,
    shading: Option<&OracleShading>,
) -> OracleRadiance {
    let mut light = Light::default();
    let Some(path) = Path::new(lattice.dims(), ray) else { return light.radiance };
    for segment in path.segments() {
        let corners = corners(lattice, segment.cell);
        let length = (segment.t1 - segment.t0) * world_per_t;
        if !(length > 0.0 && is_visible(&corners, transfer)) {
            continue;
        }
        let [entry, exit] = [segment.t0, segment.t1].map(|t| path.local(segment.cell, t));
        add(&mut light, &OracleStretch { corners, entry, exit, length }, transfer, shading);
        if light.radiance.optical_depth > OPAQUE {
            break;
        }
    }
    light.radiance
}

/// Whether anything in a cell could absorb light: all corners are finite, and there is extinction between the least and the largest.
fn is_visible(corners: &Corners, transfer: &TransferPoints) -> bool {
    if corners.iter().any(|s| !s.is_finite()) {
        return false;
    }
    let [low, high] = range(corners);
    !transfer.is_clear(low, high)
}

/// The least and the largest corner.
fn range(corners: &Corners) -> [f64; 2] {
    corners.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &s| [low.min(s), high.max(s)])
}

/// Adds a stretch behind what light there is.
fn add(
    light: &mut Light,
    stretch: &OracleStretch,
    transfer: &TransferPoints,
    shading: Option<&OracleShading>,
) {
    let factor = shading.map(|shading| FactorAlong::new(shading, stretch));
    let cubic = Cubic::<f64>::new(stretch);
    let mut pieces = Pieces::new(transfer, stretch.length, range(&stretch.corners));
    let cuts = cuts(&cubic, &pieces, factor.as_ref());
    pieces.cut(&cubic, &cuts);
    if pieces.is_doubtful() {
        pieces.cut(&Cubic::<DoubleDouble>::new(stretch), &cuts);
    }
    light.add(&pieces.list, factor.as_ref());
}

/// Parameters, ascending up to 1, between which the field is monotone, where that matters, and the factor smooth.
fn cuts(cubic: &Cubic<f64>, pieces: &Pieces, factor: Option<&FactorAlong>) -> Vec<f64> {
    let mut cuts = Vec::new();
    if !pieces.is_within_one() {
        cuts.extend(cubic.extrema());
    }
    if let Some(factor) = factor {
        cuts.extend(factor.cuts());
    }
    cuts.retain(|&u| u > 0.0 && u < 1.0);
    cuts.sort_unstable_by(f64::total_cmp);
    cuts.push(1.0);
    cuts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{adversarial_stretch, adversarial_transfer};

    /// Where the bound says that `f64` is good enough, pieces found in twice the precision give the same light.
    #[test]
    fn what_is_not_doubtful_is_right() {
        let (mut doubtful, mut worst) = (0, 0.0_f64);
        for seed in 0..60_000 {
            let stretch = adversarial_stretch(seed);
            let [low, high] = range(&stretch.corners);
            let transfer = adversarial_transfer(seed / 6, [low as f32, high as f32]);
            let (double, precise) = (Cubic::<f64>::new(&stretch), Cubic::<DoubleDouble>::new(&stretch));
            let mut pieces = Pieces::new(&transfer, stretch.length, range(&stretch.corners));
            let cuts = cuts(&double, &pieces, None);
            let [mut found, mut exact] = [Light::default(); 2];
            pieces.cut(&double, &cuts);
            found.add(&pieces.list, None);
            doubtful += u32::from(pieces.is_doubtful());
            let is_doubtful = pieces.is_doubtful();
            pieces.cut(&precise, &cuts);
            exact.add(&pieces.list, None);
            if is_doubtful {
                continue;
            }
            let [found, exact] = [found.radiance, exact.radiance];
            let depth = (found.optical_depth - exact.optical_depth).abs();
            let error = (0..3).fold(depth - 1e-13 * exact.optical_depth, |m, n| {
                m.max((found.color[n] - exact.color[n]).abs())
            });
            let error = if error > 0.0 { error / exact.optical_depth.min(1.0) } else { 0.0 };
            assert!(error < 1e-11, "{seed}: {error:e} {found:?} {exact:?} {stretch:?} {transfer:?}");
            worst = worst.max(error);
        }
        println!("{doubtful} doubtful, others within {worst:e}");
        assert!(doubtful > 1000 && doubtful < 30_000, "{doubtful}");
    }
}
