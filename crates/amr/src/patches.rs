//! What a mesh is made of, as simulations write it.

use glam::{DAffine3, DVec3};
use isoray_grid::Dims;

use crate::error::MeshError;
use crate::levels::Levels;
use crate::values::Values;

/// Where the values of a patch are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Centering {
    /// One for each cell: its average.
    Cells,
    /// One for each corner of a cell.
    Vertices,
}

/// A box of cells of one level, and their values.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// 0 is the coarsest.
    pub level: u32,
    /// The lowest cell, counted in cells of this level from the origin of level 0.
    pub low: [i32; 3],
    /// The number of cells along each axis.
    pub cells: [u32; 3],
    /// x fastest. Of cells, or of vertices, of which there is one more along each axis. Values that are not finite make cells empty.
    pub values: Values,
}

/// Patches of all levels.
///
/// Coordinates are those of level 0: cell `(i, j, k)` is the cube from there to `(i+1, j+1, k+1)`. A cell of level `l` has the edge
/// 1/(r₀·…·rₗ₋₁), with the `ratios` r. Where patches of several levels overlap, the finest wins.
#[derive(Clone, Debug, PartialEq)]
pub struct Patches {
    /// Where the values are.
    pub centering: Centering,
    /// Cells of level `l + 1` along the edge of one of level `l`: 2 or 4.
    pub ratios: Vec<u32>,
    /// From coordinates of level 0 to the world.
    pub index_to_world: DAffine3,
    /// The box that level 0 fills: its lowest cell, and the number of its cells along each axis.
    pub domain: ([i32; 3], [u32; 3]),
    /// In any order.
    pub patches: Vec<Patch>,
}

impl Patch {
    /// How many values there are along each axis.
    pub fn value_dims(&self, centering: Centering) -> [u32; 3] {
        match centering {
            Centering::Cells => self.cells,
            Centering::Vertices => self.cells.map(|n| n + 1),
        }
    }
}

/// A cell of an octree, as a code writes it.
#[derive(Clone, Debug, PartialEq)]
pub struct OctreeLeaf {
    /// Its low corner, in edges of the smallest cells there may be.
    pub low: [u32; 3],
    /// Its edge, a power of two of them.
    pub edge: u32,
    /// Its average, or the values at its corners, x fastest.
    pub values: Vec<f32>,
}

impl Patches {
    /// Points of the finest lattice along each axis, and from it to the world: those of the [`Mesh`](crate::Mesh) that they make.
    ///
    /// # Errors
    /// Ratios or a domain that no mesh has.
    pub fn lattice(&self) -> Result<(Dims, DAffine3), MeshError> {
        let levels = Levels::new(self)?;
        Ok((levels.dims()?, levels.index_to_world(self.index_to_world)))
    }

    /// Cells of all levels, also where finer ones cover them.
    pub fn cell_count(&self) -> u64 {
        self.patches.iter().map(|patch| patch.cells.iter().map(|&n| u64::from(n)).product::<u64>()).sum()
    }

    /// Cells of octrees, each a patch, in a domain of `extent` of the smallest cells' edges from the origin on, which must be as many of the largest; `index_to_world` takes
    /// those units to the world. A ratio from level to level of two is assumed: a level may have no cells.
    pub fn of_leaves(
        centering: Centering,
        index_to_world: DAffine3,
        extent: [u32; 3],
        leaves: impl IntoIterator<Item = OctreeLeaf>,
    ) -> Self {
        let leaves: Vec<_> = leaves.into_iter().collect();
        let exponents = || leaves.iter().map(|leaf| leaf.edge.max(1).ilog2());
        let (least, largest) = (exponents().min().unwrap_or(0), exponents().max().unwrap_or(0));
        let counts: Vec<usize> = leaves.iter().map(|leaf| leaf.values.len()).collect();
        let all = leaves.iter().flat_map(|leaf| leaf.values.iter().copied()).collect();
        let patch = |(OctreeLeaf { low, edge, .. }, values): (OctreeLeaf, Values)| {
            let exponent = edge.max(1).ilog2();
            let low = low.map(|c| (c >> exponent) as i32);
            Patch { level: largest - exponent, low, cells: [1; 3], values }
        };
        Self {
            centering,
            ratios: vec![2; (largest - least) as usize],
            index_to_world: index_to_world * DAffine3::from_scale(DVec3::splat(f64::from(largest).exp2())),
            domain: ([0; 3], extent.map(|n| n >> largest)),
            patches: leaves.into_iter().zip(Values::parts(all, counts)).map(patch).collect(),
        }
    }
}
