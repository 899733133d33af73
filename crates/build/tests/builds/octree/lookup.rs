//! Point location and neighbour finding, exhaustively against the dense array.

use isoray_grid::Scalar;
use isoray_octree::{
    AnyVolume, Block, CAP_EDGE, CAP_LEVEL, NODE_LEVEL, Node, OctreeView, OctreeVolume, Path, child_origin,
    extent, product,
};

use super::volumes::{Content, Sample, at, dense, for_all_volumes, octree, points};

/// Asserts that `block` holds the samples of the region of a cap at `origin`.
fn assert_block<T: Scalar>(
    block: &Block<'_, T>,
    origin: [u32; 3],
    size: [u32; 3],
    samples: &[T],
    what: &str,
) {
    let inside: [u32; 3] = std::array::from_fn(|a| CAP_EDGE.min(size[a] - origin[a]));
    let threshold = samples[samples.len() / 2];
    let at_least = block.at_least(threshold);
    for p in points(inside) {
        let expected = at(samples, size, [origin[0] + p[0], origin[1] + p[1], origin[2] + p[2]]);
        let found = block.sample(p);
        assert!(found.same_bits(expected), "{what}: {found:?}, not {expected:?} at {p:?} of {origin:?}");
        let bit = at_least >> (p[0] + CAP_EDGE * (p[1] + CAP_EDGE * p[2])) & 1;
        assert_eq!(bit == 1, expected >= threshold, "{what}: {expected:?} ≥ {threshold:?}");
    }
}

#[test]
fn point_location_finds_every_sample() {
    fn check<T: Sample>(size: [u32; 3], content: Content)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        let samples = dense::<T>(size, content);
        let volume = octree(size, &samples);
        let view = volume.view();
        for p in points(size) {
            let expected = at(&samples, size, p);
            let found = view.sample(p);
            assert!(found.same_bits(expected), "{size:?} {content:?} {p:?}: {found:?}, not {expected:?}");
        }
        for origin in points(size.map(|n| n.div_ceil(CAP_EDGE))).map(|p| p.map(|c| c * CAP_EDGE)) {
            assert_block(&view.locate(origin), origin, size, &samples, "located");
        }
        // Nothing exists outside.
        for axis in 0..3 {
            for beyond in [size[axis], size[axis].next_power_of_two(), 1 << 21, u32::MAX] {
                let mut p = size.map(|n| n - 1);
                p[axis] = beyond;
                assert!(view.sample(p).same_bits(T::default()), "{size:?}: a sample at {p:?}");
                let nowhere = view.locate(p).as_constant();
                assert!(nowhere.is_some_and(|s| s.same_bits(T::default())), "{size:?}: a block at {p:?}");
            }
        }
    }
    for_all_volumes!(check);
}

/// Visits every block of a cap's size, in the way of a traversal: depth first, with one [`Path`] that is kept.
fn visit_blocks<'a, T: Scalar>(
    view: &OctreeView<'a, T>,
    (node, level, origin): (&'a Node<T::Stored>, u32, [u32; 3]),
    path: &mut Path<'a, T>,
    visit: &mut impl FnMut(&Path<'a, T>, [u32; 3]),
) {
    for octant in 0..8 {
        let corner = child_origin(origin, level, octant);
        let size = extent(view.dims(), corner, level - 1);
        if product(size) == 0 {
            continue;
        }
        if level == NODE_LEVEL {
            visit(path, corner);
        } else if node.is_stored(octant) {
            let child = &view.nodes(level - 1)[node.child(octant)];
            path.enter_node(level - 1, child);
            visit_blocks(view, (child, level - 1, corner), path, visit);
        } else {
            path.enter_leaf(level - 1, node, octant);
            for block in points(size.map(|n| n.div_ceil(CAP_EDGE))) {
                visit(path, std::array::from_fn(|a| corner[a] + block[a] * CAP_EDGE));
            }
        }
    }
}

/// The block `steps` blocks away from `origin`, if that is in the domain.
fn neighbor(origin: [u32; 3], steps: [i64; 3], size: [u32; 3]) -> Option<[u32; 3]> {
    let to = std::array::from_fn(|a| i64::from(origin[a]) + steps[a] * i64::from(CAP_EDGE));
    let inside = (0..3).all(|a| (0..i64::from(size[a])).contains(&to[a]));
    inside.then(|| to.map(|c| u32::try_from(c).unwrap()))
}

#[test]
fn every_block_finds_its_26_neighbors() {
    fn check<T: Sample>(size: [u32; 3], content: Content)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        let samples = dense::<T>(size, content);
        let volume = octree(size, &samples);
        let view = volume.view();
        let mut path = Path::default();
        path.enter_node(view.root_level(), view.root().unwrap());
        let mut blocks = 0;
        visit_blocks(
            &view,
            (view.root().unwrap(), view.root_level(), [0; 3]),
            &mut path,
            &mut |path, from| {
                blocks += 1;
                for steps in points([3; 3]).map(|p| p.map(|c| i64::from(c) - 1)) {
                    let Some(to) = neighbor(from, steps, size) else { continue };
                    let what = format!("{size:?} {content:?} {from:?} to {steps:?}");
                    assert_block(&path.neighbor(&view, from, to), to, size, &samples, &what);
                    // From any point of the block to any of the other.
                    let last: [u32; 3] = std::array::from_fn(|a| (size[a] - 1).min(to[a] + CAP_EDGE - 1));
                    assert_block(&path.neighbor(&view, from.map(|c| c + 3), last), to, size, &samples, &what);
                }
            },
        );
        let expected: u32 = size.iter().map(|n| n.div_ceil(CAP_EDGE)).product();
        assert_eq!(blocks, expected, "{size:?} {content:?}");
    }
    for_all_volumes!(check);
}

#[test]
fn every_block_finds_every_other_however_far() {
    const SIZE: [u32; 3] = [33, 31, 18];
    let samples = dense::<i16>(SIZE, Content::Blocks);
    let volume = octree(SIZE, &samples);
    let view = volume.view();
    let mut path = Path::default();
    path.enter_node(view.root_level(), view.root().unwrap());
    let mut pairs = 0;
    visit_blocks(&view, (view.root().unwrap(), view.root_level(), [0; 3]), &mut path, &mut |path, from| {
        for to in points(SIZE.map(|n| n.div_ceil(CAP_EDGE))).map(|p| p.map(|c| c * CAP_EDGE)) {
            assert_block(&path.neighbor(&view, from, to), to, SIZE, &samples, "neighbour");
            pairs += 1;
        }
    });
    assert_eq!(pairs, (9 * 8 * 5_u32).pow(2));
}

#[test]
fn the_volumes_have_scalar_leaves_of_every_level() {
    let samples = dense::<u8>([32; 3], Content::Blocks);
    let volume = octree([32; 3], &samples);
    let view = volume.view();
    let has_leaf =
        |level| view.nodes(level).iter().any(|node| (0..8).any(|n| !node.is_stored(n))) && level > CAP_LEVEL;
    assert!((NODE_LEVEL..=5).all(has_leaf), "{:?}", volume.statistics());
}
