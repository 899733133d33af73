//! How far the ray that is traced is from the one that the camera meant, as an angle.

use glam::{DAffine3, DMat3, DVec3, EulerRot};
use isoray_oracle::SplitMix64;
use isoray_render::{Camera, Projection, View};

/// The documented bound, in radian.
const BOUND: f64 = 1.0 / (1 << 24) as f64;

/// What the arithmetic in `f64`, of the camera and of this test, adds.
const SLACK: f64 = 1e-13;

fn vector(rng: &mut SplitMix64) -> DVec3 {
    DVec3::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0))
}

/// Angle between two directions, exact also where it is small.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// The largest angles of one placement, in index space and in the world.
fn angles(rng: &mut SplitMix64, placement: &DAffine3) -> [f64; 2] {
    let world_to_index = placement.inverse();
    let projection = if rng.coin() {
        Projection::Perspective { fov: rng.range(1.0, 150.0) }
    } else {
        Projection::Orthographic { height: rng.range(0.1, 100.0) }
    };
    let view = View { eye: 1e3 * vector(rng), look_at: 1e2 * vector(rng), up: vector(rng), projection };
    let camera = Camera::new(&view, [97, 61]).unwrap();
    let mut worst = [0.0_f64; 2];
    for _ in 0..100 {
        let (x, y) = (rng.below(97), rng.below(61));
        let ray = camera.index_ray(&world_to_index, x, y);
        let (origin, meant) = camera.world_ray(x, y);
        let traced = DVec3::from_array(ray.direction.map(f64::from));
        worst[0] = worst[0].max(angle(traced, world_to_index.transform_vector3(meant)));
        worst[1] = worst[1].max(angle(placement.transform_vector3(traced), meant));
        let origin = world_to_index.transform_point3(origin);
        let moved = (DVec3::from_array(ray.origin.map(f64::from)) - origin).length();
        assert!(moved <= (BOUND + SLACK) * origin.length(), "{moved} at {origin}");
        // Distance along the ray is the world's.
        assert!(
            (placement.transform_vector3(traced).length() - 1.0).abs() < 1e-6 * condition(&placement.matrix3)
        );
    }
    worst
}

/// Condition number of the matrix of the unit vectors of the lattice's axes, from above: by Frobenius norms.
fn condition(axes: &DMat3) -> f64 {
    let unit = DMat3::from_cols(axes.x_axis.normalize(), axes.y_axis.normalize(), axes.z_axis.normalize());
    let norm = |m: DMat3| m.to_cols_array().iter().map(|c| c * c).sum::<f64>().sqrt();
    norm(unit) * norm(unit.inverse())
}

#[test]
fn rounding_turns_no_ray_further_than_documented() {
    let mut rng = SplitMix64::new(1);
    let mut worst = [0.0_f64; 3];
    for _ in 0..3000 {
        let [a, b, c] = std::array::from_fn(|_| rng.range(-3.0, 3.0));
        let rotation = DMat3::from_euler(EulerRot::XYZ, a, b, c);
        let spacing = DMat3::from_diagonal(DVec3::from_array(std::array::from_fn(|_| {
            10_f64.powf(rng.range(-3.0, 3.0))
        })));
        let origin = 100.0 * vector(&mut rng);
        let [index, world] = angles(&mut rng, &DAffine3::from_mat3_translation(rotation * spacing, origin));
        worst = [worst[0].max(index), worst[1].max(world), worst[2]];
        assert!(index <= BOUND + SLACK && world <= BOUND + SLACK, "{index} {world}");

        let shear = DMat3::from_cols(vector(&mut rng), vector(&mut rng), vector(&mut rng));
        let condition = condition(&shear);
        if condition < 100.0 {
            let oblique = DAffine3::from_mat3_translation(rotation * shear * spacing, origin);
            let [index, world] = angles(&mut rng, &oblique);
            worst = [worst[0].max(index), worst[1], worst[2].max(world)];
            assert!(index <= BOUND + SLACK, "{index}");
            assert!(world <= (BOUND + SLACK) * condition, "{world} for a condition of {condition}");
        }
    }
    println!(
        "radian over 2⁻²⁴: {:.3} in index space, {:.3} and {:.3} (oblique) in the world",
        worst[0] / BOUND,
        worst[1] / BOUND,
        worst[2] / BOUND
    );
    assert!(worst[0] > 0.8 * BOUND, "the bound is nearly attained: {}", worst[0]);
}
