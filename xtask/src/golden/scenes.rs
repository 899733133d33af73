//! The scenes of which pictures are stored: a table.

use isoray_grid::ScalarType;
use isoray_render::Normals;

use crate::catalog::Place;

/// One picture.
pub(crate) struct PictureScene {
    pub(crate) name: &'static str,
    pub(crate) of: Of,
    pub(crate) from: Place,
    pub(crate) look: Look,
}

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
    pub(crate) is_shaded: bool,
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

/// Near the middle.
const CANDLE: &[Lamp] = &[Lamp::At([0.07, -0.04, 0.06])];
const SUN: &[Lamp] = &[Lamp::From([-0.5, 1.0, 0.6])];
const TWO: &[Lamp] = &[Lamp::From([0.8, 0.5, 1.0]), Lamp::At([-0.4, 0.9, 0.7])];
const HALF: &[Cut] = &[Cut::Plane([0.3, 0.1, -1.0], 0.02)];
const BOX: &[Cut] = &[Cut::Box([-0.21, -0.33, -0.34], [0.17, 0.11, 0.27])];

/// From afar.
const ABRUPT: Levels = Levels { ratio: 1.6, blend: 0.0, by_slices: false, far_shadows: false };
/// From nearby.
const COARSE: Levels = Levels { ratio: 6.0, ..ABRUPT };

const GLOW: Layers = Layers { scheme: Scheme::Bounded(EPSILON), is_shaded: false, cuts: &[] };
const SHADED: Layers = Layers { is_shaded: true, ..GLOW };

const fn surfaces(name: &'static str, of: Of, from: Place, look: Surfaces) -> PictureScene {
    PictureScene { name, of, from, look: Look::Surfaces(look) }
}

const fn volume(name: &'static str, of: Of, from: Place, look: Layers) -> PictureScene {
    PictureScene { name, of, from, look: Look::Volume(look) }
}

/// All of them, those of one volume beside each other.
#[rustfmt::skip]
pub(crate) const SCENES: &[PictureScene] = {
    use Of::*;
    use Place::*;
    &[
        surfaces("highlights", Tooth, Far, Surfaces { specular: 0.5, ..SKIN }),
        surfaces("central normals", Tooth, Close, Surfaces { normals: Normals::Central, ..SKIN }),
        surfaces("orthographic, central normals", Tooth, Along, Surfaces { normals: Normals::Central, ..ENAMEL }),
        surfaces("shadows", Tooth, Far, Surfaces { lamps: SUN, shadows: true, ..SKIN }),
        surfaces("two lamps, shadows, highlights", Tooth, Far, Surfaces { lamps: TWO, shadows: true, specular: 0.4, ..ENAMEL }),
        surfaces("shadows from inside", Tooth, Inside, Surfaces { lamps: CANDLE, shadows: true, ..ENAMEL }),
        surfaces("ambient occlusion", Tooth, Far, Surfaces { sky_samples: 16, lamps: SUN, ..SKIN }),
        surfaces("three surfaces", Tooth, Far, Surfaces { surfaces: &[(600.0, 0.3), (850.0, 0.5), (1050.0, 0.8)], ..PLAIN }),
        surfaces("translucent, shadows", Tooth, Far, Surfaces { surfaces: &[(600.0, 0.4), (1050.0, 0.8)], lamps: SUN, shadows: true, ..PLAIN }),
        surfaces("a plane", Tooth, Far, Surfaces { cuts: HALF, lamps: SUN, shadows: true, ..SKIN }),
        surfaces("a plane, capped", Tooth, Far, Surfaces { surfaces: &[(600.0, 1.0), (1050.0, 1.0)], cuts: HALF, cap: true, ..PLAIN }),
        surfaces("a box, capped, translucent", Tooth, Far, Surfaces { cuts: BOX, cap: true, ..BOTH }),
        surfaces("a box, orthographic", Tooth, Along, Surfaces { cuts: BOX, ..SKIN }),
        surfaces("coloured by a field", Tooth, Far, Surfaces { by_place: true, ..SKIN }),
        volume("bounded", Tooth, Far, GLOW),
        volume("bounded, shaded, inside", Tooth, Inside, SHADED),
        volume("bounded, orthographic", Tooth, Along, SHADED),
        volume("adaptive", Tooth, Far, Layers { scheme: Scheme::Adaptive, ..SHADED }),
        volume("fixed", Tooth, Far, Layers { scheme: Scheme::Fixed(4), ..SHADED }),
        volume("table", Tooth, Far, Layers { scheme: Scheme::Table, ..SHADED }),
        volume("bounded, a plane", Tooth, Far, Layers { cuts: HALF, ..SHADED }),
        volume("bounded, a box", Tooth, Close, Layers { cuts: BOX, ..GLOW }),
        surfaces("plain", Oblique, Far, SKIN),
        surfaces("central normals, shadows", Oblique, Far, Surfaces { normals: Normals::Central, lamps: SUN, shadows: true, ..ENAMEL }),
        surfaces("orthographic, capped", Oblique, Along, Surfaces { cuts: HALF, cap: true, ..BOTH }),
        volume("bounded", Oblique, Far, SHADED),
        surfaces("shadows", Rings(ScalarType::U8), Far, RINGS),
        surfaces("shadows", Rings(ScalarType::I8), Far, RINGS),
        surfaces("shadows", Rings(ScalarType::U16), Far, RINGS),
        surfaces("shadows", Rings(ScalarType::I16), Far, RINGS),
        surfaces("shadows", Rings(ScalarType::F32), Far, RINGS),
        surfaces("one level of detail", Rings(ScalarType::U8), Along, Surfaces { lamps: &[Lamp::Head], levels: Some(Levels { ratio: 2.5, ..ABRUPT }), ..RINGS }),
        surfaces("levels of detail, shadows", Rings(ScalarType::U8), Close, Surfaces { levels: Some(COARSE), ..RINGS }),
        surfaces("levels of detail in colours", Turbulence, Far, Surfaces { by_level: true, levels: Some(ABRUPT), ..MIXED }),
        surfaces("levels of detail, transitions", Turbulence, Close, Surfaces { levels: Some(Levels { blend: 0.6, ..COARSE }), ..MIXED }),
        surfaces("levels of detail by slices, translucent", Turbulence, Close, Surfaces { surfaces: &[(60.5, 0.3), (99.5, 0.6)], levels: Some(Levels { by_slices: true, ..COARSE }), ..PLAIN }),
        surfaces("levels of detail, far shadows", Turbulence, Close, Surfaces { lamps: SUN, shadows: true, levels: Some(Levels { far_shadows: true, ..COARSE }), ..MIXED }),
        surfaces("shadows", Turbulence, Close, Surfaces { lamps: SUN, shadows: true, ..MIXED }),
        volume("bounded, from inside", Turbulence, Inside, SHADED),
        surfaces("central normals, shadows", Gaps, Far, Surfaces { normals: Normals::Central, lamps: SUN, shadows: true, ..MIXED }),
        volume("bounded", Gaps, Far, GLOW),
        surfaces("shadows", Mesh(0), Close, Surfaces { lamps: SUN, shadows: true, ..GYROID }),
        surfaces("translucent", Mesh(1), Far, Surfaces { surfaces: &[(0.1, 0.4), (0.9, 1.0)], ..PLAIN }),
        surfaces("orthographic, a box", Mesh(2), Along, Surfaces { cuts: BOX, ..GYROID }),
        volume("by level", Mesh(1), Far, Layers { scheme: Scheme::ByLevel(EPSILON), ..GLOW }),
    ]
};
