//! The cells of one block, in the order of the ray.

use std::ops::ControlFlow;

use isoray_cell::{Segment, relative};
use isoray_grid::{Scalar, ScalarType};
use isoray_octree::{CAP_EDGE, OctreeView, Path};
use wide::f64x4;

use crate::hit::{Candidate, HitPolicy};
use crate::neighborhood::{Find, Neighborhood};
use crate::place::Place;
use crate::ray::{ClippedRay, least};
use crate::work::Counters;

/// All three upper faces.
pub(crate) const ALL_BORDERS: u32 = 0b111;
/// Not only the cells at upper faces: a block that is not constant.
pub(crate) const EVERYWHERE: u32 = 0b1000;

/// Offset of the last cell of a block along an axis: the one that touches the next block.
pub(crate) const LAST: u32 = CAP_EDGE - 1;

/// Strides of the three axes in a block's bit mask.
pub(crate) const STRIDES: [u32; 3] = [1, CAP_EDGE, CAP_EDGE * CAP_EDGE];

/// What stays the same from block to block of a ray.
pub(crate) struct BlockWalk<'r, 'a, T: Scalar> {
    pub(crate) view: &'a OctreeView<'a, T>,
    pub(crate) ray: &'r ClippedRay,
    pub(crate) isovalue: f32,
    pub(crate) threshold: T,
}

/// A ray's position among the cells of a block (Amanatides and Woo 1987).
///
/// Cells and planes are counted along the ray: the cell that lies behind `n` of the planes across an axis is the `n`-th, whichever
/// way the ray runs.
pub(crate) struct Steps {
    /// Where the ray crosses the five planes of the block's cells, by plane and axis.
    planes: [[f64; 4]; CAP_EDGE as usize + 1],
    /// Number of inner planes behind.
    count: [u32; 3],
    /// What turns `count` into an offset: all ones for an axis on which the ray runs backward.
    flip: [u32; 3],
}

impl Steps {
    /// The cell at `t`.
    #[inline(always)]
    fn at(ray: &ClippedRay, base: f64x4, t: f64) -> Self {
        // The middle of the block, less two steps, is the face that the ray enters by.
        const HALF: f64 = CAP_EDGE as f64 / 2.0;
        let first = base + f64x4::splat(HALF) - ray.step * f64x4::splat(HALF);
        let crossings: [f64x4; CAP_EDGE as usize + 1] =
            std::array::from_fn(|k| ray.crossings(first + ray.step * f64x4::splat(k as f64)));
        let behind = |k: usize| crossings[k].simd_le(f64x4::splat(t)).to_bitmask();
        let inner = behind(1) | behind(2) << 4 | behind(3) << 8;
        Self {
            planes: crossings.map(f64x4::to_array),
            count: std::array::from_fn(|a| (inner & 0x111 << a).count_ones()),
            flip: std::array::from_fn(|a| LAST & (ray.backward >> a & 1).wrapping_neg()),
        }
    }

    /// Where the ray crosses the planes behind the cell.
    #[inline(always)]
    fn near(&self, axis: usize) -> f64 {
        self.planes[self.count[axis] as usize][axis]
    }

    /// Where it crosses those ahead.
    #[inline(always)]
    fn far(&self, axis: usize) -> f64 {
        self.planes[self.count[axis] as usize + 1][axis]
    }

    /// Steps across every plane that is crossed at `t`; false when that leads out of the block.
    #[inline(always)]
    fn cross(&mut self, t: f64) -> bool {
        for a in 0..3 {
            self.count[a] += u32::from(self.far(a) == t);
        }
        (self.count[0] | self.count[1] | self.count[2]) < CAP_EDGE
    }

    /// Offset of the cell in the block.
    #[inline(always)]
    pub(crate) fn offset(&self, axis: usize) -> u32 {
        self.count[axis] ^ self.flip[axis]
    }

    /// Bit of the cell's low corner in the block's mask.
    #[inline(always)]
    pub(crate) fn bit(&self) -> u32 {
        self.offset(0) + STRIDES[1] * self.offset(1) + STRIDES[2] * self.offset(2)
    }

    /// Bit `a`: the cell touches the next block along axis `a`.
    #[inline(always)]
    fn at_last(&self) -> u32 {
        (0..3).fold(0, |m, a| m | u32::from(self.offset(a) == LAST) << a)
    }
}

impl<'a, T: Scalar> BlockWalk<'_, 'a, T> {
    /// Hands to `policy` the cells of the neighbourhood's own block on the stretch `[t, t_end]` whose corners lie on both sides of the
    /// isovalue.
    ///
    /// All samples of a block are compared with the isovalue at once; a cell is then told by eight bits of the mask, and
    /// samples are fetched for cells that hold the isovalue only.
    #[expect(
        clippy::too_many_arguments,
        reason = "called from one place, with values that have no common owner"
    )]
    #[inline(never)]
    pub(crate) fn cells(
        &self,
        neighborhood: &mut Neighborhood<'a, T>,
        path: &Path<'a, T>,
        place: Place,
        borders: u32,
        mut t: f64,
        t_end: f64,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let origin = place.corner();
        let find = Find { view: self.view, path, origin, threshold: self.threshold };
        let mut steps = Steps::at(self.ray, place.base, t);
        loop {
            let t_out = least(least(steps.far(0), steps.far(1)), least(steps.far(2), t_end));
            let at_last = steps.at_last();
            if (at_last | EVERYWHERE) & borders != 0 {
                counters.lookups(8);
                if neighborhood.is_mixed(&find, &steps, at_last) {
                    let samples = neighborhood.corners(&find, &steps, at_last);
                    if T::TYPE != ScalarType::F32 || samples.iter().all(|s| s.is_finite()) {
                        counters.cell();
                        policy.candidate(&self.candidate(&samples, &steps, origin, [t, t_out]))?;
                    }
                }
            }
            if !steps.cross(t_out) || t_out >= t_end {
                return ControlFlow::Continue(());
            }
            t = t_out;
        }
    }

    #[inline(always)]
    fn candidate(&self, samples: &[T; 8], steps: &Steps, origin: [u32; 3], interval: [f64; 2]) -> Candidate {
        let cell: [u32; 3] = std::array::from_fn(|a| origin[a] + steps.offset(a));
        let mut segment = Segment { entry: [0.0; 3], exit: [0.0; 3] };
        for a in 0..3 {
            let (behind, ahead) = if self.ray.is_backward(a) { (1.0, 0.0) } else { (0.0, 1.0) };
            let [begin, end] = interval;
            segment.entry[a] =
                if steps.near(a) == begin { behind } else { self.ray.local(a, cell[a], begin) };
            segment.exit[a] = if steps.far(a) == end { ahead } else { self.ray.local(a, cell[a], end) };
        }
        let corners = relative(&samples.map(T::to_f32), self.isovalue);
        Candidate { cell, corners, segment, interval }
    }
}
