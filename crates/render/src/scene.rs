//! What is drawn, and how it is lit.

use glam::{DVec3, Vec3};
use isoray_packet::Traversal;

use crate::clip::Clip;

/// How normals are taken from the volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Normals {
    /// The gradient of the cell's own interpolant: exact for the surface drawn, with a crease at each cell face.
    #[default]
    Forward,
    /// Interpolated central differences of the samples: smooth, not exactly the surface's own.
    Central,
}

/// Where light comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Light {
    /// From where the ray comes; what a viewer sees is never in its shadow.
    #[default]
    Headlight,
    /// A point, in world space.
    Point(DVec3),
    /// From far away: the direction to it, in world space, of any length but zero.
    Direction(DVec3),
}

/// One isosurface. Colours are linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The isovalue, in the data's own units.
    pub isovalue: f32,
    /// Its colour, if no other field gives it one.
    pub color: Vec3,
    /// Share of the light behind it that it takes, above 0; 1 is opaque.
    pub opacity: f32,
}

/// A field that surfaces are coloured by.
pub trait ColorField: Sync {
    /// The colour at a cell-local position in a cell of the lattice.
    fn color(&self, cell: [u32; 3], local: [f32; 3]) -> Vec3;
}

/// What is drawn, and its looks.
#[derive(Clone)]
pub struct Scene<'a> {
    /// The isosurfaces; those whose isovalues are equal are drawn in order.
    pub surfaces: Vec<Surface>,
    /// Which normals.
    pub normals: Normals,
    /// The lights, among which the light is shared.
    pub lights: Vec<Light>,
    /// Share of a surface's colour that needs no light, so that what faces away from a lamp is not lost.
    pub ambient: f32,
    /// How bright white highlights are (J. Blinn's, 1977); zero: there are none.
    pub specular: f32,
    /// The larger, the smaller highlights are; at least 1.
    pub exponent: f32,
    /// Whether surfaces keep light from one another.
    pub shadows: bool,
    /// Directions in which it is looked whether the sky is seen, by which the ambient share is multiplied; zero: it is not.
    pub sky_samples: u32,
    /// What is cut away; it casts no shadows either.
    pub clip: Clip,
    /// Whether cuts are closed where the field is inside of a surface there.
    pub cap: bool,
    /// What colours surfaces instead of their own colours.
    pub colors: Option<&'a dyn ColorField>,
    /// Whether the level of detail that is drawn colours surfaces: [`LEVEL_COLORS`].
    pub level_colors: bool,
    /// How rays to a single opaque surface, and from there to lights, go through an octree; of all else each goes alone. The picture is the same, bit for bit.
    pub traversal: Traversal,
    /// Pixels along the edge of a packet of such rays: from 2 to 16.
    pub packet_edge: u32,
}

/// The colour of a surface without one.
pub const SURFACE_COLOR: Vec3 = Vec3::new(0.80, 0.74, 0.64);

/// Of levels of detail, from the finest on, and again.
pub const LEVEL_COLORS: [Vec3; 6] = [
    Vec3::new(0.72, 0.70, 0.66),
    Vec3::new(0.20, 0.52, 0.80),
    Vec3::new(0.88, 0.52, 0.10),
    Vec3::new(0.16, 0.60, 0.32),
    Vec3::new(0.72, 0.20, 0.22),
    Vec3::new(0.48, 0.32, 0.66),
];

impl Scene<'_> {
    /// Whether any light can be hidden from what the viewer sees.
    pub(crate) fn has_shadows(&self) -> bool {
        self.shadows && self.lights.iter().any(|light| !matches!(light, Light::Headlight))
    }

    /// The opaque isosurface of `isovalue` in a headlight.
    pub fn of(isovalue: f32) -> Self {
        Self {
            surfaces: vec![Surface { isovalue, color: SURFACE_COLOR, opacity: 1.0 }],
            normals: Normals::Forward,
            lights: vec![Light::Headlight],
            ambient: 0.1,
            specular: 0.0,
            exponent: 32.0,
            shadows: false,
            sky_samples: 0,
            clip: Clip::default(),
            cap: false,
            colors: None,
            level_colors: false,
            traversal: Traversal::Auto,
            packet_edge: 8,
        }
    }
}
