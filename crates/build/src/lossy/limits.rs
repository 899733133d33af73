//! How much each sample may change so that isosurfaces keep within their bound.
//!
//! The derivation stands in [the module's documentation](super).

use super::surfaces::{Meeting, Surfaces};

/// Samples beyond a box on which the limits of the samples in it depend: two cells beyond it bound a sample's change, and the slope of
/// such a cell is taken of its neighbours too.
pub(super) const HALO: usize = 3;

/// A box of the lattice, x fastest. Where it ends before the domain, limits are right for samples [`HALO`] or more inside.
#[derive(Clone, Debug, Default)]
pub(super) struct Window {
    pub(super) size: [usize; 3],
    pub(super) samples: Vec<f32>,
    /// Where each of its cells is to the isosurfaces.
    meetings: Vec<Meeting>,
}

/// An axis along which the field is monotone in a cell, and in those of its two neighbours that surfaces meet.
struct Slope {
    axis: usize,
    /// The least change from corner to corner.
    least: f64,
    /// Whether the neighbour before and the one after are met.
    met: [bool; 2],
}

impl Window {
    /// Lowers `limits`, one a sample, to what `surfaces` allow. What surfaces do not bound keeps its limit: it only must keep to its
    /// [bracket](Surfaces::bracket).
    pub(super) fn limit(&mut self, surfaces: &Surfaces, limits: &mut [f64]) {
        let Some(cells) = self.cells() else { return };
        self.meet(surfaces, cells);
        for cell in (0..cells[2])
            .flat_map(|z| (0..cells[1]).map(move |y| [y, z]))
            .flat_map(|[y, z]| (0..cells[0]).map(move |x| [x, y, z]))
        {
            match self.meetings[linear(cells, cell)] {
                Meeting::Empty | Meeting::Apart => {}
                Meeting::Flat => self.lower(limits, cell, 0.0),
                Meeting::Met => self.limit_around(cell, cells, surfaces, limits),
            }
        }
    }

    /// Number of cells along each axis, if there are any.
    fn cells(&self) -> Option<[usize; 3]> {
        let cells = self.size.map(|n| n.saturating_sub(1));
        (!cells.contains(&0)).then_some(cells)
    }

    fn meet(&mut self, surfaces: &Surfaces, [cx, cy, cz]: [usize; 3]) {
        self.meetings.clear();
        let [nx, ny, _] = self.size;
        let mut columns: Vec<[f32; 2]> = Vec::with_capacity(nx);
        for (y, z) in (0..cz).flat_map(|z| (0..cy).map(move |y| (y, z))) {
            let row = |y, z| &self.samples[nx * (y + ny * z)..][..nx];
            let rows = [row(y, z), row(y + 1, z), row(y, z + 1), row(y + 1, z + 1)];
            columns.clear();
            columns.extend((0..nx).map(|x| range(rows.map(|row| row[x]))));
            self.meetings.extend(columns.windows(2).take(cx).map(|pair| {
                let [min, max] = [pair[0][0].min(pair[1][0]), pair[0][1].max(pair[1][1])];
                if min.is_finite() && max.is_finite() { surfaces.meeting(min, max) } else { Meeting::Empty }
            }));
        }
    }

    /// What a cell that is met asks of its corners, and of those of its neighbours.
    fn limit_around(&self, cell: [usize; 3], cells: [usize; 3], surfaces: &Surfaces, limits: &mut [f64]) {
        let mut best: Option<Slope> = None;
        if surfaces.share > 0.0 {
            for slope in (0..3).filter_map(|axis| self.slope(cell, cells, axis)) {
                if best.as_ref().is_none_or(|b| slope.least > b.least) {
                    best = Some(slope);
                }
            }
        }
        let Some(Slope { axis, least, met }) = best else { return self.lower(limits, cell, 0.0) };
        let limit = surfaces.share * least;
        self.lower(limits, cell, limit);
        for (offset, _) in [(-1, met[0]), (1, met[1])].into_iter().filter(|(_, is_met)| *is_met) {
            if let Some(neighbor) = neighbor(cell, cells, axis, offset) {
                self.lower(limits, neighbor, limit);
            }
        }
    }

    /// The slope along an axis, if it has one sign wherever a surface can be displaced to.
    fn slope(&self, cell: [usize; 3], cells: [usize; 3], axis: usize) -> Option<Slope> {
        let [mut min, mut max] = self.differences(cell, axis);
        let mut met = [false; 2];
        for (offset, is_met) in [-1, 1].into_iter().zip(&mut met) {
            let neighbor = neighbor(cell, cells, axis, offset)?;
            match self.meetings[linear(cells, neighbor)] {
                Meeting::Empty => return None,
                Meeting::Apart | Meeting::Flat => {}
                Meeting::Met => {
                    let [least, most] = self.differences(neighbor, axis);
                    (min, max, *is_met) = (min.min(least), max.max(most), true);
                }
            }
        }
        let least = if min > 0.0 { min } else { -max };
        (least > 0.0).then_some(Slope { axis, least, met })
    }

    /// The least and the greatest of the differences of the four edges of a cell along an axis.
    fn differences(&self, cell: [usize; 3], axis: usize) -> [f64; 2] {
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        let low = linear(self.size, cell);
        let [u, v] = [strides[(axis + 1) % 3], strides[(axis + 2) % 3]];
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for edge in [low, low + u, low + v, low + u + v] {
            let difference = f64::from(self.samples[edge + strides[axis]]) - f64::from(self.samples[edge]);
            range = [range[0].min(difference), range[1].max(difference)];
        }
        range
    }

    /// Lowers the limits of a cell's corners to `limit`.
    fn lower(&self, limits: &mut [f64], cell: [usize; 3], limit: f64) {
        let [y, z] = [self.size[0], self.size[0] * self.size[1]];
        let low = linear(self.size, cell);
        for edge in [low, low + y, low + z, low + y + z] {
            for corner in [edge, edge + 1] {
                limits[corner] = limits[corner].min(limit);
            }
        }
    }
}

/// The cell beside another one, if there is one.
fn neighbor(cell: [usize; 3], cells: [usize; 3], axis: usize, offset: isize) -> Option<[usize; 3]> {
    let mut neighbor = cell;
    neighbor[axis] = cell[axis].checked_add_signed(offset).filter(|&c| c < cells[axis])?;
    Some(neighbor)
}

/// Position in an array of this size, x fastest.
pub(super) fn linear([nx, ny, _]: [usize; 3], [x, y, z]: [usize; 3]) -> usize {
    x + nx * (y + ny * z)
}

/// Least and greatest of four samples; infinite if one is not finite.
fn range(samples: [f32; 4]) -> [f32; 2] {
    samples.into_iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[min, max], s| {
        if s.is_finite() { [min.min(s), max.max(s)] } else { [f32::NEG_INFINITY, f32::INFINITY] }
    })
}
