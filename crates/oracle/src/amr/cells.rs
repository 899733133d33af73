//! Leaves of a mesh, and which one is where.

use std::collections::HashMap;
use std::fmt;

use super::field::corner;
use super::lattice::multiples;

/// A cell that no finer one covers: a cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmrLeaf<T> {
    /// Its lowest corner; each coordinate is a multiple of the edge.
    pub low: [u32; 3],
    /// The length of its edges, a power of two.
    pub edge: u32,
    /// Its average, an `f64`, or a value for each corner, `[f64; 8]`. Corner `c` lies at `x = c & 1`, `y = c >> 1 & 1`, `z = c >> 2`.
    pub value: T,
}

impl<T> AmrLeaf<T> {
    /// The lattice point that is corner `c`.
    pub fn corner(&self, c: usize) -> [u32; 3] {
        std::array::from_fn(|axis| self.low[axis] + (c >> axis & 1) as u32 * self.edge)
    }

    /// Its middle, in lattice coordinates.
    pub fn centre(&self) -> [f64; 3] {
        self.low.map(|c| f64::from(c) + 0.5 * f64::from(self.edge))
    }
}

/// Why leaves are no mesh; numbers count leaves in the order given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadLeaf {
    /// The edge is no power of two.
    Edge(usize),
    /// A coordinate is no multiple of the edge.
    Alignment(usize),
    /// It is not inside the domain.
    Outside(usize),
    /// Two have volume in common.
    Overlap(usize, usize),
}

impl fmt::Display for BadLeaf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Edge(n) => write!(f, "the edge of leaf {n} is no power of two"),
            Self::Alignment(n) => write!(f, "leaf {n} does not lie at multiples of its edge"),
            Self::Outside(n) => write!(f, "leaf {n} is not inside the domain"),
            Self::Overlap(n, other) => write!(f, "leaves {n} and {other} overlap"),
        }
    }
}

impl std::error::Error for BadLeaf {}

/// Leaves in the box from the origin to `dims`; they need not fill it.
#[derive(Clone, Debug)]
pub struct AmrCells<T> {
    dims: [u32; 3],
    leaves: Vec<AmrLeaf<T>>,
    /// By edge and low corner.
    places: HashMap<(u32, [u32; 3]), usize>,
    /// The edges that occur, descending.
    edges: Vec<u32>,
}

impl<T> AmrCells<T> {
    /// Checks that leaves are cubes of the domain without volume in common.
    ///
    /// # Errors
    ///
    /// The first leaf that is not as [`AmrLeaf`] says, or two that overlap.
    pub fn new(dims: [u32; 3], leaves: Vec<AmrLeaf<T>>) -> Result<Self, BadLeaf> {
        let mut places = HashMap::with_capacity(leaves.len());
        let mut edges = Vec::new();
        for (n, leaf) in leaves.iter().enumerate() {
            if !leaf.edge.is_power_of_two() {
                return Err(BadLeaf::Edge(n));
            }
            if leaf.low.iter().any(|c| c % leaf.edge != 0) {
                return Err(BadLeaf::Alignment(n));
            }
            let fits =
                |axis: usize| leaf.low[axis].checked_add(leaf.edge).is_some_and(|high| high <= dims[axis]);
            if !(0..3).all(fits) {
                return Err(BadLeaf::Outside(n));
            }
            if let Some(other) = places.insert((leaf.edge, leaf.low), n) {
                return Err(BadLeaf::Overlap(n, other));
            }
            if !edges.contains(&leaf.edge) {
                edges.push(leaf.edge);
            }
        }
        edges.sort_unstable_by(|a, b| b.cmp(a));
        let mesh = Self { dims, leaves, places, edges };
        // Cubes at multiples of their edges overlap only if one holds the other, and with it the other's lowest unit cell.
        for (n, leaf) in mesh.leaves.iter().enumerate() {
            if let Some(other) = mesh.find(leaf.low).filter(|&other| other != n) {
                return Err(BadLeaf::Overlap(n, other));
            }
        }
        Ok(mesh)
    }

    /// The number of unit cells along each axis; of points, there is one more.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// The leaves, in the order given.
    pub fn leaves(&self) -> &[AmrLeaf<T>] {
        &self.leaves
    }

    /// The edges that occur, descending.
    pub fn edges(&self) -> &[u32] {
        &self.edges
    }

    /// The number of the leaf that covers a unit cell, given by its lowest corner.
    pub fn find(&self, cell: [u32; 3]) -> Option<usize> {
        self.edges.iter().find_map(|&edge| self.places.get(&(edge, cell.map(|c| c - c % edge))).copied())
    }

    /// The leaves of the eight octants around a point: octant `o` lies above it along x if `o & 1`, y if `o >> 1 & 1`, z if `o >> 2`.
    pub fn around(&self, point: [u32; 3]) -> [Option<usize>; 8] {
        std::array::from_fn(|octant| {
            let mut cell = point;
            for axis in 0..3 {
                if octant >> axis & 1 == 0 {
                    cell[axis] = cell[axis].checked_sub(1)?;
                }
            }
            self.find(cell)
        })
    }

    /// The edge of the cube around a unit cell, given by its lowest corner, in which the field is surely the interpolant of its corners: the leaf, or the largest of its
    /// octants, of theirs and so on, that no corner of a leaf touches but at corners of its own.
    pub fn cube(&self, cell: [u32; 3]) -> Option<u32> {
        let mut edge = self.leaves[self.find(cell)?].edge;
        while self.is_touched(cell.map(|c| c - c % edge), edge) {
            edge /= 2;
        }
        Some(edge)
    }

    /// Whether a corner of a leaf lies in a closed cube, other than at its corners. All corners are at multiples of the smallest edge.
    fn is_touched(&self, low: [u32; 3], edge: u32) -> bool {
        let least = self.edges.last().copied().unwrap_or(1);
        multiples(least, low, low.map(|c| c + edge)).any(|p| {
            let is_own = (0..3).all(|axis| (p[axis] - low[axis]).is_multiple_of(edge));
            let mut around = self.around(p).into_iter().flatten();
            !is_own && around.any(|leaf| corner(&self.leaves[leaf], p).is_some())
        })
    }

    /// The same leaves with other values.
    pub fn map<U>(&self, mut value: impl FnMut(&AmrLeaf<T>) -> U) -> AmrCells<U> {
        let leaf = |leaf: &AmrLeaf<T>| AmrLeaf { low: leaf.low, edge: leaf.edge, value: value(leaf) };
        AmrCells {
            dims: self.dims,
            leaves: self.leaves.iter().map(leaf).collect(),
            places: self.places.clone(),
            edges: self.edges.clone(),
        }
    }

    /// The same mesh in units half as long: all coordinates double, and a gap of one unit gets a point in its middle.
    ///
    /// # Panics
    ///
    /// If a coordinate no longer fits into 32 bits.
    pub fn halved(&self) -> Self
    where
        T: Clone,
    {
        let double = |c: u32| c.checked_mul(2).expect("coordinates of half the size are 32-bit numbers");
        let leaf =
            |l: &AmrLeaf<T>| AmrLeaf { low: l.low.map(double), edge: double(l.edge), value: l.value.clone() };
        Self {
            dims: self.dims.map(double),
            leaves: self.leaves.iter().map(leaf).collect(),
            places: self.places.iter().map(|(&(e, low), &n)| ((double(e), low.map(double)), n)).collect(),
            edges: self.edges.iter().map(|&e| double(e)).collect(),
        }
    }
}
