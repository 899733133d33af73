//! Linear data stay what they are.

use isoray_octree::{AnyVolume, Coarse, OctreeVolume};

use super::dense::{octree, places};
use crate::octree::volumes::{Sample, points};

/// How far coarse samples of `size` samples of `f` are from `f`, at most.
fn worst<T: Sample>(size: [u32; 3], kind: Coarse, f: impl Fn([u32; 3]) -> T) -> f64
where
    AnyVolume: From<OctreeVolume<T>>,
{
    let samples: Vec<T> = points(size).map(&f).collect();
    let volume = octree(size, &samples, kind);
    let view = volume.view();
    let mut worst = 0.0_f64;
    for level in 1..=5 {
        let along = size.map(|n| places(n, level));
        for i in points(std::array::from_fn(|a| along[a].len() as u32)) {
            let p = std::array::from_fn(|a| along[a][i[a] as usize]);
            let found: T = view.coarse_sample(level, p, kind).unwrap();
            worst = worst.max(f64::from((found.to_f32() - f(p).to_f32()).abs()));
        }
    }
    worst
}

const SIZES: [[u32; 3]; 2] = [[33, 65, 17], [50, 31, 42]];
const SLOPES: [[i32; 3]; 6] = [[1, 0, 0], [0, -3, 0], [0, 0, 2], [1, 2, 3], [-1, 4, -7], [5, -5, 5]];

#[test]
fn whole_ramps_of_integers_are_exact() {
    for (size, slope) in SIZES.into_iter().flat_map(|size| SLOPES.map(|slope| (size, slope))) {
        let value = |p: [u32; 3]| (0..3).map(|a| slope[a] * p[a] as i32).sum::<i32>();
        for kind in [Coarse::Injected, Coarse::Filtered] {
            assert_eq!(worst(size, kind, |p| value(p) as i16), 0.0, "{size:?} {slope:?} {kind:?}");
            assert_eq!(worst(size, kind, |p| (value(p) + 1000) as u16), 0.0, "{size:?} {slope:?} {kind:?}");
        }
        // Half a voxel more at every level.
        assert!(worst(size, Coarse::Mean, |p| value(p) as i16) >= 1.0, "{size:?} {slope:?}");
    }
}

#[test]
fn ramps_of_floats_are_exact_to_rounding() {
    for (size, slope) in SIZES.into_iter().flat_map(|size| SLOPES.map(|slope| (size, slope))) {
        let value = |p: [u32; 3]| (0..3).map(|a| f64::from(slope[a]) * 0.1 * f64::from(p[a])).sum::<f64>();
        assert_eq!(worst(size, Coarse::Injected, |p| value(p) as f32), 0.0);
        // Half a unit of the samples' last place, another for each of five means, of numbers up to about 100.
        let bound = 100.0 * f64::from(f32::EPSILON) / 2.0 * 6.0;
        let found = worst(size, Coarse::Filtered, |p| value(p) as f32);
        assert!(found <= bound, "{size:?} {slope:?}: {found}");
    }
}
