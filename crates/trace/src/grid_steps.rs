//! Steps through a grid of cubes of any edge, in the order of the ray (Amanatides and Woo 1987).

use isoray_cell::Segment;
use wide::f64x4;

use crate::corner::Corner;
use crate::ray::{ClippedRay, least_lane};

/// By the axes whose planes are crossed at once, how a packed index changes.
pub(crate) struct Strides([u64; 8]);

impl Strides {
    #[inline(always)]
    pub(crate) fn new(ray: &ClippedRay) -> Self {
        let along = |a: usize| {
            let one = Corner::new(std::array::from_fn(|b| u32::from(a == b))).0;
            if ray.backward >> a & 1 == 1 { one.wrapping_neg() } else { one }
        };
        let [x, y, z] = [along(0), along(1), along(2)];
        // No index becomes negative where it is used, so no difference borrows from the next field.
        let sum = |n: usize| {
            let pick = |a: usize, stride: u64| if n >> a & 1 == 1 { stride } else { 0 };
            pick(0, x).wrapping_add(pick(1, y)).wrapping_add(pick(2, z))
        };
        Self(std::array::from_fn(sum))
    }
}

/// A ray's position in a grid. Every plane is the ray's own [`crossings`](ClippedRay::crossings) of it, computed from its whole coordinates, so
/// that all grids, and the octree, see the same path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GridSteps {
    /// Where the ray crosses the cube's planes: behind it, ahead, and those after. The last are computed before it is known which of them come
    /// next, to keep them out of the chain from cube to cube.
    near: f64x4,
    far: f64x4,
    beyond: f64x4,
    /// Coordinates of the planes ahead.
    plane: f64x4,
    /// From plane to plane: the edge, with the sign of the direction.
    step: f64x4,
    /// Which cube: its number along each axis.
    index: Corner,
}

impl GridSteps {
    /// The cube of edge `edge`, counted from the lattice's origin, at `t`: along each axis it has crossed the planes whose crossing is at most `t`.
    #[inline(always)]
    pub(crate) fn at(ray: &ClippedRay, edge: u32, t: f64) -> Self {
        let edges = f64x4::splat(edge.into());
        let step = ray.step * edges;
        let p = f64x4::splat(t).mul_add(ray.direction, ray.held_at());
        // A guess, which its own crossings correct where it is off by a rounding.
        let low = (p / edges).floor().fast_max(f64x4::ZERO) * edges;
        let mut plane = ray.ahead.mul_add(edges, low);
        let time = f64x4::splat(t);
        loop {
            let late = ray.crossings(plane).simd_le(time);
            let early = ray.crossings(plane - step).simd_gt(time);
            if (late | early).to_bitmask() & 7 == 0 {
                break;
            }
            plane += (late & step) - (early & step);
        }
        let number = (plane - ray.ahead * edges) / edges;
        let [x, y, z, _] = number.to_array();
        Self {
            near: ray.crossings(plane - step),
            far: ray.crossings(plane),
            beyond: ray.crossings(plane + step),
            plane,
            step,
            index: Corner::new([x, y, z].map(|c| c as u32)),
        }
    }

    /// Where the ray leaves the cube.
    #[inline(always)]
    pub(crate) fn leaves(&self) -> f64 {
        least_lane(self.far)
    }

    /// Steps across every plane that is crossed at `t`.
    #[inline(always)]
    pub(crate) fn cross(&mut self, ray: &ClippedRay, strides: &Strides, t: f64) {
        let crossed = self.far.simd_eq(f64x4::splat(t));
        self.index.0 = self.index.0.wrapping_add(strides.0[crossed.to_bitmask() as usize & 7]);
        self.near = crossed.select(self.far, self.near);
        self.far = crossed.select(self.beyond, self.far);
        self.plane += crossed & self.step;
        self.beyond = ray.crossings(self.plane + self.step);
    }

    /// The cube's number along each axis.
    #[inline(always)]
    pub(crate) fn index(&self) -> [u32; 3] {
        self.index.coordinates()
    }

    /// The cube's centre.
    #[inline(always)]
    pub(crate) fn center(&self) -> f64x4 {
        self.plane - self.step * f64x4::splat(0.5)
    }

    /// The ray's stretch in the cube, a cell, cell-local.
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
