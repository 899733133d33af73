//! The bound on samples, what is reported of it, and that nothing depends on how it is read.

use isoray_build::{Isovalues, Loss, LossError, Lossy, LossyError, SurfaceTolerance, build};
use isoray_grid::{Scalar, SlabSource};

use super::common::{dense, for_all_types, lose, octree, samples, size};

fn tolerance(tolerance: f64) -> Loss {
    Loss { tolerance, ..Loss::default() }
}

fn is_bounded<T: Scalar>(seed: u64) {
    let dims = size(seed);
    let before: Vec<T> = samples(dims, seed);
    for bound in [0.0, 1e-300, 1e-3, 0.7, 1.0, 3.9, 40.0, 1e38, f64::MAX] {
        let (after, changes) = lose(dims, &before, &tolerance(bound));
        let (mut changed, mut largest) = (0, 0f64);
        for (&a, &b) in before.iter().zip(&after) {
            assert!(a.is_finite() || a.same_bits(b), "{a:?} became {b:?}");
            assert_eq!(a.is_finite(), b.is_finite());
            if !a.same_bits(b) {
                // A difference beyond the bound is not rounded to less than it: the bound is an f64.
                let change = (f64::from(b.to_f32()) - f64::from(a.to_f32())).abs();
                assert!(change <= bound, "{a:?} became {b:?}, more than {bound} away");
                changed += 1;
                largest = largest.max(change);
            }
        }
        assert_eq!((changes.samples, changes.largest), (changed, largest));
        let [lossless, lossy] = [&before, &after].map(|s| octree(dims, s).file_bytes());
        assert!(lossy <= lossless, "{lossy} bytes instead of {lossless}: {dims:?}, seed {seed}, {bound}");
    }
}

#[test]
fn no_sample_is_off_by_more_than_the_tolerance() {
    for seed in 0..48 {
        for_all_types!(is_bounded(seed));
    }
}

/// Everything at once.
fn losses() -> [Loss; 3] {
    let surface = |displacement, isovalues| Some(SurfaceTolerance { displacement, isovalues });
    [
        tolerance(2.5),
        Loss { range: Some([-3.0, 20.5]), ..Loss::default() },
        Loss {
            tolerance: 9.0,
            range: Some([2.0, 9.0]),
            surface: surface(0.5, Isovalues::List(vec![12.0, 3.5])),
        },
    ]
}

fn is_the_same_however_it_is_read<T: Scalar>(seed: u64) {
    let dims = size(seed);
    let before: Vec<T> = samples(dims, seed);
    let layer = (dims[0] * dims[1]) as usize;
    for loss in losses() {
        let (whole, changes) = lose(dims, &before, &loss);
        let is_whole = |out: &[T]| out.iter().zip(&whole).all(|(a, b)| a.same_bits(*b));
        let mut source = Lossy::new(dense(dims, &before), &loss).unwrap();
        for layers in [1, 3, 8, 9] {
            let mut out = vec![T::default(); before.len()];
            for (first, out) in (0..).step_by(layers).zip(out.chunks_mut(layers * layer)) {
                source.read_layers(first, out).unwrap();
            }
            assert!(is_whole(&out), "{layers} layers at a time, {dims:?}, seed {seed}, {loss:?}");
            assert_eq!(source.changes(), changes);
        }
        // Backwards, which the trait does not ask for.
        let mut last = vec![T::default(); layer];
        for z in (0..dims[2]).rev() {
            source.read_layers(z, &mut last).unwrap();
            assert!(last.iter().zip(&whole[z as usize * layer..]).all(|(a, b)| a.same_bits(*b)));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let (out, same) = pool.install(|| lose(dims, &before, &loss));
        assert!(is_whole(&out) && same == changes, "three threads, {dims:?}, seed {seed}");
    }
}

#[test]
fn what_is_read_does_not_depend_on_how() {
    for seed in 0..24 {
        for_all_types!(is_the_same_however_it_is_read(seed));
    }
}

#[test]
fn smooth_data_become_much_smaller() {
    let dims = [40, 40, 40];
    let before: Vec<u16> =
        (0..64_000).map(|n| 1000 + (n % 40) as u16 * 2 + (n / 1600) as u16 + (n * 7919 % 5) as u16).collect();
    let lossless = octree(dims, &before).file_bytes();
    let mut bytes = vec![lossless];
    for bound in [2.0, 5.0, 12.0, 200.0] {
        let mut source = Lossy::new(dense(dims, &before), &tolerance(bound)).unwrap();
        bytes.push(build(&mut source, glam::DAffine3::IDENTITY, |_| {}).unwrap().file_bytes());
    }
    println!("{bytes:?} bytes");
    assert!(bytes.is_sorted_by(|a, b| a >= b), "{bytes:?}");
    assert!(bytes[3] * 4 < lossless, "{bytes:?}");
    // All 64 thousand samples can be 1024, and so they are: nothing but the header and the root is left.
    assert_eq!(bytes[4], octree(dims, &[1024u16; 64_000]).file_bytes());
}

#[test]
fn what_makes_no_sense_is_refused() {
    let surface = |displacement, isovalues| Loss {
        surface: Some(SurfaceTolerance { displacement, isovalues }),
        ..Loss::default()
    };
    let range = |low, high| Loss { range: Some([low, high]), ..Loss::default() };
    let list = |values: &[f32]| Isovalues::List(values.to_vec());
    let cases = [
        (Loss::default(), "an infinite tolerance: expected a range or a displacement of isosurfaces with it"),
        (tolerance(-1.0), "tolerance -1: expected a number that is not negative"),
        (tolerance(f64::NAN), "tolerance NaN: expected a number that is not negative"),
        (range(2.0, 1.0), "range 2 to 1: expected two numbers in ascending order"),
        (range(f64::NAN, 1.0), "range NaN to 1: expected two numbers in ascending order"),
        (
            surface(0.1, list(&[])),
            "isosurfaces with bounded displacement: expected at least one isovalue, found none",
        ),
        (surface(0.1, list(&[1.0, f32::INFINITY])), "isovalue inf: expected a finite number"),
        (
            surface(0.1, Isovalues::Range([1.0, -1.0])),
            "range 1 to -1: expected two numbers in ascending order",
        ),
        (
            surface(-0.1, list(&[1.0])),
            "displacement of isosurfaces -0.1: expected a finite number of voxels that is not negative",
        ),
    ];
    let before = [0u8; 8];
    for (loss, message) in cases {
        let error: LossError = Lossy::new(dense([2; 3], &before), &loss).unwrap_err();
        assert_eq!(error.to_string(), message);
    }
    let mut source = Lossy::new(dense([2; 3], &before), &tolerance(1.0)).unwrap();
    for (first, samples) in [(0, 3), (1, 8), (2, 4), (u32::MAX, 4)] {
        let error = source.read_layers(first, &mut vec![0; samples]).unwrap_err();
        assert!(matches!(error, LossyError::Layers { .. }), "{error}");
    }
}
