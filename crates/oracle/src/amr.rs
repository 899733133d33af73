//! Adaptive meshes: the continuous field through the values of cells of several sizes.
//!
//! A mesh ([`AmrCells`]) is made of *leaves*, the cells that no finer ones cover. Its coordinates are integers, in units of the finest cell
//! or of a part of it: those of a lattice, on which the field is known everywhere once it is known at the lattice's points ([`AmrLattice`]).
//! Averages of cells become values at their corners first ([`vertex_values`]).
//!
//! # Where nothing is
//!
//! A leaf with a value that is not finite is none at all: none of its corners counts, finite or not. What no leaf covers is a *gap*. The
//! field in a closed leaf depends on what lies in that closed leaf only, so that gaps and the border of the domain change nothing
//! inside of leaves. A lattice says that a cell is empty by a corner without a value, and a gap one unit wide has no point of its own to say it
//! with: its corners are those of leaves around it. [`AmrCells::halved`] gives it one.

mod cells;
mod field;
mod lattice;
mod vertices;

pub use cells::{AmrCells, AmrLeaf, BadLeaf};
pub use field::AmrField;
pub use lattice::AmrLattice;
pub use vertices::{Border, vertex_values};
