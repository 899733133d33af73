//! Adaptive meshes that touch each other in every way, with values that agree nowhere.

use super::SplitMix64;
use crate::{AmrCells, AmrLeaf};

/// The kinds of adversarial meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AmrKind {
    /// Cells of one size.
    Uniform,
    /// One cell of many is split into eight.
    SingleOct,
    /// A random octree of four levels. Cells that share a face, in some also an edge, in some a vertex, differ by one level at most.
    Balanced,
    /// A random octree of four levels, the smallest cells beside the largest.
    Unbalanced,
    /// Each level has a quarter of the edge of the one before it.
    RatioFour,
    /// A half or a quarter, in turn.
    MixedRatios,
    /// As `MixedRatios`, one cell in eight missing. The smallest edge is two, so that the gaps have points of their own.
    Gaps,
}

impl AmrKind {
    /// All kinds, in the order in which seeds cycle through them.
    pub const ALL: [Self; 7] = [
        Self::Uniform,
        Self::SingleOct,
        Self::Balanced,
        Self::Unbalanced,
        Self::RatioFour,
        Self::MixedRatios,
        Self::Gaps,
    ];

    /// A mesh of this kind, at most 49 points wide along each axis.
    pub fn generate(self, seed: u64) -> AmrCells<()> {
        const MISSING: u32 = 8;
        let mut rng = SplitMix64::new(seed);
        let rng = &mut rng;
        let mixed = if seed & 1 == 0 { [2, 4] } else { [4, 2] };
        match self {
            Self::Uniform => nested(&[], 4, rng),
            Self::SingleOct => {
                let dims: [u32; 3] = std::array::from_fn(|_| 2 * (2 + rng.below(3)));
                let mut leaves = filled([0; 3], dims, 2);
                let split = leaves.swap_remove(rng.below(leaves.len() as u32) as usize);
                leaves.extend(halves(&split));
                made(dims, leaves)
            }
            Self::Balanced => balanced(nested(&[2, 2, 2], 3, rng), 1 + rng.below(3)),
            Self::Unbalanced => nested(&[2, 2, 2], 3, rng),
            Self::RatioFour => nested(&[4, 4], 2, rng),
            Self::MixedRatios => nested(&mixed, 3, rng),
            Self::Gaps => {
                let whole = nested(&mixed, 3, rng).halved();
                let kept = whole.leaves().iter().filter(|_| rng.below(MISSING) != 0).copied();
                made(whole.dims(), kept.collect())
            }
        }
    }
}

/// A mesh of the kind that `seed` comes to in the cycle of [`AmrKind::ALL`].
pub fn adversarial_mesh(seed: u64) -> AmrCells<()> {
    AmrKind::ALL[(seed % AmrKind::ALL.len() as u64) as usize].generate(seed)
}

/// Random values at the corners of a mesh's leaves, each an f32: leaves of one size agree at shared corners, those of several do not.
pub fn adversarial_corners<T>(mesh: &AmrCells<T>, seed: u64) -> AmrCells<[f64; 8]> {
    mesh.map(|leaf| std::array::from_fn(|c| value(seed, leaf.corner(c), leaf.edge)))
}

/// Random averages of a mesh's leaves, each an f32.
pub fn adversarial_averages<T>(mesh: &AmrCells<T>, seed: u64) -> AmrCells<f64> {
    mesh.map(|leaf| value(seed, leaf.low, leaf.edge))
}

/// A value that depends on a point and an edge: any, one of few, or mostly zero, by the seed.
fn value(seed: u64, point: [u32; 3], edge: u32) -> f64 {
    let numbers = point.into_iter().chain([edge]);
    let mixed = numbers.fold(seed, |state, n| SplitMix64::new(state ^ u64::from(n)).next_u64());
    let mut rng = SplitMix64::new(mixed);
    match seed % 3 {
        0 => f64::from(rng.range(-1.0, 1.0) as f32),
        1 => f64::from(rng.below(5)),
        _ => f64::from(u32::from(rng.below(6) == 0)) * rng.sign(),
    }
}

/// Up to `most` cells along each axis, each split at random, and so are its parts, by one ratio after the other.
fn nested(ratios: &[u32], most: u32, rng: &mut SplitMix64) -> AmrCells<()> {
    const SPLIT_OF_SIXTEEN: u32 = 7;
    let edge: u32 = ratios.iter().product();
    let dims: [u32; 3] = std::array::from_fn(|_| edge * (1 + rng.below(most)));
    let mut leaves = filled([0; 3], dims, edge);
    for ratio in ratios {
        // Those of the last level only: the others have been decided on.
        let last = leaves.iter().map(|leaf| leaf.edge).min();
        let mut parts = Vec::new();
        for leaf in leaves {
            if Some(leaf.edge) == last && rng.below(16) < SPLIT_OF_SIXTEEN {
                parts.extend(filled(leaf.low, leaf.corner(7), leaf.edge / ratio));
            } else {
                parts.push(leaf);
            }
        }
        leaves = parts;
    }
    made(dims, leaves)
}

/// The cells of a box.
fn filled(low: [u32; 3], high: [u32; 3], edge: u32) -> Vec<AmrLeaf<()>> {
    let along = |axis: usize| (low[axis]..high[axis]).step_by(edge as usize);
    let mut leaves = Vec::new();
    for z in along(2) {
        for y in along(1) {
            leaves.extend(along(0).map(|x| AmrLeaf { low: [x, y, z], edge, value: () }));
        }
    }
    leaves
}

/// The eight parts of a leaf.
fn halves(leaf: &AmrLeaf<()>) -> Vec<AmrLeaf<()>> {
    filled(leaf.low, leaf.corner(7), leaf.edge / 2)
}

/// Splits cells until those that touch, with at most `apart` of the axes to cross, differ by a factor of two at most.
fn balanced(mesh: AmrCells<()>, apart: u32) -> AmrCells<()> {
    let mut mesh = mesh;
    loop {
        let mut is_split = vec![false; mesh.leaves().len()];
        for leaf in mesh.leaves() {
            for direction in 0..27_u32 {
                let step = [direction % 3, direction / 3 % 3, direction / 9].map(|d| d as i32 - 1);
                if step.iter().filter(|&&d| d != 0).count() as u32 > apart {
                    continue;
                }
                // Below the origin it wraps around, to where no leaf is.
                let beside = std::array::from_fn(|axis| {
                    leaf.low[axis].wrapping_add_signed(step[axis] * leaf.edge as i32)
                });
                if let Some(other) = mesh.find(beside) {
                    is_split[other] |= mesh.leaves()[other].edge > 2 * leaf.edge;
                }
            }
        }
        if !is_split.contains(&true) {
            return mesh;
        }
        let mut leaves = Vec::new();
        for (leaf, is_split) in mesh.leaves().iter().zip(is_split) {
            if is_split { leaves.extend(halves(leaf)) } else { leaves.push(*leaf) }
        }
        mesh = made(mesh.dims(), leaves);
    }
}

fn made(dims: [u32; 3], leaves: Vec<AmrLeaf<()>>) -> AmrCells<()> {
    AmrCells::new(dims, leaves).expect("made as leaves have to be")
}
