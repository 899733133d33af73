//! One block of 8³ samples: eight children of 4³, their ranges and caps.

use isoray_grid::{Dims, Scalar};
use isoray_octree::{
    CAP_EDGE, CAP_LEVEL, CAP_SAMPLES, NODE_LEVEL, Range, cap_unit, child_origin, extent, product, push_cap,
};

use crate::consolidate::Region;

/// Samples along the edge of a block.
pub(crate) const BLOCK_EDGE: usize = 1 << NODE_LEVEL;
/// With the forward neighbours.
const APRON_EDGE: usize = BLOCK_EDGE + 1;

/// The layers that a row of blocks needs: eight, and the one after them if there is one.
#[derive(Clone, Copy)]
pub(crate) struct Layers<'a, T> {
    pub(crate) dims: Dims,
    /// Index of the first layer.
    pub(crate) first: u32,
    pub(crate) samples: &'a [T],
}

impl<T: Scalar> Layers<'_, T> {
    /// The block at `origin` and its forward neighbours; beyond the domain the last sample is repeated, which
    /// changes no range.
    fn gather(&self, origin: [u32; 3]) -> [[[T; APRON_EDGE]; APRON_EDGE]; APRON_EDGE] {
        let n = self.dims.axes();
        let clamp = |a: usize, offset: usize| (origin[a] + offset as u32).min(n[a] - 1);
        let mut block = [[[T::default(); APRON_EDGE]; APRON_EDGE]; APRON_EDGE];
        for (z, plane) in block.iter_mut().enumerate() {
            for (y, row) in plane.iter_mut().enumerate() {
                let start = self.dims.linear([0, clamp(1, y), clamp(2, z) - self.first]);
                let x0 = start + origin[0] as usize;
                match self.samples.get(x0..x0 + APRON_EDGE) {
                    Some(samples) if origin[0] as usize + APRON_EDGE <= n[0] as usize => {
                        row.copy_from_slice(samples)
                    }
                    _ => (0..).zip(row).for_each(|(x, s)| *s = self.samples[start + clamp(0, x) as usize]),
                }
            }
        }
        block
    }

    /// The block at `origin`, which is inside the domain. Caps are appended to `caps`, where
    /// the node's link counts from the start of it.
    pub(crate) fn block(&self, origin: [u32; 3], caps: &mut Vec<u8>) -> Region<T> {
        let samples = self.gather(origin);
        let ranges = child_ranges(&samples, self.dims, origin);
        let low = samples[0][0][0];
        caps.resize(caps.len().next_multiple_of(cap_unit::<T>()), 0);
        let first = (caps.len() / cap_unit::<T>()) as u32;
        let mut mask = 0;
        let values: [T; 8] = std::array::from_fn(|octant| {
            let corner = child_origin([0; 3], NODE_LEVEL, octant as u32);
            let size = extent(self.dims, child_origin(origin, NODE_LEVEL, octant as u32), CAP_LEVEL);
            if product(size) == 0 {
                return low;
            }
            let value = at(&samples, corner);
            if !is_constant(&samples, corner, size) {
                mask |= 1 << octant;
                push_cap(&cap(&samples, corner, size), size, ranges[octant], caps);
            }
            value
        });
        Region::of_children(ranges, values, first, mask)
    }
}

type Samples<T> = [[[T; APRON_EDGE]; APRON_EDGE]; APRON_EDGE];

fn at<T: Scalar>(samples: &Samples<T>, [x, y, z]: [u32; 3]) -> T {
    samples[z as usize][y as usize][x as usize]
}

fn is_constant<T: Scalar>(samples: &Samples<T>, corner: [u32; 3], size: [u32; 3]) -> bool {
    let first = at(samples, corner);
    rows(samples, corner, size).all(|row| row.iter().all(|s| s.same_bits(first)))
}

fn cap<T: Scalar>(samples: &Samples<T>, corner: [u32; 3], size: [u32; 3]) -> [T; CAP_SAMPLES] {
    let mut cap = [T::default(); CAP_SAMPLES];
    let mut rest = &mut cap[..];
    for row in rows(samples, corner, size) {
        let (to, after) = rest.split_at_mut(row.len());
        to.copy_from_slice(row);
        rest = after;
    }
    cap
}

fn rows<T>(samples: &Samples<T>, corner: [u32; 3], size: [u32; 3]) -> impl Iterator<Item = &[T]> {
    let [x, y, z] = corner.map(|c| c as usize);
    let [nx, ny, nz] = size.map(|c| c as usize);
    samples[z..z + nz].iter().flat_map(move |plane| plane[y..y + ny].iter().map(move |row| &row[x..x + nx]))
}

/// The ranges of the cells of the eight children, axis by axis: a child spans five of the nine samples along each.
fn child_ranges<T: Scalar>(samples: &Samples<T>, dims: Dims, origin: [u32; 3]) -> [Range<T>; 8] {
    let least = child_extrema(samples, T::HIGHEST, |a, b| if b < a { b } else { a });
    let greatest = child_extrema(samples, T::LOWEST, |a, b| if b > a { b } else { a });
    std::array::from_fn(|octant| {
        let corner = child_origin(origin, NODE_LEVEL, octant as u32);
        let has_cells = (0..3).all(|a| corner[a] + 1 < dims.axes()[a]);
        if has_cells { Range { min: least[octant], max: greatest[octant] } } else { Range::EMPTY }
    })
}

/// Folds each child's 5³ samples, non-finite ones replaced by `neutral`.
fn child_extrema<T: Scalar>(samples: &Samples<T>, neutral: T, pick: impl Fn(T, T) -> T + Copy) -> [T; 8] {
    const SPAN: usize = CAP_EDGE as usize;
    let halves = |line: &dyn Fn(usize) -> T| {
        let fold = |from: usize| (from + 1..=from + SPAN).fold(line(from), |a, n| pick(a, line(n)));
        [fold(0), fold(SPAN)]
    };
    let clean = |s: T| if s.is_finite() { s } else { neutral };
    let along_x = samples.map(|plane| plane.map(|row| halves(&|x| clean(row[x]))));
    let along_xy = along_x.map(|plane| [0, 1].map(|x| halves(&|y| plane[y][x])));
    std::array::from_fn(|octant| {
        let [x, y, z] = [octant & 1, octant >> 1 & 1, octant >> 2 & 1];
        halves(&|k| along_xy[k][x][y])[z]
    })
}
