//! The check of coarse samples and their ranges.

use isoray_grid::Scalar;
use isoray_octree::{
    AnyVolume, Coarse, NODE_LEVEL, Node, OctreeVolume, Parts, check_well_formed, check_well_formed_as,
    child_origin,
};

use super::dense::{KINDS, SIZES, octree};
use crate::octree::volumes::{CONTENTS, Content, Sample, dense};

#[test]
fn what_is_built_is_well_formed() {
    fn check<T: Sample>(size: [u32; 3], content: Content)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        for kind in Coarse::ALL {
            let volume = octree(size, &dense::<T>(size, content), kind);
            assert_eq!(check_well_formed_as(&volume.view(), kind), Ok(()), "{size:?} {content:?} {kind:?}");
        }
    }
    for size in SIZES {
        for content in CONTENTS {
            check::<u8>(size, content);
        }
        check::<i16>(size, Content::Noise);
        check::<f32>(size, Content::Noise);
    }
}

#[test]
fn kinds_are_told_apart() {
    let size = [40, 35, 33];
    let samples = dense::<u16>(size, Content::Noise);
    for kind in KINDS {
        let volume = octree(size, &samples, kind);
        for other in KINDS {
            let found = check_well_formed_as(&volume.view(), other);
            assert_eq!(found.is_ok(), kind == other, "{kind:?} as {other:?}: {found:?}");
        }
    }
    let none = octree(size, &samples, Coarse::None);
    assert_eq!(check_well_formed(&none.view()), Ok(()));
}

/// Origins of all nodes, by level and index.
fn places<T: Scalar>(volume: &OctreeVolume<T>) -> Vec<(u32, usize, [u32; 3])> {
    let view = volume.view();
    let mut places = vec![(view.root_level(), 0, [0; 3])];
    let mut next = 0;
    while let Some(&(level, index, origin)) = places.get(next) {
        next += 1;
        let node = &view.nodes(level)[index];
        let stored = node.stored_before(8).filter(|_| level > NODE_LEVEL);
        places.extend(stored.map(|n| (level - 1, node.child(n), child_origin(origin, level, n))));
    }
    places
}

#[test]
fn every_change_of_a_node_is_refused() {
    let size = [40, 35, 17];
    for kind in [Coarse::Mean, Coarse::Filtered] {
        let volume = octree(size, &dense::<u16>(size, Content::Blocks), kind);
        let view = volume.view();
        let levels: Vec<_> =
            (NODE_LEVEL..=view.root_level()).map(|level| view.nodes(level).to_vec()).collect();
        let places = places(&volume);
        assert!(places.len() > 15, "{}", places.len());
        let refuses = |level: u32, index: usize, what: &str, change: &dyn Fn(&mut Node<_>)| {
            let mut parts = Parts { levels: levels.clone(), caps: view.caps().to_vec() };
            change(&mut parts.levels[(level - NODE_LEVEL) as usize][index]);
            let bad = OctreeVolume::<u16>::from_parts(volume.meta().clone(), parts);
            assert!(
                check_well_formed_as(&bad.view(), kind).is_err(),
                "{kind:?}: level {level}, node {index}: {what}"
            );
        };
        for (level, index, origin) in places {
            for octant in 0..8_usize {
                // No value of the volume, and above all of them.
                let other = 65_534_u16.into();
                refuses(level, index, "minimum", &|node| node.mins[octant] = other);
                refuses(level, index, "maximum", &|node| node.maxs[octant] = other);
                refuses(level, index, "mask", &|node| node.mask ^= 1 << octant);
                if view.dims().contains(child_origin(origin, level, octant as u32)) {
                    refuses(level, index, "value", &|node| node.values[octant] = other);
                }
            }
        }
    }
}
