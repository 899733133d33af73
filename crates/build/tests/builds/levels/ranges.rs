//! Ranges bound what is in a coarse cell.

use isoray_grid::Scalar;
use isoray_octree::{AnyVolume, Coarse, NODE_LEVEL, Node, OctreeView, OctreeVolume, Range, child_origin};

use super::dense::{KINDS, Pyramid, SIZES, octree, top};
use crate::octree::volumes::{CONTENTS, Content, Sample, dense, points};

fn bounds<T: Scalar>(outer: Range<T>, inner: Range<T>) -> bool {
    inner.min > inner.max || (outer.min <= inner.min && inner.max <= outer.max)
}

/// The range of all samples of the lattices of levels `levels` in the closed box of the cube of edge `2^level` at `origin`; empty if there are no cells.
fn closed<T: Scalar>(
    pyramid: &Pyramid<T>,
    size: [u32; 3],
    (level, origin): (u32, [u32; 3]),
    levels: std::ops::RangeInclusive<u32>,
) -> Range<T> {
    let mut range = Range::EMPTY;
    if (0..3).any(|a| origin[a] + 1 >= size[a]) {
        return range;
    }
    for finer in levels {
        let along: [Vec<u32>; 3] = std::array::from_fn(|a| {
            let ends = (0..=1 << (level - finer)).map(|i| (origin[a] + (i << finer)).min(size[a] - 1));
            ends.collect()
        });
        for i in points(along.each_ref().map(|places| places.len() as u32)) {
            range.include(pyramid.at(finer, std::array::from_fn(|a| along[a][i[a] as usize])));
        }
    }
    range
}

#[test]
fn coarse_ranges_bound_their_corners_and_finer_cells() {
    fn check<T: Sample>(size: [u32; 3], content: Content)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        let samples = dense::<T>(size, content);
        for kind in KINDS {
            let volume = octree(size, &samples, kind);
            let view = volume.view();
            let pyramid = Pyramid::new(size, &samples, kind, top(size));
            for level in 0..=view.root_level() {
                for index in points(size.map(|n| n.div_ceil(1 << level))) {
                    let origin = index.map(|c| c << level);
                    let inner = closed(&pyramid, size, (level, origin), 0..=level);
                    let outer = view.coarse_range(level, origin, kind);
                    assert!(
                        bounds(outer, inner),
                        "{size:?} {content:?} {kind:?} level {level} at {origin:?}: {outer:?}, in it {inner:?}"
                    );
                }
            }
        }
    }
    for size in SIZES {
        check::<u8>(size, Content::Blocks);
        check::<i8>(size, Content::Specks);
        check::<f32>(size, Content::Noise);
    }
    for content in CONTENTS {
        check::<u16>([17, 16, 15], content);
        check::<i16>([33, 9, 5], content);
        check::<f32>([18, 3, 17], content);
    }
}

/// Ranges of edge 8 and more hold nothing but what they must.
fn assert_tight<T: Scalar>(
    view: &OctreeView<'_, T>,
    (node, level, origin): (&Node<T::Stored>, u32, [u32; 3]),
    pyramid: &Pyramid<T>,
    lattices: bool,
) {
    let size = view.dims().axes();
    for octant in 0..8 {
        let corner = child_origin(origin, level, octant);
        let coarsest = if lattices && level > NODE_LEVEL { level - 1 } else { 0 };
        let expected = closed(pyramid, size, (level - 1, corner), 0..=coarsest);
        assert_eq!(node.range(octant as usize), expected, "{size:?}: level {} at {corner:?}", level - 1);
        if level > NODE_LEVEL && node.is_stored(octant) {
            let child = &view.nodes(level - 1)[node.child(octant)];
            assert_tight(view, (child, level - 1, corner), pyramid, lattices);
        }
    }
}

#[test]
fn ranges_are_tight() {
    for size in SIZES {
        let contents = [Content::Noise, Content::Blocks, Content::Specks];
        for (content, kind) in contents.into_iter().flat_map(|c| KINDS.map(|k| (c, k))) {
            let samples = dense::<i16>(size, content);
            let volume = octree(size, &samples, kind);
            let view = volume.view();
            let pyramid = Pyramid::new(size, &samples, kind, top(size));
            let root = (view.root().unwrap(), view.root_level(), [0; 3]);
            assert_tight(&view, root, &pyramid, kind != Coarse::Injected);
        }
    }
}

#[test]
fn a_nan_empties_the_coarse_cells_that_it_takes_part_in() {
    let size = [33; 3];
    let mut samples: Vec<f32> = points(size).map(|[x, y, z]| (x + 2 * y + 3 * z) as f32).collect();
    samples[(9 * 33 + 9) * 33 + 9] = f32::NAN;
    let is_nan = |kind, level, p| {
        let sample: f32 = octree(size, &samples, kind).view().coarse_sample(level, p, kind).unwrap();
        sample.is_nan()
    };
    // (9, 9, 9) is on no coarse lattice, so that injection does not see it.
    for (kind, p, expected) in [
        (Coarse::Injected, [8; 3], false),
        (Coarse::Mean, [8; 3], true),
        (Coarse::Mean, [10; 3], false),
        (Coarse::Filtered, [8; 3], true),
        (Coarse::Filtered, [10; 3], true),
        (Coarse::Filtered, [12; 3], false),
    ] {
        assert_eq!(is_nan(kind, 1, p), expected, "{kind:?} {p:?}");
    }
    assert!(is_nan(Coarse::Mean, 3, [8; 3]) && is_nan(Coarse::Filtered, 3, [8; 3]));
}
