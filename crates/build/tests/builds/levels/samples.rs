//! Coarse samples against those of the dense array.

use isoray_grid::Dims;
use isoray_octree::{AnyVolume, Coarse, OctreeVolume, coarse_dims, coarse_position};

use super::dense::{KINDS, Pyramid, SIZES, agree, octree, places, top};
use crate::octree::volumes::{CONTENTS, Content, Sample, dense, points};

#[test]
fn coarse_samples_are_those_of_the_dense_array() {
    fn check<T: Sample>(size: [u32; 3], content: Content)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        let samples = dense::<T>(size, content);
        for kind in KINDS {
            let volume = octree(size, &samples, kind);
            assert_eq!(volume.meta().coarse, kind);
            let view = volume.view();
            let pyramid = Pyramid::new(size, &samples, kind, top(size));
            for level in 0..=top(size) {
                let along = size.map(|n| places(n, level));
                for i in points(std::array::from_fn(|a| along[a].len() as u32)) {
                    let p = std::array::from_fn(|a| along[a][i[a] as usize]);
                    assert_eq!(coarse_position(view.dims(), level, i), p);
                    let found = view.coarse_sample(level, p, kind).unwrap();
                    // In small volumes the top is above the root, whose one sample counts from there on.
                    let expected = pyramid.at(level.min(view.root_level()), p);
                    assert!(
                        agree(found, expected),
                        "{size:?} {content:?} {kind:?} level {level} at {p:?}: {found:?}, expected {expected:?}"
                    );
                }
            }
            let unchanged = view.to_dense();
            assert!(unchanged.iter().zip(&samples).all(|(a, b)| a.same_bits(*b)), "{size:?} {kind:?}");
        }
    }
    for size in SIZES {
        for content in CONTENTS {
            check::<u8>(size, content);
            check::<f32>(size, content);
        }
        check::<i8>(size, Content::Noise);
        check::<u16>(size, Content::Blocks);
        check::<i16>(size, Content::Noise);
    }
}

#[test]
fn places_off_the_lattice_have_no_sample() {
    let size = [11, 9, 8];
    let volume = octree(size, &dense::<u8>(size, Content::Noise), Coarse::Filtered);
    let view = volume.view();
    assert!(view.coarse_sample(2, [8, 4, 4], Coarse::Filtered).is_some());
    assert!(view.coarse_sample(2, [10, 8, 7], Coarse::Filtered).is_some(), "the last one");
    for p in [[9, 4, 4], [8, 5, 4], [11, 8, 4], [12, 0, 0], [u32::MAX, 0, 0]] {
        assert_eq!(view.coarse_sample(2, p, Coarse::Filtered), None, "{p:?}");
    }
    assert_eq!(view.coarse_sample(1, [2; 3], Coarse::None), None);
    assert_eq!(view.coarse_sample(0, [2; 3], Coarse::None), Some(view.sample([2; 3])));
    assert_eq!(view.coarse_sample(u32::MAX, [0, 8, 7], Coarse::Injected), Some(view.sample([0, 8, 7])));
    assert_eq!(coarse_dims(Dims::new([1, 2, 17]).unwrap(), 3), [1, 2, 3]);
    assert_eq!(coarse_dims(Dims::new([16, 18, 33]).unwrap(), 4), [2, 3, 3]);
    assert_eq!(coarse_dims(Dims::new([16, 18, 33]).unwrap(), 99), [2; 3]);
}
