//! The cells of one block, in the order of the ray.

use std::ops::ControlFlow;

use isoray_cell::{Segment, relative};
use isoray_grid::{Scalar, ScalarType};
use isoray_octree::{Block, CAP_EDGE, OctreeView, Path};
use wide::f64x4;

use crate::hit::{Candidate, HitPolicy};
use crate::neighborhood::{Find, Neighborhood};
use crate::place::Place;
use crate::ray::ClippedRay;
use crate::work::Counters;

/// All three upper faces.
pub(crate) const ALL_BORDERS: u32 = 0b111;

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
pub(crate) struct Steps {
    /// Where the ray crosses the five planes of the block's cells, by plane and axis.
    planes: [[f64; 4]; CAP_EDGE as usize + 1],
    /// Offset of the cell in the block.
    pub(crate) offset: [u32; 3],
    /// Where the ray crosses the cell's planes: behind it, and ahead.
    near: [f64; 3],
    far: [f64; 3],
}

impl Steps {
    /// The cell at `t`: along each axis as many planes on as the ray has crossed by then.
    #[inline(always)]
    fn at(ray: &ClippedRay, base: f64x4, t: f64) -> Self {
        let crossings: [f64x4; CAP_EDGE as usize + 1] =
            std::array::from_fn(|k| ray.crossings(base + f64x4::splat(k as f64)));
        let crossed = |k: usize| crossings[k].simd_le(f64x4::splat(t)).to_bitmask();
        let crossed = [crossed(1), crossed(2), crossed(3)];
        let planes = crossings.map(f64x4::to_array);
        let mut steps = Self { planes, offset: [0; 3], near: [0.0; 3], far: [0.0; 3] };
        for a in 0..3 {
            let crossed = crossed.iter().map(|bits| bits >> a & 1).sum::<u32>();
            let offset = if ray.is_backward(a) { LAST - crossed } else { crossed };
            steps.offset[a] = offset;
            let (low, high) = (steps.planes[offset as usize][a], steps.planes[offset as usize + 1][a]);
            (steps.near[a], steps.far[a]) = if ray.is_backward(a) { (high, low) } else { (low, high) };
        }
        steps
    }

    /// Steps across every plane that is crossed at `t`; false when that leads out of the block.
    #[inline(always)]
    fn cross(&mut self, ray: &ClippedRay, t: f64) -> bool {
        let mut inside = true;
        for a in 0..3 {
            if self.far[a] == t {
                self.near[a] = t;
                let (offset, ahead) = if ray.is_backward(a) {
                    (self.offset[a].wrapping_sub(1), self.offset[a].wrapping_sub(1))
                } else {
                    (self.offset[a] + 1, self.offset[a] + 2)
                };
                inside &= offset < CAP_EDGE;
                self.offset[a] = offset & LAST;
                self.far[a] = self.planes.get(ahead as usize).map_or(t, |plane| plane[a]);
            }
        }
        inside
    }

    /// Bit of the cell's low corner in the block's mask.
    #[inline(always)]
    pub(crate) fn bit(&self) -> u32 {
        self.offset[0] + STRIDES[1] * self.offset[1] + STRIDES[2] * self.offset[2]
    }

    /// Bit `a`: the cell touches the next block along axis `a`.
    #[inline(always)]
    fn at_last(&self) -> u32 {
        (0..3).fold(0, |m, a| m | u32::from(self.offset[a] == LAST) << a)
    }
}

impl<'a, T: Scalar> BlockWalk<'_, 'a, T> {
    /// Hands to `policy` the cells of `block` on the stretch `[t, t_end]` whose corners lie on both sides of the
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
        block: Block<'a, T>,
        place: Place,
        borders: u32,
        [mut t, t_end]: [f64; 2],
        path: &Path<'a, T>,
        neighborhood: &mut Neighborhood<'a, T>,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let is_constant = block.as_constant().is_some();
        neighborhood.begin(block, self.threshold);
        let origin = place.corner();
        let find = Find { view: self.view, path, origin, threshold: self.threshold };
        let mut steps = Steps::at(self.ray, place.base, t);
        loop {
            let t_out = steps.far[0].min(steps.far[1]).min(steps.far[2]).min(t_end);
            let at_last = steps.at_last();
            if !is_constant || at_last & borders != 0 {
                counters.lookups(8);
                if neighborhood.is_mixed(&find, &steps, at_last) {
                    let samples = neighborhood.corners(&find, &steps, at_last);
                    if T::TYPE != ScalarType::F32 || samples.iter().all(|s| s.is_finite()) {
                        counters.cell();
                        policy.candidate(&self.candidate(&samples, &steps, origin, [t, t_out]))?;
                    }
                }
            }
            if !steps.cross(self.ray, t_out) || t_out >= t_end {
                return ControlFlow::Continue(());
            }
            t = t_out;
        }
    }

    #[inline(always)]
    fn candidate(&self, samples: &[T; 8], steps: &Steps, origin: [u32; 3], interval: [f64; 2]) -> Candidate {
        let cell: [u32; 3] = std::array::from_fn(|a| origin[a] + steps.offset[a]);
        let mut segment = Segment { entry: [0.0; 3], exit: [0.0; 3] };
        for a in 0..3 {
            let (behind, ahead) = if self.ray.is_backward(a) { (1.0, 0.0) } else { (0.0, 1.0) };
            let [begin, end] = interval;
            segment.entry[a] =
                if steps.near[a] == begin { behind } else { self.ray.local(a, cell[a], begin) };
            segment.exit[a] = if steps.far[a] == end { ahead } else { self.ray.local(a, cell[a], end) };
        }
        let corners = relative(&samples.map(T::to_f32), self.isovalue);
        Candidate { cell, corners, segment, interval }
    }
}
