//! Every field: the same samples however they are asked for; and each against its formula.

use std::f64::consts::PI;

use isoray_grid::{Dims, SlabSource};
use isoray_synth::{LayersError, MarschnerLobb, Mixing, MixingParams, Noise, Ramp, Sample, Sphere};

fn dims(size: [u32; 3]) -> Dims {
    Dims::new(size).unwrap()
}

fn all<T: Sample>(mut source: impl SlabSource<T, Error = LayersError>) -> Vec<T> {
    let mut samples = vec![T::default(); source.dims().samples()];
    source.read_layers(0, &mut samples).unwrap();
    samples
}

fn mixing(size: [u32; 3], seed: u64) -> Mixing {
    Mixing::new(dims(size), MixingParams { seed, time: 1.0 }).unwrap()
}

fn ramp(size: [u32; 3], direction: [f64; 3]) -> Ramp {
    Ramp::new(dims(size), direction).unwrap()
}

/// A checksum of samples that a change of any of them changes.
fn sum<T: Sample>(samples: &[T]) -> u64 {
    samples.iter().fold(0, |sum: u64, s| {
        sum.wrapping_add(u64::from(s.to_f32().to_bits())).wrapping_mul(0x9e37_79b9_7f4a_7c15)
    })
}

/// Layers one by one and backwards, in slabs of odd size, and on one thread or two.
fn is_the_same_however_it_is_read<T: Sample, S>(source: &S)
where
    S: SlabSource<T, Error = LayersError> + Clone + Sync,
{
    let expected = sum(&all(source.clone()));
    let layer = source.dims().layer();
    let layers = source.dims().axes()[2];
    let mut samples = vec![T::default(); source.dims().samples()];
    let mut one_by_one = source.clone();
    for k in (0..layers).rev() {
        let at = k as usize * layer;
        one_by_one.read_layers(k, &mut samples[at..at + layer]).unwrap();
    }
    assert_eq!(sum(&samples), expected);
    let mut slabs = source.clone();
    for (n, slab) in samples.chunks_mut(7 * layer).enumerate() {
        slabs.read_layers(7 * n as u32, slab).unwrap();
    }
    assert_eq!(sum(&samples), expected);
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(sum(&pool.install(|| all(source.clone()))), expected);
    }
}

#[test]
fn samples_do_not_depend_on_slabs_or_threads() {
    for size in [[33, 20, 50], [64, 64, 64], [1, 1, 1], [5, 1, 2], [300, 2, 9]] {
        for_each_type::<u8>(size);
        for_each_type::<u16>(size);
        for_each_type::<f32>(size);
    }
}

fn for_each_type<T: Sample>(size: [u32; 3]) {
    is_the_same_however_it_is_read::<T, _>(&mixing(size, 1));
    is_the_same_however_it_is_read::<T, _>(&MarschnerLobb::new(dims(size)));
    is_the_same_however_it_is_read::<T, _>(&Sphere::new(dims(size)));
    is_the_same_however_it_is_read::<T, _>(&ramp(size, Ramp::DIRECTION));
    is_the_same_however_it_is_read::<T, _>(&Noise::new(dims(size), 1));
}

#[test]
fn seeds_differ() {
    const SIZE: [u32; 3] = [24, 24, 24];
    let sums = |seed| [sum(&all::<u8>(mixing(SIZE, seed))), sum(&all::<u8>(Noise::new(dims(SIZE), seed)))];
    let [a, b, c] = [0, 1, u64::MAX].map(sums);
    for field in 0..2 {
        assert!(a[field] != b[field] && a[field] != c[field] && b[field] != c[field]);
    }
}

/// On every machine the same: whoever changes a field changes these, and says so.
#[test]
fn samples_stay_what_they_are() {
    const SIZE: [u32; 3] = [40, 24, 48];
    let sums = [
        sum(&all::<f32>(mixing(SIZE, 1))),
        sum(&all::<f32>(MarschnerLobb::new(dims(SIZE)))),
        sum(&all::<f32>(Sphere::new(dims(SIZE)))),
        sum(&all::<f32>(Noise::new(dims(SIZE), 1))),
    ];
    assert_eq!(sums, [13892339108710802676, 2516974104415354692, 16791677231075875968, 15956436160256220880]);
}

#[test]
fn layers_that_are_not_there_are_refused() {
    let refused = |first, samples: usize| {
        let size = [4, 3, 2];
        let mut out = vec![9u8; samples];
        let errors = [
            mixing(size, 0).read_layers(first, &mut out).unwrap_err(),
            MarschnerLobb::new(dims(size)).read_layers(first, &mut out).unwrap_err(),
            Sphere::new(dims(size)).read_layers(first, &mut out).unwrap_err(),
            ramp(size, [1.0; 3]).read_layers(first, &mut out).unwrap_err(),
            Noise::new(dims(size), 0).read_layers(first, &mut out).unwrap_err(),
        ];
        assert!(errors.iter().all(|e| *e == LayersError { dims: dims(size), first, samples }));
        assert!(out.iter().all(|&sample| sample == 9));
    };
    refused(0, 36);
    refused(1, 24);
    refused(3, 12);
    refused(u32::MAX, 12);
    refused(0, 13);
    // None are there, always.
    mixing([4, 3, 2], 0).read_layers(2, &mut [0u8; 0]).unwrap();
}

#[test]
fn marschner_lobb_is_the_formula() {
    let size = [41, 30, 23];
    let field = MarschnerLobb::new(dims(size));
    let (bytes, words) = (all::<u8>(field.clone()), all::<u16>(field.clone()));
    let position = |axis: usize, i: u32| 2.0 * f64::from(i) / f64::from(size[axis] - 1) - 1.0;
    for (at, (&byte, &word)) in bytes.iter().zip(&words).enumerate() {
        let at = at as u32;
        let p = [at % size[0], at / size[0] % size[1], at / (size[0] * size[1])];
        let [x, y, z] = std::array::from_fn(|axis| position(axis, p[axis]));
        let rings = (12.0 * PI * (PI * x.hypot(y) / 2.0).cos()).cos();
        let expected = (1.0 - (PI * z / 2.0).sin() + 0.25 * (1.0 + rings)) / 2.5;
        assert!((field.value(p) - expected).abs() < 1e-13, "{p:?}");
        assert!((f64::from(byte) - 255.0 * expected).abs() < 0.5 + 1e-9, "{p:?}");
        assert!((f64::from(word) - 65535.0 * expected).abs() < 0.5 + 1e-8, "{p:?}");
    }
}

#[test]
fn ramps_are_linear() {
    let size = [30, 20, 10];
    // Exact: 29 + 38 + 27 = 94 has room in a byte.
    for (direction, corner) in [([1.0, 2.0, 3.0], [0, 0, 0]), ([-1.0, 2.0, -3.0], [29, 0, 9])] {
        let [bytes, words] = [
            all::<u8>(ramp(size, direction)).iter().map(|&s| f64::from(s)).collect::<Vec<_>>(),
            all::<u16>(ramp(size, direction)).iter().map(|&s| f64::from(s)).collect(),
        ];
        let floats = all::<f32>(ramp(size, direction));
        for at in 0..6000usize {
            let p = [at % 30, at / 30 % 20, at / 600];
            let steps = |axis: usize| p[axis].abs_diff(corner[axis]) as f64;
            let expected = steps(0) + 2.0 * steps(1) + 3.0 * steps(2);
            assert_eq!([bytes[at], words[at], f64::from(floats[at])], [expected; 3], "{p:?}");
        }
    }
    // Scaled: 5 times as steep does not fit; half as steep is not whole.
    for direction in [[5.0, 10.0, 15.0], [0.5, 1.0, 1.5]] {
        let field = ramp(size, direction);
        let bytes = all::<u8>(field.clone());
        let span = field.value([29, 19, 9]);
        for (at, &byte) in bytes.iter().enumerate() {
            let value = field.value([at as u32 % 30, at as u32 / 30 % 20, at as u32 / 600]);
            assert!((f64::from(byte) - 255.0 * value / span).abs() < 0.5 + 1e-9);
        }
        assert_eq!((bytes[0], bytes[5999]), (0, 255));
    }
    assert!(all::<u16>(ramp([1; 3], [0.5; 3])) == [0]);
}

#[test]
fn directions_that_are_none_are_refused() {
    for direction in [[0.0; 3], [f64::NAN, 0.0, 1.0], [0.0, f64::INFINITY, 0.0], [1e38, 1e38, 1e38]] {
        let error = Ramp::new(dims([9; 3]), direction).unwrap_err();
        assert!(error.to_string().contains("not all zero"), "{error}");
    }
}

#[test]
fn spheres_are_distances() {
    let size = [21, 31, 41];
    let field = Sphere::new(dims(size));
    assert_eq!(field.radius(), 8.0);
    let (bytes, floats) = (all::<u8>(field.clone()), all::<f32>(field.clone()));
    let at = |p: [usize; 3]| (p[2] * 31 + p[1]) * 21 + p[0];
    assert_eq!(
        [floats[at([10, 15, 20])], floats[at([13, 15, 24])], floats[at([10, 15, 31])]],
        [8.0, 3.0, -3.0]
    );
    let farthest = (100.0f64 + 225.0 + 400.0).sqrt() - 8.0;
    assert_eq!(bytes[0], 0);
    for (byte, float) in bytes.iter().zip(&floats) {
        let expected = 127.5 * (1.0 + f64::from(*float) / farthest);
        assert!((f64::from(*byte) - expected).abs() < 0.5 + 1e-4);
    }
    assert_eq!(
        (all::<u16>(Sphere::new(dims([1; 3]))), all::<f32>(Sphere::new(dims([1; 3])))),
        (vec![32768], vec![0.0])
    );
}

#[test]
fn noise_is_uniform() {
    let size = [64, 32, 32];
    let bytes = all::<u8>(Noise::new(dims(size), 2));
    let mut counts = [0u32; 256];
    bytes.iter().for_each(|&byte| counts[usize::from(byte)] += 1);
    // χ² of 255 degrees of freedom has deviation √510: six of them about the mean.
    let expected = bytes.len() as f64 / 256.0;
    let chi: f64 = counts.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
    assert!((chi - 255.0).abs() < 6.0 * 510f64.sqrt(), "{chi}");
    // Neighbours along each axis are uncorrelated: the mean of n products of unit variance deviates by 1/√n.
    for step in [1, 64, 64 * 32] {
        let unit = |byte: u8| (f64::from(byte) - 127.5) / 73.9;
        let mean = bytes.iter().zip(&bytes[step..]).map(|(&a, &b)| unit(a) * unit(b)).sum::<f64>()
            / (bytes.len() - step) as f64;
        assert!(mean.abs() < 6.0 / (bytes.len() as f64).sqrt(), "step {step}: {mean}");
    }
    let floats = all::<f32>(Noise::new(dims(size), 2));
    assert!(floats.iter().all(|&s| (0.0..255.0).contains(&s)));
}
