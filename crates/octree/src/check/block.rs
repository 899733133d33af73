//! Parents of caps.

use isoray_grid::Scalar;

use super::Malformed;
use super::contents::{Around, Contents, Region};
use crate::cap::Block;
use crate::geometry::{CAP_EDGE, CAP_LEVEL, NODE_LEVEL, child_origin, extent, product};
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

impl<'a, T: Scalar> Contents<'_, 'a, T> {
    /// The parent of caps at `around`.
    pub(super) fn check_caps(&mut self, around: &Around<'a, T>, index: usize) -> Result<(), Malformed> {
        let Around { regions: [Region::Node(node), ..], level, origin } = *around else { return Ok(()) };
        let error = |what| Err(Malformed { level, index, what });
        self.cube.fill(self.view, around);
        let ranges = self.cube.ranges();
        let n = self.view.dims().axes();
        for octant in 0..8u32 {
            let corner = child_origin(origin, NODE_LEVEL, octant);
            let has_cells = (0..3).all(|a| corner[a] + 1 < n[a]);
            let range = if has_cells { ranges[octant as usize] } else { Range::EMPTY };
            if range != node.range(octant as usize) {
                return error("a child's range is not that of its samples");
            }
            let size = extent(self.view.dims(), corner, CAP_LEVEL);
            if product(size) == 0 {
                continue;
            }
            // Samples beyond the child are those of others in the domain, so that they cannot harm.
            self.statistics.range = self.statistics.range.union(ranges[octant as usize]);
            let value: T = node.value(octant);
            if !node.is_stored(octant) {
                self.statistics.counts.add(value, product(size) as u64);
                continue;
            }
            let low = low_of(octant);
            let own = self.cube.rows[low[2]][low[1]][low[0]];
            let expected = self.coarse.as_ref().map_or(own, |cube| cube.quarter(corner));
            if !expected.same_bits(value) {
                return error("a child's value is not that of its low corner");
            }
            let mut differing = 0;
            for layer in &self.cube.rows[low[2]..][..size[2] as usize] {
                for row in &layer[low[1]..][..size[1] as usize] {
                    for &s in &row[low[0]..][..size[0] as usize] {
                        differing |= s.to_bits() ^ own.to_bits();
                        self.statistics.counts.add(s, 1);
                    }
                }
            }
            if differing == 0 {
                return error("a cap is stored whose samples are all equal");
            }
        }
        Ok(())
    }
}

/// Place of the first sample of a child.
fn low_of(octant: u32) -> [usize; 3] {
    [octant & 1, octant >> 1 & 1, octant >> 2].map(|c| (c * CAP_EDGE) as usize)
}

impl<T: Scalar> Cube<T> {
    /// The ranges of the samples of each child and their forward neighbours.
    fn ranges(&self) -> [Range<T>; 8] {
        let low = self.fold(T::HIGHEST, |a, b| if b < a { b } else { a });
        let high = self.fold(T::LOWEST, |a, b| if b > a { b } else { a });
        std::array::from_fn(|octant| Range { min: low[octant], max: high[octant] })
    }

    /// Fetches the samples of a block and the first ones beyond it; outside the domain the last one inside is repeated.
    fn fill<'a>(&mut self, view: &OctreeView<'a, T>, around: &Around<'a, T>) {
        for (direction, region) in (0u32..).zip(&around.regions) {
            let beyond: [u32; 3] = std::array::from_fn(|a| (direction >> a & 1) << NODE_LEVEL);
            let origin: [u32; 3] = std::array::from_fn(|a| around.origin[a] + beyond[a]);
            for octant in (0..8u32).filter(|octant| octant & direction == 0) {
                let corner = child_origin(origin, NODE_LEVEL, octant);
                let low = low_of(octant);
                let at = std::array::from_fn(|a| low[a] + beyond[a] as usize);
                let child = view.child_region(region, NODE_LEVEL, origin, octant);
                self.put(&child, extent(view.dims(), corner, CAP_LEVEL), at);
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
        if nx == 1 {
            // The first samples of rows beyond the block.
            for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
                self.rows[at[2] + z][at[1] + y][at[0]] = block.sample([0, y as u32, z as u32]);
            }
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
