//! The cells of one block, in the order of the ray.

use std::ops::ControlFlow;

use isoray_cell::{Segment, relative};
use isoray_grid::{Scalar, ScalarType};
use isoray_octree::{OctreeView, Path};
use wide::f64x4;

use crate::hit::{Candidate, HitPolicy};
use crate::neighborhood::{Find, Neighborhood, SPREAD, lasts};
use crate::place::Place;
use crate::ray::{ClippedRay, least, least_lane};
use crate::work::Counters;

/// What stays the same from block to block of a ray.
pub(crate) struct BlockWalk<'r, 'a, T: Scalar> {
    pub(crate) view: &'a OctreeView<'a, T>,
    pub(crate) ray: &'r ClippedRay,
    pub(crate) isovalue: f32,
    pub(crate) threshold: T,
}

/// A ray's position among the cells of a block (Amanatides and Woo 1987).
///
/// Planes are counted along the ray: the first across each axis is the one that it enters the block by, whichever way it runs.
pub(crate) struct Steps {
    /// Where the ray crosses the cell's planes: behind it, ahead, and those after. The last are computed before it is known
    /// which of them come next, to keep them out of the chain from cell to cell.
    near: f64x4,
    pub(crate) far: f64x4,
    beyond: f64x4,
    /// Coordinates of the planes ahead.
    plane: f64x4,
    /// Number of inner planes behind, two bits an axis.
    count: u32,
}

impl Steps {
    /// The cell at `t` in the block around `center`: along each axis as many planes on as the ray has crossed by then.
    #[inline(always)]
    pub(crate) fn at(ray: &ClippedRay, center: f64x4, mid: f64x4, t: f64) -> Self {
        let time = f64x4::splat(t);
        let two = ray.step + ray.step;
        // From the face that the ray enters by to that by which it leaves.
        let planes = [center - two, center - ray.step, center, center + ray.step, center + two];
        let at = [0, 1, 2, 3, 4].map(|n| if n == 2 { mid } else { ray.crossings(planes[n]) });
        let behind = [at[1].simd_le(time), at[2].simd_le(time), at[3].simd_le(time)];
        let pick =
            |of: [f64x4; 4]| behind[2].select(of[3], behind[1].select(of[2], behind[0].select(of[1], of[0])));
        let axes = |n: usize| SPREAD[behind[n].to_bitmask() as usize & 7];
        Self {
            near: pick([at[0], at[1], at[2], at[3]]),
            far: pick([at[1], at[2], at[3], at[4]]),
            // Nothing is asked of the plane after the last.
            beyond: pick([at[2], at[3], at[4], at[4]]),
            plane: pick([planes[1], planes[2], planes[3], planes[4]]),
            // The count of an axis is that of the sets it is in: no carry leaves its two bits.
            count: axes(0) + axes(1) + axes(2),
        }
    }

    /// Steps across every plane that is crossed at `t`; false when that leads out of the block.
    #[inline(always)]
    pub(crate) fn cross(&mut self, ray: &ClippedRay, t: f64) -> bool {
        let crossed = self.far.simd_eq(f64x4::splat(t));
        let axes = SPREAD[crossed.to_bitmask() as usize & 7];
        if axes & lasts(self.count) != 0 {
            return false;
        }
        self.count += axes;
        self.near = crossed.select(self.far, self.near);
        self.far = crossed.select(self.beyond, self.far);
        self.plane += crossed & ray.step;
        self.beyond = ray.crossings(self.plane + ray.step);
        true
    }

    /// The cell's offset in its block.
    #[inline(always)]
    pub(crate) fn offset(&self, ray: &ClippedRay) -> u32 {
        self.count ^ (3 * SPREAD[ray.backward as usize & 7])
    }

    /// The ray's stretch in the cell, cell-local.
    #[inline(always)]
    pub(crate) fn segment(&self, ray: &ClippedRay, [begin, end]: [f64; 2]) -> Segment {
        let low = self.plane - ray.ahead;
        let entered = self.near.simd_eq(f64x4::splat(begin));
        let left = self.far.simd_eq(f64x4::splat(end));
        Segment {
            entry: ray.local(low, begin, entered, ray.behind),
            exit: ray.local(low, end, left, ray.ahead),
        }
    }
}

impl<'a, T: Scalar> BlockWalk<'_, 'a, T> {
    /// Hands to `policy` the cells of the neighbourhood's own block on the stretch `[t, t_end]` whose corners lie on both sides of the
    /// isovalue.
    ///
    /// All samples of a block are compared with the isovalue at once; a cell is then told by eight bits of the mask, and
    /// samples are fetched for cells that hold the isovalue only. `mid` is where the ray crosses the block's mid-planes.
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
        mid: f64x4,
        mut t: f64,
        t_end: f64,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let find = Find { view: self.view, path, place, threshold: self.threshold };
        let mut steps = Steps::at(self.ray, place.center, mid, t);
        loop {
            let t_out = least(least_lane(steps.far), t_end);
            let offset = steps.offset(self.ray);
            counters.lookups(8);
            if neighborhood.is_mixed(&find, offset) {
                let samples = neighborhood.corners(&find, offset);
                if T::TYPE != ScalarType::F32 || samples.iter().all(|s| s.is_finite()) {
                    counters.cell();
                    policy.candidate(&self.candidate(&samples, &steps, place, offset, [t, t_out]))?;
                }
            }
            if t_out >= t_end || !steps.cross(self.ray, t_out) {
                return ControlFlow::Continue(());
            }
            t = t_out;
        }
    }

    #[inline(always)]
    fn candidate(
        &self,
        samples: &[T; 8],
        steps: &Steps,
        place: Place,
        offset: u32,
        interval: [f64; 2],
    ) -> Candidate {
        let corner = place.corner();
        Candidate {
            cell: std::array::from_fn(|a| corner[a] + (offset >> (2 * a) & 3)),
            corners: relative(&samples.map(T::to_f32), self.isovalue),
            segment: steps.segment(self.ray, interval),
            interval,
        }
    }
}
