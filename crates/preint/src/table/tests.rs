//! Tables against exact pieces.

use std::time::Instant;

use proptest::prelude::*;

use super::{Entry, PreintegrationTable, TableAxes, TableError};
use crate::linear::tests::{transfer, transfers};
use crate::{ControlPoint, LinearPieces, Piece, TransferFunction};

fn numbers(piece: &Piece) -> [f64; 7] {
    let [f, b] = [piece.front, piece.back];
    [piece.alpha, f[0], f[1], f[2], b[0], b[1], b[2]].map(f64::from)
}

fn difference(a: &Piece, b: &Piece) -> f64 {
    let [a, b] = [a, b].map(numbers);
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The largest error at the nodes; colours are at most 1.
fn node_error<E: Entry>(table: &PreintegrationTable<E>, pieces: &LinearPieces) -> f64 {
    let axes = *table.axes();
    let mut worst = 0.0_f64;
    for k in 0..axes.lengths {
        for i in 0..axes.values {
            for j in 0..axes.values {
                let exact = pieces.sums(axes.value(i), axes.value(j), axes.length(k)).numbers();
                let found = numbers(&table.node(i, j, k));
                worst = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(worst, f64::max);
            }
        }
    }
    worst
}

fn small(range: [f32; 2]) -> TableAxes {
    TableAxes { values: 14, lengths: 7, range, least_length: 1e-3, greatest_length: 30.0 }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn nodes_are_exact(transfer in transfers(30.0), low in -0.25_f32..0.5, width in 0.1_f32..1.0) {
        let pieces = LinearPieces::new(&transfer);
        let axes = small([low, low + width]);
        let table = PreintegrationTable::<f32>::new(&transfer, axes).unwrap();
        let error = node_error(&table, &pieces);
        prop_assert!(error <= PreintegrationTable::<f32>::NODE_ERROR + f64::from(f32::EPSILON), "{error}");
        let table = PreintegrationTable::<u16>::new(&transfer, axes).unwrap();
        let error = node_error(&table, &pieces);
        prop_assert!(error <= PreintegrationTable::<u16>::NODE_ERROR + 7.7e-6, "{error}");
    }

    #[test]
    fn entry_by_entry_makes_the_same_table(transfer in transfers(30.0)) {
        let axes = small([-0.1, 1.0]);
        let fast = PreintegrationTable::<u16>::new(&transfer, axes).unwrap();
        let plain = PreintegrationTable::<u16>::entry_by_entry(&transfer, axes).unwrap();
        let pairs = fast.entries.iter().flatten().zip(plain.entries.iter().flatten());
        for (a, b) in pairs {
            prop_assert!(a.abs_diff(*b) <= 1);
        }
    }

    /// Neither more opaque than a wall, nor brighter than the brightest colour behind that opacity.
    #[test]
    fn looked_up_pieces_are_possible(
        transfer in transfers(30.0), s0 in -0.5_f32..1.5, s1 in -0.5_f32..1.5, log_length in -6.0_f32..4.0,
    ) {
        let table = PreintegrationTable::<f32>::new(&transfer, small([0.0, 1.0])).unwrap();
        let piece = table.look_up(s0, s1, 10_f32.powf(log_length));
        prop_assert!((0.0..=1.0 + 1e-6).contains(&piece.alpha));
        for color in piece.color() {
            prop_assert!((0.0..=piece.alpha + 1e-6).contains(&color), "{piece:?}");
        }
    }
}

#[test]
fn the_table_of_the_paper_is_exact_at_its_nodes() {
    let transfer = peaks(9);
    let table = PreintegrationTable::<f32>::new(&transfer, TableAxes { lengths: 3, ..paper() }).unwrap();
    let error = node_error(&table, &LinearPieces::new(&transfer));
    assert!(error <= PreintegrationTable::<f32>::NODE_ERROR + f64::from(f32::EPSILON), "{error}");
}

#[test]
fn lengths_beyond_the_axis() {
    let haze = transfer(&[(0.0, [1.0, 0.0, 0.5], 0.01), (1.0, [0.0, 1.0, 0.5], 0.01)]);
    let axes = TableAxes { least_length: 0.01, greatest_length: 1.0, ..small([0.0, 1.0]) };
    let table = PreintegrationTable::<f32>::new(&haze, axes).unwrap();
    let pieces = LinearPieces::new(&haze);
    // Below the least length, opacity is taken as linear, the depth being at most 10⁻⁴; above the greatest, these are cut into parts of just
    // that.
    for length in [0.0, 1e-30, 1e-6, 0.01, 1.0, 2.0, 10.0, 64.0] {
        let [found, exact] = [table.look_up(0.0, 1.0, length), pieces.integrate(0.0, 1.0, length)];
        assert!(difference(&found, &exact) <= 1e-4 * f64::from(exact.alpha), "{length} {found:?} {exact:?}");
    }
    assert_eq!(table.look_up(0.0, 1.0, 1e9), table.look_up(0.0, 1.0, 64.0));
}

/// Thin pieces are linear in the length, and interpolated as linear in its logarithm: too much by a factor of up to `1 + ln²r/8` with the
/// ratio `r` of two lengths in the table, to the second order.
#[test]
fn thin_pieces_are_overstated_between_lengths() {
    let haze = transfer(&[(0.0, [1.0; 3], 1e-6)]);
    let axes = TableAxes { values: 4, ..TableAxes::new([0.0, 1.0], 1.0) };
    let table = PreintegrationTable::<f32>::new(&haze, axes).unwrap();
    let bound = (1e3_f64.ln() / 31.0).powi(2) / 8.0;
    let mut largest = 0.0_f64;
    for n in 0..1000 {
        let length = 10_f32.powf(-3.0 + 0.003 * n as f32);
        let excess = f64::from(table.look_up(0.1, 0.9, length).alpha / (1e-6 * length)) - 1.0;
        assert!((-1e-5..=1.01 * bound).contains(&excess), "{length}: {excess}");
        largest = largest.max(excess);
    }
    assert!(largest >= 0.98 * bound, "{largest}");
}

#[test]
fn axes_are_checked() {
    let veil = transfer(&[(0.0, [1.0; 3], 1.0)]);
    let axes = TableAxes::new([0.0, 1.0], 1.0);
    let error = |axes| PreintegrationTable::<u16>::new(&veil, axes).unwrap_err();
    assert_eq!(error(TableAxes { values: 1, ..axes }), TableError::Samples { axis: "values", found: 1 });
    assert_eq!(error(TableAxes { range: [1.0, 1.0], ..axes }), TableError::Range { found: [1.0, 1.0] });
    assert!(matches!(error(TableAxes { range: [f32::NAN, 1.0], ..axes }), TableError::Range { .. }));
    assert!(matches!(error(TableAxes { least_length: 0.0, ..axes }), TableError::Lengths { .. }));
    assert_eq!(
        error(TableAxes { least_length: 2.0, ..axes }).to_string(),
        "expected two increasing lengths, both positive, found [2.0, 1.0]"
    );
}

/// Triangles of extinction and colour, `points` control points in all.
fn peaks(points: u16) -> TransferFunction {
    let last = f32::from(points - 1);
    let point = |n: u16| {
        let x = f32::from(n) / last;
        let peak = (16.0 * x).sin().powi(2);
        ControlPoint { value: x, color: [x, peak, 1.0 - x], extinction: 8.0 * peak * x }
    };
    TransferFunction::new((0..points).map(point).collect()).unwrap()
}

fn paper() -> TableAxes {
    TableAxes::new([0.0, 1.0], 2.0)
}

/// Prints time and error.
#[test]
#[ignore = "a minute's measurement: cargo test --release -p isoray-preint -- --ignored --nocapture measure"]
fn measure() {
    for points in [9, 33, 256] {
        let transfer = peaks(points);
        let axes = paper();
        let start = Instant::now();
        let fast = PreintegrationTable::<u16>::new(&transfer, axes).unwrap();
        let running = start.elapsed().as_secs_f64();
        let plain = PreintegrationTable::<u16>::entry_by_entry(&transfer, axes).unwrap();
        let anew = start.elapsed().as_secs_f64() - running;
        assert_eq!(fast.entries.len(), plain.entries.len());
        println!(
            "{points} points: running {running:.3} s, entry by entry {anew:.3} s, ratio {:.1}",
            anew / running
        );
    }
    println!("| control points | values × lengths | rms alpha | largest alpha | rms u16 |");
    for points in [2, 9, 33] {
        for (values, lengths) in [(64, 16), (128, 32), (256, 32), (256, 64), (512, 32)] {
            measure_error(points, TableAxes { values, lengths, ..paper() });
        }
    }
}

fn measure_error(points: u16, axes: TableAxes) {
    let transfer = if points == 2 {
        transfer(&[(0.0, [1.0, 0.0, 0.5], 0.0), (1.0, [0.0, 1.0, 0.5], 4.0)])
    } else {
        peaks(points)
    };
    let pieces = LinearPieces::new(&transfer);
    let table = PreintegrationTable::<f32>::new(&transfer, axes).unwrap();
    let coarse = PreintegrationTable::<u16>::new(&transfer, axes).unwrap();
    let mut random = isoray_oracle::SplitMix64::new(7);
    let [mut worst, mut sum, mut sum_coarse] = [0.0_f64; 3];
    let samples = 200_000;
    for _ in 0..samples {
        let [s0, s1] = [random.unit() as f32, random.unit() as f32];
        let length = (2.0 * random.range(-6.9, 0.0).exp()) as f32;
        let exact = f64::from(pieces.integrate(s0, s1, length).alpha);
        let error = (f64::from(table.look_up(s0, s1, length).alpha) - exact).abs();
        worst = worst.max(error);
        sum += error * error;
        sum_coarse += (f64::from(coarse.look_up(s0, s1, length).alpha) - exact).powi(2);
    }
    let [rms, rms_coarse] = [sum, sum_coarse].map(|s| (s / f64::from(samples)).sqrt());
    println!(
        "| {points} | {} × {} | {rms:.1e} | {worst:.1e} | {rms_coarse:.1e} |",
        axes.values, axes.lengths
    );
}
