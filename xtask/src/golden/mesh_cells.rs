//! What the oracle knows of the cells of a mesh: how large those are in which the renderer interpolates, and differences across them, as far apart as the cell is wide.

use isoray_oracle::{GRAZING_VOXELS, Lattice, OracleHit, central_gradient};

use super::isosurfaces::{BESIDE, Cells};
use crate::finest::{Field, Finest};

/// A mesh, and its field.
pub(crate) struct MeshCells<'a> {
    pub(crate) finest: &'a Finest,
    pub(crate) field: &'a Field<'a>,
}

/// Every so-manieth point of the field along each axis.
struct Sparse<'a> {
    field: &'a Field<'a>,
    edge: u32,
}

impl Lattice for Sparse<'_> {
    fn dims(&self) -> [u32; 3] {
        self.field.dims().map(|n| (n - 1) / self.edge + 1)
    }

    fn sample(&self, p: [u32; 3]) -> f64 {
        self.field.sample(p.map(|c| c * self.edge))
    }
}

impl MeshCells<'_> {
    /// The edge of the cube that is interpolated at a point, if there is no cube of another one next to it.
    fn edge_at(&self, point: [f64; 3], close: f64) -> Option<u32> {
        let last = self.field.dims().map(|n| f64::from(n) - 1.5);
        let ends = [-close, close].map(|by| [0, 1, 2].map(|a| (point[a] + by).clamp(0.0, last[a]) as u32));
        let mut edges = (0..8usize)
            .map(|n| [0, 1, 2].map(|a| ends[n >> a & 1][a]))
            .filter_map(|cell| self.finest.cube(cell));
        let edge = edges.next()?;
        edges.all(|other| other == edge).then_some(edge)
    }
}

impl Cells for MeshCells<'_> {
    fn level_at(&self, point: [f64; 3]) -> Option<u32> {
        Some((self.edge_at(point, GRAZING_VOXELS)? / self.finest.scale() as u32).ilog2())
    }

    fn central_gradient(&self, hit: &OracleHit) -> Option<[f64; 3]> {
        let edge = self.edge_at(hit.position, BESIDE)?;
        let sparse = Sparse { field: self.field, edge };
        let position = hit.position.map(|c| c / f64::from(edge));
        Some(central_gradient(&sparse, position, hit.cell.map(|c| c / edge)).map(|g| g / f64::from(edge)))
    }
}
