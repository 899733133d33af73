//! Every method finds every sample, from anywhere near.

use glam::DAffine3;
use isoray_build::build;
use isoray_grid::{DenseVolume, Dims};
use isoray_octree::{OctreeVolume, Path};

use super::*;

const METHODS: [Method; 4] = [Method::TopDown, Method::FriskenPerry, Method::Knoll2006, Method::Jump];

/// Constant in large parts, so that there are scalar leaves of all sizes.
fn volume(n: [u32; 3]) -> (Dims, Vec<u16>, OctreeVolume<u16>) {
    let dims = Dims::new(n).unwrap();
    let [nx, ny, nz] = n;
    let samples: Vec<u16> = (0..nx * ny * nz)
        .map(|n| [n % nx, n / nx % ny, n / (nx * ny)])
        .map(|[x, y, z]| if x < 16 || y > 29 { 7 } else { (x + 40 * y + 1600 * (z / 5)) as u16 })
        .collect();
    let octree = build(&mut DenseVolume::new(dims, &samples).unwrap(), DAffine3::IDENTITY, |_| {}).unwrap();
    (dims, samples, octree)
}

#[test]
fn all_methods_find_every_sample_and_its_neighbours() {
    for n in [[37, 41, 33], [5, 3, 2], [8, 8, 64]] {
        let (dims, samples, octree) = volume(n);
        let tree = Tree::new(octree.view());
        let at = |p: [u32; 3]| samples[dims.linear(p)];
        let points = (0..n[2]).flat_map(|z| (0..n[1]).flat_map(move |y| (0..n[0]).map(move |x| [x, y, z])));
        for from in points {
            let (trail, nodes) = tree.trail(from);
            assert_eq!(nodes.len(), trail.depth + 1);
            assert!(trail.leaf().is_none_or(|(_, value)| value == at(from)));
            for method in METHODS {
                assert_eq!(tree.sample(method, from, &mut ()), at(from), "{method:?} {from:?}");
            }
            for step in 0..27 {
                let step = [step % 3, step / 3 % 3, step / 9];
                let to: [u32; 3] = std::array::from_fn(|a| (from[a] + step[a]).wrapping_sub(1));
                if !dims.contains(to) {
                    continue;
                }
                for method in METHODS {
                    let found = tree.neighbor(method, &trail, [from, to], &mut ());
                    assert_eq!(found, at(to), "{method:?} from {from:?} to {to:?}");
                }
            }
        }
    }
}

/// The way to `p` as the project keeps it.
fn path<'a>(tree: &Tree<'a, u16>, p: [u32; 3]) -> Path<'a, u16> {
    let (trail, nodes) = tree.trail(p);
    let mut path = Path::default();
    for (level, &node) in tree.levels().zip(&nodes) {
        path.enter_node(level, node);
    }
    if let (Some((level, _)), Some(&parent)) = (trail.leaf(), nodes.last()) {
        path.enter_leaf(level, parent, octant_of(p, level + 1));
    }
    path
}

#[test]
fn the_copy_that_is_counted_ends_in_the_same_blocks() {
    let n = [37, 41, 33];
    let (dims, _, octree) = volume(n);
    let view = octree.view();
    let tree = Tree::new(view);
    let mut constant = 0;
    for from in
        (0..dims.samples() as u32).step_by(7).map(|at| [at % n[0], at / n[0] % n[1], at / (n[0] * n[1])])
    {
        let (trail, _) = tree.trail(from);
        let path = path(&tree, from);
        let ours = view.locate(from);
        let found = tree.by_codes(tree.root(), view.root_level(), from, &mut ());
        assert_eq!((found.samples(), found.as_constant()), (ours.samples(), ours.as_constant()), "{from:?}");
        for step in 0..27 {
            let step = [step % 3, step / 3 % 3, step / 9];
            let to: [u32; 3] = std::array::from_fn(|a| (from[a] + step[a]).wrapping_sub(1));
            if dims.contains(to) {
                let [ours, found] =
                    [path.neighbor(&view, from, to), tree.step_by_jump(&trail, [from, to], &mut ())];
                let [ours, found] = [ours, found].map(|block| (block.samples(), block.as_constant()));
                assert_eq!(found, ours, "from {from:?} to {to:?}");
                constant += u32::from(ours.1.is_some());
            }
        }
    }
    assert!(constant > 1000);
}

#[test]
fn the_work_is_that_of_the_way() {
    let (_, _, octree) = volume([64, 64, 64]);
    let tree = Tree::new(octree.view());
    let count = |work: &dyn Fn(&mut Count)| {
        let mut count = Count::default();
        work(&mut count);
        count
    };
    // Of 64³ samples the root is of level 6, and the parents of caps of level 3.
    for method in METHODS {
        assert_eq!(count(&|c| _ = tree.sample(method, [20, 9, 9], c)), Count { nodes: 4, levels: 0 });
    }
    let (trail, _) = tree.trail([23, 9, 9]);
    let work = |method, to| count(&|c| _ = tree.neighbor(method, &trail, [[23, 9, 9], to], c));
    // In the same cap; and across the middle of a node of level 5, the third above that cap.
    for (to, levels) in [([23, 9, 10], [3, 1, 1]), ([24, 9, 9], [5, 2, 1])] {
        let nodes = if to[0] == 23 { 1 } else { 2 };
        for (method, levels) in
            [Method::FriskenPerry, Method::Knoll2006, Method::Jump].into_iter().zip(levels)
        {
            assert_eq!(work(method, to), Count { nodes, levels }, "{method:?} to {to:?}");
        }
        assert_eq!(work(Method::TopDown, to).nodes, 4);
    }
}
