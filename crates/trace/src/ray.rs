//! A ray, and its plane crossings.

use isoray_cell::Segment;
use wide::f64x4;

use crate::quotient::quotient;
use crate::region::Region;

/// A ray in index space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is zero.
    pub origin: [f32; 3],
    /// Change of position per unit of `t`; of any length. Components of either zero are parallel to the axis' planes.
    pub direction: [f32; 3],
    /// Where the ray begins.
    pub t_min: f32,
    /// Where it ends; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// The square of the distance at `t` from another ray.
    pub fn square_apart(&self, other: &Self, t: f64) -> f64 {
        let along = |ray: &Self, a: usize| f64::from(ray.origin[a]) + t * f64::from(ray.direction[a]);
        (0..3).map(|a| (along(other, a) - along(self, a)).powi(2)).sum()
    }
}

/// A ray that starts on an isosurface, as shadow rays do, and leaves it to one side; [`Hit::departing_ray`](crate::Hit::departing_ray)
/// makes one.
///
/// No offset moves it off the surface. In the first cell on its way, that in which it has a stretch from its start on, the field along the ray is
/// zero at the start but for rounding; there the root is divided out ([`Departing`](isoray_cell::root::Departing)), and what is left tells
/// the side that the ray leaves to and where it crosses the surface again, if it does. If it leaves to the other side than is
/// expected of it, a crossing at the start is reported first: light from there meets the back of the surface. The side on which it leaves
/// the cell is that which the next cell sees, bit for bit, so that behind it no crossing is missed and none invented.
///
/// The start is kept to within `2⁻³²` voxel of the hit, however large its coordinates. The hit itself is off the surface by a rounding of the
/// cell's coordinates, `2⁻²⁴` voxel. So what can be wrong is a sheet or a gap that the ray passes within about that distance from its
/// start: it may be missed, or met where it is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepartingRay {
    /// In index space.
    pub(crate) origin: [f64; 3],
    /// Change of position per unit of `t`, which is zero at the start.
    pub direction: [f32; 3],
    /// Where it ends; may be infinite.
    pub t_max: f32,
    /// Which surface it starts on: an index into the isovalues that are asked for with it.
    pub surface: usize,
    /// Whether it is expected to leave to the inside, where the field is at least the isovalue.
    pub into_inside: bool,
}

impl DepartingRay {
    /// In single precision, where it starts within a rounding of its coordinates.
    pub fn rounded(&self) -> Ray {
        let origin = self.origin.map(|c| c as f32);
        Ray { origin, direction: self.direction, t_min: 0.0, t_max: self.t_max }
    }

    /// Where it starts, in index space.
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// From `cell`, of a level of detail, and the cell-local position in it.
    pub(crate) fn new(
        cell: [u32; 3],
        local: [f32; 3],
        level: u32,
        direction: [f32; 3],
        t_max: f32,
        into_inside: bool,
    ) -> Self {
        /// Differences from any plane are then exact, as those of `f32` coordinates are.
        const UNIT: f64 = 1.0 / (1u64 << 31) as f64;
        let width = (1u64 << level) as f64;
        let along = |a: usize| f64::from(cell[a]) + (f64::from(local[a]) * width / UNIT).round() * UNIT;
        Self { origin: [0, 1, 2].map(along), direction, t_max, surface: 0, into_inside }
    }
}

/// Either kind of ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Exact to `2⁻³¹` where the coordinates are in a domain, or to 24 bits.
    origin: [f64; 3],
    /// Of 24 bits.
    direction: [f64; 3],
    pub(crate) t_min: f32,
    t_max: f32,
}

impl From<&Ray> for Line {
    #[inline(always)]
    fn from(&Ray { origin, direction, t_min, t_max }: &Ray) -> Self {
        Self { origin: origin.map(f64::from), direction: direction.map(f64::from), t_min, t_max }
    }
}

impl From<&DepartingRay> for Line {
    #[inline(always)]
    fn from(&DepartingRay { origin, direction, t_max, .. }: &DepartingRay) -> Self {
        Self { origin, direction: direction.map(f64::from), t_min: 0.0, t_max }
    }
}

impl Line {
    /// On the lattice of a level of detail, exactly.
    pub(crate) fn on_level(self, level: u32) -> Self {
        let by = 1.0 / (1u64 << level) as f64;
        Self { origin: self.origin.map(|c| c * by), direction: self.direction.map(|c| c * by), ..self }
    }

    /// Between two parameters.
    pub(crate) fn within(self, [from, to]: [f32; 2]) -> Self {
        Self { t_min: self.t_min.max(from), t_max: self.t_max.min(to), ..self }
    }
}

/// A ray clipped to a region, ready to be compared with lattice planes. The fourth lane of its vectors is idle: planes there are
/// beyond all others.
#[derive(Clone, Copy, Debug)]
pub struct ClippedRay {
    pub(crate) origin: f64x4,
    pub(crate) direction: f64x4,
    /// As `origin`, but for an axis the ray is parallel to: the middle of its cell.
    plane_origin: f64x4,
    /// As `direction`, but for an axis the ray is parallel to: [`PARALLEL`].
    plane_direction: f64x4,
    /// Its reciprocal, correctly rounded.
    inverse: f64x4,
    /// 1, or -1 for an axis on which the ray runs towards smaller coordinates.
    pub(crate) step: f64x4,
    /// Cell-local coordinate of the plane by which the ray enters a cell, and of that by which it leaves: 0 and 1 or 1 and 0.
    pub(crate) behind: f64x4,
    pub(crate) ahead: f64x4,
    /// Bit `a`: the ray runs towards smaller coordinates of axis `a`.
    pub(crate) backward: u32,
    /// The stretch inside the region; of positive length.
    pub(crate) t_begin: f64,
    pub(crate) t_end: f64,
    /// The stretch begins where the ray does, and not where it enters the region.
    pub(crate) starts_inside: bool,
}

/// Stands for a direction component of zero: half a voxel over this is beyond any `t` that `f32` directions give, and finite.
const PARALLEL: f64 = 1e-200;

/// Where the planes of the idle lane are crossed.
pub(crate) const BEYOND: f64 = 1e300;

impl ClippedRay {
    /// A ray in a region; `None` if it has no positive length there.
    pub fn of(ray: &Ray, region: &Region) -> Option<Self> {
        Self::new(ray, region)
    }

    /// Likewise, of a ray that starts on a surface.
    pub fn departing(ray: &DepartingRay, region: &Region) -> Option<Self> {
        Self::new(ray, region)
    }

    /// Where the stretch in the region begins and ends.
    pub fn interval(&self) -> [f64; 2] {
        [self.t_begin, self.t_end]
    }

    /// Bit `a`: the ray runs towards smaller coordinates of axis `a`.
    pub fn backward(&self) -> u32 {
        self.backward
    }

    /// Origin and direction, of three lanes.
    pub fn line(&self) -> [f64x4; 2] {
        [self.origin, self.direction]
    }

    /// From plane to plane along the ray: 1, or -1.
    pub fn step(&self) -> f64x4 {
        self.step
    }

    /// `None` if the ray has no positive length in the region, or is not made of numbers; only `t_min` and `t_max` may be infinite.
    #[inline]
    pub(crate) fn new(ray: impl Into<Line>, region: &Region) -> Option<Self> {
        let ray: Line = ray.into();
        let [ox, oy, oz] = ray.origin;
        let [dx, dy, dz] = ray.direction;
        let origin = f64x4::new([ox, oy, oz, 0.0]);
        let direction = f64x4::new([dx, dy, dz, 0.0]);
        let largest = f64x4::splat(f64::MAX);
        let is_finite = origin.abs().simd_le(largest) & direction.abs().simd_le(largest);
        // Also false for ends that are not numbers.
        let has_length = ray.t_min < ray.t_max;
        if is_finite.to_bitmask() != 0b1111 || !has_length {
            return None;
        }
        let mut plane_origin = f64x4::new([ox, oy, oz, -BEYOND]);
        let mut plane_direction = f64x4::new([dx, dy, dz, 1.0]);
        let is_parallel = plane_direction.simd_eq(f64x4::ZERO);
        if is_parallel.to_bitmask() != 0 {
            let is_inside = origin.simd_ge(f64x4::ZERO) & origin.simd_le(region.last);
            let is_outside = is_parallel.to_bitmask() & !is_inside.to_bitmask();
            if ray.direction == [0.0; 3] || is_outside != 0 {
                return None;
            }
            plane_origin = is_parallel.select(column(origin, region.last), plane_origin);
            plane_direction = is_parallel.select(f64x4::splat(PARALLEL), plane_direction);
        }
        let one = f64x4::splat(1.0);
        let step = one.copysign(plane_direction);
        let ahead = (one + step) * f64x4::splat(0.5);
        let mut clipped = Self {
            origin,
            direction,
            plane_origin,
            plane_direction,
            inverse: one / plane_direction,
            step,
            behind: one - ahead,
            ahead,
            backward: plane_direction.simd_lt(f64x4::ZERO).to_bitmask() & 7,
            t_begin: f64::from(ray.t_min),
            t_end: f64::from(ray.t_max),
            starts_inside: false,
        };
        let [low, high] = [region.low, region.high].map(|plane| clipped.crossings(plane));
        let [enter, leave] = [low.fast_min(high).to_array(), low.fast_max(high).to_array()];
        for a in 0..3 {
            clipped.t_begin = clipped.t_begin.max(enter[a]);
            clipped.t_end = clipped.t_end.min(leave[a]);
        }
        clipped.starts_inside = clipped.t_begin == f64::from(ray.t_min);
        (clipped.t_begin < clipped.t_end).then_some(clipped)
    }

    /// The same ray on a lattice that is finer by a power of two, `factor`, with its upper planes at `last`. No number changes but for its exponent.
    pub fn scaled(&self, factor: f64, last: f64x4) -> Self {
        let by = f64x4::new([factor, factor, factor, 1.0]);
        let origin = self.origin * by;
        let is_parallel = self.plane_direction.simd_eq(f64x4::splat(PARALLEL));
        Self {
            origin,
            direction: self.direction * by,
            plane_origin: is_parallel.select(column(origin, last), self.plane_origin * by),
            plane_direction: is_parallel.select(self.plane_direction, self.plane_direction * by),
            inverse: is_parallel.select(self.inverse, self.inverse / by),
            ..*self
        }
    }

    /// The origin; for an axis the ray is parallel to, the middle of its cell.
    #[inline(always)]
    pub(crate) fn held_at(&self) -> f64x4 {
        self.plane_origin
    }

    /// Where the stretch begins; for an axis the ray is parallel to, the middle of its cell.
    #[inline(always)]
    pub(crate) fn at_begin(&self) -> f64x4 {
        f64x4::splat(self.t_begin).mul_add(self.direction, self.plane_origin)
    }

    /// The direction; of a component of zero, one next to nothing.
    #[inline(always)]
    pub(crate) fn plane_direction(&self) -> f64x4 {
        self.plane_direction
    }

    /// Reciprocals of the direction; of a component of zero, beyond all others.
    #[inline(always)]
    pub(crate) fn inverse(&self) -> f64x4 {
        self.inverse
    }

    /// Where the ray crosses planes `k` of the three axes, `(k − o)/d` correctly rounded. If the ray is parallel to the plane, a number
    /// beyond all others, on the side that tells in which half it runs.
    #[inline(always)]
    pub fn crossings(&self, k: f64x4) -> f64x4 {
        quotient(k - self.plane_origin, self.plane_direction, self.inverse)
    }

    /// The ray's stretch in the cell with low corner `cell`, cell-local.
    #[inline(always)]
    pub fn segment(&self, cell: f64x4, [begin, end]: [f64; 2]) -> Segment {
        let entered = self.crossings(cell + self.behind).simd_eq(f64x4::splat(begin));
        let left = self.crossings(cell + self.ahead).simd_eq(f64x4::splat(end));
        Segment {
            entry: self.local(cell, begin, entered, self.behind),
            exit: self.local(cell, end, left, self.ahead),
        }
    }

    /// Cell-local coordinates at `t` in the cell with low corner `cell`, in [0, 1]; those of axes whose planes the ray crosses
    /// at `t` are `exact`, told by the lanes of `crossed`.
    #[inline(always)]
    pub(crate) fn local(&self, cell: f64x4, t: f64, crossed: f64x4, exact: f64x4) -> [f32; 3] {
        // In one rounding where the build has it, like the scalar form.
        let along = f64x4::splat(t).mul_add(self.direction, self.origin - cell);
        let inside = along.fast_max(f64x4::ZERO).fast_min(f64x4::splat(1.0));
        let [x, y, z, _] = crossed.select(exact, inside).to_array();
        [x as f32, y as f32, z as f32]
    }
}

/// The middle of the column of cells in which a ray from `origin` lies along axes that it is parallel to; in the upper planes of the domain it is the last one.
fn column(origin: f64x4, last: f64x4) -> f64x4 {
    let one = f64x4::splat(1.0);
    let low = origin.floor().fast_min(last.ceil() - one);
    // The last one can be cut short.
    (low + (low + one).fast_min(last)) * f64x4::splat(0.5)
}

/// The least of the first three lanes.
#[inline(always)]
pub(crate) fn least_lane(v: f64x4) -> f64 {
    let [x, y, z, _] = v.to_array();
    least(least(x, y), z)
}

/// The lesser of two numbers, in one instruction: `f64::min` would take care of NaN as well.
#[inline(always)]
pub(crate) fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater, likewise.
#[inline(always)]
pub(crate) fn greatest(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use isoray_grid::Dims;
    use isoray_oracle::SplitMix64;

    use super::*;

    #[test]
    fn crossings_are_correctly_rounded_quotients() {
        let mut random = SplitMix64::new(1);
        let dims = Dims::new([1 << 21, 4096, 512]).unwrap();
        let domain = Region::whole(dims).unwrap();
        let mut tested = 0;
        for _ in 0..200_000 {
            let mut component = |scale: f64| {
                let exponent = random.range(-30.0, 0.0);
                (random.sign() * random.range(0.5, 1.0) * exponent.exp2() * scale) as f32
            };
            let origin = [component(1e4), component(1e4), component(1e4)];
            let direction = [component(1.0), component(1e-3), component(1e-20)];
            let ray = Ray { origin, direction, t_min: f32::NEG_INFINITY, t_max: f32::INFINITY };
            let Some(clipped) = ClippedRay::new(&ray, &domain) else { continue };
            let k = [random.below(1 << 21), random.below(4096), random.below(512)].map(f64::from);
            let found = clipped.crossings(f64x4::new([k[0], k[1], k[2], 0.0])).to_array();
            for a in 0..3 {
                let exact = (k[a] - f64::from(origin[a])) / f64::from(direction[a]);
                assert_eq!(found[a].to_bits(), exact.to_bits(), "plane {} of {ray:?}, axis {a}", k[a]);
                tested += 1;
            }
        }
        assert!(tested > 10_000, "only {tested}");
    }

    #[test]
    fn parallel_planes_are_beyond_all_others() {
        let domain = Region::whole(Dims::new([9; 3]).unwrap()).unwrap();
        for zero in [0.0, -0.0] {
            let ray = Ray {
                origin: [8.0, 3.0, 4.5],
                direction: [zero, 1e-45, zero],
                t_min: 0.0,
                t_max: f32::INFINITY,
            };
            let clipped = ClippedRay::new(&ray, &domain).unwrap();
            let at = |k: f64| clipped.crossings(f64x4::splat(k)).to_array();
            assert!(
                at(7.0)[0] < clipped.t_begin && at(8.0)[0] > clipped.t_end,
                "the upper face belongs to the last cell"
            );
            assert!(at(4.0)[2] < clipped.t_begin && at(5.0)[2] > clipped.t_end);
        }
    }

    #[test]
    fn what_is_no_ray_meets_nothing() {
        let domain = Region::whole(Dims::new([9; 3]).unwrap()).unwrap();
        let ray =
            Ray { origin: [-1.0, 4.0, 4.0], direction: [1.0, 0.0, 0.0], t_min: 0.0, t_max: f32::INFINITY };
        assert!(ClippedRay::new(&ray, &domain).is_some());
        let not_numbers = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].into_iter().flat_map(|x| {
            (0..3).flat_map(move |a| {
                let (mut from, mut along) = (ray, ray);
                (from.origin[a], along.direction[a]) = (x, x);
                [from, along]
            })
        });
        let others = [
            Ray { direction: [0.0; 3], ..ray },
            Ray { direction: [-0.0; 3], ..ray },
            Ray { t_min: f32::NAN, ..ray },
            Ray { t_max: f32::NAN, ..ray },
            Ray { t_min: 3.0, t_max: 2.0, ..ray },
            Ray { t_min: 3.0, t_max: 3.0, ..ray },
        ];
        for ray in not_numbers.chain(others) {
            assert!(ClippedRay::new(&ray, &domain).is_none(), "{ray:?}");
        }
    }
}
