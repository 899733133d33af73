//! The volume rendering integral against closed forms and against brute force.

use isoray_oracle::{
    DenseLattice, Lattice, LatticeKind, OracleRadiance, OracleRay, OracleShading, OracleStretch, RayKind,
    SplitMix64, StretchKind, TransferKind, TransferPoint, TransferPoints, adversarial_stretch,
    adversarial_transfer, integrate_ray, integrate_stretch,
};

fn point(value: f64, extinction: f64) -> TransferPoint {
    TransferPoint { value, color: [1.0, 0.5, 0.25], extinction }
}

/// A field that goes from `a` to `b` along x.
fn ramp(a: f64, b: f64, length: f64) -> OracleStretch {
    let corners = std::array::from_fn(|c| if c & 1 == 0 { a } else { b });
    OracleStretch { corners, entry: [0.0, 0.25, 0.75], exit: [1.0, 0.25, 0.75], length }
}

fn range(corners: &[f64]) -> [f32; 2] {
    let finite = || corners.iter().copied().filter(|s| s.is_finite());
    [finite().fold(f64::INFINITY, f64::min) as f32, finite().fold(f64::NEG_INFINITY, f64::max) as f32]
}

fn worst(a: &OracleRadiance, b: &OracleRadiance) -> f64 {
    (0..3).fold((a.alpha() - b.alpha()).abs(), |m, n| m.max((a.color[n] - b.color[n]).abs()))
}

fn random_shading(rng: &mut SplitMix64, scale: f64) -> OracleShading {
    const EXPONENTS: [f64; 6] = [0.0, 0.5, 1.0, 3.7, 32.0, 100.0];
    let mut direction = || std::array::from_fn(|_| rng.range(-1.0, 1.0) / scale);
    let (light, half) = (direction(), direction());
    OracleShading {
        ambient: 0.25,
        diffuse: 0.5,
        specular: 0.25,
        exponent: EXPONENTS[rng.below(6) as usize],
        light,
        half,
    }
}

#[test]
fn constant_extinction_is_beers_law() {
    for sigma in [1e-30, 1e-12, 1e-3, 0.5, 1.0, 1.5, 40.0, 1e6] {
        for length in [1e-6, 1.0, 3.0, 100.0] {
            let seen =
                integrate_stretch(&ramp(2.0, 5.0, length), &TransferPoints(vec![point(0.0, sigma)]), None);
            let (depth, alpha) = (sigma * length, -(-sigma * length).exp_m1());
            assert!((seen.optical_depth - depth).abs() <= 1e-15 * depth);
            assert!((seen.alpha() - alpha).abs() <= 1e-14 * alpha);
            for n in 0..3 {
                let color = alpha * [1.0, 0.5, 0.25][n];
                assert!((seen.color[n] - color).abs() <= 1e-13 * color, "{sigma} {length}: {seen:?}");
            }
        }
    }
}

/// Extinction k·s and colour s along a ramp from 0 to 1: `∫ k·t²·L·e^(−k·L·t²/2) dt = −e^(−D) + ∫ e^(−D·t²) dt`, with `D = k·L/2`.
#[test]
fn linear_extinction_along_a_ramp() {
    for k in [1e-20, 1e-3, 1.0, 7.0, 300.0, 1e6] {
        let ends = [(0.0, 0.0), (1.0, k)];
        let transfer = TransferPoints(
            ends.map(|(value, extinction)| TransferPoint { value, color: [value; 3], extinction }).to_vec(),
        );
        let (up, down) = (ramp(0.0, 1.0, 2.0), ramp(1.0, 0.0, 2.0));
        let seen = integrate_stretch(&up, &transfer, None);
        assert!((seen.optical_depth - k).abs() <= 1e-14 * k);
        assert!((integrate_stretch(&down, &transfer, None).optical_depth - k).abs() <= 1e-14 * k);
        // The series of the error function's integral, or its asymptote.
        let exact = if k <= 10.0 {
            let term = |n: i32| (1..=n).fold(1.0, |t, m| -t * k / f64::from(m));
            (1..80).map(|n| term(n) * (1.0 / f64::from(2 * n + 1) - 1.0)).sum()
        } else {
            0.5 * (std::f64::consts::PI / k).sqrt()
        };
        assert!((seen.color[0] - exact).abs() <= 1e-13 + 1e-13 * exact, "{k}: {} {exact}", seen.color[0]);
        if k < 1e-10 {
            assert!((seen.color[0] - 2.0 / 3.0 * k).abs() <= 1e-13 * k, "{:e}", seen.color[0]);
        }
    }
}

#[test]
fn the_later_point_of_a_step_holds_at_and_above_it() {
    let step = TransferPoints(vec![point(3.0, 1.0), point(3.0, 2.0)]);
    let depth = |a: f64, b: f64| integrate_stretch(&ramp(a, b, 1.0), &step, None).optical_depth;
    assert_eq!(step.at(3.0).extinction, 2.0);
    assert_eq!(step.at(3.0_f64.next_down()).extinction, 1.0);
    assert_eq!(step.at(9.0).value, 9.0);
    assert_eq!(TransferPoints(Vec::new()).at(1.0), TransferPoint { value: 1.0, ..Default::default() });
    assert_eq!(depth(3.0, 3.0), 2.0);
    assert_eq!(depth(2.0, 3.0), 1.0);
    assert_eq!(depth(3.0, 2.0), 1.0);
    assert_eq!(depth(3.0, 4.0), 2.0);
    assert_eq!(depth(2.0, 4.0), 1.5);
    assert!((depth(2.0, 5.0) - 5.0 / 3.0).abs() < 1e-15);
    // A ray in a plane at exactly the step's value.
    let along = OracleStretch { entry: [0.5, 0.0, 0.3], exit: [0.5, 1.0, 0.9], ..ramp(2.0, 4.0, 1.0) };
    assert_eq!(integrate_stretch(&along, &step, None).optical_depth, 2.0);
    // As exact where products of coordinates are not.
    let third = f64::from(1.0_f32 / 3.0);
    let step = TransferPoints(vec![point(third, 0.0), point(third, 1e6)]);
    let along = OracleStretch { entry: [third, 0.0, 0.1], exit: [third, 1.0, 0.9], ..ramp(0.0, 1.0, 1.0) };
    assert_eq!(integrate_stretch(&along, &step, None).optical_depth, 1e6);
}

#[test]
fn nothing_is_seen_of_what_is_not_there() {
    let transfer = TransferPoints(vec![point(0.0, 1.0)]);
    let nothing = OracleRadiance::default();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut stretch = ramp(0.0, 1.0, 1.0);
        stretch.corners[6] = bad;
        assert_eq!(integrate_stretch(&stretch, &transfer, None), nothing);
    }
    for length in [0.0, -1.0, f64::NAN] {
        assert_eq!(integrate_stretch(&ramp(0.0, 1.0, length), &transfer, None), nothing);
    }
    assert_eq!(integrate_stretch(&ramp(0.0, 1.0, 1.0), &TransferPoints(Vec::new()), None), nothing);
    // One empty cell of three.
    let volume = DenseLattice::from_fn([4, 2, 2], |p| if p == [3, 0, 0] { f32::NAN } else { 1.0 });
    let ray = OracleRay { origin: [-1.0, 0.5, 0.5], direction: [0.5, 0.0, 0.0], t_min: 0.0, t_max: 100.0 };
    let seen = integrate_ray(&volume, &ray, 0.25, &transfer, None);
    assert!((seen.optical_depth - 1.0).abs() < 1e-15, "{seen:?}");
}

/// The field less that at corner 0, by a sum of differences.
fn field(stretch: &OracleStretch, p: [f64; 3]) -> f64 {
    let weight = |c: usize| -> f64 {
        (0..3).map(|axis| if c >> axis & 1 == 1 { p[axis] } else { 1.0 - p[axis] }).product()
    };
    (1..8).map(|c| weight(c) * (stretch.corners[c] - stretch.corners[0])).sum()
}

/// The product of the gradient and `v`, by central differences, which are exact along each axis.
fn gradient_times(stretch: &OracleStretch, p: [f64; 3], v: [f64; 3]) -> f64 {
    let moved = |axis: usize, to: f64| std::array::from_fn(|n| if n == axis { to } else { p[n] });
    (0..3).map(|n| (field(stretch, moved(n, 1.0)) - field(stretch, moved(n, 0.0))) * v[n]).sum()
}

/// The midpoint rule in `steps` steps, each of constant extinction and colour.
fn midpoint(
    stretch: &OracleStretch,
    transfer: &TransferPoints,
    shading: Option<&OracleShading>,
    steps: u32,
) -> OracleRadiance {
    let base = stretch.corners[0];
    let shifted: Vec<TransferPoint> =
        transfer.0.iter().map(|p| TransferPoint { value: p.value - base, ..*p }).collect();
    let shifted = TransferPoints(shifted);
    let length = stretch.length / f64::from(steps);
    let mut sum = OracleRadiance::default();
    for n in 0..steps {
        let u = (f64::from(n) + 0.5) / f64::from(steps);
        let p = std::array::from_fn(|axis| stretch.entry[axis] * (1.0 - u) + stretch.exit[axis] * u);
        let at = shifted.at(field(stretch, p));
        let factor = shading.map_or(1.0, |s| {
            let highlight = gradient_times(stretch, p, s.half).abs().min(1.0).powf(s.exponent);
            s.ambient + s.diffuse * gradient_times(stretch, p, s.light).abs() + s.specular * highlight
        });
        let step = OracleRadiance { color: [0.0; 3], optical_depth: at.extinction * length };
        let color = at.color.map(|c| c * factor * step.alpha());
        sum = sum.over(&OracleRadiance { color, ..step });
    }
    sum
}

/// Richardson's extrapolation of the midpoint rule, and how far several step counts are apart.
fn brute_force(
    stretch: &OracleStretch,
    transfer: &TransferPoints,
    shading: Option<&OracleShading>,
) -> (OracleRadiance, f64) {
    // No number is a multiple of another, so that a step does not fall into all three grids alike.
    const STEPS: [u32; 3] = [3001, 5741, 11113];
    let [coarse, middle, fine] = STEPS.map(|steps| midpoint(stretch, transfer, shading, steps));
    let extrapolated = |[a, b]: [&OracleRadiance; 2], [n, m]: [u32; 2]| {
        let (n, m) = (f64::from(n).powi(2), f64::from(m).powi(2));
        let limit = |a: f64, b: f64| b + (b - a) * n / (m - n);
        OracleRadiance {
            color: std::array::from_fn(|n| limit(a.color[n], b.color[n])),
            optical_depth: limit(a.optical_depth, b.optical_depth),
        }
    };
    let (one, two) = (
        extrapolated([&coarse, &middle], [STEPS[0], STEPS[1]]),
        extrapolated([&middle, &fine], [STEPS[1], STEPS[2]]),
    );
    (two, worst(&one, &two).max(1e-3 * worst(&middle, &fine)))
}

/// Compares a stretch with brute force, as far as that is good; whether it is to 10⁻⁹ itself.
fn compare(
    context: &str,
    stretch: &OracleStretch,
    transfer: &TransferPoints,
    shading: Option<&OracleShading>,
) -> bool {
    let seen = integrate_stretch(stretch, transfer, shading);
    let (expected, doubt) = brute_force(stretch, transfer, shading);
    let error = worst(&seen, &expected);
    // Where a step happens to fall in the grid of the rule, three rules may agree by chance to a few digits.
    let allowed = if doubt < 1e-11 { 1e-9 } else { 1e-9 + 100.0 * doubt };
    assert!(
        error <= allowed,
        "{context}: {error:e}, doubt {doubt:e}: {seen:?} {expected:?}\n{stretch:?} {transfer:?} {shading:?}"
    );
    doubt < 1e-11
}

#[test]
fn stretches_agree_with_brute_force() {
    let (mut sharp, mut count) = (0, 0);
    for (k, kind) in StretchKind::ALL.into_iter().enumerate() {
        for (m, transfer) in TransferKind::ALL.into_iter().enumerate() {
            for seed in 0..6 {
                let seed = 1000 * (7 * k + m) as u64 + seed;
                let mut stretch = kind.generate(seed);
                if stretch.length == 0.0 {
                    stretch.length = 1.0;
                }
                let [low, high] = range(&stretch.corners);
                let transfer = transfer.generate(seed, [low, high]);
                let shading = random_shading(&mut SplitMix64::new(seed), f64::from(high - low).max(1e-30));
                let shading = (seed % 2 == 1).then_some(&shading);
                count += 1;
                sharp += u32::from(compare(&format!("{kind:?} {seed}"), &stretch, &transfer, shading));
            }
        }
    }
    println!("{sharp} of {count} compared to 1e-9");
    assert!(2 * sharp > count, "{sharp} of {count}");
}

/// Cubics with a polynomial transfer function of two points: brute force is good to 10⁻¹⁰ at every depth up to some hundreds.
#[test]
fn smooth_stretches_agree_with_brute_force_to_1e_9() {
    let (mut sharp, mut count) = (0, 0);
    for seed in 0..150 {
        let mut rng = SplitMix64::new(seed);
        let stretch = OracleStretch { length: 1.0, ..StretchKind::TwoExtrema.generate(seed) };
        let [low, high] = range(&stretch.corners).map(f64::from);
        let most = 10_f64.powf(rng.range(-3.0, 2.0));
        let mut end = |value: f64| TransferPoint {
            value,
            color: std::array::from_fn(|_| rng.unit()),
            extinction: most * rng.unit(),
        };
        let transfer = TransferPoints(vec![end(low), end(high)]);
        count += 1;
        sharp += u32::from(compare(&format!("{seed}"), &stretch, &transfer, None));
    }
    assert!(5 * sharp > 4 * count, "{sharp} of {count}");
}

#[test]
fn halves_make_up_the_whole() {
    let mut most = 0.0_f64;
    for seed in 0..30_000 {
        let stretch = adversarial_stretch(seed);
        let [low, high] = range(&stretch.corners);
        let transfer = adversarial_transfer(seed / 6, [low, high]);
        let shading = random_shading(&mut SplitMix64::new(seed), f64::from(high - low).max(1e-30));
        let shading = (seed % 2 == 1).then_some(&shading);
        // Where the middle is not exact the halves are another line.
        let middle: [f64; 3] = std::array::from_fn(|n| 0.5 * (stretch.entry[n] + stretch.exit[n]));
        if (0..3).any(|n| middle[n] - stretch.entry[n] != stretch.exit[n] - middle[n]) {
            continue;
        }
        // Coordinates that lift the field off a step by less than can be told.
        if stretch.entry.iter().chain(&stretch.exit).any(|&x| x > 0.0 && x < 1e-30) {
            continue;
        }
        let half = OracleStretch { length: 0.5 * stretch.length, ..stretch };
        let front = integrate_stretch(&OracleStretch { exit: middle, ..half }, &transfer, shading);
        let back = integrate_stretch(&OracleStretch { entry: middle, ..half }, &transfer, shading);
        let whole = integrate_stretch(&stretch, &transfer, shading);
        let error = worst(&whole, &front.over(&back));
        most = most.max(error);
        assert!(
            error < 1e-11,
            "{seed}: {error:e} {whole:?} {:?}\n{stretch:?}\n{transfer:?}",
            front.over(&back)
        );
    }
    println!("halves differ from the whole by at most {most:e}");
}

#[test]
fn all_is_finite_and_alpha_is_one_at_most() {
    for seed in 0..100_000 {
        let stretch = adversarial_stretch(seed);
        let [low, high] = range(&stretch.corners);
        let transfer = adversarial_transfer(seed / 6, [low, high]);
        let seen = integrate_stretch(&stretch, &transfer, None);
        let alpha = seen.alpha();
        assert!(seen.optical_depth.is_finite() && (0.0..=1.0).contains(&alpha), "{seed}: {seen:?}");
        let most = transfer.0.iter().fold(0.0, |m: f64, p| m.max(p.extinction)) * stretch.length;
        let limit = alpha * (1.0 + 1e-12) + 1e-15 * most;
        assert!(
            seen.color.iter().all(|&c| (0.0..=limit).contains(&c)),
            "{seed}: {seen:?} {stretch:?} {transfer:?}"
        );
        if seed % 16 == 0 {
            let shading = random_shading(&mut SplitMix64::new(seed), f64::from(high - low).max(1e-30));
            let shaded = integrate_stretch(&stretch, &transfer, Some(&shading));
            assert!(shaded.color.iter().all(|c| c.is_finite()), "{seed}: {shaded:?}");
            // Cut where the shading is not smooth, the same depth is summed in more parts.
            assert!(
                (shaded.alpha() - alpha).abs() <= 1e-11 * alpha + 1e-15 * most,
                "{seed}: {shaded:?} {seen:?}"
            );
        }
    }
}

#[test]
fn numbers_at_the_ends_of_the_range_do_no_harm() {
    for value in [1e-45, 1e30] {
        for extinction in [1e-45, 1e30] {
            for length in [1e-45, 1e30] {
                let points = [(0.0, 0.0), (value, extinction), (value, 0.0), (2.0 * value, extinction)];
                let transfer = TransferPoints(points.map(|(value, tau)| point(value, tau)).to_vec());
                for end in [0.5 * value, value, 3.0 * value] {
                    let seen = integrate_stretch(&ramp(0.0, end, length), &transfer, None);
                    assert!(seen.optical_depth > 0.0 && seen.optical_depth.is_finite(), "{seen:?}");
                    assert!(seen.color.iter().all(|c| c.is_finite()), "{seen:?}");
                }
            }
        }
    }
}

/// Rays through lattices, cut at lattice planes by sorting all their parameters.
fn ray_by_brute_force(
    l: &impl Lattice,
    ray: &OracleRay,
    world_per_t: f64,
    transfer: &TransferPoints,
    shading: Option<&OracleShading>,
) -> (OracleRadiance, f64) {
    let dims = l.dims();
    let [origin, direction] = [ray.origin, ray.direction].map(|v| v.map(f64::from));
    let mut cuts = vec![f64::from(ray.t_min), f64::from(ray.t_max)];
    for axis in (0..3).filter(|&axis| direction[axis] != 0.0) {
        cuts.extend((0..dims[axis]).map(|k| (f64::from(k) - origin[axis]) / direction[axis]));
    }
    cuts.retain(|t| (f64::from(ray.t_min)..=f64::from(ray.t_max)).contains(t));
    cuts.sort_unstable_by(f64::total_cmp);
    let (mut sum, mut doubt) = (OracleRadiance::default(), 0.0_f64);
    for pair in cuts.windows(2) {
        let [t0, t1] = [pair[0], pair[1]];
        let at = |axis: usize, t: f64| origin[axis] + t * direction[axis];
        let cell: [i64; 3] = std::array::from_fn(|axis| {
            let floor = at(axis, 0.5 * (t0 + t1)).floor() as i64;
            let last = i64::from(dims[axis]) - 2;
            // The far face of the domain belongs to the last cell.
            if direction[axis] == 0.0 && floor == last + 1 && at(axis, 0.0) == f64::from(dims[axis] - 1) {
                last
            } else {
                floor
            }
        });
        if (0..3).any(|axis| cell[axis] < 0 || cell[axis] > i64::from(dims[axis]) - 2) || t1 <= t0 {
            continue;
        }
        let corners: [f64; 8] = std::array::from_fn(|c| {
            l.sample(std::array::from_fn(|axis| cell[axis] as u32 + (c >> axis & 1) as u32))
        });
        if corners.iter().any(|s| !s.is_finite()) {
            continue;
        }
        let local = |t: f64| std::array::from_fn(|axis| at(axis, t) - cell[axis] as f64);
        let stretch =
            OracleStretch { corners, entry: local(t0), exit: local(t1), length: (t1 - t0) * world_per_t };
        let (light, error) = brute_force(&stretch, transfer, shading);
        doubt += error * (1.0 - sum.alpha());
        sum = sum.over(&light);
    }
    (sum, doubt)
}

#[test]
fn rays_agree_with_brute_force() {
    const DIMS: [u32; 3] = [4, 5, 3];
    let (mut sharp, mut count) = (0, 0);
    for seed in 0..210_u64 {
        let mut rng = SplitMix64::new(seed);
        let kind = LatticeKind::ALL[(seed % 7) as usize];
        let samples = kind.generate(DIMS, seed);
        let [low, high] = range(&samples.iter().map(|&s| f64::from(s)).collect::<Vec<f64>>());
        let volume = DenseLattice::from_vec(DIMS, samples).unwrap();
        let ray = RayKind::ALL[(seed % 16) as usize].generate(DIMS, seed);
        let mut transfer = adversarial_transfer(rng.next_u64(), [low, high]);
        // Depths at which there is something behind the first cell.
        let largest = transfer.0.iter().fold(0.0, |m: f64, p| m.max(p.extinction));
        let scale = 10_f64.powf(rng.range(-2.0, 2.0)) / largest.max(1e-40);
        transfer.0.iter_mut().for_each(|p| p.extinction *= scale);
        let shading = random_shading(&mut rng, f64::from(high - low).max(1e-30));
        let shading = rng.coin().then_some(&shading);
        let speed = ray.direction.iter().map(|&d| f64::from(d).powi(2)).sum::<f64>().sqrt();
        let seen = integrate_ray(&volume, &ray, speed, &transfer, shading);
        let (expected, doubt) = ray_by_brute_force(&volume, &ray, speed, &transfer, shading);
        let error = worst(&seen, &expected);
        let allowed = if doubt < 1e-11 { 1e-9 } else { 1e-9 + 100.0 * doubt };
        assert!(
            error <= allowed,
            "{seed} {kind:?}: {error:e}, doubt {doubt:e}: {seen:?} {expected:?} {ray:?}\n{transfer:?}"
        );
        count += u32::from(expected.alpha() > 0.0);
        sharp += u32::from(expected.alpha() > 0.0 && doubt < 1e-11);
    }
    println!("{sharp} of {count} compared to 1e-9");
    assert!(count > 60 && 3 * sharp > count, "{sharp} of {count}");
}
