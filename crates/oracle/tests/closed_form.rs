//! The oracle against fields whose hits and gradients are known in closed form.

use isoray_oracle::{
    DenseLattice, Field, FnLattice, Gyroid, Lattice, MarschnerLobb, OracleRay, Ramp, Sphere, SplitMix64,
    all_hits, central_gradient, error_in_ulps, first_hit,
};

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn towards(origin: [f32; 3], target: [f64; 3]) -> OracleRay {
    let direction = std::array::from_fn(|axis| (target[axis] - f64::from(origin[axis])) as f32);
    OracleRay { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

fn somewhere(rng: &mut SplitMix64, low: f64, high: f64) -> [f64; 3] {
    std::array::from_fn(|_| rng.range(low, high))
}

#[test]
fn a_ramp_is_hit_exactly_where_the_plane_is() {
    let mut rng = SplitMix64::new(1);
    let dims = [20, 17, 23];
    for _ in 0..2000 {
        let ramp = Ramp { offset: rng.range(-5.0, 5.0), slope: somewhere(&mut rng, -2.0, 2.0) };
        let volume = FnLattice::new(dims, |p| ramp.value(p.map(f64::from)));
        let inside = std::array::from_fn(|axis| rng.range(1.0, f64::from(dims[axis]) - 2.0));
        let v = ramp.value(inside);
        let origin = somewhere(&mut rng, -30.0, 60.0).map(|c| c as f32);
        let ray = towards(origin, inside);
        let (o, d) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
        let climb: f64 = (0..3).map(|axis| ramp.slope[axis] * d[axis]).sum();
        let expected = (v - ramp.value(o)) / climb;
        let domain = |t: f64| (0..3).all(|a| (0.0..=f64::from(dims[a] - 1)).contains(&(o[a] + t * d[a])));
        if !domain(0.0) && climb.abs() > 0.1 && domain(expected) {
            let hit = first_hit(&volume, &ray, v).expect("the plane is in the domain");
            assert!((hit.t - expected).abs() < 1e-11, "{} for {expected}", hit.t);
            assert_eq!(hit.entering, climb > 0.0);
            assert_eq!(all_hits(&volume, &ray, v).len(), 1);
            for axis in 0..3 {
                assert!((hit.gradient[axis] - ramp.slope[axis]).abs() < 1e-12);
                assert!((hit.position[axis] - (o[axis] + hit.t * d[axis])).abs() < 1e-11);
            }
            let central = central_gradient(&volume, hit.position, hit.cell);
            assert!((0..3).all(|axis| (central[axis] - ramp.slope[axis]).abs() < 1e-12));
        }
    }
}

#[test]
fn an_integer_ramp_has_no_error_at_all() {
    let volume = DenseLattice::from_fn([9, 9, 9], |p| p[0] as u8);
    let ray = OracleRay {
        origin: [-2.0, 3.25, 4.5],
        direction: [0.5, 0.0, -0.0],
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    for eighths in 1..64_u32 {
        let v = f64::from(eighths) / 8.0;
        let hit = first_hit(&volume, &ray, v).expect("a value between the ends");
        assert_eq!(hit.t, 2.0 * (v + 2.0));
        assert_eq!(hit.position, [v, 3.25, 4.5]);
        assert_eq!(hit.gradient, [1.0, 0.0, 0.0]);
        assert_eq!(error_in_ulps(hit.t as f32, hit.t), 0.0);
    }
}

/// Trilinear interpolation of a distance `r` errs by at most h²/8 · 2/r per voxel of size 1 (the trace
/// of its Hessian is 2/r), always upwards because a distance is convex along each axis.
#[test]
fn a_sphere_is_hit_within_the_error_of_its_interpolation() {
    const CENTRE: f64 = 32.3;
    const RADIUS: f64 = 25.0;
    let sphere = Sphere { centre: [CENTRE; 3] };
    let volume = DenseLattice::from_field([66; 3], &sphere, |s| s);
    let bound = 1.1 * 0.25 / RADIUS;
    let mut rng = SplitMix64::new(2);
    for _ in 0..3000 {
        let out = somewhere(&mut rng, -1.0, 1.0);
        let origin = out.map(|c| (CENTRE + 90.0 * c / length(out).max(0.1)) as f32);
        let target = somewhere(&mut rng, CENTRE - 10.0, CENTRE + 10.0);
        let hits = all_hits(&volume, &towards(origin, target), RADIUS);
        assert_eq!(hits.len(), 2, "in and out");
        assert!(!hits[0].entering && hits[1].entering);
        for hit in hits {
            let error = sphere.value(hit.position) - RADIUS;
            assert!(error <= 1e-12 && error > -bound, "{error}");
            let exact = sphere.gradient(hit.position);
            let central = central_gradient(&volume, hit.position, hit.cell);
            for axis in 0..3 {
                assert!((hit.gradient[axis] - exact[axis]).abs() < 1.5 / RADIUS);
                assert!((central[axis] - exact[axis]).abs() < 4.0 / (RADIUS * RADIUS));
            }
        }
    }
}

#[test]
fn fine_lattices_of_curved_fields_converge_to_them() {
    let volume = DenseLattice::from_field([40; 3], &Gyroid { period: 25.0 }, |s| s as f32);
    let lobb = MarschnerLobb { n: 65 };
    let ripples = DenseLattice::from_field([65; 3], &lobb, |s| s);
    let mut rng = SplitMix64::new(3);
    for _ in 0..500 {
        let origin = somewhere(&mut rng, -60.0, -20.0).map(|c| c as f32);
        let ray = towards(origin, somewhere(&mut rng, 5.0, 34.0));
        if let Some(hit) = first_hit(&volume, &ray, 0.25) {
            assert!((Gyroid { period: 25.0 }.value(hit.position) - 0.25).abs() < 0.03);
        }
        if let Some(hit) = first_hit(&ripples, &ray, 127.5) {
            assert!((lobb.value(hit.position) - 127.5).abs() < 25.0, "{}", lobb.value(hit.position));
        }
    }
}

#[test]
fn central_differences_are_exact_on_quadratics_up_to_the_border() {
    let value = |p: [f64; 3]| p[0] * p[0] - 3.0 * p[1] * p[1] + p[1] * p[2] + 2.0 * p[2];
    let slope = |p: [f64; 3]| [2.0 * p[0], -6.0 * p[1] + p[2], p[1] + 2.0];
    let volume = FnLattice::new([4, 5, 6], |p| value(p.map(f64::from)));
    let mut rng = SplitMix64::new(4);
    for _ in 0..1000 {
        let cell = [rng.below(3), rng.below(4), rng.below(5)];
        let position = cell.map(|c| f64::from(c) + rng.unit());
        let (found, exact) = (central_gradient(&volume, position, cell), slope(position));
        assert!((0..3).all(|axis| (found[axis] - exact[axis]).abs() < 1e-12), "{found:?} {exact:?}");
    }
}

#[test]
fn central_differences_fall_back_beside_missing_samples() {
    let square = |x: u32| f64::from(x * x);
    let two = FnLattice::new([2, 2, 2], |p| square(p[0]));
    assert_eq!(central_gradient(&two, [0.5; 3], [0; 3]), [1.0, 0.0, 0.0]);

    // Samples 0, 1, 4, NaN, 16: at 2 the difference leans back, at 1 it is central.
    let holed = FnLattice::new([5, 2, 2], |p| if p[0] == 3 { f64::NAN } else { square(p[0]) });
    assert_eq!(central_gradient(&holed, [2.0, 0.5, 0.5], [1, 0, 0])[0], 4.0);
    assert_eq!(central_gradient(&holed, [1.0, 0.5, 0.5], [1, 0, 0])[0], 2.0);

    // Samples NaN, 1, 4, NaN: only first order is left.
    let narrow = FnLattice::new([4, 2, 2], |p| if p[0] % 3 == 0 { f64::INFINITY } else { square(p[0]) });
    assert_eq!(central_gradient(&narrow, [1.5, 0.5, 0.5], [1, 0, 0])[0], 3.0);

    assert_eq!(central_gradient(&two, [0.5; 3], [1, 0, 0]), [0.0; 3], "no such cell");
    assert_eq!(two.dims(), [2; 3]);
}
