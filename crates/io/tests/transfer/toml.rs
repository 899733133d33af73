//! isoray's own files.

use isoray_io::transfer::Remap;
use isoray_io::{TransferOptions, read_transfer_function};
use isoray_preint::ControlPoint;

use crate::{encode, fixture, read_as};

const TWO: &str = "points = [{ value = -1, color = '#000000', extinction = 0 }, \
                   { value = 3.0, color = [1, 0.5, 0.0], extinction = 2 }]\n";

#[test]
fn numbers_and_notations() {
    let function = read_as("a.toml", TWO, &TransferOptions::default()).unwrap();
    let half = 0.214_041_14;
    let expected = [
        ControlPoint { value: -1.0, color: [0.0; 3], extinction: 0.0 },
        ControlPoint { value: 3.0, color: [1.0, half, 0.0], extinction: 2.0 },
    ];
    assert_eq!(function.points(), expected);
    let linear = format!("color_space = 'linear'\n{TWO}");
    let function = read_as("a.toml", linear, &TransferOptions::default()).unwrap();
    assert_eq!(function.points()[1].color, [1.0, 0.5, 0.0]);
    // Whatever its name, and with a mark of its encoding.
    let function = read_as("a.txt", format!("\u{feff}{TWO}"), &TransferOptions::default()).unwrap();
    assert_eq!(function.points(), expected);
}

#[test]
fn the_example_reads() {
    let function = read_transfer_function(&fixture("tooth.toml"), &TransferOptions::default()).unwrap();
    assert_eq!(function.points().len(), 5);
    // The step, and opacity 0.2 in two units.
    let [below, above] = [899.999, 900.0].map(|v| function.at(v).extinction);
    assert!(
        (below - 0.03).abs() < 1e-5 && (f64::from(above) + 0.8f64.ln() / 2.0).abs() < 1e-7,
        "{below} {above}"
    );
}

#[test]
fn opacities_are_per_unit_distance() {
    let text = "points = [{ value = 0, color = '#ffffff', opacity = 0.75 }, { value = 1, color = '#FFFFFF', opacity = 1 }]";
    let options = TransferOptions { unit_distance: 4.0, ..TransferOptions::default() };
    let [a, b] = [0, 1].map(|n| read_as("a.toml", text, &options).unwrap().points()[n].extinction);
    assert!((a - 4f32.ln() / 4.0).abs() < 1e-7 && (b - 1024f32.ln() / 4.0).abs() < 1e-6, "{a} {b}");
    let own = format!("unit_distance = 0.5\n{text}");
    let a = read_as("a.toml", own, &options).unwrap().points()[0].extinction;
    assert!((a - 4f32.ln() / 0.5).abs() < 1e-6);
}

#[test]
fn a_colour_map_spans_the_points() {
    let text = "colormap = 'Gray'\npoints = [{ value = 10, extinction = 0 }, { value = 20, extinction = 3 }, \
                { value = 30, extinction = 3 }]";
    let function = read_as("a.toml", text, &TransferOptions::default()).unwrap();
    for n in 0..=100 {
        let at = function.at(10.0 + 0.2 * n as f32);
        assert!((encode(at.color[1]) - f64::from(n) / 100.0).abs() <= 1.0 / 1024.0, "{n}: {at:?}");
        assert!((at.extinction - (0.06 * n as f32).min(3.0)).abs() < 1e-5, "{n}: {at:?}");
    }
}

#[test]
fn values_move_only_where_asked_for() {
    let data_range = Some([100.0, 200.0]);
    let ends = |text: &str, options: TransferOptions| {
        let function = read_as("a.toml", text, &options).unwrap();
        [function.points().first(), function.points().last()].map(|p| p.unwrap().value)
    };
    let default = TransferOptions { data_range, ..TransferOptions::default() };
    assert_eq!(ends(TWO, default), [-1.0, 3.0]);
    let normalized = format!("normalized = true\n{TWO}");
    assert_eq!(ends(&normalized, default), [100.0, 200.0]);
    assert_eq!(ends(&normalized, TransferOptions::default()), [-1.0, 3.0]);
    let remap = Remap { range: Some([-7.0, -5.0]), log: false };
    assert_eq!(ends(&normalized, TransferOptions { remap, ..default }), [-7.0, -5.0]);
    // Data of one value.
    assert_eq!(ends(&normalized, TransferOptions { data_range: Some([5.0, 5.0]), ..default }), [5.0, 5.0]);
}

#[test]
fn logarithms() {
    let options = |range| TransferOptions { remap: Remap { range, log: true }, ..TransferOptions::default() };
    let function = read_as("a.toml", TWO, &options(Some([1.0, 100.0]))).unwrap();
    assert!((function.at(10.0).extinction - 1.0).abs() < 2.0 / 1024.0);
    let own = "colormap = 'gray'\npoints = [{ value = 1, extinction = 0 }, { value = 1e4, extinction = 1 }]";
    let function = read_as("a.toml", own, &options(None)).unwrap();
    assert!((function.at(10.0).extinction - 0.25).abs() < 1.0 / 1024.0);
    assert_eq!(function.points().last().unwrap().value, 1e4);
}
