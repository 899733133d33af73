//! The family of first-root finders, in scalars and in lanes.

use isoray_cell::root::{
    BernsteinItp, BernsteinNewton, BernsteinSeries, FirstRoot, HermiteNewton, Neubauer, Root, Schwarze,
    SplitNewton, crossings,
};
use isoray_cell::{
    Cubic, EXCURSION_UNITS, Mask, Real, Segment, central_gradients, corner_gradients, gradient, relative,
    stencil_gradient,
};
use isoray_oracle::SplitMix64;
use wide::{f32x4, f32x8, f32x16};

use crate::cases::{U, cell, segment};

const CASES: usize = 20_000;

fn cases(seed: u64, count: usize) -> Vec<([f32; 8], Segment)> {
    let mut rng = SplitMix64::new(seed);
    (0..count as u64).map(|n| (cell(&mut rng, n).corners, segment(&mut rng))).collect()
}

/// The cases of one packlet in lanes.
fn gather<R: Real<Scalar = f32>>(cases: &[([f32; 8], Segment)]) -> ([R; 8], Segment<R>) {
    let (entry, exit) = (R::gather(|n| cases[n].1.entry), R::gather(|n| cases[n].1.exit));
    (R::gather(|n| cases[n].0), Segment { entry, exit })
}

fn agree_in_lanes<F: FirstRoot, R: Real<Scalar = f32>>() {
    let mut roots = 0;
    for cases in cases(11, CASES).chunks_exact(R::LANES) {
        let (corners, lanes) = gather::<R>(cases);
        let Root { s, found } = F::first_root(&corners, &lanes);
        for (n, (corners, segment)) in cases.iter().enumerate() {
            let lane = (found.bits() >> n & 1 == 1).then(|| s.lane(n).to_bits());
            let alone = F::first_root(corners, segment).get().map(f32::to_bits);
            assert_eq!(lane, alone, "{}, {} lanes: {corners:?} on {segment:?}", F::NAME, R::LANES);
            roots += usize::from(alone.is_some());
        }
    }
    assert!(roots > CASES / 10, "{}: only {roots} roots", F::NAME);
}

fn agree<F: FirstRoot>() {
    agree_in_lanes::<F, f32x4>();
    agree_in_lanes::<F, f32x8>();
    agree_in_lanes::<F, f32x16>();
}

#[test]
fn lanes_agree_with_scalars_bit_for_bit() {
    agree::<BernsteinSeries>();
    agree::<BernsteinNewton>();
    agree::<BernsteinItp>();
    agree::<HermiteNewton>();
    agree::<SplitNewton>();
    agree::<Neubauer>();
    agree::<Schwarze>();
}

/// Each method in double precision finds what the default finds, where that is not decided by rounding.
fn agree_in_double<F: FirstRoot>(tolerance: f64, least_share: f64) {
    let (mut roots, mut right) = (0, 0);
    let mut rng = SplitMix64::new(12);
    for _ in 0..CASES {
        let mut values = |low| std::array::from_fn(|_| rng.range(low, 1.0) as f32);
        let (corners, entry): ([f32; 8], [f32; 8]) = (values(-1.0), values(0.0));
        let segment = Segment { entry: [entry[0], entry[1], entry[2]], exit: [entry[3], entry[4], entry[5]] };
        let [entry, exit] = [segment.entry, segment.exit].map(|p| p.map(f64::from));
        let wide = Segment { entry, exit };
        let corners = corners.map(f64::from);
        let exact = Cubic::along(&corners, &wide);
        let Some(root) = exact.first_root().get() else { continue };
        // Graze not: a root at which the slope is large.
        let magnitude = corners.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        let slope = (exact.at((root + 1e-4).min(1.0)) - exact.at((root - 1e-4).max(0.0))).abs() / 2e-4;
        if slope < 1e-2 * magnitude || !(0.001..0.999).contains(&root) {
            continue;
        }
        roots += 1;
        let found = F::first_root(&corners, &wide).get();
        right += usize::from(found.is_some_and(|s| (s - root).abs() <= tolerance));
    }
    let share = right as f64 / roots as f64;
    assert!(roots > CASES / 20 && share >= least_share, "{}: {right} of {roots}", F::NAME);
}

#[test]
fn methods_agree_in_double_precision() {
    agree_in_double::<BernsteinNewton>(1e-13, 1.0);
    agree_in_double::<BernsteinItp>(1e-13, 1.0);
    agree_in_double::<HermiteNewton>(1e-12, 1.0);
    agree_in_double::<SplitNewton>(1e-10, 1.0);
    agree_in_double::<Schwarze>(1e-6, 0.99);
    // Three interpolations, by design.
    agree_in_double::<Neubauer>(0.15, 0.99);
}

#[test]
fn gradients_agree_in_lanes() {
    let mut rng = SplitMix64::new(13);
    for cases in cases(13, 4000).chunks_exact(8) {
        let (corners, lanes) = gather::<f32x8>(cases);
        let s = rng.unit() as f32;
        let g = gradient(&corners, lanes.at(f32x8::splat(s)));
        for (n, (corners, segment)) in cases.iter().enumerate() {
            let alone = gradient(corners, segment.at(s));
            assert_eq!(g.map(|g| g.to_array()[n].to_bits()), alone.map(f32::to_bits));
        }
    }
}

#[test]
fn stencil_gradients_agree_in_lanes_and_are_exact_on_quadratics() {
    let mut rng = SplitMix64::new(16);
    for _ in 0..2000 {
        let stencils: [[f32; 64]; 8] =
            std::array::from_fn(|_| std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32));
        // Samples 1 and 2 along each axis, the cell's corners, always exist.
        let is_corner = |n: usize| (0..3).all(|a| matches!(n / 4_usize.pow(a) % 4, 1 | 2));
        let exists: [[bool; 64]; 8] =
            std::array::from_fn(|_| std::array::from_fn(|n| is_corner(n) || rng.below(4) > 0));
        let p: [f32; 3] = std::array::from_fn(|_| rng.unit() as f32);
        let lanes = f32x8::gather(|lane| stencils[lane]);
        let masks = std::array::from_fn(|n| {
            f32x8::from_lanes(|lane| if exists[lane][n] { 1.0 } else { -1.0 }).gt(Real::splat(0.0))
        });
        let found = stencil_gradient(&lanes, &masks, p.map(f32x8::splat));
        for lane in 0..8 {
            let alone = stencil_gradient(&stencils[lane], &exists[lane], p);
            assert_eq!(found.map(|g| g.to_array()[lane].to_bits()), alone.map(f32::to_bits));
        }
        assert_eq!(central_gradients(&stencils[0]), corner_gradients(&stencils[0], &[true; 64]));
    }
    // s = x² + y·z, sampled at −1, 0, 1, 2: central differences are exact, and so is their interpolation.
    let samples = std::array::from_fn(|n| {
        let [x, y, z] = [n % 4, n / 4 % 4, n / 16].map(|c| c as f32 - 1.0);
        x * x + y * z
    });
    assert_eq!(stencil_gradient(&samples, &[true; 64], [0.25, 0.5, 0.75]), [0.5, 0.75, 0.5]);
}

#[test]
fn all_roots_alternate_and_begin_with_the_first() {
    let mut of_count = [0; 4];
    for (corners, segment) in cases(14, 4 * CASES) {
        let cubic = Cubic::along(&corners, &segment);
        let roots = cubic.roots();
        assert_eq!(roots.first().copied(), cubic.first_root().get());
        assert!(roots.is_sorted(), "{roots:?}");
        let is_odd = cubic.starts_inside() != cubic.ends_inside();
        assert_eq!(roots.len() % 2 == 1, is_odd, "{roots:?} of {cubic:?}");
        // Between two crossings that are apart, the field is on the other side.
        for (n, pair) in roots.windows(2).enumerate().filter(|(_, pair)| pair[1] - pair[0] > 1e-3) {
            let middle = cubic.at(0.5 * (pair[0] + pair[1]));
            let largest = corners.iter().fold(0.0, |m: f32, c| m.max(c.abs()));
            if f64::from(middle.abs()) <= f64::from(EXCURSION_UNITS) * U * f64::from(largest) {
                continue;
            }
            assert_eq!(middle >= 0.0, cubic.starts_inside() == (n % 2 == 1), "{roots:?} of {cubic:?}");
        }
        of_count[roots.len()] += 1;
    }
    assert!(of_count.iter().all(|&n| n > 20), "{of_count:?}");
}

#[test]
fn crossings_of_several_isovalues_are_in_order() {
    let mut rng = SplitMix64::new(15);
    let mut into = Vec::new();
    let mut total = 0;
    for _ in 0..CASES {
        let samples: [f32; 8] = std::array::from_fn(|_| rng.range(0.0, 255.0).round() as f32);
        let segment = segment(&mut rng);
        let isovalues: [f32; 4] = std::array::from_fn(|_| rng.range(0.0, 255.0).round() as f32);
        crossings(&samples, &isovalues, &segment, &mut into);
        total += into.len();
        assert!(into.is_sorted_by(|a, b| a.s <= b.s));
        for (surface, &isovalue) in isovalues.iter().enumerate() {
            let alone = Cubic::along(&relative(&samples, isovalue), &segment);
            let mine: Vec<_> = into.iter().filter(|c| c.surface == surface).collect();
            assert_eq!(mine.iter().map(|c| c.s).collect::<Vec<_>>(), alone.roots().to_vec());
            let first = mine.first().map(|c| c.is_entering);
            assert!(first.is_none_or(|entering| entering != alone.starts_inside()));
            assert!(mine.windows(2).all(|pair| pair[0].is_entering != pair[1].is_entering));
        }
    }
    assert!(total > CASES / 2, "only {total}");
}

#[test]
fn what_is_no_cell_has_no_crossing() {
    let segment = Segment { entry: [0.0; 3], exit: [1.0; 3] };
    let nowhere = Segment { entry: [0.5; 3], exit: [0.5; 3] };
    let corners = [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];
    assert_eq!(BernsteinSeries::first_root(&[f32::NAN; 8], &segment).get(), None);
    assert_eq!(BernsteinSeries::first_root(&[f32::INFINITY; 8], &segment).get(), None);
    assert_eq!(BernsteinSeries::first_root(&corners, &nowhere).get(), None);
    for n in 0..8 {
        let mut broken: [f32; 8] = corners;
        broken[n] = f32::NAN;
        assert_eq!(BernsteinSeries::first_root(&broken, &segment).get(), None);
    }
    let nan = Segment { entry: [f32::NAN, 0.0, 0.0], exit: [1.0; 3] };
    assert_eq!(BernsteinSeries::first_root(&corners, &nan).get(), None);
}
