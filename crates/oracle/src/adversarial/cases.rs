//! Stretches in cells on which root finders usually fail.

use super::{SplitMix64, adversarial_cell};
use crate::CellCase;

/// Least denormal number.
const DENORMAL: f64 = 1.5e-45;

/// A cell, an isovalue and a stretch made from `seed`: of all kinds in turn.
///
/// Cells: the [kinds](super::CellKind) of cells, cubics with planted roots a chosen gap apart, down to a few units in the last place, and any
/// of these scaled to 10^±30 or among denormal numbers, or with one huge corner, or with equal corners. Isovalues: zero, a corner's value,
/// that of all corners, values beside them. Stretches: between faces, edges and vertices; nearly parallel to axes; inside; of
/// length zero; those of rays from far away, whose ends are rounded.
pub fn adversarial_case(seed: u64) -> CellCase {
    let mut rng = SplitMix64::new(seed);
    let rng = &mut rng;
    let is_planted = rng.below(3) == 0;
    let cell = if is_planted { planted(rng) } else { adversarial_cell(seed) };
    let samples = distorted(rng, cell).map(|s| s as f32);
    // Planted roots are roots of the diagonal, at zero.
    if is_planted && rng.below(4) != 0 {
        let flip: [bool; 3] = std::array::from_fn(|_| rng.coin());
        let [entry, exit] = [0.0, 1.0].map(|end| flip.map(|flip| if flip { 1.0 - end } else { end }));
        let flips = (0..3).map(|a| usize::from(flip[a]) << a).sum::<usize>();
        return CellCase { samples: std::array::from_fn(|c| samples[c ^ flips]), isovalue: 0.0, entry, exit };
    }
    let isovalue = match rng.below(6) {
        0 => samples[rng.below(8) as usize],
        1 => samples[rng.below(8) as usize].next_up(),
        2 => (rng.range(-1.0, 1.0) * f64::from(samples[0])) as f32,
        _ => 0.0,
    };
    let [entry, exit] = stretch(rng);
    CellCase { samples, isovalue, entry, exit }
}

/// A cell whose cubic along the main diagonal has planted roots.
fn planted(rng: &mut SplitMix64) -> [f64; 8] {
    let first = match rng.below(4) {
        0 => 0.0,
        1 => 1.0,
        _ => rng.unit(),
    };
    let mut gap = || rng.sign() * 10_f64.powf(rng.range(-8.0, 0.5)) * f64::from(rng.below(5) != 0);
    let roots = [first, first + gap(), first + gap()];
    // The polar form of the product of (s − r): the mean over the ways to give each factor one argument.
    let blossom = |s: [f64; 3]| {
        const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let product = |order: [usize; 3]| (0..3).map(|n| s[order[n]] - roots[n]).product::<f64>();
        ORDERS.into_iter().map(product).sum::<f64>() / 6.0
    };
    let b: [f64; 4] =
        std::array::from_fn(|n| blossom(std::array::from_fn(|k| if k < n { 1.0 } else { 0.0 })));
    let mut corners: [f64; 8] = std::array::from_fn(|c| b[c.count_ones() as usize]);
    // What leaves the sums, and so the cubic, as they are.
    for [up, down] in [[1, 2], [2, 4], [3, 5], [5, 6]] {
        let shift = rng.range(-0.5, 0.5) * f64::from(rng.below(2));
        corners[up] += shift;
        corners[down] -= shift;
    }
    corners
}

/// Scaled, or with one corner out of the line, or as it is.
fn distorted(rng: &mut SplitMix64, mut cell: [f64; 8]) -> [f64; 8] {
    let scaled = |scale: f64| cell.map(|s| s * scale);
    match rng.below(16) {
        0 => scaled(1e30),
        1 => scaled(1e-30),
        2 => scaled(DENORMAL * 1000.0),
        3 => {
            cell[rng.below(8) as usize] = rng.sign() * 1e6;
            cell
        }
        4 => [cell[0]; 8],
        5 => scaled(1.0 / 3.0),
        _ => cell,
    }
}

/// Both ends of a stretch.
fn stretch(rng: &mut SplitMix64) -> [[f32; 3]; 2] {
    let mut entry: [f32; 3] = std::array::from_fn(|_| coordinate(rng));
    let mut exit: [f32; 3] = std::array::from_fn(|_| coordinate(rng));
    match rng.below(8) {
        // Nearly parallel to an axis, or exactly so.
        0 | 1 => {
            let along = rng.below(3) as usize;
            for axis in (0..3).filter(|&axis| axis != along) {
                let tilt = [0.0, 1e-7, 1e-38, DENORMAL][rng.below(4) as usize] as f32;
                exit[axis] = (entry[axis] + tilt).min(1.0);
            }
            (entry[along], exit[along]) = if rng.coin() { (0.0, 1.0) } else { (1.0, 0.0) };
        }
        2 => exit = entry,
        // From a ray whose origin is 10⁶ away: ends are off the line by what rounding leaves of that.
        3 => {
            let far = |c: f32| ((f64::from(c) + 1e6) as f32 - 1e6).clamp(0.0, 1.0);
            (entry, exit) = (entry.map(far), exit.map(far));
        }
        // From face to face.
        4..=6 => {
            entry[rng.below(3) as usize] = rng.below(2) as f32;
            exit[rng.below(3) as usize] = rng.below(2) as f32;
        }
        _ => {}
    }
    [entry, exit]
}

/// A cell-local coordinate: often on a face, or next to one.
fn coordinate(rng: &mut SplitMix64) -> f32 {
    match rng.below(8) {
        0 => 0.0,
        1 => 1.0,
        2 => 1.0 - f32::EPSILON / 2.0,
        3 => rng.range(0.0, 1e-6) as f32,
        _ => rng.unit() as f32,
    }
}
