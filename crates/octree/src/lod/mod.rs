//! Coarse samples: a volume at a half, a quarter, … of its resolution.
//!
//! # Lattices
//!
//! The coarse lattice of level `l` has its samples at `{0, 2^l, 2·2^l, …}` and at the last position `n − 1` along each axis
//! ([`coarse_dims`], [`coarse_position`]): it spans the same domain as the volume, its last cell may be shorter, and every sample
//! stands at its true place. Level 0 is the volume itself.
//!
//! # Kinds
//!
//! What the sample at `p` is, with `h = 2^(l−1)`:
//!
//! - *Injected*: the volume's sample at `p`. Exact on linear data, since the trilinear interpolant of the coarse samples is. It takes no
//!   room and no time to make.
//! - *Filtered*: the mean of the 27 samples of level `l − 1` at `p` and at a distance of `h` along axes, with weights ½ at `p` and ¼ beside it along each
//!   axis; symmetric, so that it is exact on linear data too. Where that stencil reaches out of the domain it is the sample of level `l − 1` at `p`; in a uniform region, where all
//!   samples in the aligned cube of edge `max(4, 2^l)` at `p` are bitwise equal, it is the volume's sample, since there are no nodes.
//! - *Mean*: the mean of the samples of level `l − 1` at `p + {0, h}³`, as far as they are in the domain: the mean of the cube of edge
//!   `2^l` *above* `p`, but placed at `p` (Knoll 2006, section 4.1; 2009, section 6.1). It displaces surfaces by `(2^l − 1)/2` voxels along each axis.
//!
//! The last sample along an axis, where `n − 1` is no multiple of `2^l`, is the volume's own for each kind. A mean of bitwise equal samples is
//! that sample; another one is NaN if any contribution is not finite, which makes its coarse cells empty. Means are rounded to the
//! nearest value of the sample type, ties to even, at every level; rounding to nearest has no bias, where truncation would lower a mean by half a unit a level.
//! Sums are in `f64`, in which those of integers are exact.
//!
//! # Ranges
//!
//! The range of a region in a node bounds the region's own cells. With injection it bounds every coarse cell too: the corners of a coarse
//! cell are samples of the cell's closed box, all of which are corners of cells in it, and so does the range of a region for all coarse cells in it. With
//! the other kinds corners take in samples from outside the box, and the ranges of regions of edge 8 and more are widened by *all* samples of the coarse lattices up to
//! the region's own level that lie in its closed box. Regions of edge 4 are not: their ranges tell how caps are stored. Cells of levels 1 and 2 are to be culled by their
//! own eight corners, or by [`OctreeView::coarse_range`].

mod around;
mod average;
mod cube;
mod detail;
mod faces;
mod fill;
mod frame;
mod resolve;

use isoray_grid::{Dims, Scalar};

use crate::fidelity::Coarse;
use crate::geometry::{CAP_LEVEL, MAX_LEVEL, NODE_LEVEL, octant_of};
use crate::node::Range;
use crate::view::OctreeView;
use average::coarsen;

pub(crate) use cube::{Cube, TASK_LEVEL};
pub(crate) use fill::{expected_value, has_cells, widened};

pub use detail::{Detail, DetailRequest, DistanceMeasure, PartsDetail, PixelWidth};
pub use fill::fill_coarse;
pub use resolve::{BLOCK_EDGE, BLOCK_SAMPLES, DetailBlock, DetailView, REACHED};

/// Size of the coarse lattice of `level`: one sample along an axis of one sample, else two or more.
pub fn coarse_dims(dims: Dims, level: u32) -> [u32; 3] {
    let step = 1 << level.min(MAX_LEVEL);
    dims.axes().map(|n| (n - 1).div_ceil(step) + 1)
}

/// Place of a sample of the coarse lattice of `level` among the volume's, `index` counting coarse samples along each axis; the last one's
/// beyond the end.
pub fn coarse_position(dims: Dims, level: u32, index: [u32; 3]) -> [u32; 3] {
    let place = |a: usize| {
        let last = dims.axes()[a] - 1;
        u64::from(index[a]).saturating_mul(1 << level.min(MAX_LEVEL)).min(last.into()) as u32
    };
    std::array::from_fn(place)
}

/// Whether `p` is a multiple of `2^level` along each axis.
fn is_aligned(p: [u32; 3], level: u32) -> bool {
    (p[0] | p[1] | p[2]) & ((1 << level) - 1) == 0
}

/// Whether nodes hold coarse samples that are not the volume's own.
pub(crate) fn is_averaged(kind: Coarse) -> bool {
    matches!(kind, Coarse::Mean | Coarse::Filtered)
}

impl<'a, T: Scalar> OctreeView<'a, T> {
    /// The sample of the coarse lattice of `level` at `p`, a place among the volume's samples; `kind` is the volume's
    /// ([`Meta::coarse`](crate::Meta::coarse)). `None` if `p` is not on that lattice, or if there are no coarse samples and `level` is not 0.
    ///
    /// Takes time in proportion to the levels above; at level 1, and at the root's, up to 27 times that.
    pub fn coarse_sample(&self, level: u32, p: [u32; 3], kind: Coarse) -> Option<T> {
        let step = 1 << level.min(MAX_LEVEL);
        let n = self.dims().axes();
        let is_there = (0..3).all(|a| p[a] < n[a] && (p[a].is_multiple_of(step) || p[a] == n[a] - 1));
        if !is_there || (kind == Coarse::None && level > 0) {
            return None;
        }
        Some(self.coarse(level.min(self.root_level()), p, kind))
    }

    /// The same for places on the lattice, up to the root's level.
    pub(crate) fn coarse(&self, level: u32, p: [u32; 3], kind: Coarse) -> T {
        if level == 0 || !is_aligned(p, level) {
            return self.sample(p);
        }
        let finer = |level: u32| coarsen(self.dims(), kind, level, p, |q| self.coarse(level - 1, q, kind));
        match (kind, level) {
            (Coarse::None | Coarse::Injected, _) => self.injected(p),
            (_, 1) if kind == Coarse::Filtered => match self.locate(p).as_constant() {
                Some(value) => value,
                None => finer(1),
            },
            (_, 1) => finer(1),
            _ if level >= self.root_level() => finer(self.root_level()),
            _ => self.stored_value(level, p, |_| false),
        }
    }

    /// The sample at `p`, from the highest node that has it.
    fn injected(&self, p: [u32; 3]) -> T {
        match p.map(u32::trailing_zeros).into_iter().min() {
            Some(zeros) if zeros >= CAP_LEVEL => {
                self.stored_value(CAP_LEVEL, p, |level| is_aligned(p, level))
            }
            _ => self.sample(p),
        }
    }

    /// The value that stands for the region of `level` at `p`, or for a higher one of which `p` is said to be enough.
    fn stored_value(&self, level: u32, p: [u32; 3], is_enough: impl Fn(u32) -> bool) -> T {
        let Some(mut node) = self.root() else { return T::default() };
        let mut above = self.root_level();
        loop {
            let octant = octant_of(p, above);
            above -= 1;
            if above <= level || above < NODE_LEVEL || !node.is_stored(octant) || is_enough(above) {
                return node.value(octant);
            }
            match self.nodes(above).get(node.child(octant)) {
                Some(next) => node = next,
                None => return T::default(),
            }
        }
    }

    /// A range that bounds the coarse cell of `level` whose low corner is `origin`, a multiple of `2^level`: its own eight corners, and all cells of
    /// finer levels in it; `kind` is the volume's. Empty outside the domain, and if nothing there is finite.
    pub fn coarse_range(&self, level: u32, origin: [u32; 3], kind: Coarse) -> Range<T> {
        let level = level.min(self.root_level());
        let n = self.dims().axes();
        if !has_cells(self, origin) || !is_aligned(origin, level) {
            return Range::EMPTY;
        }
        let mut range = match level {
            0 => Range::EMPTY,
            _ => self.range_of_region(level.max(CAP_LEVEL), origin),
        };
        // What nodes do not tell.
        let lattices = match level {
            0 => 0..=0,
            _ if !is_averaged(kind) => return range,
            1..=CAP_LEVEL => 1..=level,
            NODE_LEVEL if level == self.root_level() => 1..=level,
            _ if level == self.root_level() => level..=level,
            _ => return range,
        };
        for finer in lattices {
            let points = (1 << (level - finer)) + 1;
            for i in 0..points * points * points {
                let index = [i % points, i / points % points, i / points / points];
                let p = std::array::from_fn(|a| (origin[a] + (index[a] << finer)).min(n[a] - 1));
                range.include(self.coarse(finer, p, kind));
            }
        }
        range
    }

    /// The range that the parent holds of the region of `level`, or of a scalar leaf in which it lies.
    fn range_of_region(&self, level: u32, p: [u32; 3]) -> Range<T> {
        let Some(mut node) = self.root() else { return Range::EMPTY };
        let mut above = self.root_level();
        if level >= above {
            return (0..8).map(|n| node.range(n)).fold(Range::EMPTY, Range::union);
        }
        loop {
            let octant = octant_of(p, above);
            above -= 1;
            if above <= level || !node.is_stored(octant) {
                return node.range(octant as usize);
            }
            match self.nodes(above).get(node.child(octant)) {
                Some(next) => node = next,
                None => return Range::EMPTY,
            }
        }
    }
}
