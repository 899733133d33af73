//! The scenes of which pictures are stored: a table.

use glam::DAffine3;
use isoray_grid::{Dims, ScalarType};
use isoray_octree::Coarse;
use isoray_render::{Normals, Projection, View};

use crate::catalog::Place;

/// One picture.
pub(crate) struct PictureScene {
    pub(crate) name: &'static str,
    pub(crate) of: Of,
    pub(crate) from: Spot,
    pub(crate) look: Look,
}

/// Where the camera stands, and of its distance from what it looks at, or of the picture's height if rays are parallel, the share that is left: small things
/// fill a picture too.
#[derive(Clone, Copy)]
pub(crate) struct Spot(Place, f64);

/// What is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Of {
    /// The bundled scan.
    Tooth,
    /// The same on a lattice that is turned, sheared and of unequal spacings.
    Oblique,
    /// Marschner and Lobb's field on 65³ samples of each type: the pictures are one.
    Rings(ScalarType),
    /// A mixing layer.
    Turbulence,
    /// The mixing layer with samples that are not finite.
    Gaps,
    /// One of the adaptive meshes of [`Source`](super::mesh::Source), by number.
    Mesh(usize),
    /// The same in a world that is turned, sheared and stretched.
    ObliqueMesh(usize),
}

/// How it is shown.
pub(crate) enum Look {
    Surfaces(Surfaces),
    Volume(Layers),
}

/// Isosurfaces.
#[derive(Clone, Copy)]
pub(crate) struct Surfaces {
    /// Isovalue and opacity.
    pub(crate) surfaces: &'static [(f32, f32)],
    pub(crate) normals: Normals,
    pub(crate) lamps: &'static [Lamp],
    pub(crate) shadows: bool,
    pub(crate) specular: f32,
    pub(crate) sky_samples: u32,
    pub(crate) cuts: &'static [Cut],
    pub(crate) cap: bool,
    /// Whether places colour the surfaces.
    pub(crate) by_place: bool,
    /// Whether levels of detail do.
    pub(crate) by_level: bool,
    pub(crate) levels: Option<Levels>,
}

/// Emission and absorption.
#[derive(Clone, Copy)]
pub(crate) struct Layers {
    pub(crate) scheme: Scheme,
    pub(crate) light: Option<Lamp>,
    pub(crate) cuts: &'static [Cut],
}

/// A light. Places and distances are in units of the volume's longest side, from its centre.
#[derive(Clone, Copy)]
pub(crate) enum Lamp {
    Head,
    At([f64; 3]),
    From([f64; 3]),
}

/// What is cut away.
#[derive(Clone, Copy)]
pub(crate) enum Cut {
    /// What is beyond a plane of this normal, at a distance from the centre.
    Plane([f64; 3], f64),
    /// What is outside of a box from one corner to the other.
    Box([f64; 3], [f64; 3]),
}

/// Levels of detail.
#[derive(Clone, Copy)]
pub(crate) struct Levels {
    pub(crate) ratio: f64,
    /// Width of the transition.
    pub(crate) blend: f64,
    pub(crate) by_slices: bool,
    /// Whether shadows come through coarser levels.
    pub(crate) far_shadows: bool,
    /// What coarse samples are.
    pub(crate) coarse: Coarse,
}

/// How rays are integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scheme {
    Bounded(f64),
    Adaptive,
    Fixed(u32),
    Table,
    /// Bounded, coloured by the levels of a mesh.
    ByLevel(f64),
}

/// Half a step of 8 bits: the program's default.
pub(crate) const EPSILON: f64 = 1.0 / 510.0;

const PLAIN: Surfaces = Surfaces {
    surfaces: &[],
    normals: Normals::Forward,
    lamps: &[Lamp::Head],
    shadows: false,
    specular: 0.0,
    sky_samples: 0,
    cuts: &[],
    cap: false,
    by_place: false,
    by_level: false,
    levels: None,
};

const SKIN: Surfaces = Surfaces { surfaces: &[(600.0, 1.0)], ..PLAIN };
const ENAMEL: Surfaces = Surfaces { surfaces: &[(1050.0, 1.0)], ..PLAIN };
const BOTH: Surfaces = Surfaces { surfaces: &[(600.0, 0.4), (1050.0, 1.0)], ..PLAIN };
const RINGS: Surfaces = Surfaces { surfaces: &[(127.5, 1.0)], lamps: SUN, shadows: true, ..PLAIN };
const MIXED: Surfaces = Surfaces { surfaces: &[(99.5, 1.0)], ..PLAIN };
const GYROID: Surfaces = Surfaces { surfaces: &[(0.1, 1.0)], ..PLAIN };

const FAR: Spot = Spot(Place::Far, 1.0);
const NEAR: Spot = Spot(Place::Far, 0.6);
const CLOSE: Spot = Spot(Place::Close, 1.0);
const INSIDE: Spot = Spot(Place::Inside, 1.0);
const ALONG: Spot = Spot(Place::Along, 1.0);
const ALONG_NEAR: Spot = Spot(Place::Along, 0.45);

/// Near the middle.
const CANDLE: &[Lamp] = &[Lamp::At([0.07, -0.04, 0.06])];
const SUN: &[Lamp] = &[Lamp::From([-0.5, 1.0, 0.6])];
/// For what is seen along z.
const ASLANT: &[Lamp] = &[Lamp::From([-0.6, -0.3, -0.5])];
const TWO: &[Lamp] = &[Lamp::From([0.8, 0.5, 1.0]), Lamp::At([-0.4, 0.9, 0.7])];
const HALF: &[Cut] = &[Cut::Plane([0.3, 0.1, -1.0], 0.02)];
const BOX: &[Cut] = &[Cut::Box([-0.21, -0.33, -0.34], [0.17, 0.11, 0.27])];

/// From afar.
const ABRUPT: Levels =
    Levels { ratio: 1.6, blend: 0.0, by_slices: false, far_shadows: false, coarse: Coarse::Injected };
/// From nearby.
const COARSE: Levels = Levels { ratio: 6.0, ..ABRUPT };

const GLOW: Layers = Layers { scheme: Scheme::Bounded(EPSILON), light: None, cuts: &[] };
const SHADED: Layers = Layers { light: Some(Lamp::From([0.3, -0.5, 0.8])), ..GLOW };

impl Spot {
    pub(crate) fn view(self, dims: Dims, index_to_world: &DAffine3) -> View {
        let Self(place, share) = self;
        let view = place.view(dims, index_to_world);
        match view.projection {
            Projection::Perspective { .. } => {
                View { eye: view.look_at + (view.eye - view.look_at) * share, ..view }
            }
            Projection::Orthographic { height } => {
                View { projection: Projection::Orthographic { height: height * share }, ..view }
            }
        }
    }
}

const fn surfaces(name: &'static str, of: Of, from: Spot, look: Surfaces) -> PictureScene {
    PictureScene { name, of, from, look: Look::Surfaces(look) }
}

const fn volume(name: &'static str, of: Of, from: Spot, look: Layers) -> PictureScene {
    PictureScene { name, of, from, look: Look::Volume(look) }
}

/// All of them, those of one volume beside each other.
#[rustfmt::skip]
pub(crate) const SCENES: &[PictureScene] = {
    use Of::*;
    &[
        surfaces("highlights", Tooth, NEAR, Surfaces { specular: 0.5, ..SKIN }),
        surfaces("central normals", Tooth, CLOSE, Surfaces { normals: Normals::Central, ..SKIN }),
        surfaces("orthographic, central normals", Tooth, ALONG, Surfaces { normals: Normals::Central, ..ENAMEL }),
        surfaces("shadows", Tooth, NEAR, Surfaces { lamps: SUN, shadows: true, ..SKIN }),
        surfaces("two lamps, shadows, highlights", Tooth, NEAR, Surfaces { lamps: TWO, shadows: true, specular: 0.4, ..ENAMEL }),
        surfaces("a lamp inside", Tooth, INSIDE, Surfaces { lamps: CANDLE, ..ENAMEL }),
        surfaces("orthographic, shadows", Tooth, ALONG_NEAR, Surfaces { lamps: ASLANT, shadows: true, ..SKIN }),
        surfaces("ambient occlusion", Tooth, NEAR, Surfaces { sky_samples: 16, lamps: SUN, ..SKIN }),
        surfaces("three surfaces", Tooth, FAR, Surfaces { surfaces: &[(600.0, 0.3), (850.0, 0.5), (1050.0, 0.8)], ..PLAIN }),
        surfaces("translucent, shadows", Tooth, NEAR, Surfaces { surfaces: &[(600.0, 0.4), (1050.0, 0.8)], lamps: SUN, shadows: true, ..PLAIN }),
        surfaces("a plane", Tooth, NEAR, Surfaces { cuts: HALF, lamps: SUN, shadows: true, ..SKIN }),
        surfaces("a plane, capped", Tooth, NEAR, Surfaces { surfaces: &[(600.0, 1.0), (1050.0, 1.0)], cuts: HALF, cap: true, ..PLAIN }),
        surfaces("a plane, capped, shadows", Tooth, NEAR, Surfaces { surfaces: &[(600.0, 1.0), (1050.0, 1.0)], cuts: HALF, cap: true, lamps: SUN, shadows: true, ..PLAIN }),
        surfaces("a box, capped, translucent", Tooth, NEAR, Surfaces { cuts: BOX, cap: true, ..BOTH }),
        surfaces("a box, orthographic", Tooth, ALONG, Surfaces { cuts: BOX, ..SKIN }),
        surfaces("coloured by a field", Tooth, FAR, Surfaces { by_place: true, ..SKIN }),
        volume("bounded", Tooth, FAR, GLOW),
        volume("bounded, shaded, inside", Tooth, INSIDE, SHADED),
        volume("bounded, orthographic", Tooth, ALONG, SHADED),
        volume("bounded, headlight", Tooth, NEAR, Layers { light: Some(Lamp::Head), ..GLOW }),
        volume("adaptive", Tooth, FAR, Layers { scheme: Scheme::Adaptive, ..SHADED }),
        volume("fixed", Tooth, FAR, Layers { scheme: Scheme::Fixed(4), ..SHADED }),
        volume("table", Tooth, FAR, Layers { scheme: Scheme::Table, ..SHADED }),
        volume("bounded, a plane", Tooth, NEAR, Layers { cuts: HALF, ..SHADED }),
        volume("bounded, a box", Tooth, CLOSE, Layers { cuts: BOX, ..GLOW }),
        surfaces("plain", Oblique, FAR, SKIN),
        surfaces("central normals, shadows", Oblique, FAR, Surfaces { normals: Normals::Central, lamps: SUN, shadows: true, ..ENAMEL }),
        surfaces("orthographic, capped", Oblique, ALONG, Surfaces { cuts: HALF, cap: true, ..BOTH }),
        volume("bounded", Oblique, FAR, SHADED),
        surfaces("shadows", Rings(ScalarType::U8), FAR, RINGS),
        surfaces("shadows", Rings(ScalarType::I8), FAR, RINGS),
        volume("bounded", Rings(ScalarType::I8), FAR, SHADED),
        surfaces("shadows", Rings(ScalarType::U16), FAR, RINGS),
        surfaces("shadows", Rings(ScalarType::I16), FAR, RINGS),
        volume("bounded", Rings(ScalarType::I16), FAR, SHADED),
        surfaces("shadows", Rings(ScalarType::F32), FAR, RINGS),
        surfaces("one level of detail", Rings(ScalarType::U8), ALONG, Surfaces { lamps: &[Lamp::Head], shadows: false, levels: Some(Levels { ratio: 2.5, ..ABRUPT }), ..RINGS }),
        surfaces("levels of detail, shadows", Rings(ScalarType::U8), CLOSE, Surfaces { levels: Some(COARSE), ..RINGS }),
        surfaces("levels of detail in colours", Turbulence, FAR, Surfaces { by_level: true, levels: Some(ABRUPT), ..MIXED }),
        surfaces("levels of detail, transitions", Turbulence, CLOSE, Surfaces { levels: Some(Levels { blend: 0.6, ..COARSE }), ..MIXED }),
        surfaces("levels of detail, transitions, central normals", Turbulence, CLOSE, Surfaces { normals: Normals::Central, levels: Some(Levels { blend: 0.6, ..COARSE }), ..MIXED }),
        surfaces("levels of detail, means", Turbulence, CLOSE, Surfaces { levels: Some(Levels { coarse: Coarse::Mean, ..COARSE }), ..MIXED }),
        surfaces("levels of detail, filtered", Turbulence, CLOSE, Surfaces { levels: Some(Levels { coarse: Coarse::Filtered, ..COARSE }), ..MIXED }),
        surfaces("levels of detail by slices, translucent", Turbulence, CLOSE, Surfaces { surfaces: &[(60.5, 0.3), (99.5, 0.6)], levels: Some(Levels { by_slices: true, ..COARSE }), ..PLAIN }),
        surfaces("levels of detail, far shadows", Turbulence, CLOSE, Surfaces { lamps: SUN, shadows: true, levels: Some(Levels { far_shadows: true, ..COARSE }), ..MIXED }),
        surfaces("shadows", Turbulence, CLOSE, Surfaces { lamps: SUN, shadows: true, ..MIXED }),
        volume("bounded, from inside", Turbulence, INSIDE, SHADED),
        surfaces("central normals, shadows", Gaps, FAR, Surfaces { normals: Normals::Central, lamps: SUN, shadows: true, ..MIXED }),
        volume("bounded", Gaps, FAR, GLOW),
        surfaces("shadows", Mesh(0), CLOSE, Surfaces { lamps: SUN, shadows: true, ..GYROID }),
        surfaces("levels of detail", Mesh(0), NEAR, Surfaces { levels: Some(COARSE), ..GYROID }),
        surfaces("levels in colours", Mesh(0), NEAR, Surfaces { by_level: true, ..GYROID }),
        surfaces("central normals", Mesh(1), NEAR, Surfaces { normals: Normals::Central, ..GYROID }),
        surfaces("central normals, shadows", Mesh(2), NEAR, Surfaces { normals: Normals::Central, lamps: SUN, shadows: true, ..GYROID }),
        volume("adaptive", Mesh(0), NEAR, Layers { scheme: Scheme::Adaptive, ..SHADED }),
        volume("bounded, a box", Mesh(0), NEAR, Layers { cuts: BOX, ..SHADED }),
        surfaces("translucent", Mesh(1), NEAR, Surfaces { surfaces: &[(0.1, 0.4), (0.9, 1.0)], ..PLAIN }),
        surfaces("orthographic, a box", Mesh(2), ALONG_NEAR, Surfaces { cuts: BOX, ..GYROID }),
        volume("fixed", Mesh(2), NEAR, Layers { scheme: Scheme::Fixed(4), ..SHADED }),
        surfaces("shadows", ObliqueMesh(1), NEAR, Surfaces { lamps: SUN, shadows: true, ..GYROID }),
        volume("bounded", ObliqueMesh(1), NEAR, SHADED),
        volume("by level", Mesh(1), NEAR, Layers { scheme: Scheme::ByLevel(EPSILON), ..GLOW }),
    ]
};
