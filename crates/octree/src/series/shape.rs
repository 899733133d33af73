//! What all steps of a series have in common.

use std::fmt;

use glam::{DAffine3, DVec3};
use isoray_grid::{Dims, ScalarType};

use crate::volume::AnyVolume;

/// Lattice, type and placement of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Size of the lattice.
    pub dims: Dims,
    /// Type of a sample.
    pub scalar: ScalarType,
    /// World position of an index position.
    pub index_to_world: DAffine3,
}

/// The first thing in which two shapes differ, in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShapeDifference {
    /// `dimensions`, `sample type` or `placement`.
    pub what: &'static str,
    /// As it should be.
    pub expected: String,
    /// As it is.
    pub found: String,
}

impl Shape {
    /// That of a volume.
    pub fn of(volume: &AnyVolume) -> Self {
        let meta = volume.meta();
        Self { dims: meta.dims, scalar: volume.scalar(), index_to_world: meta.index_to_world }
    }

    /// Where `found` differs, if it does; every number counts, to the last bit.
    pub fn difference(&self, found: &Self) -> Option<ShapeDifference> {
        let difference = |what, expected, found| Some(ShapeDifference { what, expected, found });
        if self.dims != found.dims {
            return difference("dimensions", self.dims.to_string(), found.dims.to_string());
        }
        if self.scalar != found.scalar {
            return difference("sample type", self.scalar.to_string(), found.scalar.to_string());
        }
        if self.index_to_world != found.index_to_world {
            let [expected, found] = [self, found].map(|s| placement(&s.index_to_world));
            return difference("placement", expected, found);
        }
        None
    }
}

impl fmt::Display for ShapeDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}, found {}", self.what, self.expected, self.found)
    }
}

fn placement(affine: &DAffine3) -> String {
    let vector = |v: DVec3| format!("({}, {}, {})", v.x, v.y, v.z);
    let [x, y, z, origin] = [affine.x_axis, affine.y_axis, affine.z_axis, affine.w_axis].map(vector);
    format!("axes {x} {y} {z}, origin {origin}")
}
