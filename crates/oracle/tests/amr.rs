//! The field of adaptive meshes: what it is exact for, where it is continuous, and between what it stays.

use isoray_oracle::{
    AmrCells, AmrKind, AmrLattice, AmrLeaf, BadLeaf, DenseLattice, Lattice, SplitMix64, adversarial_corners,
    adversarial_mesh,
};

/// Several of each kind.
const SEEDS: u64 = 12 * AmrKind::ALL.len() as u64;

fn kind(seed: u64) -> AmrKind {
    AmrKind::ALL[(seed % AmrKind::ALL.len() as u64) as usize]
}

fn points([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// The points of a closed leaf.
fn points_of<T>(leaf: &AmrLeaf<T>) -> impl Iterator<Item = [u32; 3]> {
    let low = leaf.low;
    points([leaf.edge + 1; 3]).map(move |p| std::array::from_fn(|axis| low[axis] + p[axis]))
}

fn linear(p: [u32; 3]) -> f64 {
    let [x, y, z] = p.map(f64::from);
    3.0 + 0.7 * x - 1.3 * y + 0.11 * z
}

/// From values at the corners of a box of the lattice.
fn in_box(field: &AmrLattice, low: [u32; 3], high: [u32; 3], p: [u32; 3]) -> f64 {
    let values: [f64; 8] = std::array::from_fn(|c| {
        field.sample(std::array::from_fn(|axis| if c >> axis & 1 == 1 { high[axis] } else { low[axis] }))
    });
    let unit = |axis: usize| f64::from(p[axis] - low[axis]) / f64::from(high[axis] - low[axis]);
    let weight = |c: usize, axis: usize| if c >> axis & 1 == 1 { unit(axis) } else { 1.0 - unit(axis) };
    (0..8).map(|c| values[c] * (0..3).map(|axis| weight(c, axis)).product::<f64>()).sum()
}

#[test]
fn linear_fields_are_exact_and_what_no_leaf_covers_is_empty() {
    for seed in 0..SEEDS {
        let mesh = adversarial_mesh(seed).map(|leaf| std::array::from_fn(|c| linear(leaf.corner(c))));
        let field = AmrLattice::new(&mesh);
        for p in points(field.dims()) {
            let is_covered = mesh.around(p).iter().any(Option::is_some);
            let s = field.sample(p);
            assert_eq!(s.is_finite(), is_covered, "{seed}: {p:?}");
            assert!(!is_covered || (s - linear(p)).abs() < 1e-12, "{seed}: {p:?} {s} {}", linear(p));
        }
    }
}

#[test]
fn cells_of_the_lattice_are_empty_where_gaps_are() {
    for seed in 0..20 {
        let mesh = AmrKind::Gaps.generate(seed).map(|_| [1.0; 8]);
        let field = AmrLattice::new(&mesh);
        for cell in points(mesh.dims()) {
            let middle = field.value(cell.map(|c| f64::from(c) + 0.5));
            assert_eq!(middle.is_finite(), mesh.find(cell).is_some(), "{seed}: {cell:?}");
        }
    }
}

#[test]
fn one_level_is_a_dense_lattice() {
    for seed in 0..20 {
        let mesh = AmrKind::Uniform.generate(seed);
        let mesh = adversarial_corners(&mesh, seed);
        let samples = DenseLattice::from_fn(mesh.dims().map(|n| n + 1), |p| {
            mesh.around(p).iter().enumerate().find_map(|(o, n)| n.map(|n| mesh.leaves()[n].value[7 - o]))
        });
        let field = AmrLattice::new(&mesh);
        for (p, &sample) in points(field.dims()).zip(samples.samples()) {
            assert_eq!(Some(field.sample(p)), sample);
            assert!(field.is_owned(p));
        }
    }
}

#[test]
fn owned_points_have_the_values_of_the_finest_leaf() {
    for seed in 0..SEEDS {
        let mesh = adversarial_corners(&adversarial_mesh(seed), seed);
        let field = AmrLattice::new(&mesh);
        for p in points(field.dims()) {
            let mut corners = Vec::new();
            for leaf in mesh.around(p).iter().flatten().map(|&n| &mesh.leaves()[n]) {
                corners.extend((0..8).filter(|&c| leaf.corner(c) == p).map(|c| (leaf.edge, leaf.value[c])));
            }
            let finest = corners.iter().min_by_key(|(edge, _)| *edge);
            assert_eq!(field.is_owned(p), finest.is_some(), "{seed}: {p:?}");
            assert!(finest.is_none_or(|&(_, v)| v == field.sample(p)), "{seed}: {p:?}");
        }
    }
}

/// Leaves without owned points but their corners are the interpolants of these, up to their border: what is beside them has the same values there.
#[test]
fn leaves_that_are_not_hybrid_are_trilinear() {
    let mut counts = [0; 2];
    for seed in 0..SEEDS {
        let mesh = adversarial_corners(&adversarial_mesh(seed), seed);
        let field = AmrLattice::new(&mesh);
        for leaf in mesh.leaves() {
            counts[usize::from(field.is_hybrid(leaf))] += u32::from(leaf.edge > 1);
            if field.is_hybrid(leaf) {
                continue;
            }
            for p in points_of(leaf) {
                let expected = in_box(&field, leaf.low, leaf.corner(7), p);
                assert!((field.sample(p) - expected).abs() < 1e-12, "{seed}: {leaf:?} {p:?}");
            }
        }
    }
    assert!(counts.iter().all(|&n| n > 1000), "{counts:?}");
}

#[test]
fn cubes_are_the_largest_parts_of_leaves_that_are_not_hybrid() {
    let mut counts = [0; 2];
    for seed in 0..2 * AmrKind::ALL.len() as u64 {
        let mesh = adversarial_corners(&adversarial_mesh(seed), seed);
        let field = AmrLattice::new(&mesh);
        for leaf in mesh.leaves() {
            let cells = (0..leaf.edge.pow(3))
                .map(|n| [n % leaf.edge, n / leaf.edge % leaf.edge, n / leaf.edge.pow(2)]);
            for cell in cells.map(|by| [0, 1, 2].map(|a| leaf.low[a] + by[a])) {
                let edge = mesh.cube(cell).unwrap();
                let part = |edge: u32| AmrLeaf { low: cell.map(|c| c - c % edge), edge, value: () };
                assert!(edge == leaf.edge || field.is_hybrid(&part(2 * edge)), "{seed}: {leaf:?} {cell:?}");
                assert!(edge == 1 || !field.is_hybrid(&part(edge)), "{seed}: {leaf:?} {cell:?}");
                counts[usize::from(edge < leaf.edge)] += 1;
            }
        }
        assert_eq!(mesh.cube(mesh.dims()), None);
    }
    assert!(counts.iter().all(|&n| n > 1000), "{counts:?}");
}

#[test]
fn without_gaps_a_leaf_is_hybrid_if_the_middle_of_an_edge_is_owned() {
    for seed in (0..SEEDS).filter(|&seed| kind(seed) != AmrKind::Gaps) {
        let mesh = adversarial_mesh(seed).map(|_| [0.0; 8]);
        let field = AmrLattice::new(&mesh);
        for leaf in mesh.leaves().iter().filter(|leaf| leaf.edge > 1) {
            let half = leaf.edge / 2;
            let is_middle =
                |p: [u32; 3]| (0..3).filter(|&axis| p[axis] - leaf.low[axis] == half).count() == 1;
            let is_on_edge = |p: [u32; 3]| {
                (0..3).filter(|&axis| (p[axis] - leaf.low[axis]).is_multiple_of(leaf.edge)).count() == 2
            };
            let middles = points_of(leaf).filter(|&p| is_middle(p) && is_on_edge(p));
            let owned = middles.filter(|&p| field.is_owned(p)).count();
            assert_eq!(field.is_hybrid(leaf), owned > 0, "{seed}: {leaf:?}");
        }
    }
}

/// Halving what is hybrid until nothing is gives the field; and where once is enough, the axes along which edges have owned middles are.
#[test]
fn hybrid_leaves_are_trilinear_in_parts() {
    let mut counts = [0; 2];
    for seed in 0..SEEDS {
        let mesh = adversarial_corners(&adversarial_mesh(seed), seed);
        let field = AmrLattice::new(&mesh);
        for leaf in mesh.leaves().iter().filter(|leaf| field.is_hybrid(leaf)) {
            let mut cubes = vec![AmrLeaf { low: leaf.low, edge: leaf.edge, value: () }];
            let mut depth = 0;
            while let Some(cube) = cubes.pop() {
                if field.is_hybrid(&cube) {
                    let edge = cube.edge / 2;
                    depth = depth.max(leaf.edge / edge);
                    let low =
                        |o: usize| std::array::from_fn(|axis| cube.low[axis] + (o >> axis & 1) as u32 * edge);
                    cubes.extend((0..8).map(|o| AmrLeaf { low: low(o), edge, value: () }));
                    continue;
                }
                for p in points_of(&cube) {
                    let expected = in_box(&field, cube.low, cube.corner(7), p);
                    assert!((field.sample(p) - expected).abs() < 1e-12, "{seed}: {leaf:?} {cube:?} {p:?}");
                }
            }
            counts[usize::from(depth > 2)] += 1;
            if depth > 2 || kind(seed) == AmrKind::Gaps {
                continue;
            }
            let half = leaf.edge / 2;
            let is_split: [bool; 3] = std::array::from_fn(|axis| {
                (0..8).filter(|c| c >> axis & 1 == 0).any(|c| {
                    let mut middle = leaf.corner(c);
                    middle[axis] += half;
                    field.is_owned(middle)
                })
            });
            for p in points_of(leaf) {
                let edge = is_split.map(|is_split| if is_split { half } else { leaf.edge });
                let last = |axis: usize| leaf.low[axis] + leaf.edge - edge[axis];
                let low: [u32; 3] =
                    std::array::from_fn(|axis| (p[axis] - p[axis] % edge[axis]).min(last(axis)));
                let expected = in_box(&field, low, std::array::from_fn(|axis| low[axis] + edge[axis]), p);
                assert!((field.sample(p) - expected).abs() < 1e-12, "{seed}: {leaf:?} {is_split:?} {p:?}");
            }
        }
    }
    assert!(counts.iter().all(|&n| n > 300), "{counts:?}");
}

#[test]
fn the_field_stays_between_the_owned_values_of_a_leaf() {
    let mut rng = SplitMix64::new(1);
    for seed in 0..SEEDS {
        let mesh = adversarial_corners(&adversarial_mesh(seed), seed);
        let field = AmrLattice::new(&mesh);
        for leaf in mesh.leaves() {
            let [low, high] = field.range(leaf);
            for p in points_of(leaf) {
                assert!((low..=high).contains(&field.sample(p)), "{seed}: {leaf:?} {p:?}");
            }
            let inside = |c: u32| f64::from(c) + rng.range(0.001, 0.999) * f64::from(leaf.edge);
            let value = field.value(leaf.low.map(inside));
            assert!(value >= low - 1e-12 && value <= high + 1e-12, "{seed}: {leaf:?}");
        }
    }
}

#[test]
fn halves_of_units_change_nothing() {
    for seed in 0..2 * AmrKind::ALL.len() as u64 {
        let mesh = adversarial_corners(&adversarial_mesh(seed), seed);
        let (field, halved) = (AmrLattice::new(&mesh), AmrLattice::new(&mesh.halved()));
        for p in points(field.dims()) {
            let s = field.sample(p);
            assert!(halved.sample(p.map(|c| 2 * c)) == s || s.is_nan());
        }
        for cell in points(mesh.dims()).filter(|&cell| mesh.find(cell).is_some()) {
            let middle = field.value(cell.map(|c| f64::from(c) + 0.5));
            assert!((halved.sample(cell.map(|c| 2 * c + 1)) - middle).abs() < 1e-12);
        }
    }
}

#[test]
fn leaves_without_a_finite_value_own_nothing() {
    let coarse = AmrLeaf { low: [0; 3], edge: 2, value: [2.0; 8] };
    let mut fine = AmrLeaf { low: [2, 0, 0], edge: 1, value: [1.0; 8] };
    fine.value[7] = f64::NAN;
    let field = AmrLattice::new(&AmrCells::new([4, 2, 2], vec![coarse, fine]).unwrap());
    assert_eq!(field.sample([2, 0, 0]), 2.0);
    assert!(!field.is_hybrid(&coarse));
    assert!(field.sample([3, 0, 0]).is_nan());
    assert!(field.value([2.5, 0.5, 0.5]).is_nan());
    assert!(field.value([-0.5, 0.5, 0.5]).is_nan());
    assert_eq!(field.value([1.5, 2.0, 2.0]), 2.0);
}

/// A leaf of zeros from (2, 2, 2) to (4, 4, 4), and small ones that touch it by edges only; where they own the middles of edges, they are 1.
#[test]
fn middles_follow_their_edges_and_are_clamped() {
    let touching = |lows: &[[u32; 3]]| {
        let mut leaves = vec![AmrLeaf { low: [2; 3], edge: 2, value: [0.0; 8] }];
        for &low in lows {
            let leaf = AmrLeaf { low, edge: 1, value: () };
            let is_middle = |c: usize| leaf.corner(c).iter().filter(|&&x| x == 3).count() == 1;
            let value = std::array::from_fn(|c| f64::from(u32::from(is_middle(c))));
            leaves.push(AmrLeaf { low, edge: 1, value });
        }
        AmrLattice::new(&AmrCells::new([6; 3], leaves).unwrap())
    };
    let one = touching(&[[4, 4, 2]]);
    let middles = [[4, 4, 3], [4, 3, 3], [3, 4, 3], [3, 3, 4], [3, 3, 3]];
    assert_eq!(middles.map(|p| one.sample(p)), [1.0, 0.5, 0.5, 0.0, 0.25]);
    // All edges of the face x = 4: its middle would be 2, that of the cell 1, and the four faces beside it have ½ each.
    let four = touching(&[[4, 4, 2], [4, 1, 2], [4, 2, 4], [4, 2, 1]]);
    assert_eq!([[4, 3, 3], [3, 4, 3], [2, 3, 3]].map(|p| four.sample(p)), [1.0, 0.5, 0.0]);
    assert_eq!(four.sample([3, 3, 3]), 0.5 * (1.0 + 4.0 * 0.5) - 0.25 * 4.0);
    assert_eq!(four.range(&AmrLeaf { low: [2; 3], edge: 2, value: () }), [0.0, 1.0]);
}

#[test]
fn bad_leaves_are_told_apart() {
    let leaf = |low, edge| AmrLeaf { low, edge, value: 0.0 };
    let fault = |leaves| AmrCells::new([8; 3], leaves).unwrap_err();
    let good = leaf([0; 3], 4);
    assert_eq!(fault(vec![good, leaf([3, 0, 0], 3)]), BadLeaf::Edge(1));
    assert_eq!(fault(vec![good, leaf([4, 0, 0], 0)]), BadLeaf::Edge(1));
    assert_eq!(fault(vec![good, leaf([4, 0, 1], 2)]), BadLeaf::Alignment(1));
    assert_eq!(fault(vec![good, leaf([0, 8, 0], 4)]), BadLeaf::Outside(1));
    assert_eq!(fault(vec![good, leaf([0; 3], 4)]), BadLeaf::Overlap(1, 0));
    assert_eq!(fault(vec![good, leaf([2, 3, 3], 1)]), BadLeaf::Overlap(1, 0));
    assert_eq!(fault(vec![leaf([2, 3, 3], 1), good]), BadLeaf::Overlap(0, 1));
    assert_eq!(BadLeaf::Overlap(0, 1).to_string(), "leaves 0 and 1 overlap");
}
