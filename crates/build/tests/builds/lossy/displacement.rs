//! How far a point is from an isosurface, along the axes, by plain f64 arithmetic.

use isoray_oracle::{DenseLattice, Lattice, OracleHit};

/// What a point found by the oracle may be off, and what a line through it is farther from the surface for that, in voxels: its position is
/// exact to 10⁻¹⁴ here, and slopes across the line are less than 10⁴ times those along it.
const SLACK: f64 = 1e-9;

/// Whether a hit on one lattice's isosurface has the other lattice's within `reach` along an axis.
pub(crate) fn is_near(
    hit: &OracleHit,
    on: &DenseLattice<f32>,
    other: &DenseLattice<f32>,
    v: f64,
    reach: f64,
) -> bool {
    let corner =
        |l: &DenseLattice<f32>, n: u32| l.sample(std::array::from_fn(|a| hit.cell[a] + (n >> a & 1)));
    let is_same_cell = (0..8).all(|n| corner(on, n) == corner(other, n));
    is_same_cell || (0..3).any(|axis| crosses(other, hit.position, axis, v, reach + SLACK))
}

/// Whether the field passes the isovalue on the stretch of length `reach` to both sides of `p`.
fn crosses(l: &DenseLattice<f32>, p: [f64; 3], axis: usize, v: f64, reach: f64) -> bool {
    let last = l.dims().map(|n| f64::from(n - 1));
    let (begin, end) = ((p[axis] - reach).max(0.0), (p[axis] + reach).min(last[axis]));
    // The field is linear from plane to plane.
    let mut planes = vec![begin];
    planes.extend((begin.ceil() as u32..=end.floor() as u32).map(f64::from));
    planes.push(end);
    // On a lattice plane there is a cell to both sides.
    let sides = |a: usize| if p[a].fract() == 0.0 { [p[a] - 1.0, p[a]] } else { [p[a].floor(); 2] };
    let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
    sides(b).into_iter().flat_map(|at_b| sides(c).map(|at_c| (at_b, at_c))).any(|(at_b, at_c)| {
        let mut seen = [false; 2];
        for pair in planes.windows(2).filter(|pair| pair[1] > pair[0]) {
            let mut cell = [0.0; 3];
            (cell[axis], cell[b], cell[c]) = (pair[0].floor(), at_b, at_c);
            let values = pair_values(l, cell, p, axis, pair);
            let Some(values) = values else {
                seen = [false; 2];
                continue;
            };
            values.into_iter().for_each(|s| seen[usize::from(s >= v)] = true);
            if seen == [true; 2] {
                return true;
            }
        }
        false
    })
}

/// The values at two places of a line in a cell; `None` where there is no cell, or an empty one.
fn pair_values(
    l: &DenseLattice<f32>,
    cell: [f64; 3],
    p: [f64; 3],
    axis: usize,
    pair: &[f64],
) -> Option<[f64; 2]> {
    let dims = l.dims();
    if (0..3).any(|a| cell[a] < 0.0 || cell[a] + 1.0 > f64::from(dims[a] - 1)) {
        return None;
    }
    let mut values = [0.0; 2];
    for (value, &at) in values.iter_mut().zip(pair) {
        let mut q = p;
        q[axis] = at;
        for n in 0..8u32 {
            let corner: [f64; 3] = std::array::from_fn(|a| cell[a] + f64::from(n >> a & 1));
            let weight: f64 = (0..3).map(|a| 1.0 - (q[a] - corner[a]).abs()).product();
            let s = l.sample(corner.map(|c| c as u32));
            if !s.is_finite() {
                return None;
            }
            *value += weight * s;
        }
    }
    Some(values)
}
