//! The same picture, whichever way rays go.

use glam::{DAffine3, DMat3, DVec3};
use isoray_grid::{DenseVolume, GridVolume};
use isoray_render::{
    Camera, Clip, Light, Plane, Projection, Scene, Slicing, Traversal, View, render, render_counted,
};

use crate::images::{bits, volume};

fn cameras(size: [u32; 2]) -> Vec<Camera> {
    let perspective = Projection::Perspective { fov: 50.0 };
    let view = |eye: [f64; 3], look_at: [f64; 3], projection| View {
        eye: DVec3::from_array(eye),
        look_at: DVec3::from_array(look_at),
        up: DVec3::new(0.1, 1.0, 0.2),
        projection,
    };
    let views = [
        view([70.0, 55.0, 90.0], [16.0, 14.0, 12.0], perspective),
        view([24.0, 20.0, 19.0], [11.0, 10.0, 12.0], perspective),
        // From inside, in all directions at once, and along the lattice's planes.
        view([15.5, 14.25, 12.125], [16.0, 20.0, 3.0], Projection::Perspective { fov: 170.0 }),
        view([16.0, 14.0, 80.0], [16.0, 14.0, 0.0], Projection::Orthographic { height: 40.0 }),
        view([70.0, -55.0, 90.0], [16.0, 14.0, 12.0], Projection::Orthographic { height: 45.0 }),
    ];
    views.iter().map(|view| Camera::new(view, size).unwrap()).collect()
}

#[test]
fn every_traversal_makes_the_picture_of_single_rays() {
    let waves = |p: DVec3| (0.9 * p.x).sin() + (0.7 * p.y).cos() + (0.8 * p.z + 0.1 * p.x).sin() - 0.02 * p.y;
    let volume = volume([33, 29, 25], waves);
    let view = volume.view();
    let samples = view.to_dense();
    let grid = GridVolume::new(DenseVolume::new(view.dims(), &samples).unwrap());
    let oblique = DAffine3::from_mat3(DMat3::from_cols(
        DVec3::new(1.0, 0.1, 0.0),
        DVec3::new(-0.2, 0.9, 0.1),
        DVec3::new(0.1, 0.2, 1.3),
    ));
    let plane = Plane { normal: DVec3::new(0.3, -0.2, 1.0), offset: 9.0 };
    let lit =
        Scene { lights: vec![Light::Point(DVec3::new(60.0, 80.0, 40.0))], shadows: true, ..Scene::of(0.4) };
    let scenes = [Scene::of(0.4), Scene { clip: Clip(vec![plane]), ..Scene::of(0.1) }, lit];
    let mut hits = 0;
    for size in [[1, 1], [37, 21], [64, 48]] {
        for (scene, placement) in scenes.iter().zip([DAffine3::IDENTITY, oblique, oblique]) {
            for camera in cameras(size) {
                let single = Scene { traversal: Traversal::Single, ..scene.clone() };
                let (expected, statistics) = render_counted(&view, placement, &camera, &single);
                hits += statistics.hits;
                for (traversal, packet_edge) in [
                    (Traversal::Auto, 8),
                    (Traversal::Masked, 2),
                    (Traversal::Masked, 3),
                    (Traversal::Masked, 4),
                    (Traversal::Masked, 8),
                    (Traversal::Masked, 16),
                    (Traversal::Coherent(Slicing::default()), 3),
                    (Traversal::Coherent(Slicing::default()), 8),
                    (Traversal::Coherent(Slicing::default()), 16),
                ] {
                    let scene = Scene { traversal, packet_edge, ..scene.clone() };
                    let picture = render(&view, placement, &camera, &scene);
                    assert!(bits(&picture) == bits(&expected), "{traversal:?} of {packet_edge}², {size:?}");
                }
                let picture = render(&grid, placement, &camera, scene);
                assert!(bits(&picture) == bits(&expected), "grid, {size:?}");
            }
        }
    }
    assert!(hits > 20_000, "only {hits}");
}
