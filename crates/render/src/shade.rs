//! What is drawn, and how it is lit.

use glam::{DVec3, Vec3};

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
    /// From where the ray comes.
    #[default]
    Headlight,
    /// A point, in world space.
    Point(DVec3),
}

/// The surface to draw and its looks. Colours are linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// The isovalue, in the data's own units.
    pub isovalue: f32,
    /// Which normals.
    pub normals: Normals,
    /// The light.
    pub light: Light,
    /// Colour of the surface.
    pub color: Vec3,
    /// Share of the surface's colour that needs no light, so that what faces away from a lamp is not lost.
    pub ambient: f32,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            isovalue: 0.0,
            normals: Normals::Forward,
            light: Light::Headlight,
            color: Vec3::new(0.80, 0.74, 0.64),
            ambient: 0.1,
        }
    }
}

/// Lambert's law, two-sided: the normal is turned to the viewer. A surface without a normal faces the viewer.
pub(crate) fn shade(scene: &Scene, normal: Vec3, position: DVec3, direction: DVec3) -> Vec3 {
    let to_viewer = -direction.as_vec3();
    let facing = if normal == Vec3::ZERO {
        to_viewer
    } else if normal.dot(to_viewer) < 0.0 {
        -normal
    } else {
        normal
    };
    let to_light = match scene.light {
        Light::Headlight => to_viewer,
        Light::Point(at) => (at - position).normalize_or_zero().as_vec3(),
    };
    let lit = facing.dot(to_light).max(0.0);
    scene.color * (scene.ambient + (1.0 - scene.ambient) * lit)
}
