use super::*;
use crate::camera::{Projection, View};

const SIZE: [u32; 2] = [41, 31];

/// From (0, -10, 0) along +y.
fn camera(projection: Projection) -> Camera {
    let view = View { eye: DVec3::new(0.0, -10.0, 0.0), look_at: DVec3::ZERO, projection, ..View::default() };
    Camera::new(&view, SIZE).unwrap()
}

const ORTHOGRAPHIC: Projection = Projection::Orthographic { height: 31.0 };
const PERSPECTIVE: Projection = Projection::Perspective { fov: 60.0 };

fn line(a: [f64; 3], b: [f64; 3]) -> Line {
    Line { ends: [a, b].map(DVec3::from_array), color: Vec3::new(1.0, 0.5, 0.25) }
}

fn picture(projection: Projection, pixel: Pixel, lines: &[Line], clip: &Clip) -> Image {
    let mut image = Image::empty(SIZE);
    image.pixels_mut().fill(pixel);
    draw_lines(&mut image, &camera(projection), lines.iter().copied(), clip, 1.0);
    image
}

/// The pixels that are not empty, in rows.
fn marked(image: &Image) -> Vec<[u32; 2]> {
    let all = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
    all.filter(|&[x, y]| image.pixel(x, y).color.w > 0.0).collect()
}

#[test]
fn a_line_goes_from_end_to_end() {
    // A pixel is one unit wide; that in the middle is (20, 15).
    let image =
        picture(ORTHOGRAPHIC, Pixel::EMPTY, &[line([-8.0, 0.0, 5.0], [9.0, 3.0, 5.0])], &Clip::default());
    for x in 12..=29 {
        assert_eq!(image.pixel(x, 10).color, Vec3::new(1.0, 0.5, 0.25).extend(1.0));
        for y in [9, 11] {
            assert!((image.pixel(x, y).color.w as f64 - (REACH - 1.0)).abs() < 1e-6);
        }
    }
    for (x, y) in [(10, 10), (31, 10), (20, 8), (20, 12)] {
        assert_eq!(image.pixel(x, y), Pixel::EMPTY);
    }
    // Its ends are round, a tenth of the next pixels.
    assert!((f64::from(image.pixel(11, 10).color.w) - (REACH - 1.0)).abs() < 1e-6);
    assert_eq!(marked(&image).len(), 18 * 3 + 2);
}

#[test]
fn lines_are_where_rays_pass_them() {
    let (a, b) = (DVec3::new(-3.0, -4.0, -2.0), DVec3::new(5.0, 9.0, 4.0));
    for projection in [ORTHOGRAPHIC, PERSPECTIVE] {
        let camera = camera(projection);
        let image =
            picture(projection, Pixel::EMPTY, &[Line { ends: [a, b], color: Vec3::ONE }], &Clip::default());
        let drawn = Drawn::new(&camera, &Line { ends: [a, b], color: Vec3::ONE }, &Clip::default()).unwrap();
        let mut covered = 0;
        drawn.cover(SIZE, |[x, y], coverage, ahead| {
            let (origin, direction) = camera.world_ray(x, y);
            // The point of the ray nearest to the line is as far away, and the line as close as the pixel's width tells.
            let point = origin + direction * camera.distance([x, y], ahead);
            let on_line = a + (b - a) * ((point - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            let width = camera.width_of_pixel(ahead);
            assert!(point.distance(on_line) < 1.2 * REACH * width, "{x}, {y}: {point} {on_line}");
            assert_eq!(image.pixel(x, y).color.w > ALIKE, coverage > ALIKE);
            covered += 1;
        });
        assert!(covered > 20 && marked(&image).len() <= covered);
    }
}

#[test]
fn what_is_nearer_hides_them() {
    let across = [line([-30.0, 2.0, 0.0], [30.0, 2.0, 0.0])];
    let solid = |depth: f32, alpha: f32| Pixel {
        color: (Vec3::splat(0.2) * alpha).extend(alpha),
        depth,
        normal: Vec3::Z,
    };
    let middle = |pixel: Pixel| picture(ORTHOGRAPHIC, pixel, &across, &Clip::default()).pixel(20, 15);
    // The line is at 12, a pixel one unit wide.
    assert_eq!(middle(solid(10.9, 1.0)), solid(10.9, 1.0));
    let over = middle(solid(11.1, 1.0));
    assert_eq!(over, Pixel { color: Vec3::new(1.0, 0.5, 0.25).extend(1.0), ..solid(11.1, 1.0) });
    let through = middle(solid(5.0, 0.75));
    assert!((through.color - Vec3::new(0.4, 0.275, 0.2125).extend(1.0)).abs().max_element() < 1e-6);
    assert_eq!((through.depth, through.normal), (5.0, Vec3::Z));
}

#[test]
fn a_hidden_line_leaves_the_pixel_to_another() {
    let (behind, before) =
        (line([-9.0, 5.0, 0.0], [9.0, 5.0, 0.0]), line([-9.0, -5.0, 0.4], [9.0, -5.0, 0.4]));
    let pixel = Pixel { color: Vec3::ZERO.extend(1.0), depth: 10.0, normal: Vec3::Z };
    let image = picture(ORTHOGRAPHIC, pixel, &[behind, before], &Clip::default());
    assert!((image.pixel(20, 15).color.x as f64 - (REACH - 0.4)).abs() < 1e-6);
}

#[test]
fn nothing_behind_the_eye_or_outside_the_picture() {
    let is_empty = |projection, a, b| {
        marked(&picture(projection, Pixel::EMPTY, &[line(a, b)], &Clip::default())).is_empty()
    };
    for projection in [ORTHOGRAPHIC, PERSPECTIVE] {
        assert!(is_empty(projection, [0.0, -11.0, 0.0], [1.0, -30.0, 1.0]));
        assert!(is_empty(projection, [300.0, 0.0, 0.0], [300.0, 5.0, 90.0]));
        assert!(is_empty(projection, [-90.0, 0.0, 40.0], [90.0, 0.0, 40.0]));
        assert!(!is_empty(projection, [-1e9, 0.0, 0.0], [1e9, 0.0, 0.0]));
    }
}

#[test]
fn a_line_through_the_plane_of_the_eye_ends_there() {
    // Past the eye on its right; the far end is in the middle, the near one beyond the right border.
    let image =
        picture(PERSPECTIVE, Pixel::EMPTY, &[line([2.0, -40.0, 0.0], [2.0, 1e6, 0.0])], &Clip::default());
    let marked = marked(&image);
    assert!(marked.iter().all(|&[x, y]| x >= 19 && (14..=16).contains(&y)), "{marked:?}");
    assert!((20..41).all(|x| image.pixel(x, 15).color.w == 1.0));
    // Through the eye itself it is a point.
    let through =
        picture(PERSPECTIVE, Pixel::EMPTY, &[line([0.0, -40.0, 0.0], [0.0, 40.0, 0.0])], &Clip::default());
    assert_eq!(through.pixel(20, 15).color.w, 1.0);
}

#[test]
fn what_is_cut_away_is_not_drawn() {
    let clip = Clip(vec![crate::clip::Plane { normal: DVec3::X, offset: 0.0 }]);
    let image = picture(ORTHOGRAPHIC, Pixel::EMPTY, &[line([-30.0, 0.0, 0.0], [30.0, 0.0, 0.0])], &clip);
    assert!(marked(&image).iter().all(|&[x, _]| x >= 19));
    assert!((20..41).all(|x| image.pixel(x, 15).color.w == 1.0));
}

#[test]
fn a_box_has_twelve_edges() {
    let corners = std::array::from_fn(|n| DVec3::new((n & 1) as f64, (n >> 1 & 1) as f64, (n >> 2) as f64));
    let edges = Line::edges(&corners, Vec3::ONE);
    assert!(edges.iter().all(|edge| (edge.ends[1] - edge.ends[0]).length() == 1.0));
    for (n, edge) in edges.iter().enumerate() {
        assert!(edges[..n].iter().all(|other| other.ends != edge.ends));
    }
}
