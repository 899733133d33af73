//! Emission and absorption along a ray's segment in a hexahedral cell, with a bounded error.
//!
//! A ray gathers `I = ∫ τ(s)·c(s)·f·e^(−∫τ) dt` front to back, where `s` is the field along it, `τ` and `c` extinction and colour that a
//! [`TransferFunction`] gives to its values, and `f` the factor of [`Lighting`], 1 without. In a cell the field is trilinear, so along the ray
//! it is a cubic, and `∇s·L` a quadratic (Marchesin and Colin de Verdière 2009, sections 3.1 and 3.2). Existing renderers sample these at fixed
//! steps, and skip what is thinner.
//!
//! The caller finds the ray's way and hands over its [`Segments`] in cells, up to [`LANES`] at a time; a scheme that [`Integrate`]s adds
//! them to a [`Radiance`]:
//!
//! ```
//! use isoray_preint::{Bounded, ControlPoint, Integrate, Radiance, Segments, TransferFunction};
//!
//! // A red shell around the value 5, thinner than any step that would sample it.
//! let point = |value, extinction| ControlPoint { value, color: [1.0, 0.1, 0.1], extinction };
//! let shell = TransferFunction::new(vec![point(4.999, 0.0), point(5.0, 2000.0), point(5.001, 0.0)])?;
//! let scheme = Bounded::new(&shell, 1e-3, 1.0);
//!
//! // A cell on whose lower face the field is 0, and 10 on its upper one; a ray straight up through it, one world unit long.
//! let corners = [0.0, 0.0, 0.0, 0.0, 10.0, 10.0, 10.0, 10.0];
//! let mut segments = Segments::default();
//! segments.push(&corners, [0.5, 0.5, 0.0], [0.5, 0.5, 1.0], 1.0);
//! let mut radiance = Radiance::default();
//! scheme.integrate(&segments, None, &mut radiance);
//!
//! // The optical depth is 2000/2 times the 2·10⁻⁴ that the ray is in the shell.
//! let opacity = 1.0 - f64::exp(-0.2);
//! assert!((radiance.alpha() - opacity).abs() < 1e-3 && (radiance.color[0] - opacity).abs() < 1e-3);
//! assert!(radiance.error <= 1e-3);
//! # Ok::<(), isoray_preint::TransferFunctionError>(())
//! ```
//!
//! # Schemes
//!
//! - [`Bounded`] keeps every premultiplied linear RGBA channel of the pixel within ε. It cuts segments where the transfer function bends and where
//!   the error asks for it, and nowhere else.
//! - [`Linearised`] takes the value to be linear between [`Cuts`]: a fixed number of pieces, or the adaptive split of the paper, at the extrema. Its
//!   pieces are integrated by
//!   - [`LinearPieces`], to 2·10⁻⁷ of what the linear value gives;
//!   - a [`PreintegrationTable`], by look-up;
//!   - [`CubicPieces`], with the exact optical depth of the cubic instead, or that and the colour of another by [`ExactDepth`].
//!
//! Between extrema the linear form takes the values that the cubic takes, so none is missed; how far it misplaces them, and what that does to the
//! optical depth, is proved in [`distortion`].
//!
//! [`Visibility`] tells which ranges of values show anything at all, so that a traversal can pass by all others.
//!
//! Lengths are in world units, extinction per world unit, colours linear RGB. Values are in the data's own units, of any magnitude up to
//! [`LARGEST`]; what matters for precision is their variation within a cell.

mod bounded;
mod cubic_pieces;
pub mod distortion;
mod fragment;
mod fragments;
mod intervals;
mod leaf;
mod lighting;
mod linear;
mod linearised;
mod moments;
mod opacity;
mod piece;
mod pieces;
mod refine;
mod segments;
mod shade;
mod table;
mod transfer;
mod visibility;
mod whole;

pub use bounded::{Bounded, LEAST_EPSILON};
pub use cubic_pieces::CubicPieces;
pub use lighting::Lighting;
pub use linear::LinearPieces;
pub use linearised::{Cuts, ExactDepth, IntegratePiece, Linearised};
pub use opacity::opacity;
pub use piece::Piece;
pub use segments::{LANES, LanesMut, Radiance, Segments};
pub use table::{Entry, PreintegrationTable, TableAxes, TableError};

pub use transfer::{ControlPoint, LARGEST, TransferFunction, TransferFunctionError};
pub use visibility::Visibility;

/// A way to integrate emission and absorption along a ray's segments in cells.
pub trait Integrate: Sync {
    /// Adds `segments`, shaded if there is `lighting`, behind what `into` holds.
    fn integrate(&self, segments: &Segments, lighting: Option<&Lighting>, into: &mut Radiance);
}

/// A scheme chosen at run time: sixteen segments at a time, the choice costs next to nothing.
impl<I: Integrate + ?Sized> Integrate for Box<I> {
    fn integrate(&self, segments: &Segments, lighting: Option<&Lighting>, into: &mut Radiance) {
        (**self).integrate(segments, lighting, into);
    }
}
