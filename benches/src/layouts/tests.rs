//! The counts against structures that exist.

use isoray_build::build;
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_octree::{OctreeVolume, cap_reach};

use super::{NodeKind, Payload, Tally};
use crate::knoll2006::PaperOctree;

/// Slopes and plateaus, noise in a corner, and of floating-point numbers some that are none.
fn samples<T: Scalar>(dims: Dims, of: fn(u32) -> T) -> Vec<T> {
    let mut state = 1_u32;
    let mut sample = |n: usize| {
        let [nx, ny, _] = dims.axes().map(|n| n as usize);
        let [i, j, k] = [n % nx, n / nx % ny, n / (nx * ny)];
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        of(match (i / 9 + j / 10 + k / 11) % 3 {
            0 => 5,
            1 => 40 + (i + j / 2 + k / 3) as u32,
            _ => state >> 8,
        })
    };
    (0..dims.samples()).map(&mut sample).collect()
}

fn octree<T: Scalar>(dims: Dims, samples: &[T]) -> OctreeVolume<T> {
    build(&mut DenseVolume::new(dims, samples).unwrap(), glam::DAffine3::IDENTITY, |_| {}).unwrap()
}

fn check<T: Scalar>(of: fn(u32) -> T) {
    let payload = if T::IS_INTEGER { Payload::Range } else { Payload::Raw };
    for size in [[1, 1, 1], [2, 2, 2], [3, 2, 1], [8, 8, 8], [17, 9, 30], [33, 70, 12], [64, 64, 64]] {
        let dims = Dims::new(size).unwrap();
        let samples = samples(dims, of);
        let tally = Tally::of(dims, &samples, 4, false);
        let real = octree(dims, &samples);
        let counted = tally.node_bytes(NodeKind::Mask) + tally.cap_bytes(payload) + cap_reach::<T>() as u64;
        assert_eq!(counted, real.structure_bytes() as u64, "{dims} {}", T::TYPE);
        let tally = Tally::of(dims, &samples, 2, false);
        let counted = tally.node_bytes(NodeKind::Offsets) + tally.whole_cap_bytes();
        assert_eq!(counted, PaperOctree::build(dims, &samples).bytes() as u64, "{dims} {}", T::TYPE);
    }
}

#[test]
fn counts_are_those_of_real_structures() {
    check(|n| n as u8);
    check(|n| n as i8);
    check(|n| n as u16);
    check(|n| n as i16);
    check(|n| if n.is_multiple_of(50) { f32::NAN } else { n as f32 });
}

#[test]
fn noise_is_no_more_than_raw_and_the_tree() {
    fn check<T: Scalar>(n: u32, of: fn(u32) -> T) {
        let dims = Dims::new([n; 3]).unwrap();
        let mut state = 7_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            of(state >> 8)
        };
        let samples: Vec<T> = (0..dims.samples()).map(|_| random()).collect();
        let raw = size_of_val(samples.as_slice());
        let volume = octree(dims, &samples);
        // At the border the caps of a parent may end short of a multiple of eight samples.
        let parents = (n as usize).div_ceil(8).pow(3) - (n as usize / 8).pow(3);
        let most = raw + cap_reach::<T>() + parents * 8 * size_of::<T>();
        let caps = volume.statistics()[0].bytes;
        assert!(caps <= most, "{dims} {}: {caps} bytes of caps, {raw} raw", T::TYPE);
    }
    for n in [32, 45, 64] {
        check(n, |n| (n >> 8) as u8);
        check(n, |n| (n >> 4) as u16);
        check(n, |n| (n >> 4) as i16);
        check(n, |n| n as f32);
    }
}

#[test]
fn a_volume_counted_by_hand() {
    // One cap of 4³ in the corner of 8³ has two values, 3 apart; the rest is zero.
    let dims = Dims::new([8, 8, 8]).unwrap();
    let mut samples = vec![0_u8; 512];
    samples[dims.linear([1, 1, 1])] = 3;
    let tally = Tally::of(dims, &samples, 4, false);
    assert_eq!((tally.nodes, tally.stored, tally.caps), (1, 1, 1));
    let bytes = Payload::ALL.map(|payload| tally.cap_bytes(payload));
    // 64 samples of 8 and of 2 bits; the last with two bytes more, which begin a unit of eight.
    assert_eq!(bytes, [64, 16, 16, 24]);
    assert_eq!(NodeKind::ALL.map(|kind| tally.node_bytes(kind)), [56, 36, 29, 28]);
    // The apron of the cap is as empty as the seven others; 125 samples.
    let tally = Tally::of(dims, &samples, 4, true);
    assert_eq!((tally.caps, tally.cap_bytes(Payload::Raw)), (1, 128));
    // In caps of 2³ it is in one, and in the aprons of seven more if it is moved to an even place.
    let mut samples = vec![0_u8; 512];
    samples[dims.linear([2, 2, 2])] = 3;
    assert_eq!(Tally::of(dims, &samples, 2, false).caps, 1);
    assert_eq!(Tally::of(dims, &samples, 2, true).caps, 8);
}
