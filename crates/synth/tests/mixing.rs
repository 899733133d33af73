//! What the mixing layer looks like, in numbers.

use isoray_grid::{Dims, SlabSource};
use isoray_synth::{Mixing, MixingParams, Sample, TimeError};

fn volume<T: Sample>(size: [u32; 3], seed: u64, time: f64) -> Vec<T> {
    let dims = Dims::new(size).unwrap();
    let mut samples = vec![T::default(); dims.samples()];
    Mixing::new(dims, MixingParams { seed, time }).unwrap().read_layers(0, &mut samples).unwrap();
    samples
}

/// Share of vertical lines on which the value passes 125 at least three times.
fn overturned(samples: &[u8], size: [u32; 3]) -> f64 {
    let layer = (size[0] * size[1]) as usize;
    let crossings = |line: usize| {
        let sides: Vec<bool> = samples[line..].iter().step_by(layer).map(|&s| s >= 125).collect();
        sides.windows(2).filter(|pair| pair[0] != pair[1]).count()
    };
    (0..layer).filter(|&line| crossings(line) >= 3).count() as f64 / layer as f64
}

/// Share of samples that are one of the fluids.
fn constant(samples: &[u8]) -> f64 {
    samples.iter().filter(|&&s| s == 10 || s == 240).count() as f64 / samples.len() as f64
}

const SIZE: [u32; 3] = [128; 3];

#[test]
fn layers_overturn_with_time() {
    let shares = [0.0, 0.25, 0.5, 0.75, 1.0].map(|time| overturned(&volume(SIZE, 1, time), SIZE));
    assert_eq!(shares[0], 0.0, "waves do not fold");
    assert!(shares.is_sorted(), "{shares:?}");
    assert!(shares[4] > 0.3, "{shares:?}");
}

#[test]
fn the_layer_grows_with_time_and_leaves_most_constant() {
    for seed in [1, 2] {
        let shares = [1.0, 0.8, 0.6, 0.4, 0.2, 0.0].map(|time| constant(&volume(SIZE, seed, time)));
        assert!(shares.is_sorted(), "{shares:?}");
        assert!(shares[0] > 0.65 && shares[0] < 0.85, "{shares:?}");
        assert!(shares[5] > 0.95, "{shares:?}");
    }
}

#[test]
fn half_is_of_each_fluid_and_all_values_are_between_them() {
    let samples = volume::<u8>(SIZE, 4, 1.0);
    let mean = samples.iter().map(|&s| f64::from(s)).sum::<f64>() / samples.len() as f64;
    assert!((mean - 125.0).abs() < 8.0, "{mean}");
    assert_eq!((samples.iter().min(), samples.iter().max()), (Some(&10), Some(&240)));
    assert!((10..=240).all(|value| samples.contains(&value)));
}

#[test]
fn volumes_of_different_size_look_alike() {
    let [small, large] = [96, 192].map(|n| {
        let samples = volume::<u8>([n; 3], 5, 1.0);
        (constant(&samples), overturned(&samples, [n; 3]))
    });
    assert!((small.0 - large.0).abs() < 0.03, "{small:?} {large:?}");
    assert!((small.1 - large.1).abs() < 0.2, "{small:?} {large:?}");
}

#[test]
fn detail_goes_down_to_two_voxels() {
    // In the middle, neighbours differ often, and in both directions in turn.
    let samples = volume::<f32>([128, 128, 128], 6, 1.0);
    let rows = samples[64 * 128 * 128..65 * 128 * 128].chunks(128);
    let turns = |row: &[f32]| row.windows(3).filter(|w| (w[1] - w[0]) * (w[2] - w[1]) < 0.0).count();
    let mixed = |row: &[f32]| row.windows(3).filter(|w| w.iter().all(|&s| s > 10.0 && s < 240.0)).count();
    let [turns, mixed] = rows.fold([0, 0], |sum, row| [sum[0] + turns(row), sum[1] + mixed(row)]);
    assert!(mixed > 3000 && turns * 6 > mixed, "{turns} of {mixed}");
}

#[test]
fn types_are_roundings_of_one_field() {
    let size = [40, 30, 50];
    let [bytes, words, floats] = [
        volume::<u8>(size, 8, 0.9).iter().map(|&s| f64::from(s)).collect::<Vec<_>>(),
        volume::<u16>(size, 8, 0.9).iter().map(|&s| f64::from(s) / 257.0).collect(),
        volume::<f32>(size, 8, 0.9).iter().map(|&s| f64::from(s)).collect(),
    ];
    for ((byte, word), float) in bytes.iter().zip(&words).zip(&floats) {
        assert!((byte - float).abs() <= 0.5, "{byte} {float}");
        // Half a step, and some roundings of float arithmetic.
        assert!((word - float).abs() <= 0.501 / 257.0 + 1e-4, "{word} {float}");
    }
}

#[test]
fn times_outside_the_mixing_are_refused() {
    let dims = Dims::new([4; 3]).unwrap();
    for time in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        let error = Mixing::new(dims, MixingParams { seed: 0, time }).unwrap_err();
        assert!(matches!(error, TimeError(_)) && error.to_string().contains("from 0 to 1"), "{error}");
    }
}
