//! Steps through a grid of cubes of any edge, in the order of the ray (Amanatides and Woo 1987).

use isoray_cell::Segment;
use wide::f64x4;

use crate::corner::Corner;
use crate::ray::{ClippedRay, least_lane};

/// What a step changes in the index of a cube, by the axes whose planes are crossed at once: bit `a` for axis `a`.
pub type Strides = [u64; 8];

/// The strides of an index that grows by `unit` along each axis, by the axes along which the ray runs backward.
pub(crate) const fn strides(unit: [u64; 3]) -> [Strides; 8] {
    let mut strides = [[0u64; 8]; 8];
    let mut n = 0;
    while n < 64 {
        let (backward, crossed) = (n / 8, n % 8);
        let mut a = 0;
        while a < 3 {
            if crossed >> a & 1 == 1 {
                let sum = strides[backward][crossed];
                strides[backward][crossed] = match backward >> a & 1 {
                    1 => sum.wrapping_sub(unit[a]),
                    _ => sum.wrapping_add(unit[a]),
                };
            }
            a += 1;
        }
        n += 1;
    }
    strides
}

/// Those of a [`Corner`], by the axes along which the ray runs backward. A borrow that one of them takes from the next is given back by the sum.
pub const CORNER_STRIDES: [Strides; 8] =
    strides([Corner::new([1, 0, 0]).0, Corner::new([0, 1, 0]).0, Corner::new([0, 0, 1]).0]);

/// The cubes of one edge, as a ray meets them.
#[derive(Clone, Copy, Debug)]
pub struct Cubes {
    edge: f64x4,
    inverse: f64x4,
    /// From the low corner of a cube to the planes by which the ray enters and leaves it, and to those after.
    behind: f64x4,
    ahead: f64x4,
    beyond: f64x4,
}

impl Cubes {
    /// Of so many cells along an edge; `inverse` is the reciprocal.
    #[inline(always)]
    pub fn new(ray: &ClippedRay, edge: f64, inverse: f64) -> Self {
        let edge = f64x4::splat(edge);
        let (behind, ahead) = (ray.behind * edge, ray.ahead * edge);
        Self { edge, inverse: f64x4::splat(inverse), behind, ahead, beyond: ahead + ray.step * edge }
    }

    /// Where the ray crosses planes of the cube `cube`. Their coordinates are whole numbers, which arithmetic makes no errors with.
    #[inline(always)]
    fn crossings(&self, ray: &ClippedRay, cube: f64x4, plane: f64x4) -> f64x4 {
        ray.crossings(cube.mul_add(self.edge, plane))
    }
}

/// A ray's position in a grid. Every plane is the ray's own [`crossings`](ClippedRay::crossings) of it, computed from its whole coordinates, so
/// that all grids, and the octree, see the same path.
#[derive(Clone, Copy, Debug)]
pub struct GridSteps {
    /// Where the ray crosses the cube's planes ahead, and those after. The last are computed before it is known which of them come
    /// next, to keep them out of the chain from cube to cube.
    far: f64x4,
    beyond: f64x4,
    /// Which cube: its number along each axis.
    cube: f64x4,
    /// The same as an index.
    index: u64,
}

impl GridSteps {
    pub(crate) const NOWHERE: Self =
        Self { far: f64x4::ZERO, beyond: f64x4::ZERO, cube: f64x4::ZERO, index: 0 };

    /// The cube, of those from `first` to `last`, at `t`: along each axis the ray has crossed the planes whose crossing is at most `t`.
    /// `index` makes numbers an index.
    #[inline(always)]
    pub fn at(
        ray: &ClippedRay,
        cubes: &Cubes,
        [first, last]: [f64x4; 2],
        t: f64,
        index: impl Fn([u32; 3]) -> u64,
    ) -> Self {
        let time = f64x4::splat(t);
        // A guess, which its own crossings correct where it is off by a rounding. The bounds come last: they are known late.
        let position = time.mul_add(ray.direction, ray.held_at()) * cubes.inverse;
        let mut cube = position.floor().fast_max(first).fast_min(last);
        let mut far = cubes.crossings(ray, cube, cubes.ahead);
        loop {
            let late = far.simd_le(time);
            let early = cubes.crossings(ray, cube, cubes.behind).simd_gt(time);
            if (late | early).to_bitmask() & 7 == 0 {
                break;
            }
            cube += (late & ray.step) - (early & ray.step);
            far = cubes.crossings(ray, cube, cubes.ahead);
        }
        let beyond = cubes.crossings(ray, cube, cubes.beyond);
        Self { far, beyond, cube, index: index(whole(cube)) }
    }

    /// Where the ray leaves the cube.
    #[inline(always)]
    pub fn leaves(&self) -> f64 {
        least_lane(self.far)
    }

    /// Steps across every plane that is crossed at `t`.
    #[inline(always)]
    pub fn cross(&mut self, ray: &ClippedRay, cubes: &Cubes, strides: &Strides, t: f64) {
        let crossed = self.far.simd_eq(f64x4::splat(t));
        self.index = self.index.wrapping_add(strides[crossed.to_bitmask() as usize & 7]);
        // The lanes are all ones or all zeros: bits are selected some cycles sooner than lanes by their signs.
        self.far = crossed.bitselect(self.beyond, self.far);
        self.cube += crossed & ray.step;
        self.beyond = cubes.crossings(ray, self.cube, cubes.beyond);
    }

    /// The cube's index.
    #[inline(always)]
    pub fn index(&self) -> u64 {
        self.index
    }

    /// The cube's number along each axis.
    #[inline(always)]
    pub fn cube(&self) -> f64x4 {
        self.cube
    }

    /// The ray's stretch in the cube, a cell, cell-local.
    #[inline(always)]
    pub fn segment(&self, ray: &ClippedRay, [begin, end]: [f64; 2]) -> Segment {
        let entered = ray.crossings(self.cube + ray.behind).simd_eq(f64x4::splat(begin));
        let left = self.far.simd_eq(f64x4::splat(end));
        Segment {
            entry: ray.local(self.cube, begin, entered, ray.behind),
            exit: ray.local(self.cube, end, left, ray.ahead),
        }
    }
}

/// Numbers that are whole, not negative and less than 2²¹.
#[inline(always)]
fn whole(numbers: f64x4) -> [u32; 3] {
    /// In a number from here to twice that the lowest bits count units.
    const UNITS: f64 = (1u64 << (f64::MANTISSA_DIGITS - 1)) as f64;
    let [x, y, z, _] = (numbers + f64x4::splat(UNITS)).to_array().map(|n| n.to_bits() as u32);
    [x, y, z]
}
