//! Integration with a bounded error, against the oracle and closed forms.

use isoray_oracle::{SplitMix64, TransferKind, adversarial_stretch, adversarial_transfer};
use isoray_preint::{
    Bounded, ControlPoint, Integrate, LANES, Lighting, LinearPieces, Radiance, Segments, TransferFunction,
};
use proptest::prelude::*;

use crate::common::{self, Pixel, lighting, steepest};

fn point(value: f32, color: [f32; 3], extinction: f32) -> ControlPoint {
    ControlPoint { value, color, extinction }
}

fn function(points: &[ControlPoint]) -> TransferFunction {
    TransferFunction::new(points.to_vec()).unwrap()
}

proptest! {
    #[test]
    fn constant_extinction_is_exponential(
        log_depth in -30.0_f64..6.0, count in 1_usize..=LANES, color in prop::array::uniform3(0.0_f32..1.0),
    ) {
        let extinction = 0.75_f32;
        let length = (10_f64.powf(log_depth) / f64::from(extinction) / count as f64) as f32;
        let transfer = function(&[point(0.5, color, extinction)]);
        let mut segments = Segments::default();
        for n in 0..count {
            segments.push(&[n as f32, -1.0, 2.5, 7.0, 0.25, 1e5, -3.0, 0.5], [0.0; 3], [1.0, 0.5, 0.25], length);
        }
        let mut seen = Radiance::default();
        Bounded::new(&transfer, 1e-6, 1.0).integrate(&segments, None, &mut seen);
        let alpha = -(-f64::from(extinction) * f64::from(length) * count as f64).exp_m1();
        // To roundings of single precision, until what is left is less than ε.
        let off = |found: f64, exact: f64| (found - exact).abs() <= 16.0 * 0.5 * f64::from(f32::EPSILON) * exact;
        let is_same = |found: f64, exact: f64| {
            if seen.is_done { (found - exact).abs() <= 1e-6 } else { off(found, exact) }
        };
        // Opacities that add up to less than a rounding of 1 are in the colour alone.
        prop_assert!(is_same(seen.alpha(), alpha) || alpha < 1e-8, "{seen:?} {alpha}");
        for n in 0..3 {
            prop_assert!(is_same(seen.color[n], alpha * f64::from(color[n])), "{seen:?} {alpha}");
        }
    }

    #[test]
    fn linear_fields_agree_with_the_oracle_and_with_linear_pieces(
        seed in 0_u64..1 << 40, s0 in -0.25_f32..1.25, s1 in -0.25_f32..1.25, log_length in -3.0_f32..1.0,
    ) {
        let kind = TransferKind::ALL[(seed % 6) as usize];
        let points = common::from_oracle(&kind.generate(seed, [0.0, 1.0]));
        let largest = points.iter().fold(1e-30_f32, |m, p| m.max(p.extinction));
        let transfer = function(&points).with_extinction_scaled(5.0 / largest).unwrap();
        let corners = std::array::from_fn(|c| if c & 1 == 0 { s0 } else { s1 });
        let stretch = common::Stretch {
            corners, entry: [0.0, 0.5, 0.5], exit: [1.0, 0.5, 0.5], length: 10_f32.powf(log_length),
        };
        let stretches = [stretch];
        let pixel = Pixel { points: transfer.points(), epsilon: 1e-6, lighting: None, stretches: &stretches, batch: 16 };
        let exact = pixel.exact();
        let seen = pixel.integrate();
        prop_assert!(pixel.error(&seen) <= 1e-6, "{seen:?} {exact:?} {pixel:?}");
        let piece = LinearPieces::new(&transfer).integrate(s0, s1, stretch.length);
        prop_assert!((f64::from(piece.alpha) - exact.alpha()).abs() <= 1e-6, "{piece:?} {exact:?} {pixel:?}");
        for (found, exact) in piece.color().into_iter().zip(exact.color) {
            prop_assert!((f64::from(found) - exact).abs() <= 1e-6, "{piece:?} {exact} {pixel:?}");
        }
    }
}

/// Pixels of adversarial segments, with several ε, shaded and not.
#[test]
fn errors_are_at_most_epsilon() {
    let mut rng = SplitMix64::new(17);
    let mut translucent = 0;
    for seed in 0..3000_u64 {
        let stretches: Vec<_> = (0..1 + seed % 17)
            .map(|n| common::Stretch::from(&adversarial_stretch(6 * (seed + 40 * n) + seed % 6)))
            .collect();
        let [low, high] = common::range(&stretches[0].corners);
        let points = common::from_oracle(&adversarial_transfer(rng.next_u64(), [low, high]));
        let largest = points.iter().fold(1e-30_f32, |m, p| m.max(p.extinction));
        let depth = 10_f64.powf(rng.range(-2.0, 1.0)) as f32;
        let Ok(transfer) = function(&points).with_extinction_scaled(depth / largest) else { continue };
        let pixel = Pixel {
            points: transfer.points(),
            epsilon: [1e-2, 1.0 / 255.0, 1e-3, 1e-4, 1e-5][rng.below(5) as usize],
            lighting: rng.coin().then(|| lighting(&mut rng, steepest(&stretches))),
            stretches: &stretches,
            batch: 1 + rng.below(16) as usize,
        };
        let seen = pixel.integrate();
        assert!(seen.error <= pixel.epsilon, "{seen:?} {pixel:?}");
        assert!((0.0..=1.0).contains(&seen.alpha()) && seen.color.iter().all(|&c| c >= 0.0), "{seen:?}");
        assert!(pixel.error(&seen) <= pixel.epsilon || pixel.is_undecided(), "{seen:?} {pixel:?}");
        translucent += u32::from((0.01..0.99).contains(&seen.alpha()));
    }
    assert!(translucent > 500, "{translucent}");
}

/// A spike a thousandth of the range wide is seen wherever it is met, and nowhere else.
#[test]
fn spikes_are_not_missed() {
    let mut rng = SplitMix64::new(4);
    let (mut met, mut missed, mut invented) = (0, 0, 0);
    for _ in 0..20_000 {
        let middle = rng.range(0.1, 0.9) as f32;
        let clear = |value| point(value, [1.0; 3], 0.0);
        let points =
            [clear(middle - 0.0005), point(middle, [1.0, 0.5, 0.25], 1000.0), clear(middle + 0.0005)];
        let mut coordinate = |_| rng.unit() as f32;
        let (entry, exit) = (std::array::from_fn(&mut coordinate), std::array::from_fn(&mut coordinate));
        let corners = std::array::from_fn(&mut coordinate);
        let stretches = [common::Stretch { corners, entry, exit, length: 1.0 }];
        let pixel =
            Pixel { points: &points, epsilon: 1e-3, lighting: None, stretches: &stretches, batch: 16 };
        let (seen, exact) = (pixel.integrate().alpha(), pixel.exact().alpha());
        assert!((seen - exact).abs() <= 1e-3, "{seen} {exact} {pixel:?}");
        met += u32::from(exact > 1e-3);
        missed += u32::from(exact > 1e-3 && seen == 0.0);
        invented += u32::from(exact == 0.0 && seen > 0.0);
    }
    assert!(met > 2000, "{met}");
    assert_eq!((missed, invented), (0, 0));
}

/// However segments are put together, a pixel is within ε, and the same twice over.
#[test]
fn batches_make_no_difference_beyond_epsilon() {
    let mut rng = SplitMix64::new(9);
    for seed in 0..300_u64 {
        let stretches: Vec<_> =
            (0..48).map(|n| common::Stretch::from(&adversarial_stretch(6 * (seed * 48 + n) + 5))).collect();
        let [low, high] = common::range(&stretches[0].corners);
        let points = common::from_oracle(&adversarial_transfer(seed, [low, high]));
        let largest = points.iter().fold(1e-30_f32, |m, p| m.max(p.extinction));
        let transfer = function(&points).with_extinction_scaled(0.3 / largest).unwrap();
        let lighting = rng.coin().then(|| lighting(&mut rng, steepest(&stretches)));
        let of = |batch| Pixel {
            points: transfer.points(),
            epsilon: 1e-3,
            lighting,
            stretches: &stretches,
            batch,
        };
        let whole = of(16).integrate();
        assert_eq!(whole, of(16).integrate());
        for batch in [1, 3, 7] {
            let other = of(batch).integrate();
            let difference = (0..3).fold((whole.alpha() - other.alpha()).abs(), |m, n| {
                m.max((whole.color[n] - other.color[n]).abs())
            });
            assert!(difference <= 1e-3, "{batch} {whole:?} {other:?} {:?}", of(batch));
        }
    }
}

/// Inputs on which the bound did not hold at first.
#[test]
fn what_once_was_off() {
    let stretch = |corners, entry, exit, length| common::Stretch { corners, entry, exit, length };
    let holds = |points: &[ControlPoint], epsilon, stretch: common::Stretch| {
        let stretches = [stretch];
        let pixel = Pixel { points, epsilon, lighting: None, stretches: &stretches, batch: 16 };
        let seen = pixel.integrate();
        assert!(pixel.error(&seen) <= epsilon, "{seen:?} {:?} {pixel:?}", pixel.exact());
        assert!(seen.error <= epsilon && seen.pieces < 1000, "{seen:?} {pixel:?}");
    };
    // Cuts beside a double zero left all of the rest uncut.
    holds(
        &[
            point(-9.691784e-31, [0.14517689, 0.029505732, 0.6799136], 0.8733298),
            point(1.1920929e-37, [0.9654888, 0.38813418, 0.399609], 0.0),
        ],
        1e-4,
        stretch(
            [0.16322121, 0.0, 0.9991294, -0.16380161, 0.0, -0.0, -0.0002902022, 0.0],
            [1.0, 0.0, 1.0],
            [0.0, 1.0, 0.0],
            1.0,
        ),
    );
    // So did ties with corners that are units in the last place apart.
    holds(
        &[point(29999.998, [0.98, 0.82, 0.78], 0.1363744), point(30000.0, [0.14, 0.48, 0.27], 0.0)],
        1e-4,
        stretch(
            [29999.998, 30000.002, 30000.002, 30000.002, 29999.998, 29999.998, 30000.0, 30000.0],
            [0.0, 1.0, 1.0],
            [1.0, 0.0, 0.0],
            100.0,
        ),
    );
    // In single precision the value was taken for one two intervals below, where no slope nearby told of any extinction.
    holds(
        &[
            point(-0.18834478, [0.3198422, 0.14456561, 0.7409224], 0.0),
            point(-0.18834476, [0.5769654, 0.5257666, 0.6685267], 0.0),
            point(1.3955392, [0.29380944, 0.25076357, 0.35132593], 0.02662782),
        ],
        1e-2,
        stretch(
            [1e15, -1e15, -1.1542808e-6, -0.27925977, -1e15, 1.7441215e14, 2.9840058e-12, -2.6363932e-19],
            [0.40103853, 0.99999994, 0.014137138],
            [0.40103853, 0.99999994, 0.014137138],
            1.0,
        ),
    );
    // Roots among denormal numbers were not found, and their roundings not counted.
    holds(
        &[point(0.0, [0.94, 0.5, 0.86], 0.00011886259), point(0.0, [0.44, 0.6, 0.59], 0.0063155745)],
        1e-3,
        stretch([1.491e-42, -3e-44, -8.1e-44, -0.0, 1.01e-43, -0.0, -0.0, -0.0], [1.0; 3], [0.0; 3], 100.0),
    );
    holds(
        &[point(0.0, [0.232, 0.853, 0.664], 0.20215315), point(0.0, [0.167, 0.723, 0.934], 0.2773394)],
        1e-3,
        stretch(
            [-2.75e-43, 0.0, 2.7e-44, 7.75e-43, 2.7e-44, -5.02e-43, 1.58e-42, 2.7e-44],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 1.0],
            100.0,
        ),
    );
}

/// A highlight of exponent 1 or little more, whose second derivative is none or grows without bound toward 0, is no reason to cut into
/// pieces without end.
#[test]
fn wide_highlights_converge() {
    let points = [
        point(72.0, [0.08, 0.47, 0.95], 5e-4),
        point(79.0, [0.37, 0.03, 0.58], 2e-3),
        point(179.0, [0.86, 0.97, 0.75], 2e-3),
    ];
    let stretches = [common::Stretch {
        corners: [155.0, 160.0, 130.0, 36.0, 176.0, 117.0, 21.0, 109.0],
        entry: [0.26, 0.0, 0.91],
        exit: [1.0, 0.7, 0.25],
        length: 100.0,
    }];
    for exponent in [1.0, 1.01, 1.5, 2.0, 50.0] {
        let lighting = Some(Lighting {
            ambient: 0.2,
            diffuse: 0.7,
            specular: 0.5,
            exponent,
            light: [0.0106, 0.0061, -0.0137],
            half: [0.012, -0.0105, -0.009],
        });
        let pixel = Pixel { points: &points, epsilon: 1e-5, lighting, stretches: &stretches, batch: 16 };
        let seen = pixel.integrate();
        assert!(pixel.error(&seen) <= 1e-5 && seen.error <= 1e-5, "{seen:?} {:?}", pixel.exact());
        assert!(seen.pieces < 2000, "{exponent}: {} pieces", seen.pieces);
    }
}

/// Masks have plateaus at exactly the value of a step, and rays along an axis run in their faces.
#[test]
fn a_ray_in_the_face_of_a_plateau_sees_the_step() {
    let point = |value: f32, extinction: f32| ControlPoint { value, color: [1.0; 3], extinction };
    for value in [1.0f32, 7.0, 255.0, 1000.3] {
        let step = TransferFunction::new(vec![point(value, 0.0), point(value, 2.0)]).unwrap();
        for upper_face in [false, true] {
            // Inside at one face of z, outside at the other.
            let corners: [f32; 8] = std::array::from_fn(|n| if (n >= 4) == upper_face { value } else { 0.0 });
            for [along, beside] in [[0.0, 0.3], [1.0, 0.7], [0.5, 0.1]] {
                let face = f32::from(u8::from(upper_face));
                let mut segments = Segments::default();
                segments.push(&corners, [0.0, along, face], [1.0, along, face], 0.5);
                // A little inside the cell all is below.
                segments.push(&corners, [0.0, along, beside], [1.0, along, beside], 0.5);
                let mut radiance = Radiance::default();
                Bounded::new(&step, 1e-3, 1.0).integrate(&segments, None, &mut radiance);
                let expected = 1.0 - f64::exp(-1.0);
                assert!((radiance.alpha() - expected).abs() < 1e-6, "{value} {upper_face}: {radiance:?}");
            }
        }
    }
}

/// Variances of values like these have a product below any number of single precision.
#[test]
fn the_bound_holds_for_values_whose_fourth_powers_vanish() {
    let scale = 1e-14_f32;
    let transfer = function(&[point(-scale, [0.2, 0.7, 0.8], 0.012), point(scale, [0.0, 0.2, 0.3], 0.0)]);
    for seed in 0..2000 {
        let mut random = SplitMix64::new(seed);
        let corners = std::array::from_fn(|_| (random.range(-1.0, 1.0) as f32) * scale);
        let [entry, exit] = [(); 2].map(|()| std::array::from_fn(|_| random.unit() as f32));
        let stretch = common::Stretch { corners, entry, exit, length: 30.0 };
        let stretches = [stretch];
        let pixel = Pixel {
            points: transfer.points(),
            epsilon: 1e-2,
            lighting: None,
            stretches: &stretches,
            batch: 16,
        };
        let (found, exact) = (pixel.integrate(), pixel.exact());
        for n in 0..3 {
            let error = (found.color[n] - exact.color[n]).abs();
            assert!(error <= found.error + 1e-9, "seed {seed}: off by {error:e}, bound {:e}", found.error);
        }
    }
}
