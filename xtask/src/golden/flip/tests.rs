use super::*;

const SIZE: [u32; 2] = [48, 40];

fn picture(color: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y])).flat_map(|[x, y]| color(x, y)).collect()
}

fn mean(a: &[u8], b: &[u8]) -> f64 {
    let values = flip(SIZE, a, b);
    assert!(values.iter().all(|v| (0.0..=1.0).contains(v)), "{values:?}");
    values.iter().sum::<f64>() / values.len() as f64
}

/// A disc with stripes, so many pixels to the right.
fn disc(shift: f64) -> Vec<u8> {
    picture(|x, y| {
        let [x, y] = [f64::from(x) - 20.0 - shift, f64::from(y) - 19.5];
        let inside = (12.0 - x.hypot(y)).clamp(0.0, 1.0);
        let stripe = 0.5 + 0.5 * (0.8 * x).sin();
        [200.0 * inside, 160.0 * inside * stripe, 40.0 + 60.0 * inside].map(|c| c as u8)
    })
}

#[test]
fn equal_pictures_do_not_differ() {
    assert!(flip(SIZE, &disc(0.0), &disc(0.0)).iter().all(|&v| v == 0.0));
}

/// No two colours differ more than green and blue; of what may be reached, black and white reach nearly all.
#[test]
fn the_largest_differences() {
    let plain = |color| picture(|_, _| color);
    let green_and_blue = mean(&plain([0, 255, 0]), &plain([0, 0, 255]));
    assert!((green_and_blue - 1.0).abs() < 1e-9, "{green_and_blue}");
    let black_and_white = mean(&plain([0; 3]), &plain([255; 3]));
    assert!((0.96..1.0).contains(&black_and_white), "{black_and_white}");
}

/// The paper states the largest difference, and how compressed ones are mapped.
#[test]
fn constants_are_those_of_the_paper() {
    let largest = Spaces::new().largest();
    assert!((largest - 41.276).abs() < 0.02, "{largest}");
    assert_eq!(redistributed(0.0, largest), 0.0);
    assert!((redistributed(0.4 * largest, largest) - 0.95).abs() < 1e-12);
    assert!((redistributed(largest, largest) - 1.0).abs() < 1e-12);
}

#[test]
fn it_grows_with_a_shift_and_with_a_step_of_grey() {
    let shifts = [0.25, 0.5, 1.0, 2.0, 4.0].map(|by| mean(&disc(0.0), &disc(by)));
    assert!(shifts.is_sorted() && shifts[0] > 0.0, "{shifts:?}");
    let plain = |grey: u8| picture(|_, _| [grey; 3]);
    let steps = [1, 2, 4, 8, 32, 100].map(|step| mean(&plain(100), &plain(100 + step)));
    assert!(steps.is_sorted() && steps[0] > 0.0 && steps[0] < 0.1, "{steps:?}");
}

#[test]
fn neither_picture_comes_first() {
    for (a, b) in [(disc(0.0), disc(1.5)), (disc(0.0), picture(|x, y| [x as u8, y as u8, 200]))] {
        assert_eq!(flip(SIZE, &a, &b), flip(SIZE, &b, &a));
    }
}

/// A pixel that stands out counts for more than its share of what the eye would mix.
#[test]
fn points_are_found_and_are_found_where_they_are() {
    let plain = picture(|_, _| [60; 3]);
    let point = picture(|x, y| if [x, y] == [30, 11] { [255; 3] } else { [60; 3] });
    let values = flip(SIZE, &plain, &point);
    let worst = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap();
    assert_eq!([worst as u32 % SIZE[0], worst as u32 / SIZE[0]], [30, 11]);
    assert!(values[worst] > 0.3 && values[0] == 0.0, "{}", values[worst]);
}

#[test]
fn spaces_of_colours_are_gone_through_and_back() {
    let spaces = Spaces::new();
    for rgb in [DVec3::ONE, DVec3::ZERO, DVec3::new(0.2, 0.7, 0.05)] {
        let back = spaces.of_opponent(spaces.opponent(rgb));
        assert!((back - rgb).length() < 1e-12, "{rgb} {back}");
    }
    let white = spaces.lab(DVec3::ONE);
    assert!((white - DVec3::new(100.0, 0.0, 0.0)).length() < 1e-9, "{white}");
}
