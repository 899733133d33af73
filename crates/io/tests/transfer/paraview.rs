//! ParaView's presets.

use isoray_io::transfer::Remap;
use isoray_io::{TransferOptions, read_transfer_function};

use crate::{encode, fixture, read_as};

fn preset(rest: &str) -> String {
    format!("[{{\"Name\": \"a\", \"Creator\": 3, {rest}}}, 7]")
}

#[test]
fn display_colours_are_followed() {
    let text = preset(r#""RGBPoints": [-5, 0, 0.1, 1, 5, 1, 0.9, 0, 15, 0, 0, 0]"#);
    let function = read_as("a.json", text, &TransferOptions::default()).unwrap();
    assert!((20..120).contains(&function.points().len()), "{}", function.points().len());
    for n in 0..=1000 {
        let s = f64::from(n) / 1000.0;
        let first = function.at((-5.0 + 10.0 * s) as f32).color.map(encode);
        let second = function.at((5.0 + 10.0 * s) as f32).color.map(encode);
        let near = |found: [f64; 3], exact: [f64; 3]| {
            found.iter().zip(exact).all(|(a, b)| (a - b).abs() <= 1.0 / 1024.0)
        };
        assert!(near(first, [s, 0.1 + 0.8 * s, 1.0 - s]), "{s}: {first:?}");
        assert!(near(second, [1.0 - s, 0.9 - 0.9 * s, 0.0]), "{s}: {second:?}");
    }
}

#[test]
fn default_opacity_is_a_ramp() {
    let text = preset(r#""RGBPoints": [0, 1, 1, 1, 10, 1, 1, 1]"#);
    let options = TransferOptions { unit_distance: 2.0, ..TransferOptions::default() };
    let function = read_as("a.json", text, &options).unwrap();
    for n in 0..=999 {
        let opacity = f64::from(n) / 1000.0;
        let exact = -(-opacity).ln_1p() / 2.0;
        let found = f64::from(function.at((10.0 * opacity) as f32).extinction);
        assert!((found - exact).abs() <= 0.01 * exact + 4e-4, "{opacity}: {found}, not {exact}");
    }
    assert!((function.at(11.0).extinction - 1024f32.ln() / 2.0).abs() < 1e-6);
}

#[test]
fn the_example_reads_and_is_mapped_to_the_data() {
    let data_range = Some([-40.0, 60.0]);
    let options = TransferOptions { data_range, ..TransferOptions::default() };
    let function = read_transfer_function(&fixture("cool-to-warm.json"), &options).unwrap();
    let points = function.points();
    assert_eq!([points[0].value, points[points.len() - 1].value], [-40.0, 60.0]);
    // White, clear, in the middle; the ends keep their colours.
    let middle = function.at(10.0);
    assert!(middle.extinction == 0.0 && middle.color.iter().all(|&c| (encode(c) - 0.866).abs() < 0.01));
    assert!((encode(points[0].color[2]) - 0.752_941).abs() < 1e-4, "{:?}", points[0]);
    assert!((points[0].extinction - 2f32.ln()).abs() < 1e-6);
}

#[test]
fn which_values_are_relative() {
    let ends = |points: &str, options: &TransferOptions| {
        let text = preset(&format!("\"RGBPoints\": {points}"));
        let function = read_as("a.json", text, options).unwrap();
        [function.points().first(), function.points().last()].map(|p| p.unwrap().value)
    };
    let data = TransferOptions { data_range: Some([2.0, 8.0]), ..TransferOptions::default() };
    assert_eq!(ends("[-1, 0, 0, 0, 1, 1, 1, 1]", &data), [2.0, 8.0]);
    assert_eq!(ends("[0, 0, 0, 0, 1, 1, 1, 1]", &data), [2.0, 8.0]);
    assert_eq!(ends("[0, 0, 0, 0, 2, 1, 1, 1]", &data), [0.0, 2.0]);
    let remap = Remap { range: Some([3.0, 4.0]), log: false };
    assert_eq!(ends("[0, 0, 0, 0, 2, 1, 1, 1]", &TransferOptions { remap, ..data }), [3.0, 4.0]);
    // One point is one colour.
    assert_eq!(ends("[5, 0, 0, 0]", &data), [5.0, 5.0]);
}

#[test]
fn colours_and_opacities_are_spread_each_by_its_own_ends() {
    let text = preset(r#""RGBPoints": [-1, 0, 0, 0, 1, 1, 1, 1], "Points": [0, 0, 0.5, 0, 1, 0.5, 0.5, 0]"#);
    let options = TransferOptions { data_range: Some([10.0, 20.0]), ..TransferOptions::default() };
    let function = read_as("a.json", text, &options).unwrap();
    let middle = function.at(15.0);
    assert!((encode(middle.color[0]) - 0.5).abs() < 2e-3);
    assert!((middle.extinction + 0.75f32.ln()).abs() < 0.01 * 0.29);
}

#[test]
fn steps() {
    let text = preset(r#""ColorSpace": "Step", "RGBPoints": [0, 1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1]"#);
    let function = read_as("a.json", text, &TransferOptions::default()).unwrap();
    let color = |v| function.at(v).color;
    assert_eq!(color(-0.5), [1.0, 0.0, 0.0]);
    assert_eq!([color(0.5), color(0.99)], [[0.0, 1.0, 0.0]; 2]);
    assert_eq!([color(1.5), color(3.0)], [[0.0, 0.0, 1.0]; 2]);
    let text = preset(
        r#""RGBPoints": [0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1, 3, 0, 0, 1], "Points": [0, 0.5, 0.25, 1, 4, 0, 0.5, 0]"#,
    );
    let function = read_as("a.json", text, &TransferOptions::default()).unwrap();
    assert_eq!([function.at(0.999).color, function.at(1.0).color], [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    assert!(function.at(0.999).extinction > 0.69 && function.at(1.001).extinction == 0.0);
}

#[test]
fn one_object_is_enough() {
    let text = r#" {"RGBPoints": [0, 0, 0, 0], "ColorSpace": "CIELAB"}"#;
    assert_eq!(read_as("a", text, &TransferOptions::default()).unwrap().points().len(), 2);
}
