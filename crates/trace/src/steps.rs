//! Steps from part to part of a cube, in the order of the ray.

use std::ops::ControlFlow;

use isoray_cell::Segment;
use wide::f64x4;

use crate::offset::{SPREAD, lasts, mirror};
use crate::ray::{ClippedRay, least, least_lane};

/// A cube of 4³ parts: cells, or cubes themselves.
#[derive(Clone, Copy)]
pub struct Cube {
    /// Its centre.
    pub center: f64x4,
    /// Where the ray crosses the mid-planes.
    pub mid: f64x4,
    /// From part to part along the ray: the edge of a part, with the sign of the direction.
    pub step: f64x4,
}

impl Cube {
    /// Calls `visit` for the parts on the stretch `[t, t_end]`, in order, with the position, the part's offset and its stretch, until it
    /// breaks.
    #[inline(always)]
    pub fn walk(
        self,
        ray: &ClippedRay,
        [mut t, t_end]: [f64; 2],
        mut visit: impl FnMut(&Steps, u32, [f64; 2]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut steps = Steps::at(ray, self, t);
        loop {
            let t_out = least(least_lane(steps.far), t_end);
            visit(&steps, steps.offset(ray), [t, t_out])?;
            if t_out >= t_end || !steps.cross(ray, self.step, t_out) {
                return ControlFlow::Continue(());
            }
            t = t_out;
        }
    }
}

/// A ray's position among the 4³ parts of a cube: the cells of a block, or blocks (Amanatides and Woo 1987).
///
/// Planes are counted along the ray: the first across each axis is the one that it enters the block by, whichever way it runs.
pub struct Steps {
    /// Where the ray crosses the part's planes: behind it, ahead, and those after. The last are computed before it is known
    /// which of them come next, to keep them out of the chain from part to part.
    near: f64x4,
    far: f64x4,
    beyond: f64x4,
    /// Coordinates of the planes ahead.
    plane: f64x4,
    /// Number of inner planes behind, two bits an axis.
    count: u32,
}

impl Steps {
    /// The part at `t`: along each axis as many planes on as the ray has crossed by then.
    #[inline(always)]
    fn at(ray: &ClippedRay, Cube { center, mid, step }: Cube, t: f64) -> Self {
        let time = f64x4::splat(t);
        let two = step + step;
        // From the face that the ray enters by to that by which it leaves.
        let planes = [center - two, center - step, center, center + step, center + two];
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

    /// Steps across every plane that is crossed at `t`; false when that leads out of the cube.
    #[inline(always)]
    fn cross(&mut self, ray: &ClippedRay, step: f64x4, t: f64) -> bool {
        let crossed = self.far.simd_eq(f64x4::splat(t));
        let axes = SPREAD[crossed.to_bitmask() as usize & 7];
        if axes & lasts(self.count) != 0 {
            return false;
        }
        self.count += axes;
        self.near = crossed.select(self.far, self.near);
        self.far = crossed.select(self.beyond, self.far);
        self.plane += crossed & step;
        self.beyond = ray.crossings(self.plane + step);
        true
    }

    /// The part's offset in the cube: two bits an axis, x lowest.
    #[inline(always)]
    fn offset(&self, ray: &ClippedRay) -> u32 {
        self.count ^ mirror(ray.backward)
    }

    /// The part's centre.
    #[inline(always)]
    pub(crate) fn center(&self, step: f64x4) -> f64x4 {
        self.plane - step * f64x4::splat(0.5)
    }

    /// The ray's stretch in the part, a cell, cell-local.
    #[inline(always)]
    pub fn segment(&self, ray: &ClippedRay, [begin, end]: [f64; 2]) -> Segment {
        let low = self.plane - ray.ahead;
        let entered = self.near.simd_eq(f64x4::splat(begin));
        let left = self.far.simd_eq(f64x4::splat(end));
        Segment {
            entry: ray.local(low, begin, entered, ray.behind),
            exit: ray.local(low, end, left, ray.ahead),
        }
    }
}
