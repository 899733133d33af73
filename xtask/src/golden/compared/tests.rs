use glam::{DAffine3, DVec3};
use isoray_grid::Dims;
use isoray_oracle::DenseLattice;
use isoray_render::{Light, Surface, View, render};

use super::*;
use crate::catalog::Dense;
use crate::golden::eye::Eye;

const EDGE: u32 = 24;
const SIZE: u32 = 32;

/// A large ball and a small one, which shadows it.
fn balls() -> Dense<f32> {
    let ball = |p: [f32; 3], at: [f32; 3], radius: f32| {
        radius - (0..3).map(|a| (p[a] - at[a]).powi(2)).sum::<f32>().sqrt()
    };
    let sample = |n: u32| {
        let p = [n % EDGE, n / EDGE % EDGE, n / (EDGE * EDGE)].map(|c| c as f32);
        ball(p, [10.3, 11.1, 9.7], 7.2).max(ball(p, [18.2, 17.4, 18.6], 2.9))
    };
    Dense {
        dims: Dims::new([EDGE; 3]).unwrap(),
        samples: (0..EDGE.pow(3)).map(sample).collect(),
        index_to_world: DAffine3::IDENTITY,
    }
}

/// The bounds that are broken by a picture of the balls, as it is and as it is spoiled.
fn broken(spoil: impl Fn(&mut Scene<'_>, &mut Vec<Pixel>)) -> String {
    let balls = balls();
    let octree = balls.octree().unwrap();
    let lattice = DenseLattice::from_vec([EDGE; 3], balls.samples.clone()).unwrap();
    let centre = DVec3::splat(12.0);
    let view = View {
        eye: centre + DVec3::new(9.0, 25.0, 14.0),
        look_at: centre,
        up: DVec3::Y.cross(DVec3::X),
        ..View::default()
    };
    let eye = Eye::new(view, SIZE).unwrap();
    let surface = |isovalue, opacity| Surface { isovalue, opacity, ..Scene::of(0.0).surfaces[0] };
    let right = Scene {
        surfaces: vec![surface(0.0, 0.6), surface(1.5, 1.0)],
        lights: vec![Light::Direction(DVec3::ONE)],
        shadows: true,
        ..Scene::of(0.0)
    };
    let mut scene = right.clone();
    let mut pixels = Vec::new();
    spoil(&mut scene, &mut pixels);
    pixels = render(&octree.view(), DAffine3::IDENTITY, &eye.camera, &scene).pixels().to_vec();
    spoil(&mut scene, &mut pixels);
    let truth = Truth {
        lattice: &lattice,
        scale: 1.0,
        rounding: 0.0,
        index_to_world: DAffine3::IDENTITY,
        eye: &eye,
        scene: &right,
        cells: None,
        far_shadows: false,
    };
    let seen = Compared::seen(&truth, [SIZE; 2]);
    Compared::of_seen(&truth, &seen, &pixels).failures().join("\n")
}

/// Does so with the pixels, once there are any.
fn with(pixels: &mut [Pixel], spoil: impl Fn(&mut [Pixel])) {
    if !pixels.is_empty() {
        spoil(pixels);
    }
}

#[test]
fn a_right_picture_breaks_no_bound() {
    assert_eq!(broken(|_, _| {}), "");
}

#[test]
fn what_is_wrong_is_found() {
    let shifted = broken(|_, pixels| with(pixels, |pixels| pixels.rotate_right(1)));
    assert!(shifted.contains("hit or miss unlike") && shifted.contains("a depth"), "{shifted}");
    let shadowless = broken(|scene, _| scene.shadows = false);
    assert!(shadowless.starts_with("a colour or an opacity off by"), "{shadowless}");
    let opaque = broken(|scene, _| scene.surfaces[0].opacity = 0.61);
    assert!(opaque.starts_with("a colour or an opacity off by"), "{opaque}");
    let elsewhere = broken(|scene, _| scene.surfaces[0].isovalue = 0.02);
    assert!(elsewhere.contains("a depth, in voxels,"), "{elsewhere}");
    let dark = broken(|scene, _| scene.lights = vec![Light::Direction(DVec3::new(1.0, 1.0, 1.1))]);
    assert!(dark.starts_with("a colour or an opacity off by"), "{dark}");
}

type Spoil = fn(&mut [Pixel]);

/// A pixel in the middle, and one of the background.
#[test]
fn a_single_pixel_without_a_number_is_found() {
    const MIDDLE: usize = (SIZE * SIZE / 2 + SIZE / 2) as usize;
    let spoils: [(&str, Spoil); 7] = [
        ("off by inf", |pixels| pixels[MIDDLE].color.x = f32::NAN),
        ("off by inf", |pixels| pixels[MIDDLE].color.w = f32::NAN),
        ("off by inf", |pixels| pixels[MIDDLE].depth = f32::NAN),
        ("off by inf", |pixels| pixels[MIDDLE].normal.y = f32::NAN),
        ("off by inf", |pixels| pixels[0].color.z = f32::NAN),
        ("1 pixels that hit or miss", |pixels| pixels[0].depth = f32::NAN),
        ("1 pixels that hit or miss", |pixels| pixels[0].depth = f32::NEG_INFINITY),
    ];
    for (n, (expected, spoil)) in spoils.into_iter().enumerate() {
        let told = broken(|_, pixels| with(pixels, spoil));
        assert!(told.contains(expected), "{n}: {told}");
    }
}

#[test]
fn volumes_are_held_to_their_bound_and_to_showing_something() {
    let grey = |c: f32| Pixel { color: glam::Vec4::splat(c), ..Pixel::EMPTY };
    let broken = |truth: f64, found: f32| {
        let truths = vec![Some(exactly([truth; 4])); 16];
        let compared = Compared::of_channels(&truths, &[grey(found); 16], |n| [n, 0], 1e-2);
        compared.failures().join("\n")
    };
    assert_eq!(broken(0.5, 0.505), "");
    assert!(broken(0.5, 0.52).contains("a colour or an opacity"));
    assert!(broken(0.5, f32::NAN).contains("off by inf"));
    assert!(broken(f64::NAN, 0.5).contains("off by inf"));
    assert!(broken(0.0, 0.0).contains("show anything"));
}
