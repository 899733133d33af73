//! The reference of the 2006 paper: its sizes, its samples and its hits.

use std::io::Read;
use std::path::Path;

use isoray_benches::knoll2006::PaperOctree;
use isoray_benches::views::View;
use isoray_benches::volumes::{marschner_lobb, turbulence};
use isoray_build::build;
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_trace::{Ray, Tracer};

fn cube(n: u32) -> Dims {
    Dims::new([n; 3]).unwrap()
}

/// Percent of the raw samples.
fn size<T: Scalar>(dims: Dims, samples: &[T]) -> f64 {
    100.0 * PaperOctree::build(dims, samples).bytes() as f64 / size_of_val(samples) as f64
}

fn assert_size(name: &str, found: f64, expected: f64) {
    println!("{name}: {found:.2} % of raw, expected {expected}");
    assert!((found - expected).abs() <= 1.5, "{name}: {found:.2} % of raw, expected {expected}");
}

#[test]
fn generated_volumes_have_the_recorded_sizes() {
    // Caps of every voxel and 36 bytes per 4³, 8³, … samples: 1 + 36/64·8/7.
    assert_size("Marschner-Lobb 256", size(cube(256), &marschner_lobb(256)), 164.0);
    assert_size("turbulence 512", size(cube(512), &turbulence(512)), 28.8);
}

#[test]
fn heptane_has_the_recorded_size() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/volumes/csafe_heptane.nrrd");
    let Ok(file) = std::fs::read(&path) else {
        eprintln!("SKIPPED: no {}: the size of the heptane volume is not checked", path.display());
        return;
    };
    let body = file.windows(2).position(|w| w == b"\n\n").expect("a blank line ends an NRRD header") + 2;
    let mut samples = Vec::new();
    flate2::read::GzDecoder::new(&file[body..]).read_to_end(&mut samples).unwrap();
    assert_size("heptane", size(cube(302), &samples), 38.6);
}

#[test]
fn nothing_is_lost() {
    fn check<T: Scalar>(n: [u32; 3], sample: impl Fn([u32; 3]) -> T) {
        let dims = Dims::new(n).unwrap();
        let points = || {
            let [nx, ny, nz] = n;
            (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
        };
        let samples: Vec<T> = points().map(&sample).collect();
        let tree = PaperOctree::build(dims, &samples);
        for p in points() {
            assert!(tree.sample(p).same_bits(sample(p)), "{dims} {p:?}");
        }
    }
    check([1, 1, 1], |_| 7u8);
    check([5, 3, 2], |[i, j, k]| (i + 7 * j + 31 * k) as u16);
    check([37, 20, 33], |[i, j, k]| if i < 16 && k > 5 { -3 } else { (i * j * k) as i16 });
    check([9, 17, 12], |[i, j, _]| if i < 4 { f32::NAN } else { j as f32 });
}

#[test]
fn generated_samples_are_the_recorded_ones() {
    const POINTS: [[u32; 3]; 5] = [[0, 0, 0], [31, 17, 40], [50, 33, 32], [20, 40, 30], [63, 63, 63]];
    fn check(n: u32, samples: &[u8], sum: u64, expected: [u8; 5]) {
        let found = POINTS.map(|p| samples[cube(n).linear(p)]);
        let off = |(a, b): (u8, u8)| a.abs_diff(b);
        // The last digit of the platform's mathematics library may turn a rounding.
        assert!(
            found.into_iter().zip(expected).all(|pair| off(pair) <= 1),
            "{found:?}, expected {expected:?}"
        );
        let found: u64 = samples.iter().map(|&s| u64::from(s)).sum();
        assert!(found.abs_diff(sum) * 1_000_000 <= sum, "sum {found}, expected {sum}");
    }
    check(64, &marschner_lobb(64), 33_461_088, [213, 60, 105, 110, 9]);
    check(64, &turbulence(64), 32_693_565, [10, 240, 175, 10, 240]);
    check(100, &turbulence(100), 125_375_515, [10, 10, 10, 10, 240]);
}

#[test]
fn hits_agree_with_the_tracer() {
    const ISOVALUE: f32 = 127.5;
    let dims = cube(64);
    let samples = marschner_lobb(64);
    let paper = PaperOctree::build(dims, &samples);
    let volume =
        build(&mut DenseVolume::new(dims, &samples).unwrap(), glam::DAffine3::IDENTITY, |_| {}).unwrap();
    let octree = volume.view();
    let mut tracer = Tracer::new(&octree);
    let view = View::far(dims, 256, 256);
    let (mut agree, mut both, mut close, mut alike) = (0, 0, 0, 0);
    for &direction in &view.directions {
        let ray = Ray { origin: view.origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        let (ours, theirs) =
            (tracer.first_hit(&ray, ISOVALUE), paper.first_hit(view.origin, direction, ISOVALUE));
        let in_array = paper.first_hit_in_array(&samples, view.origin, direction, ISOVALUE);
        assert_eq!(in_array, theirs, "samples from the array");
        agree += usize::from(ours.is_some() == theirs.is_some());
        if let (Some(ours), Some(theirs)) = (ours, theirs) {
            both += 1;
            close += usize::from((ours.t - theirs.t).abs() < 0.1);
            let cosine = |g: [f32; 3]| (0..3).map(|a| g[a] * direction[a]).sum::<f32>().abs();
            let length = |g: [f32; 3]| g.iter().map(|c| c * c).sum::<f32>().sqrt();
            let lambert = cosine(ours.gradient()) / length(ours.gradient());
            alike += usize::from((lambert - theirs.lambert(direction)).abs() < 0.05);
        }
    }
    let rays = view.directions.len();
    println!("{rays} rays: {agree} agree, {both} hit, {close} of them close, {alike} shaded alike");
    assert!(both * 10 > rays, "too few hits to mean anything");
    assert!(agree * 1000 >= rays * 995, "{agree} of {rays} rays agree");
    assert!(close * 100 >= both * 98, "{close} of {both} hits within 0.1 voxel");
    assert!(alike * 100 >= both * 98, "{alike} of {both} hits shaded alike");
}

#[test]
fn a_hit_where_it_must_be() {
    // A ramp along x; the rays run along the axes, two of their components zero of either sign.
    let dims = Dims::new([13, 6, 7]).unwrap();
    let samples: Vec<u8> = (0..13 * 6 * 7).map(|n| (n % 13) as u8).collect();
    let tree = PaperOctree::build(dims, &samples);
    let hit = tree.first_hit([-3.0, 2.5, 3.5], [1.0, 0.0, -0.0], 7.25).unwrap();
    assert!((hit.t - 10.25).abs() < 1e-4, "{hit:?}");
    assert_eq!(hit.gradient, [1.0, 0.0, 0.0]);
    assert_eq!(hit.lambert([1.0, 0.0, 0.0]), 1.0);
    let hit = tree.first_hit([20.0, 2.5, 3.5], [-2.0, -0.0, 0.0], 7.25).unwrap();
    assert!((hit.t - 6.375).abs() < 1e-4, "{hit:?}");
    // Leaving the domain is no hit, whatever the padding holds; nor is passing by.
    assert_eq!(tree.first_hit([7.3, 2.5, -4.0], [0.0, 0.0, 1.0], 7.25), None);
    assert_eq!(tree.first_hit([7.3, 2.5, 3.0], [0.1, 0.0, 1.0], 12.5), None);
    assert_eq!(tree.first_hit([7.3, 9.0, 3.0], [-1.0, 0.0, 0.0], 7.0), None);
    assert_eq!(tree.first_hit([f32::NAN, 2.0, 3.0], [-1.0, 0.0, 0.0], 7.0), None);
}
