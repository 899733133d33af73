//! Where the rays of pixels go.

use glam::DVec3;
use isoray_render::{Camera, CameraError, Projection, View};

const VIEW: View = View {
    eye: DVec3::new(1.0, 2.0, 3.0),
    look_at: DVec3::new(1.0, 7.0, 3.0),
    up: DVec3::Z,
    projection: Projection::Perspective { fov: 90.0 },
};

/// Where the ray of a pixel meets the plane at distance 1 from the eye, relative to the middle of the image.
fn on_plane(camera: &Camera, [x, y]: [u32; 2]) -> DVec3 {
    let (origin, direction) = camera.world_ray(x, y);
    assert!((direction.length() - 1.0).abs() < 1e-15);
    origin + direction / direction.y - (VIEW.eye + DVec3::Y)
}

fn assert_near(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-14, "{a}, not {b}");
}

#[test]
fn rays_go_through_the_centres_of_pixels() {
    // At 90 degrees the image is as high as twice its distance; looking along +y, x is right and z up.
    let camera = Camera::new(&VIEW, [4, 2]).unwrap();
    for (x, right) in [(0, -1.5), (1, -0.5), (2, 0.5), (3, 1.5)] {
        for (y, up) in [(0, 0.5), (1, -0.5)] {
            assert_near(on_plane(&camera, [x, y]), DVec3::new(right, 0.0, up));
        }
    }
    let middle = Camera::new(&VIEW, [17, 5]).unwrap();
    assert_near(on_plane(&middle, [8, 2]), DVec3::ZERO);
    let one = Camera::new(&VIEW, [1, 1]).unwrap();
    assert_near(on_plane(&one, [0, 0]), DVec3::ZERO);
}

#[test]
fn pixels_are_square_and_the_height_is_that_of_the_field_of_view() {
    for size in [[1, 9], [9, 1], [17, 5], [640, 480]] {
        for fov in [1.0, 45.0, 90.0, 179.0_f64] {
            let view = View { projection: Projection::Perspective { fov }, ..VIEW };
            let camera = Camera::new(&view, size).unwrap();
            let pixel = 2.0 * (fov / 2.0).to_radians().tan() / f64::from(size[1]);
            let corner = on_plane(&camera, [0, 0]) / pixel;
            let expected = DVec3::new(f64::from(size[0]) - 1.0, 0.0, f64::from(size[1]) - 1.0) / 2.0;
            assert!(
                (corner - expected * DVec3::new(-1.0, 0.0, 1.0)).length() < 1e-9 * expected.length().max(1.0)
            );
        }
    }
}

#[test]
fn the_image_is_right_handed_with_row_0_at_the_top() {
    for (eye, up) in [
        (DVec3::new(3.0, -4.0, 5.0), DVec3::Z),
        (DVec3::new(-3.0, 0.5, -1.0), DVec3::Y),
        (DVec3::new(0.0, 0.0, 9.0), DVec3::new(1.0, 1.0, 0.3)),
    ] {
        for projection in [Projection::Perspective { fov: 30.0 }, Projection::Orthographic { height: 2.0 }] {
            let view = View { eye, look_at: DVec3::ZERO, up, projection };
            let camera = Camera::new(&view, [3, 3]).unwrap();
            let at = |x, y| {
                let (origin, direction) = camera.world_ray(x, y);
                origin + direction * 9.0
            };
            let right = at(2, 1) - at(0, 1);
            let upward = at(1, 0) - at(1, 2);
            let backward = eye;
            assert!(right.cross(upward).dot(backward) > 0.0);
            assert!(upward.dot(up) > 0.0 && right.dot(upward).abs() < 1e-12 && right.dot(up).abs() < 1e-12);
        }
    }
}

#[test]
fn orthographic_rays_are_parallel_and_start_on_the_plane_of_the_eye() {
    let view = View { projection: Projection::Orthographic { height: 6.0 }, ..VIEW };
    let camera = Camera::new(&view, [5, 3]).unwrap();
    for x in 0..5 {
        for y in 0..3 {
            let (origin, direction) = camera.world_ray(x, y);
            assert_near(direction, DVec3::Y);
            // Three rows on six units.
            assert_near(
                origin - VIEW.eye,
                DVec3::new(2.0 * (f64::from(x) - 2.0), 0.0, 2.0 * (1.0 - f64::from(y))),
            );
        }
    }
}

#[test]
fn each_senseless_camera_has_its_error() {
    let error = |view: View, size| Camera::new(&view, size).unwrap_err();
    let of = |view: View| error(view, [8, 8]);
    for size in [[0, 8], [8, 0], [0, 0], [100_000, 100_000], [u32::MAX, u32::MAX]] {
        assert_eq!(error(VIEW, size), CameraError::Size(size[0], size[1]));
    }
    assert!(Camera::new(&VIEW, [1 << 14, 1 << 14]).is_ok());
    assert_eq!(error(VIEW, [1 << 14, (1 << 14) + 1]), CameraError::Size(1 << 14, (1 << 14) + 1));
    for bad in [f64::NAN, f64::INFINITY] {
        let bad = DVec3::new(0.0, bad, 0.0);
        assert_eq!(of(View { eye: bad, ..VIEW }), CameraError::NotFinite("eye"));
        assert_eq!(of(View { look_at: bad, ..VIEW }), CameraError::NotFinite("look-at point"));
        assert_eq!(of(View { up: bad, ..VIEW }), CameraError::NotFinite("up vector"));
    }
    assert_eq!(of(View { look_at: VIEW.eye, ..VIEW }), CameraError::NoDirection(VIEW.eye));
    for up in [DVec3::ZERO, DVec3::Y, -DVec3::Y * 1e9, DVec3::new(0.0, 1.0, 1e-12)] {
        let direction = VIEW.look_at - VIEW.eye;
        assert_eq!(of(View { up, ..VIEW }), CameraError::Up { up, direction });
    }
    for fov in [0.0, -1.0, 180.0, f64::INFINITY] {
        assert_eq!(of(View { projection: Projection::Perspective { fov }, ..VIEW }), CameraError::Fov(fov));
    }
    for height in [0.0, -1.0, f64::INFINITY] {
        let view = View { projection: Projection::Orthographic { height }, ..VIEW };
        assert_eq!(of(view), CameraError::Height(height));
    }
    let nan = f64::NAN;
    let fov = of(View { projection: Projection::Perspective { fov: nan }, ..VIEW });
    assert!(matches!(fov, CameraError::Fov(v) if v.is_nan()));
    let height = of(View { projection: Projection::Orthographic { height: nan }, ..VIEW });
    assert!(matches!(height, CameraError::Height(v) if v.is_nan()));
}
