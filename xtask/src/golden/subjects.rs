//! The volumes of the scenes of which pictures are stored.

use anyhow::{Result, bail};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use isoray_benches::volumes::{marschner_lobb, turbulence};
use isoray_grid::{Dims, Scalar, ScalarType};
use isoray_render::{Clip, Light, Plane};

use super::scenes::{Cut, Lamp, Of};
use crate::catalog::{Dense, DenseVisitor, Entry};

/// Samples along each axis of the rings: cells are 2⁶, so that coarse lattices end where the volume does.
const RINGS: u32 = 65;
/// Of the mixing layer.
const TURBULENCE: u32 = 64;

impl Of {
    /// What it is called; the rings are called alike whatever their type, as is their reference.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Tooth => "tooth",
            Self::Oblique => "oblique tooth",
            Self::Rings(_) => "rings",
            Self::Turbulence => "mixing layer",
            Self::Gaps => "mixing layer with gaps",
            Self::Mesh(0) => "mesh, unbalanced",
            Self::Mesh(1) => "mesh, mixed ratios",
            Self::Mesh(_) => "mesh, gaps",
            Self::ObliqueMesh(0) => "oblique mesh, unbalanced",
            Self::ObliqueMesh(1) => "oblique mesh, mixed ratios",
            Self::ObliqueMesh(_) => "oblique mesh, gaps",
        }
    }

    /// The values that surfaces are at in volumes rendered as shells.
    pub(crate) fn isovalues(self) -> &'static [f32] {
        match self {
            Self::Tooth | Self::Oblique => &[600.0, 1050.0],
            Self::Rings(_) => &[127.5],
            Self::Turbulence | Self::Gaps => &[100.0],
            Self::Mesh(_) | Self::ObliqueMesh(_) => &[0.1],
        }
    }

    /// A value of the rings as bytes, in their own type.
    pub(crate) fn own(self, value: f32) -> f32 {
        match self {
            Self::Rings(ScalarType::I8) => value - 128.0,
            Self::Rings(ScalarType::U16) => value * 257.0,
            Self::Rings(ScalarType::I16) => value * 257.0 - 32768.0,
            Self::Rings(ScalarType::F32) => value / 255.0,
            _ => value,
        }
    }

    /// Reads or generates a volume that is no mesh, and hands it to `visitor`.
    pub(crate) fn visit<V: DenseVisitor>(self, visitor: V) -> Result<V::Output> {
        match self {
            Self::Tooth => Entry::fixture().visit(visitor),
            Self::Oblique => Entry::fixture().visit(Placed(oblique(), visitor)),
            Self::Rings(scalar) => {
                let bytes = marschner_lobb(RINGS as usize);
                let own = |byte: &u8| self.own((*byte).into());
                Ok(match scalar {
                    ScalarType::U8 => visitor.visit(&dense(RINGS, bytes)?),
                    ScalarType::I8 => visitor.visit(&dense(RINGS, as_type(&bytes, |b| own(b) as i8))?),
                    ScalarType::U16 => visitor.visit(&dense(RINGS, as_type(&bytes, |b| own(b) as u16))?),
                    ScalarType::I16 => visitor.visit(&dense(RINGS, as_type(&bytes, |b| own(b) as i16))?),
                    ScalarType::F32 => visitor.visit(&dense(RINGS, as_type(&bytes, own))?),
                })
            }
            Self::Turbulence => Ok(visitor.visit(&dense(TURBULENCE, turbulence(TURBULENCE as usize))?)),
            Self::Mesh(_) | Self::ObliqueMesh(_) => bail!("a mesh has no lattice"),
            Self::Gaps => {
                let bytes = turbulence(TURBULENCE as usize);
                Ok(visitor.visit(&dense(TURBULENCE, with_gaps(&bytes))?))
            }
        }
    }
}

fn dense<T>(edge: u32, samples: Vec<T>) -> Result<Dense<T>> {
    Ok(Dense { dims: Dims::new([edge; 3])?, samples, index_to_world: DAffine3::IDENTITY })
}

fn as_type<T>(bytes: &[u8], convert: impl Fn(&u8) -> T) -> Vec<T> {
    bytes.iter().map(convert).collect()
}

/// A ball without values, half of it not numbers and half infinite, and single samples here and there.
fn with_gaps(bytes: &[u8]) -> Vec<f32> {
    let gap = |n: usize| {
        let edge = TURBULENCE as usize;
        let p = [n % edge, n / edge % edge, n / (edge * edge)].map(|c| c as f64);
        let from = [44.0, 40.0, 38.0];
        let distance = (0..3).map(|a| (p[a] - from[a]).powi(2)).sum::<f64>().sqrt();
        distance < 12.0 || n.is_multiple_of(9973)
    };
    let value = |(n, byte): (usize, &u8)| match gap(n) {
        true if n.is_multiple_of(2) => f32::NAN,
        true => f32::INFINITY,
        false => (*byte).into(),
    };
    bytes.iter().enumerate().map(value).collect()
}

/// A turned and sheared lattice of unequal spacings.
pub(crate) fn oblique() -> DAffine3 {
    let turned = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(0.2, 1.0, 0.4).normalize(), 0.7));
    let sheared = DMat3::from_cols(DVec3::X, DVec3::new(0.35, 1.0, 0.0), DVec3::new(-0.15, 0.25, 1.0));
    let spaced = DMat3::from_diagonal(DVec3::new(1.3, 0.9, 0.7));
    DAffine3 { matrix3: turned * sheared * spaced, translation: DVec3::new(-40.0, 12.5, 300.0) }
}

/// Hands a volume on, placed otherwise.
struct Placed<V>(DAffine3, V);

impl<V: DenseVisitor> DenseVisitor for Placed<V> {
    type Output = V::Output;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> V::Output {
        let Self(index_to_world, visitor) = self;
        visitor.visit(&Dense { dims: volume.dims, samples: volume.samples.clone(), index_to_world })
    }
}

/// What places and distances of a scene are relative to.
#[derive(Clone, Copy)]
pub(crate) struct Extent {
    centre: DVec3,
    longest: f64,
}

impl Extent {
    /// The centre, and the longest side, as cameras have them.
    pub(crate) fn new(dims: Dims, index_to_world: &DAffine3) -> Self {
        let last = DVec3::from_array(dims.axes().map(|n| f64::from(n - 1)));
        let side = |a: usize| index_to_world.matrix3.col(a).length() * f64::from(dims.axes()[a]);
        Self {
            centre: index_to_world.transform_point3(last / 2.0),
            longest: side(0).max(side(1)).max(side(2)),
        }
    }

    /// In the world.
    pub(crate) fn light(&self, lamp: Lamp) -> Light {
        match lamp {
            Lamp::Head => Light::Headlight,
            Lamp::From(direction) => Light::Direction(direction.into()),
            Lamp::At(place) => Light::Point(self.at(place)),
        }
    }

    /// In the world.
    pub(crate) fn clip(&self, cuts: &[Cut]) -> Clip {
        let mut clip = Clip::default();
        for cut in cuts {
            match *cut {
                Cut::Plane(normal, distance) => {
                    let normal = DVec3::from_array(normal).normalize();
                    clip.0.push(Plane { normal, offset: normal.dot(self.centre) + distance * self.longest });
                }
                Cut::Box(low, high) => clip.add_box(self.at(low), self.at(high)),
            }
        }
        clip
    }

    fn at(&self, place: [f64; 3]) -> DVec3 {
        self.centre + self.longest * DVec3::from_array(place)
    }
}
