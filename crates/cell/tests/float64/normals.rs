//! Normals on oblique grids.

use isoray_cell::{Real, STENCIL, gradient, stencil_gradient, unit_normal};
use isoray_oracle::SplitMix64;
use wide::f32x8;

use crate::cases::U;

type Matrix = [[f64; 3]; 3];

/// The inverse transpose: the cofactors over the determinant. `None` where it is zero.
fn inverse_transpose(m: &Matrix) -> Option<Matrix> {
    let cofactor = |i: usize, j: usize| {
        let at = |di: usize, dj: usize| m[(i + di) % 3][(j + dj) % 3];
        at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)
    };
    let determinant = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum::<f64>();
    let inverse = std::array::from_fn(|i| std::array::from_fn(|j| cofactor(i, j) / determinant));
    (determinant != 0.0).then_some(inverse)
}

/// A field that is linear in world space, on an oblique grid: whole numbers, so that all samples and differences are exact. Its normal
/// is the same everywhere and by either gradient, but for the error that is stated.
#[test]
fn oblique_grids_have_the_normals_of_the_world() {
    let mut rng = SplitMix64::new(21);
    let mut most = 0.0_f64;
    for _ in 0..20_000 {
        let mut whole = || f64::from(rng.below(41)) - 20.0;
        let index_to_world: Matrix = std::array::from_fn(|_| std::array::from_fn(|_| whole()));
        let slope: [f64; 3] = std::array::from_fn(|_| whole());
        let Some(matrix) = inverse_transpose(&index_to_world) else { continue };
        let length = slope.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length == 0.0 {
            continue;
        }
        let at = |p: [usize; 3]| {
            let world = |i: usize| (0..3).map(|j| index_to_world[i][j] * p[j] as f64).sum::<f64>();
            (0..3).map(|i| slope[i] * world(i)).sum::<f64>() as f32
        };
        let samples: [f32; STENCIL.pow(3)] = std::array::from_fn(|n| at([n % 4, n / 4 % 4, n / 16]));
        let corners: [f32; 8] = std::array::from_fn(|n| at([n & 1, n >> 1 & 1, n >> 2]));
        let p: [f32; 3] = std::array::from_fn(|_| f32::from(rng.below(5) as u8) / 4.0);
        let forward = gradient(&corners, p);
        assert_eq!(forward, stencil_gradient(&samples, &[true; STENCIL.pow(3)], p));

        let rows = matrix.map(|row| row.map(|c| c as f32));
        let normal = unit_normal(forward, &rows);
        assert!(normal.exists);
        let products = rows.map(|row| (0..3).map(|j| f64::from(row[j] * forward[j]).abs()).sum::<f64>());
        let kappa = products.iter().map(|c| c * c).sum::<f64>().sqrt() / length;
        // The matrix was rounded too.
        let bound = (4.0 * kappa + 6.0) * U;
        let off: [f64; 3] = std::array::from_fn(|a| f64::from(normal.direction[a]) - slope[a] / length);
        let error = off.iter().map(|c| c * c).sum::<f64>().sqrt();
        most = most.max(error / bound);
        assert!(error <= bound, "{error:e} > {bound:e}: {normal:?} for {slope:?} on {index_to_world:?}");
    }
    println!("error of normals: {most:.2} of the bound");
}

#[test]
fn normals_agree_in_lanes_and_do_not_exist_everywhere() {
    let mut rng = SplitMix64::new(22);
    let special = [0.0, -0.0, 1e-45, 1e-40, 1e-30, 1e30, 3e38, f32::INFINITY, f32::NAN];
    let (mut with, mut without) = (0, 0);
    for _ in 0..20_000 {
        let gradients: [[f32; 3]; 8] = std::array::from_fn(|_| {
            std::array::from_fn(|_| match rng.below(4) {
                0 => rng.range(-1.0, 1.0) as f32,
                _ => special[rng.below(special.len() as u32) as usize],
            })
        });
        let mut rows = [[0.0_f32; 3]; 3];
        (0..3).for_each(|a| rows[a][a] = rng.range(0.5, 2.0) as f32);
        let lanes = unit_normal(f32x8::gather(|n| gradients[n]), &rows.map(|row| row.map(f32x8::splat)));
        for (n, &gradient) in gradients.iter().enumerate() {
            let alone = unit_normal(gradient, &rows);
            assert_eq!(lanes.direction.map(|c| c.lane(n).to_bits()), alone.direction.map(f32::to_bits));
            let length = alone.direction.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>().sqrt();
            if alone.exists {
                with += 1;
                assert!((length - 1.0).abs() < 10.0 * U, "{alone:?} of {gradient:?}");
            } else {
                without += 1;
                assert_eq!(alone.direction, [0.0; 3]);
            }
            let products: [f32; 3] = std::array::from_fn(|a| gradient[a] * rows[a][a]);
            let is_zero = products.iter().all(|&c| c == 0.0);
            assert_eq!(alone.exists, !is_zero && products.iter().all(|c| c.is_finite()), "{gradient:?}");
        }
    }
    assert!(with > 10_000 && without > 10_000, "{with} {without}");
}
