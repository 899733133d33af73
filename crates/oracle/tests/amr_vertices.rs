//! Values at corners from averages of cells: what they are exact for, and between what they stay.

use isoray_oracle::{
    AmrCells, AmrKind, AmrLeaf, Border, adversarial_averages, adversarial_mesh, vertex_values,
};

const SEEDS: u64 = 12 * AmrKind::ALL.len() as u64;
const BORDERS: [Border; 2] = [Border::Linear, Border::Bounded];

fn has_gaps(seed: u64) -> bool {
    AmrKind::ALL[(seed % AmrKind::ALL.len() as u64) as usize] == AmrKind::Gaps
}

fn is_interior<T>(mesh: &AmrCells<T>, p: [u32; 3]) -> bool {
    mesh.around(p).iter().all(Option::is_some)
}

/// The least and the largest average of the leaves that touch a point.
fn range(mesh: &AmrCells<f64>, p: [u32; 3]) -> [f64; 2] {
    let values = mesh.around(p).into_iter().flatten().map(|n| mesh.leaves()[n].value);
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// All corners of leaves, with their values.
fn vertices(mesh: &AmrCells<[f64; 8]>) -> impl Iterator<Item = ([u32; 3], f64)> {
    mesh.leaves().iter().flat_map(|leaf| (0..8).map(|c| (leaf.corner(c), leaf.value[c])))
}

#[test]
fn constants_stay_constant() {
    for seed in 0..SEEDS {
        let mesh = adversarial_mesh(seed).map(|_| 0.1);
        for border in BORDERS {
            for (p, v) in vertices(&vertex_values(&mesh, border)) {
                assert!((v - 0.1).abs() < 1e-15, "{seed}: {p:?} {v}");
            }
        }
    }
}

#[test]
fn linear_fields_are_exact_in_the_interior_and_at_linear_borders() {
    let mut counts = [0; 2];
    for seed in (0..SEEDS).filter(|&seed| !has_gaps(seed)) {
        let mesh = adversarial_mesh(seed);
        // Without a second cell along an axis, there is nothing to take a gradient from.
        let largest = mesh.leaves().iter().map(|leaf| leaf.edge).max().unwrap();
        let slope = [1.7, -0.9, 0.3];
        let slope: [f64; 3] =
            std::array::from_fn(|axis| if mesh.dims()[axis] > largest { slope[axis] } else { 0.0 });
        let linear = |p: [f64; 3]| 2.0 + (0..3).map(|axis| slope[axis] * p[axis]).sum::<f64>();
        let mesh = mesh.map(|leaf| linear(leaf.centre()));
        for border in BORDERS {
            for (p, v) in vertices(&vertex_values(&mesh, border)) {
                let is_interior = is_interior(&mesh, p);
                if is_interior || border == Border::Linear {
                    let expected = linear(p.map(f64::from));
                    assert!((v - expected).abs() < 1e-12, "{seed}: {p:?} {v} {expected}");
                    counts[usize::from(is_interior)] += 1;
                }
            }
        }
    }
    assert!(counts.iter().all(|&n| n > 10_000), "{counts:?}");
}

#[test]
fn values_stay_between_those_of_the_leaves_around() {
    let mut beyond = 0;
    for seed in 0..SEEDS {
        let mesh = adversarial_averages(&adversarial_mesh(seed), seed);
        for border in BORDERS {
            for (p, v) in vertices(&vertex_values(&mesh, border)) {
                let [low, high] = range(&mesh, p);
                let is_between = (low..=high).contains(&v);
                let must_be = border == Border::Bounded || is_interior(&mesh, p);
                assert!(is_between || !must_be, "{seed}: {p:?} {v} {low} {high}");
                beyond += u32::from(!is_between);
            }
        }
    }
    assert!(beyond > 100, "a linear border is not bounded");
}

#[test]
fn leaves_agree_at_the_corners_they_share() {
    for seed in 0..SEEDS {
        let mesh = adversarial_averages(&adversarial_mesh(seed), seed);
        let mut known = std::collections::HashMap::new();
        for (p, v) in vertices(&vertex_values(&mesh, Border::Linear)) {
            assert_eq!(*known.entry(p).or_insert(v), v, "{seed}: {p:?}");
        }
    }
}

/// Whatever octants are missing, in gaps or beyond the border.
#[test]
fn linear_fields_are_exact_beside_gaps() {
    let linear = |p: [f64; 3]| 1.0 - 0.4 * p[0] + 1.1 * p[1] + 0.2 * p[2];
    for pattern in 1..256_u32 {
        let mut leaves = Vec::new();
        for n in 0..64 {
            let low = [n % 4, n / 4 % 4, n / 16];
            let octant = low.iter().enumerate().map(|(axis, &c)| (c / 2) << axis).sum::<u32>();
            if pattern >> octant & 1 == 1 {
                let leaf = AmrLeaf { low, edge: 1, value: () };
                leaves.push(AmrLeaf { low, edge: 1, value: linear(leaf.centre()) });
            }
        }
        let mesh = AmrCells::new([4; 3], leaves).unwrap();
        for (p, v) in vertices(&vertex_values(&mesh, Border::Linear)) {
            let expected = linear(p.map(f64::from));
            assert!((v - expected).abs() < 1e-12, "{pattern}: {p:?} {v} {expected}");
        }
    }
}

#[test]
fn one_level_is_the_mean_of_eight_the_last_ones_repeated() {
    for seed in 0..20 {
        let mesh = adversarial_averages(&AmrKind::Uniform.generate(seed), seed);
        let dims = mesh.dims();
        for (p, v) in vertices(&vertex_values(&mesh, Border::Bounded)) {
            let octant = |o: usize| {
                let along = |axis: usize| (p[axis] + (o >> axis & 1) as u32).clamp(1, dims[axis]) - 1;
                mesh.leaves()[mesh.find(std::array::from_fn(along)).unwrap()].value
            };
            let mean = (0..8).map(octant).sum::<f64>() / 8.0;
            assert!((v - mean).abs() < 1e-12, "{seed}: {p:?} {v} {mean}");
        }
    }
}

#[test]
fn a_spike_keeps_an_eighth() {
    let mesh = AmrKind::Uniform.generate(3);
    let [nx, ny, nz] = mesh.dims();
    let at = [nx / 2, ny / 2, nz / 2];
    let spike = mesh.map(|leaf| f64::from(u32::from(leaf.low == at)));
    let values = vertex_values(&spike, Border::Bounded);
    for (p, v) in vertices(&values).filter(|&(p, _)| is_interior(&spike, p)) {
        let touches = (0..3).all(|axis| p[axis] == at[axis] || p[axis] == at[axis] + 1);
        assert_eq!(v, if touches { 0.125 } else { 0.0 });
    }
}

#[test]
fn larger_leaves_are_prolonged_to_the_places_of_small_ones() {
    // Along x: a cell of edge 2 with average 0, then cells of edge 1 with averages of 6 and 2.
    let mut leaves = vec![AmrLeaf { low: [0; 3], edge: 2, value: 0.0 }];
    for o in 0..8 {
        let low = [2 + (o & 1), o >> 1 & 1, o >> 2];
        leaves.push(AmrLeaf { low, edge: 1, value: if low[0] == 2 { 6.0 } else { 2.0 } });
    }
    let mesh = AmrCells::new([4, 2, 2], leaves).unwrap();
    let value = |border, p| vertices(&vertex_values(&mesh, border)).find(|&(q, _)| q == p).unwrap().1;
    // The cube of edge 2 above the large cell has the average 4, and the gradient is 2: the place at x = 1.5 has 1.
    let middle = 0.5 * (1.0 + 6.0);
    assert_eq!(BORDERS.map(|border| value(border, [2, 1, 1])), [middle; 2]);
    // Where x = 4, the last cells' gradient is −4.
    assert_eq!(BORDERS.map(|border| value(border, [4, 1, 1])), [0.0, 2.0]);
    // Where x = 0: −2, half a place below 0, or mirrored, −1 clamped.
    assert_eq!(BORDERS.map(|border| value(border, [0, 0, 0])), [-2.0, 0.0]);
}

#[test]
fn leaves_without_a_finite_average_are_left_out() {
    let leaf = |x, value| AmrLeaf { low: [x, 0, 0], edge: 1, value };
    let mesh = AmrCells::new([3, 1, 1], vec![leaf(0, 5.0), leaf(1, f64::NAN), leaf(2, 7.0)]).unwrap();
    let values = vertex_values(&mesh, Border::Linear);
    let found: Vec<_> = values.leaves().iter().map(|leaf| (leaf.low[0], leaf.value)).collect();
    assert_eq!(found, [(0, [5.0; 8]), (2, [7.0; 8])]);
}
