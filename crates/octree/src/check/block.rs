//! The ranges of a parent of caps.

use isoray_grid::Scalar;

use super::contents::{Around, Region};
use crate::cap::Block;
use crate::geometry::{CAP_EDGE, CAP_LEVEL, NODE_LEVEL, child_origin, extent};
use crate::node::Range;
use crate::view::OctreeView;

/// Samples along an edge: those of a block, and the next.
const EDGE: usize = (1 << NODE_LEVEL) + 1;
/// Samples of a row, made up to a whole vector.
const ROW: usize = 16;
/// Those of a cap's cells along an axis.
const SPAN: usize = CAP_EDGE as usize + 1;

/// The samples of a block and the first ones beyond it.
#[derive(Clone, Debug)]
pub(super) struct Cube<T> {
    rows: [[[T; ROW]; EDGE]; EDGE],
}

impl<T: Scalar> Default for Cube<T> {
    fn default() -> Self {
        Self { rows: [[[T::default(); ROW]; EDGE]; EDGE] }
    }
}

impl<T: Scalar> Cube<T> {
    /// The ranges of the cells of each child of the parent of caps at `around`.
    pub(super) fn ranges<'a>(&mut self, view: &OctreeView<'a, T>, around: &Around<'a, T>) -> [Range<T>; 8] {
        self.fill(view, around);
        let low = self.fold(T::HIGHEST, |a, b| if b < a { b } else { a });
        let high = self.fold(T::LOWEST, |a, b| if b > a { b } else { a });
        let n = view.dims().axes();
        std::array::from_fn(|octant| {
            let corner = child_origin(around.origin, NODE_LEVEL, octant as u32);
            let has_cells = (0..3).all(|a| corner[a] + 1 < n[a]);
            if has_cells { Range { min: low[octant], max: high[octant] } } else { Range::EMPTY }
        })
    }

    /// Samples outside the domain are left as they are, except that the last one inside is repeated.
    fn fill<'a>(&mut self, view: &OctreeView<'a, T>, around: &Around<'a, T>) {
        for octant in 0..8u32 {
            let child = view.around_child(around, octant);
            let low = [octant & 1, octant >> 1 & 1, octant >> 2].map(|c| (c * CAP_EDGE) as usize);
            // Those beyond an inner child are its siblings.
            for direction in (0..8u32).filter(|direction| direction & !octant == 0) {
                let corner = std::array::from_fn(|a| child.origin[a] + (direction >> a & 1) * CAP_EDGE);
                let at = std::array::from_fn(|a| low[a] + ((direction >> a & 1) * CAP_EDGE) as usize);
                self.put(&child.regions[direction as usize], extent(view.dims(), corner, CAP_LEVEL), at);
            }
        }
        self.repeat_last(extent(view.dims(), around.origin, NODE_LEVEL + 1));
    }

    /// Puts a block's samples at `at`, as far as they belong there.
    fn put(&mut self, region: &Region<'_, T>, size: [u32; 3], at: [usize; 3]) {
        let constant;
        let block = match region {
            Region::Cap(block) => block,
            Region::Constant(value) => {
                constant = Block::constant(*value);
                &constant
            }
            Region::Node(_) | Region::Nothing => return,
        };
        let [nx, ny, nz] = std::array::from_fn(|a| (size[a] as usize).min(EDGE - at[a]));
        if nx * ny * nz == 1 {
            self.rows[at[2]][at[1]][at[0]] = block.sample([0; 3]);
            return;
        }
        let samples = block.samples();
        let edge = CAP_EDGE as usize;
        for z in 0..nz {
            for y in 0..ny {
                let row = &mut self.rows[at[2] + z][at[1] + y][at[0]..];
                let four = &samples[edge * (y + edge * z)..][..edge];
                row[..nx].copy_from_slice(&four[..nx]);
            }
        }
    }

    /// Beyond the domain, of which so many samples are left, the last sample is repeated, which changes no range.
    fn repeat_last(&mut self, left: [u32; 3]) {
        let [nx, ny, nz] = left.map(|n| (n as usize).min(EDGE));
        if nx < EDGE {
            for row in self.rows.iter_mut().flatten() {
                let last = row[nx - 1];
                row[nx..EDGE].fill(last);
            }
        }
        for layer in &mut self.rows {
            let last = layer[ny - 1];
            layer[ny..].fill(last);
        }
        let last = self.rows[nz - 1];
        self.rows[nz..].fill(last);
    }

    /// Folds the samples of each child's cells, non-finite ones replaced by `neutral`.
    fn fold(&self, neutral: T, pick: impl Fn(T, T) -> T + Copy) -> [T; 8] {
        let clean = |s: T| if s.is_finite() { s } else { neutral };
        let fold = |rows: [&[T; ROW]; SPAN]| -> [T; ROW] {
            std::array::from_fn(|x| {
                let [a, b, c, d, e] = rows.map(|row| clean(row[x]));
                pick(pick(pick(a, b), pick(c, d)), e)
            })
        };
        let along_z: [[[T; ROW]; EDGE]; 2] = std::array::from_fn(|z| {
            std::array::from_fn(|y| fold(std::array::from_fn(|n| &self.rows[z * (SPAN - 1) + n][y])))
        });
        std::array::from_fn(|octant| {
            let [x, y, z] = [octant & 1, octant >> 1 & 1, octant >> 2];
            let row = fold(std::array::from_fn(|n| &along_z[z][y * (SPAN - 1) + n]));
            row[x * (SPAN - 1)..][..SPAN].iter().copied().fold(neutral, pick)
        })
    }
}
