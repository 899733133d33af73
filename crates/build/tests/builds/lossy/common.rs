//! Small volumes of every type, and what becomes of them.

use isoray_build::{Changes, Loss, Lossy, build};
use isoray_grid::{DenseVolume, Dims, Scalar, ScalarType, SlabSource};
use isoray_octree::OctreeVolume;
use isoray_oracle::{LatticeKind, SplitMix64};

/// Calls `$check::<T>(…)` for all sample types.
macro_rules! for_all_types {
    ($check:ident($($argument:expr),*)) => {
        $check::<u8>($($argument),*);
        $check::<i8>($($argument),*);
        $check::<u16>($($argument),*);
        $check::<i16>($($argument),*);
        $check::<f32>($($argument),*);
    };
}
pub(crate) use for_all_types;

/// The sample nearest to `value`; for integer types never one that is not finite.
pub(crate) fn sample<T: Scalar>(value: f32) -> T {
    let whole = T::TYPE != ScalarType::F32;
    let value = if whole { value.round() } else { value };
    match T::threshold(value) {
        isoray_grid::Threshold::AtLeast(sample) => sample,
        // Too high, too low or not a number; an f32 that is not finite is itself.
        isoray_grid::Threshold::NoSurface if whole => {
            if value > 0.0 {
                T::HIGHEST
            } else {
                T::LOWEST
            }
        }
        isoray_grid::Threshold::NoSurface => T::read_from_bytes(&value.to_le_bytes()).unwrap(),
    }
}

/// Sizes of no and one cell, below, at and beyond the edges of caps and blocks, and beyond a piece of a row.
pub(crate) fn size(seed: u64) -> [u32; 3] {
    const SIZES: [[u32; 3]; 8] =
        [[1, 1, 1], [1, 9, 4], [3, 2, 2], [8, 8, 8], [17, 9, 5], [12, 13, 21], [270, 4, 3], [9, 31, 11]];
    SIZES[seed as usize % SIZES.len()]
}

/// The samples of a volume: gentle ones with plateaus, noise on them, or anything that is hard.
pub(crate) fn samples<T: Scalar>(dims: [u32; 3], seed: u64) -> Vec<T> {
    let random = &mut SplitMix64::new(seed);
    let values = match seed % 3 {
        0 => LatticeKind::ALL[seed as usize / 3 % LatticeKind::ALL.len()].generate(dims, seed),
        _ => {
            let (steep, noise) = (random.range(0.1, 9.0), random.range(0.0, 2.0));
            let centre = dims.map(|n| random.range(0.0, n.into()));
            let lattice = isoray_oracle::DenseLattice::from_fn(dims, |p| {
                let distance = (0..3).map(|a| (f64::from(p[a]) - centre[a]).powi(2)).sum::<f64>().sqrt();
                ((distance - 5.0) * steep).clamp(-20.0, 60.0) as f32 + random.range(0.0, noise) as f32
            });
            lattice.samples().to_vec()
        }
    };
    values.into_iter().map(sample).collect()
}

pub(crate) fn dense<T: Scalar>(dims: [u32; 3], samples: &[T]) -> DenseVolume<'_, T> {
    DenseVolume::new(Dims::new(dims).unwrap(), samples).unwrap()
}

/// What becomes of the samples, and how many of them change how far.
pub(crate) fn lose<T: Scalar>(dims: [u32; 3], samples: &[T], loss: &Loss) -> (Vec<T>, Changes) {
    let mut source = Lossy::new(dense(dims, samples), loss).unwrap();
    let mut out = vec![T::default(); samples.len()];
    source.read_layers(0, &mut out).unwrap();
    (out, source.changes())
}

pub(crate) fn octree<T: Scalar>(dims: [u32; 3], samples: &[T]) -> OctreeVolume<T> {
    build(&mut dense(dims, samples), glam::DAffine3::IDENTITY, |_| {}).unwrap()
}

pub(crate) fn widened<T: Scalar>(samples: &[T]) -> Vec<f32> {
    samples.iter().map(|s| s.to_f32()).collect()
}
