//! The two finest coarse lattices of a part of a volume, which nodes do not hold.

use isoray_grid::Scalar;

use super::average::coarsen;
use crate::fidelity::Coarse;
use crate::geometry::{CAP_EDGE, CAP_LEVEL, CAP_SAMPLES, NODE_LEVEL, child_origin};
use crate::node::Range;
use crate::view::OctreeView;

/// Level of the part that is looked at at once: one of 64³ samples, which is 1.4 times as much with what it needs of its surroundings.
pub(crate) const TASK_LEVEL: u32 = 6;

/// Samples needed beside the part: below, the aligned cubes of the coarse samples that the lowest ones are means of; above, as far
/// as two means reach.
const BELOW: u32 = CAP_EDGE;
const ABOVE: u32 = CAP_EDGE - 1;

/// Samples at the multiples of `2^level` between two corners.
#[derive(Clone, Debug)]
struct Lattice<T> {
    level: u32,
    /// Low corner, in steps of the lattice.
    low: [u32; 3],
    size: [u32; 3],
    samples: Vec<T>,
}

impl<T: Copy + Default> Lattice<T> {
    /// Of all places from `low` to `high`, both included.
    fn new(level: u32, low: [u32; 3], high: [u32; 3], mut sample: impl FnMut([u32; 3]) -> T) -> Self {
        let low = low.map(|c| c.div_ceil(1 << level));
        let size: [u32; 3] = std::array::from_fn(|a| ((high[a] >> level) + 1).saturating_sub(low[a]));
        let mut samples = Vec::with_capacity(size.iter().map(|&n| n as usize).product());
        for z in 0..size[2] {
            for y in 0..size[1] {
                samples.extend((0..size[0]).map(|x| {
                    let index = [x + low[0], y + low[1], z + low[2]];
                    sample(index.map(|c| c << level))
                }));
            }
        }
        Self { level, low, size, samples }
    }

    /// That at `p`; the default value of what is not there.
    fn at(&self, p: [u32; 3]) -> T {
        let [x, y, z] = std::array::from_fn(|a| (p[a] >> self.level).wrapping_sub(self.low[a]) as usize);
        let [nx, ny, _] = self.size.map(|n| n as usize);
        self.samples.get((z * ny + y) * nx + x).copied().unwrap_or_default()
    }
}

/// The samples of level 1 in the cube of edge 8 at `origin`, those of the 4³ that are in the domain.
pub(crate) fn half<T: Scalar>(view: &OctreeView<'_, T>, origin: [u32; 3], kind: Coarse) -> [T; CAP_SAMPLES] {
    let (dims, n) = (view.dims(), view.dims().axes());
    // As far as a mean reaches.
    let low = origin.map(|c| c.saturating_sub(1));
    let high: [u32; 3] = std::array::from_fn(|a| (origin[a] + (1 << NODE_LEVEL)).min(n[a]));
    let size: [u32; 3] = std::array::from_fn(|a| high[a] - low[a]);
    let mut samples = vec![T::default(); size.iter().map(|&n| n as usize).product()];
    view.copy_box([low, high], &mut samples);
    let fine = Lattice { level: 0, low, size, samples };
    let constants: [Option<T>; 8] = std::array::from_fn(|octant| {
        let p = child_origin(origin, NODE_LEVEL, octant as u32);
        let is_looked_for = kind == Coarse::Filtered && dims.contains(p);
        is_looked_for.then(|| view.locate(p).as_constant()).flatten()
    });
    std::array::from_fn(|n| {
        let index = [0, 1, 2].map(|a| (n >> (2 * a) & 3) as u32);
        let p = std::array::from_fn(|a| origin[a] + 2 * index[a]);
        if !dims.contains(p) {
            return T::default();
        }
        let octant: u32 = (0..3).map(|a| (index[a] >> 1) << a).sum();
        constants[octant as usize].unwrap_or_else(|| coarsen(dims, kind, 1, p, |q| fine.at(q)))
    })
}

/// A cube of the domain with its lattices of levels 1 and 2, the latter on its upper faces too.
#[derive(Clone, Debug)]
pub(crate) struct Cube<T> {
    n: [u32; 3],
    coarse: [Lattice<T>; CAP_LEVEL as usize],
}

impl<T: Scalar> Cube<T> {
    /// Of the cube of edge `2^level` at `origin`, whose low corner is in the domain.
    pub(crate) fn new(view: &OctreeView<'_, T>, origin: [u32; 3], level: u32, kind: Coarse) -> Self {
        let (dims, n) = (view.dims(), view.dims().axes());
        let beyond = |by: u32| std::array::from_fn(|a| (origin[a] + (1 << level) + by).min(n[a] - 1));
        let below = |by: u32| origin.map(|c| c.saturating_sub(by));
        let (low, high) = (below(BELOW), beyond(ABOVE));
        let size: [u32; 3] = std::array::from_fn(|a| high[a] + 1 - low[a]);
        let mut samples = vec![T::default(); size.iter().map(|&n| n as usize).product()];
        view.copy_box([low, high.map(|c| c + 1)], &mut samples);
        let fine = Lattice { level: 0, low, size, samples };
        let is_uniform = Lattice::new(CAP_LEVEL, low, beyond(0), |p| {
            let [nx, ny, nz] = std::array::from_fn(|a| CAP_EDGE.min(n[a] - p[a]).min(high[a] + 1 - p[a]));
            let first = fine.at(p);
            kind == Coarse::Filtered
                && (0..nx * ny * nz).all(|i| {
                    let q = [p[0] + i % nx, p[1] + i / nx % ny, p[2] + i / nx / ny];
                    fine.at(q).same_bits(first)
                })
        });
        let next = |level: u32, finer: &Lattice<T>, low, high| {
            Lattice::new(level, low, high, |p| match is_uniform.at(p) {
                true => fine.at(p),
                false => coarsen(dims, kind, level, p, |q| finer.at(q)),
            })
        };
        let half = next(1, &fine, below(CAP_EDGE / 2), beyond(CAP_EDGE / 2));
        let quarter = next(2, &half, origin, beyond(0));
        Self { n, coarse: [half, quarter] }
    }

    /// The sample of level 2 at `p`.
    pub(crate) fn quarter(&self, p: [u32; 3]) -> T {
        self.coarse[1].at(p)
    }

    /// The range of the samples of both levels in the closed box of the cube of edge 8 at `origin`.
    pub(crate) fn range(&self, origin: [u32; 3]) -> Range<T> {
        let mut range = Range::EMPTY;
        for lattice in &self.coarse {
            let (step, count) = (1 << lattice.level, 1 << (NODE_LEVEL - lattice.level));
            let [nx, ny, nz] =
                std::array::from_fn(|a| (count + 1).min((self.n[a] - origin[a]).div_ceil(step)));
            for i in 0..nx * ny * nz {
                let index = [i % nx, i / nx % ny, i / nx / ny];
                range.include(lattice.at(std::array::from_fn(|a| origin[a] + step * index[a])));
            }
        }
        range
    }
}
