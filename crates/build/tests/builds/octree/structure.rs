//! What the structure says of the samples: ranges, statistics, and the check of both.

use isoray_grid::{Dims, Scalar};
use isoray_octree::{
    AnyVolume, Meta, NODE_LEVEL, Node, OctreeView, OctreeVolume, Parts, Range, check_well_formed,
    child_origin,
};

use super::volumes::{Content, Sample, at, dense, for_all_volumes, octree, points};

/// The range of the cells whose low corners lie in the cube of edge `2^level` at `origin`, sample by sample.
fn range_of_cells<T: Scalar>(samples: &[T], size: [u32; 3], origin: [u32; 3], level: u32) -> Range<T> {
    let mut range = Range::EMPTY;
    let cells = std::array::from_fn(|a| (size[a] - 1).saturating_sub(origin[a]).min(1 << level));
    if cells.contains(&0) {
        return range;
    }
    for p in points(cells.map(|n| n + 1)) {
        range.include(at(samples, size, [origin[0] + p[0], origin[1] + p[1], origin[2] + p[2]]));
    }
    range
}

fn assert_ranges<T: Scalar>(
    view: &OctreeView<'_, T>,
    (node, level, origin): (&Node<T::Stored>, u32, [u32; 3]),
    samples: &[T],
) {
    let size = view.dims().axes();
    for octant in 0..8 {
        let corner = child_origin(origin, level, octant);
        let expected = range_of_cells(samples, size, corner, level - 1);
        let found = node.range(octant as usize);
        assert_eq!(found, expected, "{size:?}: child {octant} of level {level} at {origin:?}");
        if level > NODE_LEVEL && node.is_stored(octant) {
            let child = &view.nodes(level - 1)[node.child(octant)];
            assert_ranges(view, (child, level - 1, corner), samples);
        }
    }
}

#[test]
fn ranges_are_those_of_the_cells_inside_the_domain() {
    fn check<T: Sample>(size: [u32; 3], content: Content)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        let samples = dense::<T>(size, content);
        let volume = octree(size, &samples);
        let view = volume.view();
        assert_ranges(&view, (view.root().unwrap(), view.root_level(), [0; 3]), &samples);
        assert_eq!(check_well_formed(&view), Ok(()), "{size:?} {content:?}");
    }
    for_all_volumes!(check);
}

#[test]
fn decoding_is_bitwise() {
    fn check<T: Sample>(size: [u32; 3], content: Content)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        let samples = dense::<T>(size, content);
        let found = octree(size, &samples).view().to_dense();
        assert_eq!(found.len(), samples.len());
        assert!(found.iter().zip(&samples).all(|(a, b)| a.same_bits(*b)), "{size:?} {content:?}");
    }
    for_all_volumes!(check);
}

#[test]
fn statistics_are_those_of_the_samples() {
    fn check<T: Sample>(size: [u32; 3], content: Content)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        let samples = dense::<T>(size, content);
        let volume = octree(size, &samples);
        let meta = volume.meta();
        let finite: Vec<f32> = samples.iter().filter(|s| s.is_finite()).map(|s| s.to_f32()).collect();
        let least = finite.iter().copied().fold(f32::INFINITY, f32::min);
        let greatest = finite.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let expected = (!finite.is_empty()).then(|| [f64::from(least), f64::from(greatest)]);
        assert_eq!(meta.range, expected, "{size:?} {content:?}");
        assert_eq!(meta.non_finite, (samples.len() - finite.len()) as u64);
        assert_eq!(meta.histogram.iter().sum::<u64>(), finite.len() as u64, "{size:?} {content:?}");
        assert_eq!(volume.raw_bytes(), size_of_val(&*samples));
    }
    for_all_volumes!(check);
}

#[test]
fn equal_bits_are_what_merges() {
    let size = [16; 3];
    let nan = vec![f32::NAN; 4096];
    let caps = |volume: &OctreeVolume<f32>| volume.statistics()[0].count;
    assert_eq!(caps(&octree(size, &nan)), 0, "one NaN everywhere is one leaf");
    assert_eq!(octree(size, &nan).meta().range, None);
    let mut two = nan;
    two[0] = f32::from_bits(0x7fc0_0001);
    assert_eq!(caps(&octree(size, &two)), 1, "another NaN is another value");
    let mut zeros = vec![0.0_f32; 4096];
    zeros[4095] = -0.0;
    let volume = octree(size, &zeros);
    assert_eq!(caps(&volume), 1, "-0.0 is not 0.0");
    assert!(volume.view().sample([15; 3]).is_sign_negative());
}

/// The volume of `size` again, from parts that `change` has changed.
fn changed<T: Scalar>(volume: &OctreeVolume<T>, change: impl FnOnce(&mut Parts<T>)) -> OctreeVolume<T> {
    let view = volume.view();
    let levels = (NODE_LEVEL..=view.root_level()).map(|level| view.nodes(level).to_vec());
    let mut parts = Parts { levels: levels.collect(), caps: view.caps().to_vec() };
    change(&mut parts);
    OctreeVolume::from_parts(volume.meta().clone(), parts)
}

/// Origins of all nodes, by level and index.
fn origins<T: Scalar>(
    view: &OctreeView<'_, T>,
    (node, level, index, origin): (&Node<T::Stored>, u32, usize, [u32; 3]),
    found: &mut Vec<(u32, usize, [u32; 3])>,
) {
    found.push((level, index, origin));
    for octant in (0..8).filter(|&n| level > NODE_LEVEL && node.is_stored(n)) {
        let index = node.child(octant);
        let child = &view.nodes(level - 1)[index];
        origins(view, (child, level - 1, index, child_origin(origin, level, octant)), found);
    }
}

#[test]
fn the_check_refuses_every_change_of_a_node() {
    let size = [40, 35, 33];
    let samples: Vec<u16> = dense::<u16>(size, Content::Blocks);
    let volume = octree(size, &samples);
    let view = volume.view();
    let mut nodes = Vec::new();
    origins(&view, (view.root().unwrap(), view.root_level(), 0, [0; 3]), &mut nodes);
    assert!(nodes.len() > 20, "{}", nodes.len());
    let refuses = |level: u32, index: usize, what: &str, change: &dyn Fn(&mut Node<_>)| {
        let bad = changed(&volume, |parts| change(&mut parts.levels[(level - NODE_LEVEL) as usize][index]));
        assert!(check_well_formed(&bad.view()).is_err(), "level {level}, node {index}: {what}");
    };
    for (level, index, origin) in nodes {
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
        let node = &view.nodes(level)[index];
        if node.mask != 0 {
            for first in [node.first.get() + 1, node.first.get().wrapping_sub(1), u32::MAX, 1 << 31] {
                refuses(level, index, "link", &|node| node.first = first.into());
            }
        }
    }
}

#[test]
fn the_check_refuses_elements_that_nothing_links_to() {
    let size = [9, 9, 9];
    let volume = octree(size, &dense::<i8>(size, Content::Noise));
    let spare_cap = changed(&volume, |parts| parts.caps.extend([0; 16]));
    assert!(check_well_formed(&spare_cap.view()).unwrap_err().to_string().contains("nothing links to it"));
    let spare_node = changed(&volume, |parts| {
        let copy = parts.levels[0][0];
        parts.levels[0].push(copy);
    });
    assert!(check_well_formed(&spare_node.view()).is_err());
    let no_root = changed(&volume, |parts| parts.levels.truncate(1));
    assert!(check_well_formed(&no_root.view()).unwrap_err().to_string().contains("root is missing"));
}

/// A volume of `size` with the same eight nodes, linked to each other, at each level.
fn knotted(size: [u32; 3]) -> OctreeVolume<u8> {
    let meta = Meta {
        dims: Dims::new(size).unwrap(),
        index_to_world: glam::DAffine3::IDENTITY,
        range: Some([0.0, 255.0]),
        non_finite: 0,
        histogram: Box::new([0; isoray_octree::HISTOGRAM_BINS]),
        fidelity: isoray_octree::Fidelity::LOSSLESS,
        coarse: isoray_octree::Coarse::Injected,
    };
    let node = Node { mins: [0; 8], maxs: [255; 8], values: [0; 8], first: 0.into(), mask: 0xff };
    let levels = (NODE_LEVEL..=isoray_octree::root_level(meta.dims)).map(|_| vec![node; 8]).collect();
    OctreeVolume::from_parts(meta, Parts { levels, caps: vec![0; 512] })
}

#[test]
fn the_check_ends_whatever_the_dimensions() {
    // Two to the 57 samples in links that share all their nodes, and in one constant leaf.
    let size = [1 << 19; 3];
    assert!(check_well_formed(&knotted(size).view()).is_err());
    let leaves = changed(&knotted(size), |parts| {
        let leaf = Node { mins: [0; 8], maxs: [0; 8], values: [0_u8; 8], first: 0.into(), mask: 0 };
        parts.levels.iter_mut().for_each(Vec::clear);
        parts.levels.last_mut().unwrap().push(leaf);
        parts.caps.clear();
    });
    assert_eq!(check_well_formed(&leaves.view()), Ok(()));
    assert_eq!(leaves.view().sample([12_345; 3]), 0);
}
