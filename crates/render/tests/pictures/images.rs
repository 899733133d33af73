//! Pictures of fields that are known.

use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};
use isoray_build::build;
use isoray_grid::{DenseVolume, Dims};
use isoray_octree::OctreeVolume;
use isoray_render::{
    Camera, Image, Light, Normals, Pixel, Projection, Scene, Surface, View, encode_srgb, frame_all, render,
    render_counted, render_with_progress,
};

pub(crate) fn volume(n: [u32; 3], field: impl Fn(DVec3) -> f64) -> OctreeVolume<f32> {
    let dims = Dims::new(n).unwrap();
    let at = |n: usize, stride: u32, size: u32| f64::from((n as u32 / stride) % size);
    let samples: Vec<f32> = (0..dims.samples())
        .map(|s| field(DVec3::new(at(s, 1, n[0]), at(s, n[0], n[1]), at(s, n[0] * n[1], n[2]))) as f32)
        .collect();
    build(&mut DenseVolume::new(dims, &samples).unwrap(), DAffine3::IDENTITY, |_| {}).unwrap()
}

fn ball() -> OctreeVolume<f32> {
    volume([20, 22, 19], |p| 8.0 - p.distance(DVec3::new(9.0, 10.0, 9.5)))
}

fn framed(volume: &OctreeVolume<f32>, placement: &DAffine3, size: [u32; 2]) -> Camera {
    let view = View { eye: DVec3::new(-1.0, -2.0, 0.7), look_at: DVec3::ZERO, ..View::default() };
    Camera::new(&frame_all(&view, size, volume.meta().dims, placement), size).unwrap()
}

fn on_threads<R: Send>(threads: usize, f: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(f)
}

pub(crate) fn bits(image: &Image) -> Vec<u32> {
    let of = |p: &Pixel| {
        let [r, g, b, a] = p.color.to_array();
        let [x, y, z] = p.normal.to_array();
        [r, g, b, a, p.depth, x, y, z].map(f32::to_bits)
    };
    image.pixels().iter().flat_map(of).collect()
}

#[test]
fn the_number_of_threads_leaves_no_trace() {
    let volume = ball();
    let scene = Scene { normals: Normals::Central, ..Scene::of(0.3) };
    for size in [[1, 1], [17, 5], [5, 17], [64, 33]] {
        let camera = framed(&volume, &DAffine3::IDENTITY, size);
        let picture = || render(&volume.view(), DAffine3::IDENTITY, &camera, &scene);
        let one = on_threads(1, picture);
        assert_eq!(one.size(), size);
        assert_eq!(one.pixels().len(), (size[0] * size[1]) as usize);
        assert_eq!(bits(&one), bits(&on_threads(3, picture)), "{size:?}");
        let (counted, statistics) = render_counted(&volume.view(), DAffine3::IDENTITY, &camera, &scene);
        assert_eq!(bits(&one), bits(&counted));
        let hits = one.pixels().iter().filter(|p| p.depth.is_finite()).count() as u64;
        assert_eq!((statistics.rays, statistics.hits), (u64::from(size[0] * size[1]), hits));
        assert!(hits > 0, "{size:?}");
    }
}

#[test]
fn tiles_fit_together_at_any_size() {
    let volume = ball();
    let scene = Scene::of(0.3);
    let view = View { eye: DVec3::new(9.0, -30.0, 9.0), look_at: DVec3::splat(9.0), ..View::default() };
    for size in [[17, 5], [33, 31], [1, 40], [16, 16]] {
        let camera = Camera::new(&view, size).unwrap();
        let whole = render(&volume.view(), DAffine3::IDENTITY, &camera, &scene);
        for (x, y) in [(0, 0), (size[0] - 1, size[1] - 1), (size[0] / 2, size[1] / 2), (size[0] - 1, 0)] {
            let ray = camera.index_ray(&DAffine3::IDENTITY, x, y);
            let octree = volume.view();
            let hit = isoray_trace::Tracer::new(&octree).first_hit(&ray, 0.3);
            assert_eq!(hit.map_or(f32::INFINITY, |h| h.t), whole.pixel(x, y).depth, "{size:?} {x} {y}");
        }
        assert_eq!(whole.pixel(size[0], 0), Pixel::EMPTY);
        assert_eq!(whole.pixel(0, size[1]), Pixel::EMPTY);
    }
}

#[test]
fn progress_counts_every_tile() {
    let volume = ball();
    let camera = framed(&volume, &DAffine3::IDENTITY, [40, 17]);
    let calls = std::sync::Mutex::new(Vec::new());
    let note = |done, total| calls.lock().unwrap().push((done, total));
    render_with_progress(&volume.view(), DAffine3::IDENTITY, &camera, &Scene::of(0.0), note);
    let mut calls = calls.into_inner().unwrap();
    calls.sort_unstable();
    assert_eq!(calls, (1..=6).map(|n| (n, 6)).collect::<Vec<_>>());
}

#[test]
fn normals_of_a_ramp_are_its_gradient_on_an_oblique_lattice() {
    let axes =
        DMat3::from_cols(DVec3::new(1.0, 0.2, 0.1), DVec3::new(-0.4, 0.5, 0.1), DVec3::new(0.3, 0.3, -2.0));
    let placement = DAffine3::from_mat3_translation(axes, DVec3::new(5.0, -3.0, 40.0));
    // In the world, where its gradient is what it says.
    let gradient = DVec3::new(0.5, -1.0, 2.0);
    let ramp = |p: DVec3| gradient.dot(placement.transform_point3(p));
    let volume = volume([12, 13, 11], ramp);
    let isovalue = ramp(DVec3::new(5.3, 6.1, 4.9)) as f32;
    for normals in [Normals::Forward, Normals::Central] {
        let scene = Scene { normals, ..Scene::of(isovalue) };
        let camera = framed(&volume, &placement, [33, 33]);
        let image = render(&volume.view(), placement, &camera, &scene);
        let mut hits = 0;
        for y in 0..33 {
            for x in 0..33 {
                let pixel = image.pixel(x, y);
                if pixel.depth.is_finite() {
                    hits += 1;
                    let (origin, direction) = camera.world_ray(x, y);
                    let s = gradient.dot(origin + direction * f64::from(pixel.depth));
                    assert!((s - f64::from(isovalue)).abs() < 1e-3, "{s}: depth is world distance");
                    let error = (pixel.normal.as_dvec3() - gradient.normalize()).length();
                    assert!(error < 1e-4, "{normals:?}: {} is off by {error}", pixel.normal);
                } else {
                    assert_eq!(pixel, Pixel::EMPTY);
                }
            }
        }
        assert!(hits > 50, "only {hits}");
    }
}

/// One pixel that looks down at a ramp that rises with z from 0 to 8.
fn plane_pixel(scene: &Scene) -> Pixel {
    let volume = volume([9; 3], |p| p.z);
    let view = View {
        eye: DVec3::new(4.0, 4.0, 20.0),
        look_at: DVec3::new(4.0, 4.0, 0.0),
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 0.1 },
    };
    let camera = Camera::new(&view, [1, 1]).unwrap();
    render(&volume.view(), DAffine3::IDENTITY, &camera, scene).pixel(0, 0)
}

#[test]
fn lambert_with_a_headlight_and_with_a_lamp() {
    let color = Vec3::new(1.0, 0.5, 0.25);
    let near = |light: Light, expected: f32| {
        let surfaces = vec![Surface { isovalue: 4.0, color, opacity: 1.0 }];
        let scene = Scene { surfaces, ambient: 0.2, lights: vec![light], ..Scene::of(4.0) };
        let pixel = plane_pixel(&scene);
        assert_eq!((pixel.depth, pixel.normal, pixel.color.w), (16.0, Vec3::Z, 1.0));
        let error = (pixel.color.truncate() - color * expected).length();
        assert!(error < 1e-6, "{light:?}: {} is not {expected} of {color}", pixel.color);
    };
    near(Light::Headlight, 1.0);
    near(Light::Point(DVec3::new(4.0, 4.0, 100.0)), 1.0);
    // 60 degrees from the normal; behind the surface; at the surface itself.
    near(Light::Point(DVec3::new(4.0 + 3.0_f64.sqrt(), 4.0, 5.0)), 0.2 + 0.8 * 0.5);
    near(Light::Point(DVec3::new(4.0, 4.0, -100.0)), 0.2);
    near(Light::Point(DVec3::new(4.0, 4.0, 4.0)), 0.2);
    near(Light::Direction(DVec3::new(3.0_f64.sqrt(), 0.0, 1.0)), 0.2 + 0.8 * 0.5);
}

#[test]
fn the_side_that_faces_the_viewer_is_lit_whichever_way_values_rise() {
    let scene = |isovalue| Scene { ambient: 0.0, ..Scene::of(isovalue) };
    let falling = volume([9; 3], |p| -p.z);
    let view = View {
        eye: DVec3::new(4.0, 4.0, 20.0),
        look_at: DVec3::new(4.0, 4.0, 0.0),
        up: DVec3::Y,
        ..View::default()
    };
    let camera = Camera::new(&view, [1, 1]).unwrap();
    let image = render(&falling.view(), DAffine3::IDENTITY, &camera, &scene(-4.0));
    assert_eq!(image.pixel(0, 0).normal, -Vec3::Z);
    assert_eq!(image.pixel(0, 0).color, plane_pixel(&scene(4.0)).color);
}

#[test]
fn srgb_at_its_landmarks() {
    assert_eq!(encode_srgb(Vec3::new(0.0, 0.5, 1.0)), [0, 188, 255]);
    assert_eq!(encode_srgb(Vec3::new(-1.0, 0.003_130_8, 9.0)), [0, 10, 255]);
    assert_eq!(encode_srgb(Vec3::splat(f32::NAN)), [0; 3]);
    // The linear value of each code comes back as that code.
    for code in 0..=255_u8 {
        let c = f32::from(code) / 255.0;
        let linear = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
        assert_eq!(encode_srgb(Vec3::splat(linear)), [code; 3]);
    }
}

#[test]
fn colours_are_premultiplied_and_the_background_fills_the_rest() {
    let volume = ball();
    let camera = framed(&volume, &DAffine3::IDENTITY, [16, 16]);
    let image = render(&volume.view(), DAffine3::IDENTITY, &camera, &Scene::of(0.3));
    let background = Vec3::new(0.0, 0.5, 1.0);
    let (over, straight) = (image.to_rgb8(background), image.to_rgba8());
    for (n, pixel) in image.pixels().iter().enumerate() {
        let (over, straight) = (&over[3 * n..][..3], &straight[4 * n..][..4]);
        if pixel.depth.is_finite() {
            assert_eq!(pixel.color.w, 1.0);
            assert_eq!(over, encode_srgb(pixel.color.truncate()));
            assert_eq!(straight, [over, &[255]].concat());
        } else {
            assert_eq!(pixel.color, Vec4::ZERO);
            assert_eq!(over, [0, 188, 255]);
            assert_eq!(straight, [0; 4]);
        }
    }
    assert_eq!(
        image.channel(|p| p.color.w).iter().sum::<f32>(),
        image.pixels().iter().filter(|p| p.depth.is_finite()).count() as f32
    );
}
