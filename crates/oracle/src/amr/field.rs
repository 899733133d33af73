//! The field of a mesh, a point at a time.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Mutex, PoisonError};

use super::lattice::middle;
use super::vertices::Prolonged;
use super::{AmrCells, AmrLeaf, Border};
use crate::Lattice;

/// The field that an [`AmrLattice`](crate::AmrLattice) has, a point of it computed when it is asked for, and kept: for meshes whose lattice is too large to be held.
///
/// Every leaf's values are expected to be finite; without a leaf there is a gap.
pub struct AmrField<'m, T> {
    mesh: &'m AmrCells<T>,
    /// The value at a corner of a leaf.
    vertex: Box<dyn Fn([u32; 3]) -> f64 + Sync + 'm>,
    known: Mutex<HashMap<[u32; 3], f64>>,
}

impl<T> fmt::Debug for AmrField<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AmrField").field("dims", &self.mesh.dims()).finish_non_exhaustive()
    }
}

impl<'m> AmrField<'m, [f64; 8]> {
    /// Of values at corners: a vertex has that of the smallest leaf it is a corner of.
    pub fn of_corners(mesh: &'m AmrCells<[f64; 8]>) -> Self {
        let vertex = move |p| {
            let leaves = mesh.leaves();
            let around = mesh.around(p).into_iter().flatten();
            let of = around.filter(|&n| corner(&leaves[n], p).is_some());
            let smallest = of.min_by_key(|&n| (leaves[n].edge, std::cmp::Reverse(n)));
            smallest.map_or(f64::NAN, |n| leaves[n].value[corner(&leaves[n], p).unwrap_or(0)])
        };
        Self { mesh, vertex: Box::new(vertex), known: Mutex::default() }
    }
}

impl<'m> AmrField<'m, f64> {
    /// Of averages: vertices are those of [`vertex_values`](crate::vertex_values).
    pub fn of_averages(mesh: &'m AmrCells<f64>, border: Border) -> Self {
        let leaves = Prolonged::new(mesh);
        Self { mesh, vertex: Box::new(move |p| leaves.vertex(p, border)), known: Mutex::default() }
    }
}

impl<T: Sync> AmrField<'_, T> {
    fn value(&self, p: [u32; 3]) -> f64 {
        let around = self.mesh.around(p);
        let mut touching = around.into_iter().flatten().map(|n| &self.mesh.leaves()[n]).peekable();
        if touching.peek().is_none() {
            return f64::NAN;
        }
        if touching.any(|leaf| corner(leaf, p).is_some()) {
            return (self.vertex)(p);
        }
        // Not the origin, which is a corner of what touches it.
        let s = 1 << p.into_iter().map(u32::trailing_zeros).min().unwrap_or(0);
        middle(p, s, p.map(|c| c % (2 * s) != 0), |q| self.sample(q))
    }
}

impl<T: Sync> Lattice for AmrField<'_, T> {
    fn dims(&self) -> [u32; 3] {
        self.mesh.dims().map(|n| n + 1)
    }

    /// Outside the lattice the sample is NaN, as in gaps.
    fn sample(&self, p: [u32; 3]) -> f64 {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().get(&p).copied();
        found.unwrap_or_else(|| {
            let value = self.value(p);
            known().insert(p, value);
            value
        })
    }
}

/// Which corner of a leaf a point is.
pub(super) fn corner<T>(leaf: &AmrLeaf<T>, p: [u32; 3]) -> Option<usize> {
    (0..8).find(|&c| leaf.corner(c) == p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AmrKind, AmrLattice, adversarial_averages, adversarial_corners, vertex_values};

    /// Bit for bit, gaps included.
    fn compare<T: Sync>(field: &AmrField<'_, T>, lattice: &AmrLattice) {
        let [nx, ny, nz] = lattice.dims();
        assert_eq!(field.dims(), lattice.dims());
        for p in (0..nx * ny * nz).map(|n| [n % nx, n / nx % ny, n / (nx * ny)]) {
            assert_eq!(field.sample(p).to_bits(), lattice.sample(p).to_bits(), "{p:?}");
        }
        assert!(field.sample([nx, 0, 0]).is_nan());
    }

    #[test]
    fn all_points_are_those_of_the_lattice() {
        for kind in AmrKind::ALL {
            for seed in 0..4 {
                let shape = kind.generate(seed);
                let corners = adversarial_corners(&shape, seed);
                compare(&AmrField::of_corners(&corners), &AmrLattice::new(&corners));
                let averages = adversarial_averages(&shape, seed);
                for border in [Border::Linear, Border::Bounded] {
                    let lattice = AmrLattice::new(&vertex_values(&averages, border));
                    compare(&AmrField::of_averages(&averages, border), &lattice);
                }
            }
        }
    }
}
