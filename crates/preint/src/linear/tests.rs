//! Against quadrature by brute force and closed forms.

use proptest::prelude::*;

use super::LinearPieces;
use crate::{ControlPoint, Piece, TransferFunction};

pub(crate) fn transfer(points: &[(f32, [f32; 3], f32)]) -> TransferFunction {
    let point = |&(value, color, extinction): &_| ControlPoint { value, color, extinction };
    TransferFunction::new(points.iter().map(point).collect()).unwrap()
}

/// Any transfer function of a few points within `[0, 1]`, steps among them.
pub(crate) fn transfers(largest: f32) -> impl Strategy<Value = TransferFunction> {
    let point = (0_u8..=16, prop::array::uniform3(0.0_f32..1.0), prop_oneof![Just(0.0), 0.0..largest]);
    prop::collection::vec(point, 1..7).prop_map(|mut points| {
        points.sort_by_key(|p| p.0);
        let mut kept: Vec<(f32, [f32; 3], f32)> = Vec::new();
        for (value, color, extinction) in points {
            let value = f32::from(value) / 16.0;
            if kept.len() < 2 || kept[kept.len() - 2].0 < value {
                kept.push((value, color, extinction));
            }
        }
        transfer(&kept)
    })
}

/// Alpha, front and back by the midpoint rule with a step that is exact in opacity; `TransferFunction::at` in `f64`.
fn brute(transfer: &TransferFunction, s0: f64, s1: f64, length: f64) -> [f64; 7] {
    let points = transfer.points();
    let at = |s: f64| -> [f64; 4] {
        let above = points.partition_point(|p| f64::from(p.value) <= s);
        let optics = |p: &ControlPoint| [p.color[0], p.color[1], p.color[2], p.extinction].map(f64::from);
        let low = optics(&points[above.saturating_sub(1)]);
        if above == 0 || above == points.len() {
            return low;
        }
        let [a, b] = [points[above - 1].value, points[above].value].map(f64::from);
        let high = optics(&points[above]);
        std::array::from_fn(|n| low[n] + (high[n] - low[n]) * (s - a) / (b - a))
    };
    // Cut at the control points, so that steps do no harm.
    let mut cuts = vec![0.0, 1.0];
    if s0 != s1 {
        cuts.extend(
            points.iter().map(|p| (f64::from(p.value) - s0) / (s1 - s0)).filter(|x| (0.0..1.0).contains(x)),
        );
    }
    cuts.sort_by(f64::total_cmp);
    let mut out = [0.0; 7];
    let mut depth = 0.0_f64;
    for pair in cuts.windows(2) {
        let steps = 4000;
        let h = (pair[1] - pair[0]) / f64::from(steps);
        for n in 0..steps {
            let x = pair[0] + (f64::from(n) + 0.5) * h;
            let optics = at(s0 + (s1 - s0) * x);
            let step = optics[3] * length * h;
            let opacity = (-depth).exp() * -(-step).exp_m1();
            for c in 0..3 {
                out[1 + c] += opacity * (1.0 - x) * optics[c];
                out[4 + c] += opacity * x * optics[c];
            }
            depth += step;
        }
    }
    out[0] = -(-depth).exp_m1();
    out
}

fn numbers(piece: &Piece) -> [f64; 7] {
    let [f, b] = [piece.front, piece.back];
    [piece.alpha, f[0], f[1], f[2], b[0], b[1], b[2]].map(f64::from)
}

fn largest_difference(a: [f64; 7], b: [f64; 7]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn agrees_with_brute_force(
        transfer in transfers(20.0), s0 in -0.25_f32..1.25, s1 in -0.25_f32..1.25, log_length in -4.0_f32..1.0,
    ) {
        let length = 10_f32.powf(log_length);
        let piece = LinearPieces::new(&transfer).integrate(s0, s1, length);
        let exact = brute(&transfer, s0.into(), s1.into(), length.into());
        let difference = largest_difference(numbers(&piece), exact);
        prop_assert!(difference <= 1e-6, "{difference}: {piece:?} {exact:?}");
    }

    #[test]
    fn a_constant_color_is_that_times_alpha(
        transfer in transfers(20.0), s0 in -0.25_f32..1.25, s1 in -0.25_f32..1.25, log_length in -30.0_f32..6.0,
    ) {
        let white = transfer.points().iter().map(|p| ControlPoint { color: [1.0; 3], ..*p }).collect();
        let pieces = LinearPieces::new(&TransferFunction::new(white).unwrap());
        let piece = pieces.integrate(s0, s1, 10_f32.powf(log_length));
        for color in piece.color() {
            prop_assert!((color - piece.alpha).abs() <= 3e-7 * piece.alpha, "{piece:?}");
        }
    }

    #[test]
    fn depth_and_alpha_agree(
        transfer in transfers(20.0), s0 in -0.25_f32..1.25, s1 in -0.25_f32..1.25, log_length in -30.0_f32..6.0,
    ) {
        let pieces = LinearPieces::new(&transfer);
        let length = 10_f32.powf(log_length);
        let alpha = f64::from(pieces.integrate(s0, s1, length).alpha);
        let by_depth = -(-f64::from(pieces.optical_depth(s0, s1, length))).exp_m1();
        prop_assert!((alpha - by_depth).abs() <= 2.0 * f64::from(f32::EPSILON) * alpha, "{alpha} {by_depth}");
    }

    #[test]
    fn two_halves_make_the_whole(
        transfer in transfers(200.0), s0 in -0.25_f32..1.25, s1 in -0.25_f32..1.25, length in 0.0_f32..2.0,
    ) {
        let [s0, s1, length] = [s0, s1, length].map(f64::from);
        let pieces = LinearPieces::new(&transfer);
        let middle = 0.5 * (s0 + s1);
        let whole = pieces.sums(s0, s1, length);
        let [a, b] = [(s0, middle), (middle, s1)].map(|(s0, s1)| pieces.sums(s0, s1, 0.5 * length));
        let left = (-a.depth).exp();
        for n in 0..3 {
            let back = 0.5 * a.back[n] + left * 0.5 * (b.front[n] + 2.0 * b.back[n]);
            let color = a.front[n] + a.back[n] + left * (b.front[n] + b.back[n]);
            prop_assert!((whole.back[n] - back).abs() <= 2.0 * LinearPieces::ERROR);
            prop_assert!((whole.front[n] + whole.back[n] - color).abs() <= 2.0 * LinearPieces::ERROR);
        }
    }
}

/// `M = ∫ e^(−T)` is what is missing of 1 in the integral with a colour that falls from 1 to 0.
fn missing(low: f32, high: f32) -> f64 {
    let ramp = transfer(&[(0.0, [1.0, 0.0, 0.0], low), (1.0, [0.0, 1.0, 0.0], high)]);
    let sums = LinearPieces::new(&ramp).sums(0.0, 1.0, 1.0);
    1.0 - sums.front[0] - sums.back[0]
}

/// Where extinction rises from zero, `M = √π·erf(√D) / (2√D)`; where it falls to zero, Dawson's function `F(√D) / √D`.
#[test]
fn agrees_with_closed_forms() {
    for n in 1..=120 {
        let depth = 0.05 * f64::from(n);
        let [mut erf, mut dawson] = [0.0; 2];
        let [mut a, mut b] = [1.0, 1.0];
        for k in 0..80 {
            let k = f64::from(k);
            erf += a / (2.0 * k + 1.0);
            dawson += b;
            a *= -depth / (k + 1.0);
            b *= -2.0 * depth / (2.0 * k + 3.0);
        }
        let high = (2.0 * depth) as f32;
        let rounding = f64::from(f32::EPSILON) * depth;
        let [rising, falling] = [missing(0.0, high) - erf, missing(high, 0.0) - dawson].map(f64::abs);
        assert!(rising <= LinearPieces::ERROR + rounding, "{depth}: {rising}");
        assert!(falling <= LinearPieces::ERROR + rounding, "{depth}: {falling}");
    }
}

/// One stretch of any depth against 512 thin ones, on which the quadrature is exact to its last digits.
#[test]
fn the_error_is_the_documented_one() {
    let mut worst = 0.0_f64;
    for falls in 0..=8_u8 {
        let [low, high] = [f32::from(8 - falls), f32::from(falls)].map(|x| 0.25 * x);
        let ramp = transfer(&[(0.0, [1.0, 0.0, 1.0], low), (1.0, [0.0, 1.0, 1.0], high)]);
        let pieces = LinearPieces::new(&ramp);
        for n in 1..=120 {
            let length = 0.5 * f64::from(n);
            let whole = pieces.sums(0.0, 1.0, length);
            let [mut depth, mut front, mut back] = [0.0_f64, 0.0, 0.0];
            for part in 0..512 {
                let ends = [part, part + 1].map(|k| f64::from(k) / 512.0);
                let sums = pieces.sums(ends[0], ends[1], length / 512.0);
                for (weight, color) in [(1.0 - ends[0], sums.front[0]), (1.0 - ends[1], sums.back[0])] {
                    front += (-depth).exp() * weight * color;
                }
                for (weight, color) in [(ends[0], sums.front[1]), (ends[1], sums.back[1])] {
                    back += (-depth).exp() * weight * color;
                }
                depth += sums.depth;
            }
            worst = worst.max((whole.front[0] - front).abs()).max((whole.back[1] - back).abs());
        }
    }
    assert!(worst <= LinearPieces::ERROR, "{worst}");
}

#[test]
fn extremes_of_depth_keep_their_digits() {
    let ramp = transfer(&[(0.0, [1.0, 0.5, 0.0], 0.0), (1.0, [1.0, 0.5, 1.0], 2.0)]);
    let pieces = LinearPieces::new(&ramp);
    for length in [1e-38, 1e-30, 1e-12, 1e-7_f32] {
        let piece = pieces.integrate(0.0, 1.0, length);
        // ∫ (1 − x)·2x = 1/3; blue ∫ x·2x·x = 1/2 with the weight x.
        let exact = [1.0, 1.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0, 1.0 / 3.0, 0.5];
        for (found, exact) in numbers(&piece).into_iter().zip(exact) {
            assert!((found / f64::from(length) - exact).abs() <= 3e-7, "{length} {piece:?}");
        }
        assert_eq!(pieces.optical_depth(0.0, 1.0, length), length);
    }
    for length in [1e3, 1e6, 1e30, f32::MAX] {
        let piece = pieces.integrate(1.0, 0.5, length);
        assert_eq!(piece.alpha, 1.0);
        // All that is seen is at the front, down to a depth in the order of 1.
        let share = 2.0 / length;
        for (found, exact) in numbers(&piece).into_iter().zip([1.0, 1.0, 0.5, 1.0, 0.0, 0.0, 0.0]) {
            assert!((found - exact).abs() <= f64::from(share) + LinearPieces::ERROR, "{length} {piece:?}");
        }
    }
    assert_eq!(pieces.integrate(0.2, 0.7, 0.0), Piece::default());
}

#[test]
fn nothing_cancels_between_equal_and_adjacent_values() {
    // A wall before a thin veil: the antiderivative is 10⁶ where differences are 10⁻¹².
    let veil = transfer(&[
        (0.0, [1.0; 3], 2e6),
        (1.0, [1.0; 3], 0.0),
        (1.5, [1.0; 3], 1e-12),
        (2.0, [1.0; 3], 1e-12),
        (3.0, [1.0; 3], 3e-12),
    ]);
    let pieces = LinearPieces::new(&veil);
    for s in [1.2_f32, 1.5, 1.75, 2.0, 2.5, 3.0, 7.0] {
        for s1 in [s, s.next_up(), s.next_down(), s.next_up().next_up()] {
            let extinction = veil.at(s).extinction;
            // Two steps of `s` change the extinction by up to 6·10⁻⁷ of it.
            let depth = pieces.optical_depth(s, s1, 1.0);
            assert!((depth - extinction).abs() <= 1e-6 * extinction, "{s} {s1} {depth}");
            let piece = pieces.integrate(s, s1, 1.0);
            assert!((piece.alpha - extinction).abs() <= 1e-6 * extinction);
            assert!((piece.front[0] - 0.5 * extinction).abs() <= 1e-6 * extinction);
        }
    }
    // Over whole intervals: (0.25 + 0.5 + 2)·10⁻¹² / 2.
    let depth = pieces.optical_depth(3.0, 1.0, 1.0);
    assert!((depth / 1.375e-12 - 1.0).abs() <= 3e-7, "{depth}");
}

#[test]
fn steps_are_those_of_the_transfer_function() {
    let step = transfer(&[
        (0.0, [0.0; 3], 0.0),
        (0.5, [0.0; 3], 0.0),
        (0.5, [1.0, 0.5, 0.25], 4.0),
        (1.0, [1.0, 0.5, 0.25], 4.0),
    ]);
    let pieces = LinearPieces::new(&step);
    assert_eq!(pieces.integrate(0.1, 0.5_f32.next_down(), 9.0), Piece::default());
    let thick = -(-4.0_f32).exp_m1();
    assert!((pieces.integrate(0.5, 0.5, 1.0).alpha - thick).abs() <= 1e-7);
    for (s0, s1) in [(0.0, 1.0), (1.0, 0.0), (0.5, -0.5), (0.5, 1.0)] {
        let inside = if s1 == 1.0 && s0 == 0.5 { 1.0 } else { 0.5_f32 };
        let inside = if s1 == -0.5 { 0.0 } else { inside };
        let alpha = pieces.integrate(s0, s1, 1.0).alpha;
        assert!((alpha + (-4.0 * inside).exp_m1()).abs() <= 1e-7, "{s0} {s1} {alpha}");
    }
}

#[test]
fn beyond_the_control_points_all_is_constant() {
    let pieces = LinearPieces::new(&transfer(&[(0.0, [0.5; 3], 1.0), (1.0, [1.0; 3], 3.0)]));
    for (s0, s1, color, extinction) in
        [(-9.0, -2.0, 0.5, 1.0), (1.0, 1e30, 1.0, 3.0), (7.0, 2.0, 1.0, 3.0_f32)]
    {
        let piece = pieces.integrate(s0, s1, 0.5);
        let alpha = -(-0.5 * extinction).exp_m1();
        assert!((piece.alpha - alpha).abs() <= 1e-7);
        assert!((piece.color()[1] - color * alpha).abs() <= 2e-7);
        // As between equal values.
        assert!((piece.front[0] - pieces.integrate(s0, s0, 0.5).front[0]).abs() <= 1e-7);
    }
}
