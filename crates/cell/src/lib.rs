//! Mathematics of one hexahedral cell: the trilinear interpolant, its cubic along a ray, the first root
//! of that cubic, and the gradient; in `f32` and `f64`, and in lanes of `f32` ([`Real`]).
//!
//! A cell is the unit cube in *cell-local* coordinates; its eight corner values are ordered x fastest,
//! then y, then z:
//!
//! ```text
//!        6-----7         corner n lies at (n & 1, n >> 1 & 1, n >> 2 & 1)
//!       /|    /|
//!      4-----5 |
//!      | 2---|-3         z  y
//!      |/    |/          | /
//!      0-----1           |/___ x
//! ```
//!
//! # From a ray to a root
//!
//! 1. Subtract the isovalue from the corner values ([`relative`]): the sign of each corner is then exact,
//!    and a plateau at exactly the isovalue is exactly zero, which counts as *inside* (`s ≥ v`).
//! 2. Describe the ray's stretch in the cell by its end points ([`Segment`]). A coordinate at which the ray
//!    crosses a face is exactly 0 or 1, so that the two cells on either side of the face see the same
//!    bilinear value, bit for bit: no change of side can fall between two cells.
//! 3. [`Cubic::along`] gives the field on the segment as a cubic in Bernstein form over `[0, 1]`. Its
//!    coefficients are the blossom of the interpolant: averages of the trilinear values at the eight
//!    corners of the box that entry and exit span.
//! 4. [`Cubic::first_root`] returns the first parameter at which the cubic changes side.
//!
//! ```
//! use isoray_cell::{Cubic, Segment, gradient, relative};
//!
//! // s = x on the unit cell, isovalue 0.25, a ray through the middle along +x.
//! let corners: [f32; 8] = relative(&[0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0], 0.25);
//! let segment = Segment { entry: [0.0, 0.5, 0.5], exit: [1.0, 0.5, 0.5] };
//! let root = Cubic::along(&corners, &segment).first_root().get().unwrap();
//! assert!((root - 0.25).abs() < 1e-7);
//! assert_eq!(gradient(&corners, segment.at(root)), [1.0, 0.0, 0.0]);
//! ```
//!
//! # Error
//!
//! With `u` the unit roundoff (`2⁻²⁴` in `f32`, `2⁻⁵³` in `f64`) and `M` the largest magnitude of the relative corner values, each
//! Bernstein coefficient of [`Cubic::along`] is within [`VALUE_ERROR_UNITS`]`·u·M` of that of the exact cubic through the same end
//! points, and so is, everywhere on the segment, the polynomial they define. Evaluating it adds at most 13`·u·M`, so with
//! `B = `[`EXCURSION_UNITS`]`·u·M` a root is within `B / |df/ds|` of the exact one, plus `2u` (twice [`ROOT_STEP`]), where `|df/ds|` is the
//! least magnitude of the slope in between. A component of [`gradient`] is within `15·u·M`.
//!
//! What [`Cubic::first_root`] guarantees, alike in scalars and in every lane:
//!
//! - Both ends are classified by the computed end values, which are the same from both sides of a face. If they differ, there is a root.
//! - If they agree, a pair of crossings is seen whenever the exact field crosses to the other side by more than `B`, and none when it
//!   stays on its side by more than `B`. In between, where the ray grazes, either may be said.
//! - The root lies between the first points at which the exact field is within `B` of the isovalue, and beyond it by `B`, give or take `2u`.
//! - A corner, or an end of the segment, that is not a number gives no root, nor does a segment of length zero.
//!
//! This holds for `M` in [`MAGNITUDES`]; beyond, the first and the last still do. The tests in `tests/float64` assert it
//! against double precision and double-double, and so does `cargo xtask stress cell`, for as many ray-cell pairs as one has time for.
//!
//! # Watertight
//!
//! No ray slips between two cells: on a face that the ray crosses, the coordinate is exactly 0 or 1 and [`lerp`] exactly one of its ends, so
//! that the corners beyond drop out, and both cells compute the same bilinear value by the same operations. A field that is on one
//! side when a cell is left is on that side when the next is entered. `cargo xtask stress traverse` follows rays through whole volumes
//! and counts changes of side between cells: there is none.
//!
//! # Lanes
//!
//! [`Real`] is `f32`, `f64`, or 4, 8 or 16 lanes of `f32`. A formula gives in each lane the bits that it gives for that lane's numbers
//! alone, so packets of rays and single rays make the same picture.
//!
//! ```
//! use isoray_cell::{Cubic, Mask, Real, Segment, relative};
//! use wide::f32x8;
//!
//! // The same cell and ray at eight isovalues at once.
//! let isovalues = f32x8::from_lanes(|n| 0.125 * n as f32 + 0.0625);
//! let corners = [0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0].map(f32x8::splat);
//! let segment = Segment { entry: [0.0, 0.5, 0.5].map(f32x8::splat), exit: [1.0, 0.5, 0.5].map(f32x8::splat) };
//! let root = Cubic::along(&relative(&corners, isovalues), &segment).first_root();
//! assert!(root.found.all() && root.s.to_array()[4] == 0.5625);
//! ```
//!
//! # The choice among first-root finders
//!
//! [`root`] has seven, with one interface. [`root::BernsteinSeries`] is the default: on cells that rays meet in real data it is the fastest
//! of them at any width, and as accurate as the best. What does better somewhere: on grazing pairs one at a time, the closed form, by up to
//! a sixth, with errors 16 times as large or more and some roots missed, and three linear interpolations (Neubauer), which are off by
//! 10⁻³ of a cell or more in 95 of 100; those are also the fastest on random cells, with half of the roots off.
//!
//! `docs/pictures/cell.svg` in the repository shows time against error on the first of the sets below.
//!
#![doc = include_str!("../methods.md")]

mod cubic;
mod gradient;
mod interpolant;
mod power;
mod real;
pub mod root;

pub use cubic::Cubic;
pub use gradient::{
    Normal, STENCIL, central_differences, central_gradients, corner_gradients, gradient,
    interpolate_gradients, stencil_gradient, unit_normal,
};
pub use interpolant::{EXCURSION_UNITS, Segment, VALUE_ERROR_UNITS, lerp, relative, trilinear};
pub use power::Power;
pub use real::{Mask, Real, fma};

/// Magnitudes of the largest relative corner value for which the bounds hold: sums of three do not overflow, and products with a step
/// do not fall among denormal numbers.
pub const MAGNITUDES: std::ops::Range<f64> = 1e-35..1e37;

/// Step at which root refinement stops in `f32`, in the segment's parameter: half a unit in the last place of 1.
pub const ROOT_STEP: f32 = f32::EPSILON / 2.0;
