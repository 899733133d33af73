//! Frames of octree volumes and of dense ones.

use glam::{DAffine3, DMat3, DVec3};
use isoray_build::build;
use isoray_cell::gradient;
use isoray_grid::{DenseVolume, Dims, GridVolume};
use isoray_oracle::SplitMix64;
use isoray_preint::{Bounded, ControlPoint, TransferFunction, Visibility};
use isoray_render::{
    Camera, View, VolumeScene, VolumeShading, gradient_scale, render_volume, render_volume_counted,
};

const DIMS: [u32; 3] = [43, 30, 25];

/// A ball with noise around its border, and nothing further out.
fn samples() -> Vec<u16> {
    let mut random = SplitMix64::new(1);
    let centre = DVec3::new(21.0, 15.0, 12.0);
    let [nx, ny, nz] = DIMS;
    let points = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
    let value = |p: [u32; 3]| {
        let distance = DVec3::from_array(p.map(f64::from)).distance(centre);
        if distance > 13.0 { 0.0 } else { 100.0 * (13.0 - distance) + random.range(0.0, 40.0) }
    };
    points.map(value).map(|v| v as u16).collect()
}

fn oblique() -> DAffine3 {
    let matrix =
        DMat3::from_cols(DVec3::new(0.5, 0.1, 0.0), DVec3::new(0.0, 0.8, 0.0), DVec3::new(0.0, 0.2, 1.1));
    DAffine3::from_mat3_translation(matrix, DVec3::new(3.0, -4.0, 5.0))
}

#[test]
fn frames_of_both_agree() {
    let samples = samples();
    let dense = DenseVolume::new(Dims::new(DIMS).unwrap(), &samples).unwrap();
    let grid = GridVolume::new(dense);
    let index_to_world = oblique();
    let octree = build(&mut { dense }, index_to_world, |_| {}).unwrap();
    let octree = octree.view();
    let point = |value, extinction| ControlPoint { value, color: [0.9, 0.4, 0.2], extinction };
    let points =
        vec![point(5.0, 0.0), point(300.0, 0.3), point(600.0, 0.0), point(900.0, 0.0), point(1300.0, 1.0)];
    let transfer = TransferFunction::new(points).unwrap();
    let visible = Visibility::new(&transfer);
    let shading = VolumeShading {
        ambient: 0.3,
        diffuse: 0.6,
        specular: 0.2,
        exponent: 20.0,
        gradient_scale: gradient_scale(&grid, index_to_world),
        light: None,
    };
    let lit = shading.brightest(&index_to_world, 1400.0);
    let scheme = Bounded::new(&transfer, 1e-3, lit);
    let camera = Camera::new(
        &View {
            eye: DVec3::new(-30.0, -40.0, 60.0),
            look_at: DVec3::new(14.0, 8.0, 18.0),
            ..View::default()
        },
        [60, 50],
    )
    .unwrap();
    let scene = VolumeScene { visible: &visible, scheme: &scheme, shading: Some(shading), clip: None };
    let (a, a_statistics) = render_volume_counted(&octree, index_to_world, &camera, &scene);
    let (b, b_statistics) = render_volume_counted(&grid, index_to_world, &camera, &scene);
    assert!(
        a_statistics.lit > 200 && a_statistics.lit == b_statistics.lit,
        "{a_statistics:?}, {b_statistics:?}"
    );
    assert_eq!(a_statistics.work.cells, b_statistics.work.cells);
    assert!(b_statistics.largest_bound <= 1e-3);
    assert_eq!(b.pixels(), render_volume(&grid, index_to_world, &camera, &scene, |_, _| {}).pixels());
    for (a, b) in a.pixels().iter().zip(b.pixels()) {
        assert!((a.color - b.color).abs().max_element() <= 2e-3, "{a:?}, {b:?}");
    }
}

#[test]
fn the_gradient_scale_is_the_same_for_both_and_that_of_all_cells() {
    let samples = samples();
    let dense = DenseVolume::new(Dims::new(DIMS).unwrap(), &samples).unwrap();
    let octree = build(&mut { dense }, oblique(), |_| {}).unwrap();
    let found = gradient_scale(&octree.view(), oblique());
    assert_eq!(found, gradient_scale(&GridVolume::new(dense), oblique()));
    let normal_matrix = oblique().matrix3.inverse().transpose();
    let [nx, ny, nz] = DIMS.map(|n| n - 1);
    let cells = (0..nx * ny * nz).map(|n| [n % nx, n / nx % ny, n / (nx * ny)]);
    let steepness = |[x, y, z]: [u32; 3]| {
        let corner = |n: u32| f64::from(dense.sample([x + (n & 1), y + (n >> 1 & 1), z + (n >> 2)]));
        let slope = gradient(&std::array::from_fn(|n| corner(n as u32)), [0.5; 3]);
        (normal_matrix * DVec3::from_array(slope)).length()
    };
    let mut all: Vec<f64> = cells.map(steepness).filter(|&s| s > 0.0).collect();
    all.sort_unstable_by(f64::total_cmp);
    assert_eq!(found, all[(all.len() as f64 * 0.99) as usize]);
}
