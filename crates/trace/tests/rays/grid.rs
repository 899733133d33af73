//! The grid's hits are the octree's, bit for bit, whatever holds the samples and however macrocells are nested.

use std::ops::ControlFlow;

use isoray_build::build;
use isoray_grid::{Branching, BrickSizes, BrickedVolume, DenseVolume, Dims, GridVolume, Samples, Scalar};
use isoray_oracle::{OracleRay, RayKind, adversarial_isovalue, adversarial_lattice};
use isoray_trace::{CountHits, Crossing, GridTracer, Hit, Ray, Trace, Tracer, Work};

/// Bit patterns: NaN and zeros of either sign would else compare wrongly.
fn bits(hit: Option<Hit>) -> Option<Vec<u32>> {
    let numbers = |h: Hit| [&[h.t][..], &h.local, &h.corners].concat();
    hit.map(|h| {
        numbers(h).into_iter().map(f32::to_bits).chain(h.cell).chain([h.is_entering.into()]).collect()
    })
}

fn all_crossings(tracer: &mut impl Trace, ray: &Ray, isovalues: &[f32]) -> Vec<Crossing> {
    let mut found = Vec::new();
    let visit = &mut |crossing: &Crossing| {
        found.push(*crossing);
        ControlFlow::Continue(())
    };
    assert!(tracer.crossings(ray, isovalues, visit, &mut ()).is_continue());
    found
}

/// Compares a grid with the octree on every kind of ray; the number of hits.
fn compare<T: Scalar, S: Samples<Sample = T>>(
    octree: &mut Tracer<'_, T>,
    grid: &GridVolume<S>,
    isovalue: f32,
    seed: u64,
    what: &str,
) -> usize {
    let dims = grid.samples().dims().axes();
    let mut grid = GridTracer::new(grid);
    let mut hits = 0;
    for kind in RayKind::ALL {
        for n in 0..8 {
            let OracleRay { origin, direction, t_min, t_max } = kind.generate(dims, seed * 100 + n);
            let ray = Ray { origin, direction, t_min, t_max };
            let expected = octree.first_hit(&ray, isovalue);
            let found = grid.first_hit(&ray, isovalue);
            assert_eq!(bits(found), bits(expected), "{what}: {kind:?} {n} {dims:?} at {isovalue}: {ray:?}");
            assert_eq!(grid.any_hit(&ray, isovalue), expected.is_some(), "{what}");
            let (mut a, mut b) = (CountHits::default(), CountHits::default());
            octree.trace(&ray, isovalue, &mut a, &mut ());
            grid.trace(&ray, isovalue, &mut b, &mut ());
            assert_eq!(a.0, b.0, "{what}: {kind:?} {n}: all crossings of {ray:?}");
            let isovalues = [isovalue, isovalue + 1.5, isovalue - 20.0];
            assert_eq!(
                all_crossings(octree, &ray, &isovalues),
                all_crossings(&mut grid, &ray, &isovalues),
                "{what}: {ray:?}"
            );
            if let Some(hit) = expected {
                hits += 1;
                let shadow = hit.departing_ray([0.4, -0.3, 0.6], f32::INFINITY, !hit.is_entering);
                let occluded = octree.occluded(&shadow, isovalue, &mut ());
                assert_eq!(grid.occluded(&shadow, isovalue, &mut ()), occluded, "{what}: from {hit:?}");
                assert_eq!(grid.central_gradient(&hit), octree.central_gradient(&hit), "{what}");
                assert_eq!(grid.value(hit.cell, hit.local), octree.value(hit.cell, hit.local), "{what}");
            }
        }
    }
    hits
}

fn check<T: Scalar>(seeds: std::ops::Range<u64>, convert: impl Fn(f32) -> T) {
    let mut hits = 0;
    for seed in seeds {
        let side = |n: u64| 2 + (seed.wrapping_mul(n) % 23) as u32;
        let dims = Dims::new([side(7), side(11), side(13)]).unwrap();
        let samples: Vec<T> = adversarial_lattice(dims.axes(), seed).iter().map(|&s| convert(s)).collect();
        let widened: Vec<f32> = samples.iter().map(|s| s.to_f32()).collect();
        let isovalue = adversarial_isovalue(&widened, seed);
        let mut dense = DenseVolume::new(dims, &samples).unwrap();
        let volume = build(&mut dense, glam::DAffine3::IDENTITY, |_| {}).unwrap();
        let view = volume.view();
        let mut octree = Tracer::new(&view);
        let parts: &[u32] = [&[4, 4, 4][..], &[2, 2], &[3], &[5, 2, 3], &[2, 7]][seed as usize % 5];
        let branching = Branching::new(parts).unwrap();
        let sizes = BrickSizes { brick: 1 + (seed % 5) as u32, macrobrick: 1 + (seed % 3) as u32 };
        let bricked = BrickedVolume::new(&mut dense, sizes).unwrap();
        let of_array = GridVolume::with_branching(dense, &branching);
        let of_bricks = GridVolume::with_branching(&bricked, &branching);
        let of_octree = GridVolume::with_branching(&view, &branching);
        hits += compare(&mut octree, &of_array, isovalue, seed, &format!("array, {parts:?}"));
        hits += compare(&mut octree, &of_bricks, isovalue, seed, &format!("{sizes:?}, {parts:?}"));
        hits += compare(&mut octree, &of_octree, isovalue, seed, &format!("octree data, {parts:?}"));
    }
    println!("{}: {hits} hits", T::TYPE.name());
    assert!(hits > 1000, "only {hits} hits");
}

#[test]
fn the_grid_finds_the_octrees_hits() {
    check(0..40, |s| s);
    check(100..140, |s| s.clamp(0.0, 255.0) as u8);
    check(200..240, |s| (s * 0.5 - 60.0).clamp(-128.0, 127.0) as i8);
    check(300..340, |s| (s * 100.0).clamp(0.0, 65535.0) as u16);
    check(400..440, |s| (s * 100.0 - 50.0).clamp(-32768.0, 32767.0) as i16);
}

#[test]
fn macrocells_without_surface_are_passed_by() {
    // A sheet of samples in a volume of 96³.
    let dims = Dims::new([96; 3]).unwrap();
    let mut samples = vec![0u8; dims.samples()];
    let layer = dims.layer();
    samples[70 * layer..71 * layer].fill(200);
    let grid = GridVolume::new(DenseVolume::new(dims, &samples).unwrap());
    let mut tracer = GridTracer::new(&grid);
    let ray =
        Ray { origin: [30.3, 40.7, -10.0], direction: [0.1, 0.05, 1.0], t_min: 0.0, t_max: f32::INFINITY };
    let mut work = Work::default();
    let mut count = CountHits::default();
    tracer.trace(&ray, 100.0, &mut count, &mut work);
    assert_eq!(count.0, 2);
    // One of edge 64, at most two of 16 and of 4, and the cells in those.
    assert!(work.nodes <= 6 && work.lookups <= 8 * 16, "{work:?}");
    let mut passing = Work::default();
    tracer.trace(&ray, 201.0, &mut count, &mut passing);
    assert_eq!((count.0, passing), (2, Work::default()));
}

/// With an origin so far away that neighbouring planes are crossed at the same `t`, no cell outside the domain is looked at, and rays end.
#[test]
fn rays_from_beyond_precision_end() {
    let dims = Dims::new([9, 12, 7]).unwrap();
    let samples: Vec<i16> = (0..dims.samples() as i16).map(|n| n * 37 % 200 - 100).collect();
    let grid = GridVolume::new(DenseVolume::new(dims, &samples).unwrap());
    let mut tracer = GridTracer::new(&grid);
    let mut met = Work::default();
    for far in [1e6f32, 1e12, 1e16, 1e17, 1e30] {
        for sign in [1.0, -1.0] {
            let diagonal =
                Ray { origin: [-far * sign; 3], direction: [sign; 3], t_min: 0.0, t_max: f32::INFINITY };
            let along = Ray { origin: [-far * sign, 4.5, 3.0], direction: [sign, 0.0, 1e-30], ..diagonal };
            for ray in [diagonal, along, Ray { t_min: f32::NEG_INFINITY, ..along }] {
                tracer.trace(&ray, 0.0, &mut CountHits::default(), &mut met);
            }
        }
    }
    assert!(met.cells > 20, "{met:?}");
}
