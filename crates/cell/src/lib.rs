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
//! With `u = 2⁻²⁴` and `M` the largest magnitude of the relative corner values, each Bernstein coefficient
//! of [`Cubic::along`] is within [`VALUE_ERROR_UNITS`]`·u·M` of that of the exact cubic through the same end
//! points, and so is, everywhere on the segment, the polynomial they define. Evaluating it adds at most
//! 9`·u·M`, so a root is within `23·u·M / |df/ds|` of the exact one, plus twice [`ROOT_STEP`]. A
//! component of [`gradient`] is within `15·u·M`. The tests in `tests/float64` assert these bounds against double precision.

mod cubic;
mod fma;
mod gradient;
mod interpolant;
mod power;
mod real;
pub mod root;

pub use cubic::Cubic;
pub use fma::fma;
pub use gradient::{
    STENCIL, central_difference, central_differences, gradient, interpolate_gradients, stencil_gradient,
};
pub use interpolant::{EXCURSION_UNITS, Segment, VALUE_ERROR_UNITS, lerp, relative, trilinear};
pub use power::Power;
pub use real::{Mask, Real};

/// Step at which root refinement stops in `f32`, in the segment's parameter: half a unit in the last place of 1.
pub const ROOT_STEP: f32 = f32::EPSILON / 2.0;
