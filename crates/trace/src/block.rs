//! The cells of one block, in the order of the ray.

use std::ops::ControlFlow;

use isoray_cell::{Segment, relative};
use isoray_grid::{Scalar, ScalarType};
use isoray_octree::{CAP_EDGE, OctreeView, Path};
use wide::f64x4;

use crate::hit::{Candidate, HitPolicy};
use crate::neighborhood::{ALWAYS, Find, Neighborhood, SPREAD, lasts};
use crate::place::Place;
use crate::ray::{ClippedRay, least, least_lane};
use crate::work::Counters;

/// All three upper faces.
pub(crate) const ALL_BORDERS: u32 = 0b111;

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
struct Steps {
    /// Where the ray crosses the cell's planes: behind it, and ahead.
    near: f64x4,
    far: f64x4,
    /// Coordinates of the planes ahead.
    plane: f64x4,
    /// Number of inner planes behind, two bits an axis.
    count: u32,
}

impl Steps {
    /// The cell at `t` in the block around `center`.
    #[inline(always)]
    fn at(ray: &ClippedRay, center: f64x4, t: f64) -> Self {
        const HALF: f64x4 = f64x4::new([CAP_EDGE as f64 / 2.0; 4]);
        const LAST: f64x4 = f64x4::new([CAP_EDGE as f64 - 1.0; 4]);
        let time = f64x4::splat(t);
        let position = time.mul_add(ray.direction, ray.plane_origin);
        let depth = (position - center).mul_add(ray.step, HALF);
        let mut count = depth.floor().fast_max(f64x4::ZERO).fast_min(LAST);
        loop {
            let plane = ray.step.mul_add(count - HALF, center) + ray.step;
            let (near, far) = (ray.crossings(plane - ray.step), ray.crossings(plane));
            // The position is rounded; what counts are the crossings. They are monotone, and the block's own planes bracket t,
            // so this ends, nearly always at once.
            let (early, late) = (near.simd_gt(time), far.simd_le(time));
            if (early | late).to_bitmask() & 7 == 0 {
                const STRIDES: f64x4 = f64x4::new([1.0, 4.0, 16.0, 0.0]);
                let [x, y, z, _] = (count * STRIDES).to_array();
                return Self { near, far, plane, count: (x + y + z) as u32 };
            }
            let one = f64x4::splat(1.0);
            count = count + (late & one) - (early & one);
        }
    }

    /// Steps across every plane that is crossed at `t`; false when that leads out of the block.
    #[inline(always)]
    fn cross(&mut self, ray: &ClippedRay, t: f64) -> bool {
        let crossed = self.far.simd_eq(f64x4::splat(t));
        let axes = SPREAD[crossed.to_bitmask() as usize & 7];
        if axes & lasts(self.count) != 0 {
            return false;
        }
        self.count += axes;
        self.near = crossed.select(self.far, self.near);
        self.plane += crossed & ray.step;
        self.far = ray.crossings(self.plane);
        true
    }
}

impl<'a, T: Scalar> BlockWalk<'_, 'a, T> {
    /// Hands to `policy` the cells of the neighbourhood's own block on the stretch `[t, t_end]` whose corners lie on both sides of the
    /// isovalue.
    ///
    /// All samples of a block are compared with the isovalue at once; a cell is then told by eight bits of the mask, and
    /// samples are fetched for cells that hold the isovalue only. If the block is part of a scalar leaf, `borders` tells the upper
    /// faces of the leaf that it reaches, and only the cells there are looked at.
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
        borders: Option<u32>,
        mut t: f64,
        t_end: f64,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        // Along which axes a cell must touch the next block; a bit that is always set lets all pass.
        let wanted = borders.map_or(ALWAYS, |axes| SPREAD[axes as usize & 7]);
        let flip = 3 * SPREAD[self.ray.backward as usize & 7];
        let find = Find { view: self.view, path, place, threshold: self.threshold };
        let mut steps = Steps::at(self.ray, place.center, t);
        loop {
            let t_out = least(least_lane(steps.far), t_end);
            let offset = steps.count ^ flip;
            if (lasts(offset) | ALWAYS) & wanted != 0 {
                counters.lookups(8);
                if neighborhood.is_mixed(&find, offset) {
                    let samples = neighborhood.corners(&find, offset);
                    if T::TYPE != ScalarType::F32 || samples.iter().all(|s| s.is_finite()) {
                        counters.cell();
                        policy.candidate(&self.candidate(&samples, &steps, place, offset, [t, t_out]))?;
                    }
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
        let ray = self.ray;
        let low = steps.plane - ray.ahead;
        let corner = place.corner();
        let [begin, end] = interval;
        let entered = steps.near.simd_eq(f64x4::splat(begin));
        let left = steps.far.simd_eq(f64x4::splat(end));
        Candidate {
            cell: std::array::from_fn(|a| corner[a] + (offset >> (2 * a) & 3)),
            corners: relative(&samples.map(T::to_f32), self.isovalue),
            segment: Segment {
                entry: ray.local(low, begin, entered, ray.behind),
                exit: ray.local(low, end, left, ray.ahead),
            },
            interval,
        }
    }
}
