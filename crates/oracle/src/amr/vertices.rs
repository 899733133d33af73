//! From averages of cells to values at their corners.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use super::AmrCells;
use super::lattice::range;

/// What is done at a vertex around which an octant has no leaf: at the border of the domain, or of a gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// Prolonged: exact for linear fields, but the result may leave the range of the leaves that touch the vertex.
    Linear,
    /// Mirrored: stays in the range of the leaves that touch the vertex, but flattens the field within the last cell.
    Bounded,
}

/// Turns averages of cells into values at their corners; leaves with an average that is not finite are left out.
///
/// Around a vertex `p` are eight octants, with one leaf each. Let `h` be the edge of the smallest of them: the octant's *place* is the middle
/// of its cube of edge `h` at `p`. An octant gives the value that its leaf has at its place: the average, prolonged by the leaf's gradient, which
/// makes a difference if the leaf is larger. The mean of the eight is the value of the vertex, clamped to the range of the leaves' averages.
///
/// An octant that has no leaf takes the mean of those nearest to it, that is, with the fewest axes to cross: of what their leaves have at *its* place
/// if the border is linear, of what they give if it is bounded. In the first case, the value of the vertex is not clamped.
///
/// A leaf's gradient along an axis comes from the two cubes of its size next to it. A cube has a value if it is a leaf, or if smaller leaves
/// fill it: the average over them; none if it is part of a larger leaf or not filled. Of two, the central
/// difference is taken, of one, that to the leaf itself, and zero without any.
///
/// This is exact for fields that are constant, and for linear ones if the gradients of all leaves around the vertex have a cube to come from
/// along each axis, and if the border is linear or the octants all have leaves.
pub fn vertex_values(mesh: &AmrCells<f64>, border: Border) -> AmrCells<[f64; 8]> {
    let finite = mesh.leaves().iter().filter(|leaf| leaf.value.is_finite()).copied().collect();
    let mesh = AmrCells::new(mesh.dims(), finite).expect("some leaves of a mesh are a mesh");
    let leaves = Prolonged::new(&mesh);
    let mut known = HashMap::new();
    mesh.map(|leaf| {
        std::array::from_fn(|c| {
            let p = leaf.corner(c);
            *known.entry(p).or_insert_with(|| leaves.vertex(p, border))
        })
    })
}

/// A linear field for each leaf.
pub(super) struct Prolonged<'a> {
    mesh: &'a AmrCells<f64>,
    /// Of the leaves that were asked for.
    gradients: Mutex<HashMap<usize, [f64; 3]>>,
}

impl<'a> Prolonged<'a> {
    pub(super) fn new(mesh: &'a AmrCells<f64>) -> Self {
        Self { mesh, gradients: Mutex::default() }
    }

    /// The field of leaf `n` at a position inside of it or not.
    fn at(&self, n: usize, position: [f64; 3]) -> f64 {
        let leaf = &self.mesh.leaves()[n];
        let mut gradients = self.gradients.lock().unwrap_or_else(PoisonError::into_inner);
        let slope = *gradients.entry(n).or_insert_with(|| gradient(self.mesh, n));
        drop(gradients);
        let centre = leaf.centre();
        (0..3).fold(leaf.value, |v, axis| v + slope[axis] * (position[axis] - centre[axis]))
    }

    /// The value at a corner of a leaf.
    pub(super) fn vertex(&self, p: [u32; 3], border: Border) -> f64 {
        let around = self.mesh.around(p);
        let touching = || around.iter().flatten().map(|&n| &self.mesh.leaves()[n]);
        let h = touching().map(|leaf| leaf.edge).min().map_or(f64::NAN, f64::from);
        let place = |octant: usize| -> [f64; 3] {
            let side = |axis: usize| if octant >> axis & 1 == 1 { 0.5 } else { -0.5 };
            std::array::from_fn(|axis| f64::from(p[axis]) + side(axis) * h)
        };
        let given: [f64; 8] = std::array::from_fn(|octant| {
            let apart = |other: usize| (octant ^ other).count_ones();
            let with_leaf = || (0..8).filter_map(|other| around[other].map(|n| (other, n)));
            let least = with_leaf().map(|(other, _)| apart(other)).min();
            // The octant itself, if it has a leaf.
            let nearest = with_leaf().filter(|&(other, _)| Some(apart(other)) == least);
            let values = nearest.map(|(other, n)| match border {
                Border::Linear => self.at(n, place(octant)),
                Border::Bounded => self.at(n, place(other)),
            });
            mean(&values.collect::<Vec<_>>())
        });
        let value = mean(&given);
        if border == Border::Linear && around.contains(&None) {
            return value;
        }
        let [low, high] = range(touching().map(|leaf| leaf.value));
        value.max(low).min(high)
    }
}

/// The mean of some numbers.
fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The gradient of leaf `n`, per unit of the lattice.
fn gradient(mesh: &AmrCells<f64>, n: usize) -> [f64; 3] {
    let leaf = &mesh.leaves()[n];
    let edge = f64::from(leaf.edge);
    std::array::from_fn(|axis| {
        let beside = |coordinate: Option<u32>| {
            let mut low = leaf.low;
            low[axis] = coordinate?;
            average(mesh, low, leaf.edge)
        };
        let below = beside(leaf.low[axis].checked_sub(leaf.edge));
        let above = beside(leaf.low[axis].checked_add(leaf.edge));
        match (below, above) {
            (Some(below), Some(above)) => (above - below) / (2.0 * edge),
            (Some(below), None) => (leaf.value - below) / edge,
            (None, Some(above)) => (above - leaf.value) / edge,
            (None, None) => 0.0,
        }
    })
}

/// The average over a cube that is a leaf, or that smaller leaves fill.
fn average(mesh: &AmrCells<f64>, low: [u32; 3], edge: u32) -> Option<f64> {
    let leaf = &mesh.leaves()[mesh.find(low)?];
    if leaf.edge >= edge {
        return (leaf.edge == edge).then_some(leaf.value);
    }
    let half = edge / 2;
    let octants: Option<Vec<f64>> = (0..8)
        .map(|o| average(mesh, std::array::from_fn(|axis| low[axis] + (o >> axis & 1) * half), half))
        .collect();
    octants.map(|values| mean(&values))
}
