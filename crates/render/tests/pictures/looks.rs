//! Looks of isosurfaces: layers, shadows, the sky, cuts and caps.

use glam::{DAffine3, DVec3, Vec3};
use isoray_build::build;
use isoray_grid::{DenseVolume, Dims, GridVolume};
use isoray_octree::OctreeVolume;
use isoray_render::{
    Camera, Clip, ColorField, Image, Light, Plane, Projection, Scene, Surface, Traversal, View, render,
    render_counted,
};

const N: u32 = 40;

/// A field at the points of 40³ samples.
fn samples(field: impl Fn(DVec3) -> f64) -> Vec<f32> {
    (0..N * N * N)
        .map(|n| field(DVec3::new((n % N).into(), (n / N % N).into(), (n / (N * N)).into())) as f32)
        .collect()
}

fn volume(samples: &[f32]) -> OctreeVolume<f32> {
    let mut source = DenseVolume::new(Dims::new([N; 3]).unwrap(), samples).unwrap();
    build(&mut source, DAffine3::IDENTITY, |_| {}).unwrap()
}

const CENTRE: DVec3 = DVec3::new(19.3, 20.2, 18.9);

/// Rising to the centre: the surface of isovalue `-r` is the sphere of radius `r`.
fn ball() -> Vec<f32> {
    samples(|p| -p.distance(CENTRE))
}

/// Parallel rays along -z.
fn from_above(size: u32) -> Camera {
    let view = View {
        eye: DVec3::new(19.5, 19.5, 100.0),
        look_at: DVec3::new(19.5, 19.5, 0.0),
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 39.0 },
    };
    Camera::new(&view, [size; 2]).unwrap()
}

fn surface(isovalue: f32, color: Vec3, opacity: f32) -> Surface {
    Surface { isovalue, color, opacity }
}

/// Colours alone: no light matters.
fn flat(surfaces: Vec<Surface>) -> Scene<'static> {
    Scene { surfaces, ambient: 1.0, ..Scene::of(0.0) }
}

#[test]
fn layers_are_composited_in_the_order_of_the_ray() {
    let samples = ball();
    let volume = volume(&samples);
    let (red, green, blue) = (Vec3::X, Vec3::Y, Vec3::Z);
    // Given out of order. Through the middle: outer, middle, inner, and out again.
    let scene = flat(vec![surface(-5.0, blue, 0.5), surface(-15.0, red, 0.25), surface(-10.0, green, 0.4)]);
    let image = render(&volume.view(), DAffine3::IDENTITY, &from_above(39), &scene);
    let middle = image.pixel(19, 19);
    let mut expected = Vec3::ZERO;
    let mut left = 1.0;
    for (color, opacity) in [(red, 0.25), (green, 0.4), (blue, 0.5), (blue, 0.5), (green, 0.4), (red, 0.25)] {
        expected += left * opacity * color;
        left *= 1.0 - opacity;
    }
    assert!((middle.color.truncate() - expected).abs().max_element() < 1e-6, "{middle:?}, {expected}");
    assert!((middle.color.w - (1.0 - left)).abs() < 1e-6);
    assert!((f64::from(middle.depth) - (100.0 - CENTRE.z - 15.0)).abs() < 0.1, "that of the first");
    // Between the spheres of radius 10 and 15 only the outer one is met, twice.
    let beside = image.pixel(19 + 12, 19);
    assert!((beside.color.x - (0.25 + 0.75 * 0.25)).abs() < 1e-6 && beside.color.y == 0.0);
    assert_eq!(image.pixel(0, 0).color.w, 0.0);
}

#[test]
fn what_is_behind_an_opaque_surface_is_not_looked_at() {
    let samples = ball();
    let volume = volume(&samples);
    let opaque = flat(vec![surface(-15.0, Vec3::X, 1.0), surface(-5.0, Vec3::Y, 1.0)]);
    let alone = flat(vec![surface(-15.0, Vec3::X, 1.0)]);
    let of = |scene: &Scene<'_>| render(&volume.view(), DAffine3::IDENTITY, &from_above(20), scene);
    assert_eq!(of(&opaque).pixels(), of(&alone).pixels());
    // Many faint layers: the end is where nothing could be seen behind.
    let many: Vec<Surface> = (0..30).map(|n| surface(-18.0 + 0.6 * n as f32, Vec3::ONE, 0.3)).collect();
    let middle = of(&flat(many)).pixel(10, 10);
    assert_eq!(middle.color.w, 1.0);
    assert!((middle.color.truncate() - Vec3::ONE).abs().max_element() <= 1.0 / 8192.0, "{middle:?}");
}

/// A floor at z = 8 with a ball above it.
fn ball_over_floor() -> Vec<f32> {
    samples(|p| (8.2 - p.z).max(5.0 - p.distance(DVec3::new(20.0, 20.0, 24.0))))
}

fn lit(lights: Vec<Light>, shadows: bool) -> Scene<'static> {
    let surfaces = vec![surface(0.0, Vec3::ONE, 1.0)];
    Scene { surfaces, ambient: 0.0, lights, shadows, ..Scene::of(0.0) }
}

#[test]
fn a_ball_casts_a_shadow_on_the_floor_beneath_it() {
    let samples = ball_over_floor();
    let volume = volume(&samples);
    let of = |scene: &Scene<'_>| render(&volume.view(), DAffine3::IDENTITY, &from_above(78), scene);
    for light in [
        Light::Direction(DVec3::new(1.0, 0.0, 1.0)),
        Light::Point(DVec3::new(20.0 + 1000.0, 20.0, 24.0 + 1000.0)),
    ] {
        let (open, shadowed) = (of(&lit(vec![light], false)), of(&lit(vec![light], true)));
        let mut dark = 0;
        for y in 0..78 {
            for x in 0..78 {
                let (before, after) = (open.pixel(x, y), shadowed.pixel(x, y));
                let p = DVec3::new(f64::from(x) * 0.5 + 0.25, 39.0 - (f64::from(y) * 0.5 + 0.25), 8.2);
                if (before.depth - 91.8).abs() > 1e-3 {
                    continue;
                }
                // On the floor: in the cylinder of the ball along the light.
                let along = DVec3::new(1.0, 0.0, 1.0).normalize();
                let to_ball = DVec3::new(20.0, 20.0, 24.0) - p;
                let off = (to_ball - along * to_ball.dot(along)).length();
                if (off - 5.0).abs() < 0.3 {
                    continue;
                }
                assert!(before.color.x > 0.5, "{p}: {before:?}");
                assert_eq!(after.color.x == 0.0, off < 5.0, "{p}: {after:?}, {off} from the axis");
                assert!(off < 5.0 || after.color == before.color);
                dark += u32::from(off < 5.0);
            }
        }
        assert!(dark > 100, "only {dark} dark pixels");
    }
}

#[test]
fn translucent_surfaces_let_some_light_through() {
    let samples = ball_over_floor();
    let volume = volume(&samples);
    let mut scene = lit(vec![Light::Direction(DVec3::Z)], true);
    scene.surfaces[0].opacity = 0.4;
    let image = render(&volume.view(), DAffine3::IDENTITY, &from_above(39), &scene);
    // The top of the ball, the inner side of its bottom in the light that the top lets through, and the floor in what both leave.
    let expected = 0.4 * (1.0 + 0.6 * 0.6 + (0.6 * 0.6) * (0.6 * 0.6));
    let middle = image.pixel(19, 19).color.x;
    assert!((middle - expected).abs() < 0.02, "{middle}, {expected}");
    assert!((image.pixel(2, 2).color.x - 0.4).abs() < 1e-3, "{:?}", image.pixel(2, 2));
}

#[test]
fn the_sky_over_a_plane_is_whole_and_in_a_corner_half_hidden() {
    let sky = |field: &dyn Fn(DVec3) -> f64, x: u32, y: u32| {
        let samples = samples(field);
        let volume = volume(&samples);
        let scene = Scene {
            surfaces: vec![surface(0.0, Vec3::ONE, 1.0)],
            ambient: 1.0,
            sky_samples: 256,
            ..Scene::of(0.0)
        };
        render(&volume.view(), DAffine3::IDENTITY, &from_above(39), &scene).pixel(x, y).color.x
    };
    let plane = |p: DVec3| 8.2 - p.z;
    assert_eq!(sky(&plane, 19, 19), 1.0);
    // A wall at x = 6 that is as good as endless from a point close to it: the half of the sky behind it is gone.
    let corner = |p: DVec3| (4.2 - p.z).max(6.4 - p.x);
    let beside = sky(&corner, 7, 19);
    assert!((beside - 0.5).abs() < 0.05, "{beside}");
    assert!(sky(&corner, 30, 19) > 0.8);
}

fn cut(planes: &[(DVec3, f64)]) -> Clip {
    Clip(planes.iter().map(|&(normal, offset)| Plane { normal, offset }).collect())
}

#[test]
fn a_cut_shows_what_is_behind_it_and_nothing_before() {
    let samples = ball();
    let volume = volume(&samples);
    let of = |clip: Clip| {
        let scene = Scene { clip, ..Scene::of(-12.0) };
        render(&volume.view(), DAffine3::IDENTITY, &from_above(60), &scene)
    };
    let whole = of(Clip::default());
    // A slope through the ball, of any length.
    let slope = (DVec3::new(1.0, 0.5, -2.0), -19.0);
    let cut_open = of(cut(&[slope]));
    let mut changed = 0;
    for (whole, cut_open) in whole.pixels().iter().zip(cut_open.pixels()) {
        // A stretch that begins at the cut, in the middle of a cell, rounds the root in it otherwise.
        if (cut_open.depth - whole.depth).abs() <= 1e-5 || cut_open == whole {
            continue;
        }
        changed += 1;
        // The inner side, seen through the cut, or nothing at all.
        assert!(cut_open.depth > whole.depth, "{whole:?}, {cut_open:?}");
    }
    assert!(changed > 200 && changed < 3000, "{changed}");
    // Cut beyond the ball: bit for bit the same; everything cut: nothing.
    assert_eq!(of(cut(&[(DVec3::NEG_Z, -33.0)])).pixels(), whole.pixels());
    assert!(of(cut(&[(DVec3::Z, 35.0)])).pixels().iter().all(|p| p.depth.is_infinite()));
}

/// A colour of its own for each height.
struct Height;

impl ColorField for Height {
    fn color(&self, cell: [u32; 3], local: [f32; 3]) -> Vec3 {
        Vec3::splat((cell[2] as f32 + local[2]) / 40.0)
    }
}

#[test]
fn caps_close_a_cut_with_the_innermost_surface() {
    let samples = ball();
    let volume = volume(&samples);
    let (red, green) = (Vec3::X, Vec3::Y);
    let mut scene = flat(vec![surface(-12.0, red, 1.0), surface(-6.0, green, 1.0)]);
    scene.clip = cut(&[(DVec3::NEG_Z, -CENTRE.z)]);
    let open = render(&volume.view(), DAffine3::IDENTITY, &from_above(78), &scene);
    scene.cap = true;
    let closed = render(&volume.view(), DAffine3::IDENTITY, &from_above(78), &scene);
    for y in 0..78 {
        for x in 0..78 {
            let p = DVec3::new(f64::from(x) * 0.5 + 0.25, 39.0 - (f64::from(y) * 0.5 + 0.25), CENTRE.z);
            let r = p.distance(CENTRE);
            if [6.0, 12.0].iter().any(|edge| (r - edge).abs() < 0.2) {
                continue;
            }
            let pixel = closed.pixel(x, y);
            if r < 12.0 {
                let color = if r < 6.0 { green } else { red };
                assert_eq!((pixel.color.truncate(), pixel.normal), (color, Vec3::NEG_Z), "{p}");
                assert!((f64::from(pixel.depth) - (100.0 - CENTRE.z)).abs() < 1e-4);
                assert!(open.pixel(x, y).depth > pixel.depth);
            } else {
                assert_eq!(pixel, open.pixel(x, y));
            }
        }
    }
    // Coloured by a field, a cap has the field's colour there.
    scene.colors = Some(&Height);
    let coloured = render(&volume.view(), DAffine3::IDENTITY, &from_above(39), &scene).pixel(19, 19);
    assert!((coloured.color.x - CENTRE.z as f32 / 40.0).abs() < 1e-5, "{coloured:?}");
}

#[test]
fn surfaces_are_coloured_where_they_are_hit() {
    let samples = ball();
    let volume = volume(&samples);
    let mut scene = flat(vec![surface(-12.0, Vec3::X, 1.0)]);
    scene.colors = Some(&Height);
    let image = render(&volume.view(), DAffine3::IDENTITY, &from_above(30), &scene);
    let mut hits = 0;
    for pixel in image.pixels().iter().filter(|p| p.depth.is_finite()) {
        assert!((pixel.color.x - (100.0 - pixel.depth) / 40.0).abs() < 1e-5, "{pixel:?}");
        hits += 1;
    }
    assert!(hits > 200);
}

/// Everything at once.
fn rich() -> Scene<'static> {
    Scene {
        surfaces: vec![surface(-14.0, Vec3::X, 0.3), surface(-7.0, Vec3::Y, 1.0)],
        lights: vec![Light::Headlight, Light::Direction(DVec3::new(1.0, 2.0, 3.0))],
        specular: 0.4,
        shadows: true,
        sky_samples: 5,
        clip: cut(&[(DVec3::new(-1.0, -1.0, -1.0), -60.0)]),
        cap: true,
        ..Scene::of(0.0)
    }
}

#[test]
fn pictures_depend_neither_on_threads_nor_on_the_structure() {
    let samples = ball();
    let volume = volume(&samples);
    let grid = GridVolume::new(DenseVolume::new(Dims::new([N; 3]).unwrap(), &samples).unwrap());
    let camera = from_above(50);
    let with = |threads: usize, of: &(dyn Fn() -> Image + Sync)| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(of)
    };
    let view = volume.view();
    let octree = || render(&view, DAffine3::IDENTITY, &camera, &rich());
    let one = with(1, &octree);
    assert!(one.pixels().iter().filter(|p| p.depth.is_finite()).count() > 500);
    assert_eq!(with(3, &octree).pixels(), one.pixels());
    let dense = with(2, &|| render(&grid, DAffine3::IDENTITY, &camera, &rich()));
    assert_eq!(dense.pixels(), one.pixels());
}

#[test]
fn what_a_scene_does_not_need_is_not_done() {
    let samples = ball();
    let volume = volume(&samples);
    // No ray is parallel to a plane of the lattice; such go one by one.
    let view = View {
        eye: CENTRE + DVec3::new(3.0, 5.0, 80.0),
        look_at: CENTRE,
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 39.0 },
    };
    let askew = Camera::new(&view, [64; 2]).unwrap();
    let counted = |scene: &Scene<'_>| {
        let (_, found) = render_counted(&volume.view(), DAffine3::IDENTITY, &askew, scene);
        (found.hits, found.work)
    };
    // A ball of 12 in a picture 39 wide: most packets of 8² pixels see nothing of it.
    let scene = Scene::of(-6.0);
    let (hits, work) = counted(&scene);
    assert_eq!((work.packets, work.alone, work.shadow_rays), (64, 0, 0));
    assert!(work.background_packets >= 32 && work.background_packets < 64, "{work:?}");
    assert!(work.cells < 4 * hits, "{work:?}");
    // Half of it is lit; the other half needs no ray to be dark.
    let lights = vec![Light::Direction(DVec3::X)];
    for traversal in [Traversal::Single, Traversal::Masked] {
        let scene = Scene { lights: lights.clone(), shadows: true, traversal, ..Scene::of(-6.0) };
        let (hits, work) = counted(&scene);
        assert_eq!(work.shadow_rays + work.spared_shadow_rays, hits);
        assert!(work.shadow_rays * 10 > hits * 4 && work.spared_shadow_rays * 10 > hits * 4, "{work:?}");
        assert_eq!(work.alone, if traversal == Traversal::Single { 64 * 64 } else { 0 });
    }
    let layers = flat(vec![surface(-5.0, Vec3::X, 0.5), surface(-15.0, Vec3::Y, 0.25)]);
    let (_, work) = counted(&layers);
    assert_eq!((work.packets, work.alone), (0, 64 * 64));
}
