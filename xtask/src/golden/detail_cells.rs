//! What the oracle knows of the cells of a picture with levels of detail: their levels, and differences across them, by what is said of `central_gradient` in
//! `crates/trace/src/detail_tracer.rs`.

use isoray_oracle::{DenseLattice, GRAZING_VOXELS, Lattice, OracleHit, central_gradient};

use super::detail_field::DetailField;
use super::isosurfaces::{BESIDE, Cells};

/// Cells of a field, and the field on the finest lattice.
pub(crate) struct DetailCells<'a> {
    pub(crate) field: &'a DetailField<'a>,
    pub(crate) lattice: &'a DenseLattice<f64>,
}

/// The lattice of a level: the corners of a cell are those of the picture, other samples as they are on that lattice, whatever is drawn there.
struct Around<'a> {
    of: &'a DetailCells<'a>,
    level: u32,
    cell: [u32; 3],
}

impl Lattice for Around<'_> {
    fn dims(&self) -> [u32; 3] {
        [0, 1, 2].map(|a| (self.of.field.last(a) >> self.level) + 1)
    }

    fn sample(&self, p: [u32; 3]) -> f64 {
        let is_corner = (0..3).all(|a| p[a].checked_sub(self.cell[a]).is_some_and(|by| by <= 1));
        let p = p.map(|c| c << self.level);
        if is_corner { self.of.lattice.sample(p) } else { self.of.field.sample(self.level, p) }
    }
}

impl Cells for DetailCells<'_> {
    fn level_at(&self, point: [f64; 3]) -> Option<u32> {
        self.field.level_at(point, GRAZING_VOXELS)
    }

    /// Not of the cells that the domain's border cuts short, nor next to a face, as the cell beyond it may have other corners.
    fn central_gradient(&self, hit: &OracleHit) -> Option<[f64; 3]> {
        let level = self.field.level_at(hit.position, BESIDE)?;
        let edge = f64::from(1u32 << level);
        let cell = hit.cell.map(|c| c >> level);
        let is_inside = |a: usize| {
            let by = hit.position[a] - f64::from(cell[a]) * edge;
            (BESIDE..=edge - BESIDE).contains(&by)
        };
        let is_whole = |a: usize| (cell[a] + 1) << level <= self.field.last(a);
        let around = Around { of: self, level, cell };
        let gradient = || central_gradient(&around, hit.position.map(|c| c / edge), cell).map(|g| g / edge);
        (0..3).all(|a| is_inside(a) && is_whole(a)).then(gradient)
    }
}
