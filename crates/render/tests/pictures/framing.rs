//! A camera that shows the whole domain.

use glam::{DAffine3, DMat3, DVec3};
use isoray_grid::Dims;
use isoray_render::{Camera, Projection, View, frame_all};

/// Axes parallel to the world's, stretched, and oblique.
fn placements() -> [DAffine3; 3] {
    let oblique =
        DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(-0.4, 0.8, 0.1), DVec3::new(0.3, 0.3, -2.0));
    [
        DAffine3::IDENTITY,
        DAffine3::from_mat3_translation(
            DMat3::from_diagonal(DVec3::new(0.1, 5.0, 0.7)),
            DVec3::new(1e3, -7.0, 0.0),
        ),
        DAffine3::from_mat3_translation(oblique, DVec3::new(-50.0, 3.0, 9.0)),
    ]
}

fn directions() -> impl Iterator<Item = DVec3> {
    (0..27)
        .map(|n| DVec3::new(f64::from(n % 3), f64::from(n / 3 % 3), f64::from(n / 9)) - 1.0)
        .filter(|d| *d != DVec3::ZERO)
}

/// Calls `check` with every view, image size and placement.
fn for_all_views(dims: Dims, mut check: impl FnMut(View, [u32; 2], DAffine3)) {
    for placement in placements() {
        for direction in directions() {
            for size in [[64, 64], [17, 5], [3, 40], [1, 1]] {
                for projection in [
                    Projection::Perspective { fov: 10.0 },
                    Projection::Perspective { fov: 120.0 },
                    Projection::Orthographic { height: 1.0 },
                ] {
                    let up = DVec3::new(0.1, 0.2, 1.0);
                    let view = View { eye: -direction, look_at: DVec3::ZERO, up, projection };
                    check(frame_all(&view, size, dims, &placement), size, placement);
                }
            }
        }
    }
}

/// Position in the image of a point in the world, each coordinate from -1 to 1 inside it; `None` behind the eye.
fn in_image(view: &View, size: [u32; 2], p: DVec3) -> Option<[f64; 2]> {
    let forward = (view.look_at - view.eye).normalize();
    let right = forward.cross(view.up).normalize();
    let up = right.cross(forward);
    let depth = (p - view.eye).dot(forward);
    let half_height = match view.projection {
        Projection::Perspective { fov } => depth * (fov / 2.0).to_radians().tan(),
        Projection::Orthographic { height } => height / 2.0,
    };
    let half_width = half_height * f64::from(size[0]) / f64::from(size[1]);
    let across = [(p - view.eye).dot(right) / half_width, (p - view.eye).dot(up) / half_height];
    (depth > 0.0).then_some(across)
}

#[test]
fn the_whole_domain_is_in_the_image_and_fills_it() {
    for dims in [[40, 30, 20], [2, 2, 2], [300, 2, 9], [9, 9, 1], [7, 1, 1], [1, 1, 7]] {
        let dims = Dims::new(dims).unwrap();
        for_all_views(dims, |view, size, placement| {
            Camera::new(&view, size).unwrap();
            let last = dims.axes().map(|n| f64::from(n - 1));
            let corners = (0..8).map(|n| {
                let corner: [f64; 3] = std::array::from_fn(|a| if n >> a & 1 == 1 { last[a] } else { 0.0 });
                placement.transform_point3(corner.into())
            });
            let shows =
                |view: &View, p| in_image(view, size, p).is_some_and(|at| at.iter().all(|c| c.abs() <= 1.0));
            assert!(corners.clone().all(|p| shows(&view, p)), "{view:?} {size:?} cuts the domain off");
            // Not much further away than needed.
            let projection = match view.projection {
                Projection::Orthographic { height } => Projection::Orthographic { height: 0.9 * height },
                perspective => perspective,
            };
            let nearer = View { eye: view.look_at + 0.9 * (view.eye - view.look_at), projection, ..view };
            let fills = corners.clone().any(|p| !shows(&nearer, p));
            assert!(fills || dims.cells() == 0, "{view:?} {size:?} is too far away");
        });
    }
}

#[test]
fn a_domain_without_extent_is_seen_from_the_distance_of_a_voxel() {
    for_all_views(Dims::new([1; 3]).unwrap(), |view, size, placement| {
        Camera::new(&view, size).unwrap();
        assert_ne!(view.eye, view.look_at);
        assert_eq!(view.look_at, placement.translation);
        let distance = (view.eye - view.look_at).length();
        let axes = placement.matrix3;
        let voxel = axes.x_axis.length().max(axes.y_axis.length()).max(axes.z_axis.length());
        assert!((1.0..2.1).contains(&(distance / voxel)), "{distance} of {voxel}");
    });
    // Where the distance would be lost in rounding.
    let far = DAffine3::from_translation(DVec3::new(1e18, -3e18, 2e18));
    for dims in [[1; 3], [4; 3]] {
        let view = frame_all(&View::default(), [8, 8], Dims::new(dims).unwrap(), &far);
        assert!(Camera::new(&view, [8, 8]).is_ok(), "{view:?}");
    }
}
