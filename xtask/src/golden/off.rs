//! What scenes look like without what they are to show: a scene in which one of its features makes no difference is no test of that feature.

use anyhow::Result;
use glam::DAffine3;
use isoray_octree::Coarse;
use isoray_render::{Image, Normals};

use super::compared::over_background;
use super::picture::Picture;
use super::scenes::{Lamp, Layers, Levels, Surfaces};

/// Share of the pixels that are to differ by more than one step of 8 bits; with ten times less, a picture may be called the same.
const SEEN: f64 = 0.01;

/// What is off if nothing is, but for where the camera stands.
pub(crate) const MOVED: &str = "half a voxel";

/// In the world, of the longest edge.
pub(crate) fn half_a_voxel(index_to_world: &DAffine3) -> f64 {
    (0..3).map(|a| index_to_world.matrix3.col(a).length()).fold(0.0, f64::max) / 2.0
}

/// Isosurfaces without one feature each.
pub(crate) fn surfaces(look: &Surfaces) -> Vec<(&'static str, Surfaces)> {
    let opaque: &'static [(f32, f32)] = match look.surfaces {
        [(600.0, _), ..] => &[(600.0, 1.0)],
        [(60.5, _), ..] => &[(60.5, 1.0)],
        _ => &[(0.1, 1.0)],
    };
    let all = [
        ("shadows", look.shadows, Surfaces { shadows: false, levels: near(look), ..*look }),
        ("lamps", !matches!(look.lamps, [Lamp::Head]), Surfaces { lamps: &[Lamp::Head], ..*look }),
        ("highlights", look.specular > 0.0, Surfaces { specular: 0.0, ..*look }),
        ("the sky", look.sky_samples > 0, Surfaces { sky_samples: 0, ..*look }),
        ("cuts", !look.cuts.is_empty(), Surfaces { cuts: &[], ..*look }),
        ("caps", look.cap, Surfaces { cap: false, ..*look }),
        (
            "its colours",
            look.by_place || look.by_level,
            Surfaces { by_place: false, by_level: false, ..*look },
        ),
        ("levels", look.levels.is_some(), Surfaces { levels: None, ..*look }),
        (
            "central normals",
            look.normals == Normals::Central,
            Surfaces { normals: Normals::Forward, ..*look },
        ),
        ("translucence", look.surfaces.iter().any(|s| s.1 < 1.0), Surfaces { surfaces: opaque, ..*look }),
    ];
    let all = all.into_iter().filter(|(_, is_on, _)| *is_on).map(|(what, _, look)| (what, look));
    let with = |(what, levels)| (what, Surfaces { levels: Some(levels), ..*look });
    all.chain(look.levels.iter().flat_map(levels_of_detail).map(with)).collect()
}

/// Levels of detail likewise. Slices are no other order of the same work: by these a place can have another level than by its distance.
fn levels_of_detail(levels: &Levels) -> Vec<(&'static str, Levels)> {
    let all = [
        ("transitions", levels.blend > 0.0, Levels { blend: 0.0, ..*levels }),
        (
            "coarse samples of a kind",
            levels.coarse != Coarse::Injected,
            Levels { coarse: Coarse::Injected, ..*levels },
        ),
        ("slices", levels.by_slices, Levels { by_slices: false, ..*levels }),
        // Against those that come through the same levels, but from the surface itself on.
        ("far shadows", levels.far_shadows, Levels { far_shadows: false, ..*levels }),
    ];
    all.into_iter().filter(|(_, is_on, _)| *is_on).map(|(what, _, levels)| (what, levels)).collect()
}

/// Volumes likewise.
pub(crate) fn layers(look: &Layers) -> Vec<(&'static str, Layers)> {
    let all = [
        ("shading", look.light.is_some(), Layers { light: None, ..*look }),
        ("cuts", !look.cuts.is_empty(), Layers { cuts: &[], ..*look }),
    ];
    all.into_iter().filter(|(_, is_on, _)| *is_on).map(|(what, _, look)| (what, look)).collect()
}

/// Without shadows there are none from afar.
fn near(look: &Surfaces) -> Option<Levels> {
    look.levels.map(|levels| Levels { far_shadows: false, ..levels })
}

/// The feature that shows least, with the share of pixels, in percent, that it changes; and those that show too little.
pub(crate) fn seen(picture: &Picture, without: &[(&'static str, Image)]) -> Result<(String, Vec<String>)> {
    let mut shares = Vec::new();
    for (what, image) in without {
        shares.push((picture.share_of_steps(&over_background(image))?, *what));
    }
    let least = shares.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let least = least.map_or_else(String::new, |(share, what)| format!("{:>13.1} {what}", 100.0 * share));
    let told = |(share, what): &(f64, &str)| {
        let percent = 100.0 * share;
        format!("{what} changes {percent:.2} % of the pixels by more than a step, expected {}", 100.0 * SEEN)
    };
    Ok((least, shares.iter().filter(|(share, _)| *share < SEEN).map(told).collect()))
}
