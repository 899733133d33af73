//! The field of a mesh at the points of a lattice.

use super::{AmrCells, AmrLeaf};
use crate::cell::{corners, trilinear};
use crate::{DenseLattice, Lattice};

/// The continuous field of a mesh: its values at all points of the lattice, between which it is trilinear.
///
/// A point is *owned* if it is a corner of a leaf; its value is that of the smallest such leaf. Of the others in closed leaves, let `s` be the
/// largest power of two that divides the three coordinates. One, two or three of them are no multiples of `2s`: the point is the
/// middle of an edge, a face or a cell of the lattice of spacing `2s`, and its value
///
/// - of an edge, the mean of its ends;
/// - of a face, ½·Σ(4 middles of edges) − ¼·Σ(4 corners), clamped to the range of these eight;
/// - of a cell, ½·Σ(6 middles of faces) − ¼·Σ(12 middles of edges) + ⅛·Σ(8 corners), clamped to the range of these 26.
///
/// All of them are in the same closed leaf: that has an edge of `2s` at least, or the point would be a corner of it. Other points are NaN, that
/// is, empty. Same-sized leaves are expected to agree at shared corners; otherwise the last one counts. Every point is computed
/// once, when the lattice is made, and takes nine bytes.
///
/// ```
/// use isoray_oracle::{AmrCells, AmrLattice, AmrLeaf, Lattice};
///
/// // A cell of edge 2 that is 0 throughout, beside one of edge 1 that is 1.
/// let coarse = AmrLeaf { low: [0, 0, 0], edge: 2, value: [0.0; 8] };
/// let fine = AmrLeaf { low: [2, 0, 0], edge: 1, value: [1.0; 8] };
/// let field = AmrLattice::new(&AmrCells::new([4, 2, 2], vec![coarse, fine]).unwrap());
/// assert_eq!(field.sample([2, 1, 1]), 1.0); // the corner of the fine cell, for both of them
/// assert_eq!(field.sample([1, 0, 0]), 0.5); // between (0, 0, 0), which is 0, and (2, 0, 0), which is 1
/// assert!(field.sample([4, 0, 0]).is_nan()); // in no cell
/// ```
#[derive(Clone, Debug)]
pub struct AmrLattice {
    samples: DenseLattice<f64>,
    owned: Vec<bool>,
}

/// What is known of a point before its value is.
#[derive(Clone, Copy, PartialEq)]
enum Point {
    InNoLeaf,
    InLeaf,
    Owned,
}

impl AmrLattice {
    /// Computes the values at all points of the lattice.
    ///
    /// # Panics
    ///
    /// If there are more points than addresses, or than fit into memory.
    pub fn new(mesh: &AmrCells<[f64; 8]>) -> Self {
        let dims = mesh.dims().map(|n| n + 1);
        let count = dims.iter().try_fold(1_usize, |n, &d| n.checked_mul(d as usize));
        let count = count.expect("points have addresses");
        let mut values = vec![f64::NAN; count];
        let mut points = vec![Point::InNoLeaf; count];
        // Smaller leaves after larger ones, whose values they replace.
        for &edge in mesh.edges() {
            let is_seen =
                |leaf: &&AmrLeaf<[f64; 8]>| leaf.edge == edge && leaf.value.iter().all(|v| v.is_finite());
            for leaf in mesh.leaves().iter().filter(is_seen) {
                for p in multiples(1, leaf.low, leaf.corner(7)) {
                    let point = &mut points[offset(dims, p)];
                    if *point == Point::InNoLeaf {
                        *point = Point::InLeaf;
                    }
                }
                for (c, &value) in leaf.value.iter().enumerate() {
                    points[offset(dims, leaf.corner(c))] = Point::Owned;
                    values[offset(dims, leaf.corner(c))] = value;
                }
            }
        }
        // Middles of lattice 2s need its points, middles of faces those of edges, middles of cells both.
        let largest = mesh.edges().first().copied().unwrap_or(1);
        for s in (0..largest.ilog2()).rev().map(|log| 1 << log) {
            for order in 1..=3 {
                for p in multiples(s, [0; 3], mesh.dims()) {
                    let odd = p.map(|c| c % (2 * s) != 0);
                    let at = offset(dims, p);
                    if odd.iter().filter(|&&o| o).count() == order && points[at] == Point::InLeaf {
                        values[at] = middle(p, s, odd, |q| values[offset(dims, q)]);
                    }
                }
            }
        }
        let samples = DenseLattice::from_vec(dims, values).expect("one value for each point");
        Self { samples, owned: points.iter().map(|&p| p == Point::Owned).collect() }
    }

    /// Whether a point of the lattice is a corner of a leaf.
    pub fn is_owned(&self, p: [u32; 3]) -> bool {
        let dims = self.dims();
        (0..3).all(|axis| p[axis] < dims[axis]) && self.owned[offset(dims, p)]
    }

    /// Whether the field in a leaf, or in a cube that is an octant of one, or of such a cube, may be more than the interpolant of its corners:
    /// another point of the closed cube is owned.
    pub fn is_hybrid<T>(&self, cube: &AmrLeaf<T>) -> bool {
        let is_corner = |p: [u32; 3]| (0..3).all(|axis| (p[axis] - cube.low[axis]).is_multiple_of(cube.edge));
        self.owned_in(cube).any(|p| !is_corner(p))
    }

    /// The least and the largest value of the field in a closed leaf that is not empty: those of its owned points.
    pub fn range<T>(&self, leaf: &AmrLeaf<T>) -> [f64; 2] {
        range(self.owned_in(leaf).map(|p| self.sample(p)))
    }

    fn owned_in<T>(&self, leaf: &AmrLeaf<T>) -> impl Iterator<Item = [u32; 3]> {
        multiples(1, leaf.low, leaf.corner(7)).filter(|&p| self.is_owned(p))
    }

    /// The field at a position in lattice coordinates; NaN in gaps and outside of the domain.
    ///
    /// A position between cells of the lattice belongs to the one above it, at the upper border to the last.
    pub fn value(&self, position: [f64; 3]) -> f64 {
        let dims = self.dims();
        let is_inside = |axis: usize| (0.0..=f64::from(dims[axis]) - 1.0).contains(&position[axis]);
        if dims.iter().any(|&n| n < 2) || !(0..3).all(is_inside) {
            return f64::NAN;
        }
        let cell: [u32; 3] = std::array::from_fn(|axis| (position[axis] as u32).min(dims[axis] - 2));
        let local = std::array::from_fn(|axis| position[axis] - f64::from(cell[axis]));
        trilinear(&corners(&self.samples, cell), local)
    }
}

impl Lattice for AmrLattice {
    fn dims(&self) -> [u32; 3] {
        self.samples.dims()
    }

    /// Outside the lattice the sample is NaN, as in gaps.
    fn sample(&self, p: [u32; 3]) -> f64 {
        self.samples.sample(p)
    }
}

/// The value in the middle of the edge, face or cell that reaches from `p` by `s` in both directions of the axes that are `odd`.
///
/// The three rules are one: what lies off the middle along `k` of the axes, by `s` each, has the weight −(−½)ᵏ.
pub(super) fn middle(p: [u32; 3], s: u32, odd: [bool; 3], value: impl Fn([u32; 3]) -> f64) -> f64 {
    let steps = |axis: usize| if odd[axis] { -1..=1 } else { 0..=0_i32 };
    let mut sum = 0.0;
    let mut seen = Vec::with_capacity(26);
    for z in steps(2) {
        for y in steps(1) {
            for x in steps(0) {
                let step = [x, y, z];
                let off = step.iter().filter(|&&d| d != 0).count() as i32;
                if off == 0 {
                    continue;
                }
                let v = value(std::array::from_fn(|axis| p[axis].wrapping_add_signed(step[axis] * s as i32)));
                sum -= (-0.5_f64).powi(off) * v;
                seen.push(v);
            }
        }
    }
    debug_assert!(seen.iter().all(|v| v.is_finite()), "all of them are in a closed leaf");
    let [low, high] = range(seen.into_iter());
    sum.max(low).min(high)
}

/// The least and the largest of some numbers.
pub(super) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// The points of a box, its border included, at multiples of `s` from its lowest corner.
pub(super) fn multiples(s: u32, low: [u32; 3], high: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let along = move |axis: usize| (low[axis]..=high[axis]).step_by(s as usize);
    along(2).flat_map(move |z| along(1).flat_map(move |y| along(0).map(move |x| [x, y, z])))
}

/// Where a point's value is, x fastest.
fn offset([nx, ny, _]: [u32; 3], [x, y, z]: [u32; 3]) -> usize {
    (z as usize * ny as usize + y as usize) * nx as usize + x as usize
}
