//! Which of the 4³ parts of a cube a ray may meet, all at once.
//!
//! Single precision tells it, with a margin that makes up for all of its roundings: a part that the ray passes through is never left out. Some
//! that it only comes near are taken along, and their cells sorted out later, by the exact crossings of their planes.
//!
//! # The margin
//!
//! Let `u = 2⁻²⁴`, and `D` be the largest distance, along an axis, of a plane that is compared from the point at which the ray is held: the
//! edge of the outermost cube and the largest coordinate of that point together. In voxels along the axis, that is as times multiplied by the
//! component of the direction, the entry into a part is off by at most
//!
//! - `uD` each for rounding the point, its distance from the plane, the product with the reciprocal, and the reciprocal itself;
//! - `u·k·e` for the length of `k ≤ 3` parts of edge `e` before it, and `uD` for adding it, at each of at most eleven levels; the first sum up
//!   to `uD`, since edges shrink by four;
//! - `2uD` more for the exit, and `uD` for rounding the ends of the stretch.
//!
//! Together that is less than `20uD`. Entries are early and exits late by `32uD = 2⁻¹⁹·D`: in a volume of 512³ seen from twice its edge by
//! 0.004 voxel.

use wide::{f32x4, f32x16, f64x4};

use crate::corner::Corner;
use crate::ray::{ClippedRay, greatest};

/// Of `D`, see above.
pub(crate) const MARGIN: f64 = 1.0 / (1u64 << 19) as f64;

/// A ray is held at its origin if that is at most so many edges of the outermost cube from the lattice's.
pub(crate) const NEAR: f64 = 64.0;

/// The range of the largest component of directions that are used as they are.
pub(crate) const SPEEDS: [f64; 2] = [1.0 / (1 << 20) as f64, (1 << 20) as f64];

/// The largest reciprocal: along an axis with a smaller component the ray moves by less than `2⁻³⁰` voxel in all, and products with any distance
/// stay finite.
pub(crate) const STEEPEST: f64 = (1u128 << 80) as f64;

/// When the ray enters the parts of a cube, by their number along the ray, axis by axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Entries([f32x4; 3]);

impl Entries {
    /// When it passes the planes by which it enters the part of this number in the order of the ray.
    #[inline(always)]
    pub(crate) fn of(&self, number: u32) -> [f32; 3] {
        let n = number as usize;
        std::array::from_fn(|a| self.0[a].as_array()[n >> (2 * a) & 3])
    }
}

/// A ray as the test needs it.
pub(crate) struct BoxTest {
    /// Where it is held, moved on along each axis by the margin.
    origin: f32x4,
    inverse: f32x4,
    /// 1 for an axis on which it runs towards smaller coordinates.
    behind: f32x4,
    /// Twice the margin.
    margins: f32,
    /// Time it takes per voxel along each axis, and that times the number of parts before each, x fastest.
    per_voxel: [f32x16; 2],
    before: [f32x16; 2],
    /// The same for the parts along an axis.
    per_voxel_along: [f32x4; 3],
    before_along: [f32x4; 3],
    /// The ends of its stretch.
    begin: f32x4,
    end: f32x4,
}

/// Along x and y.
pub(crate) const BEFORE: [[f32; 16]; 2] = {
    let mut before = [[0.0; 16]; 2];
    let mut n = 0;
    while n < 16 {
        before[0][n] = (n & 3) as f32;
        before[1][n] = (n >> 2) as f32;
        n += 1;
    }
    before
};

/// Where a ray is held, and in which unit its time is counted from there.
struct Held {
    at: f64x4,
    begin: f64,
    end: f64,
    inverse: f64x4,
    /// How far, along an axis, it may be from the ray.
    error: f64,
}

impl Held {
    /// Held where its stretch begins, at a speed of 1 along its fastest axis. By value: references would keep the ordinary ray in memory.
    #[cold]
    #[inline(never)]
    fn reduced(self, direction: f64x4) -> Self {
        let largest = |v: f64x4| v.abs().to_array()[..3].iter().fold(0.0, |m, &c| c.max(m));
        let speed = largest(direction);
        let at = f64x4::splat(self.begin).mul_add(direction, self.at);
        Self {
            at,
            begin: 0.0,
            end: (self.end - self.begin) * speed,
            inverse: self.inverse * f64x4::splat(speed),
            // `begin`, its product and the sum are rounded, each by less than an ulp of the distance from the origin.
            error: 8.0 * f64::EPSILON * (largest(self.at) + largest(at)),
        }
    }
}

impl BoxTest {
    /// For cubes in one of edge `edge` at the lattice's origin.
    #[inline(always)]
    pub(crate) fn new(ray: &ClippedRay, edge: f64) -> Self {
        let mut held = Held {
            at: ray.held_at(),
            begin: ray.t_begin,
            end: ray.t_end,
            inverse: ray.inverse(),
            error: 0.0,
        };
        if !is_ordinary(ray, edge) {
            held = held.reduced(ray.direction);
        }
        let [x, y, z, _] = held.at.abs().to_array();
        let margin = (MARGIN * (edge + greatest(greatest(x, y), z)) + held.error) as f32;
        let steepest = f64x4::splat(STEEPEST);
        let inverse = single(held.inverse.fast_min(steepest).fast_max(-steepest));
        let times = inverse.abs().to_array();
        let per_voxel = [0, 1].map(|a| f32x16::splat(times[a]));
        let per_voxel_along = [0, 1, 2].map(|a| f32x4::splat(times[a]));
        Self {
            origin: single(held.at) + f32x4::splat(margin).copysign(inverse),
            inverse,
            behind: single(ray.behind),
            margins: 2.0 * margin,
            before: [0, 1].map(|a| f32x16::new(BEFORE[a]) * per_voxel[a]),
            per_voxel,
            before_along: per_voxel_along.map(|time| time * f32x4::new([0.0, 1.0, 2.0, 3.0])),
            per_voxel_along,
            begin: f32x4::splat(held.begin as f32),
            end: f32x4::splat(held.end as f32),
        }
    }

    /// When the ray passes the planes by which it enters a cube.
    #[inline(always)]
    pub(crate) fn entry(&self, corner: Corner, edge: f32) -> [f32; 3] {
        let [x, y, z] = corner.coordinates().map(|c| c as f32);
        let planes = self.behind.mul_add(f32x4::splat(edge), f32x4::new([x, y, z, 0.0]));
        let [x, y, z, _] = ((planes - self.origin) * self.inverse).to_array();
        [x, y, z]
    }

    /// Of the parts, of edge `edge`, of a cube that the ray enters at `entry`, those that it may meet, in its order.
    #[inline(always)]
    pub(crate) fn met(&self, [x, y, z]: [f32; 3], edge: f32) -> (u64, Entries) {
        let edges = f32x16::splat(edge);
        let enter_x = self.before[0].mul_add(edges, f32x16::splat(x));
        let enter_y = self.before[1].mul_add(edges, f32x16::splat(y));
        let stretch = f32x16::splat(edge + self.margins);
        let leave_x = self.per_voxel[0].mul_add(stretch, enter_x);
        let leave_y = self.per_voxel[1].mul_add(stretch, enter_y);
        let (enter, leave) = (enter_x.fast_max(enter_y), leave_x.fast_min(leave_y));
        let along = |a: usize, entry| self.before_along[a].mul_add(f32x4::splat(edge), f32x4::splat(entry));
        let entries = Entries([along(0, x), along(1, y), along(2, z)]);
        let enter_z = entries.0[2];
        let leave_z = self.per_voxel_along[2].mul_add(f32x4::splat(edge + self.margins), enter_z);
        let (enter_z, leave_z) =
            (enter_z.fast_max(self.begin).to_array(), leave_z.fast_min(self.end).to_array());
        let layer = |n: usize| {
            let enter = enter.fast_max(f32x16::splat(enter_z[n]));
            let leave = leave.fast_min(f32x16::splat(leave_z[n]));
            u64::from(enter.simd_le(leave).to_bitmask())
        };
        (layer(0) | layer(1) << 16 | layer(2) << 32 | layer(3) << 48, entries)
    }

    /// Whether `p` lies in the cube of edge 2^`level` that holds it by more than the margin, so that no rounding can have moved it there.
    #[inline(always)]
    pub(crate) fn is_clearly_in_its_cube(&self, p: [f64; 3], level: u32) -> bool {
        let edge = (1u64 << level) as f64;
        let margin = f64::from(self.margins);
        p.iter().all(|&c| {
            let within = c - (c / edge).floor() * edge;
            within > margin && within < edge - margin
        })
    }
}

/// Whether all numbers are of such a size that single precision does.
#[inline(always)]
fn is_ordinary(ray: &ClippedRay, edge: f64) -> bool {
    let is_near = ray.held_at().abs().simd_le(f64x4::splat(NEAR * edge)).to_bitmask() & 7 == 7;
    let speeds = ray.direction.abs();
    let is_slow = speeds.simd_le(f64x4::splat(SPEEDS[1])).to_bitmask() & 7 == 7;
    is_near && is_slow && speeds.simd_ge(f64x4::splat(SPEEDS[0])).to_bitmask() & 7 != 0
}

#[inline(always)]
fn single(v: f64x4) -> f32x4 {
    f32x4::new(v.to_array().map(|c| c as f32))
}

#[cfg(test)]
mod tests {
    use isoray_grid::Dims;
    use isoray_oracle::SplitMix64;

    use super::*;
    use crate::corner::Facing;
    use crate::offset::mirror;
    use crate::ray::Ray;
    use crate::region::Region;

    /// The parts of the cube at `corner` that the ray passes through, by the exact crossings; in the order of the lattice.
    fn passed(ray: &ClippedRay, corner: [u32; 3], part_edge: u32) -> u64 {
        let is_passed = |n: u32| {
            let low = |a: usize| corner[a] + part_edge * (n >> (2 * a) & 3);
            let planes = |high: u32| {
                let [x, y, z] = [0, 1, 2].map(|a| f64::from(low(a) + high));
                ray.crossings(f64x4::new([x, y, z, 0.0]))
            };
            let (low, high) = (planes(0), planes(part_edge));
            let (near, far) = (low.fast_min(high).to_array(), low.fast_max(high).to_array());
            let begin = (0..3).fold(ray.t_begin, |t, a| t.max(near[a]));
            let end = (0..3).fold(ray.t_end, |t, a| t.min(far[a]));
            begin < end
        };
        (0..64).filter(|&n| is_passed(n)).fold(0, |parts, n| parts | 1 << n)
    }

    /// A ray aimed at the domain, with components and distances of all sizes.
    fn ray(random: &mut SplitMix64, last: [u32; 3]) -> Ray {
        let kind = random.below(8);
        let target: [f64; 3] = std::array::from_fn(|a| match kind & 1 {
            0 => random.range(0.0, last[a].into()),
            _ => random.below(last[a] + 1).into(),
        });
        let mut direction = [(); 3].map(|()| random.sign() * random.range(0.01, 1.0));
        match kind >> 1 {
            0 => {}
            1 => direction[random.below(3) as usize] = 0.0,
            2 => direction[random.below(3) as usize] *= random.range(-140.0, 0.0).exp2(),
            _ => direction = direction.map(|d| d * 2f64.powi(10 * (random.below(20) as i32 - 10))),
        }
        let length = direction.iter().fold(0f64, |m, d| m.max(d.abs()));
        let back = [0.0, 1.0, 700.0, 1e6, 1e12][random.below(5) as usize] / length;
        Ray {
            origin: std::array::from_fn(|a| (target[a] - back * direction[a]) as f32),
            direction: direction.map(|d| d as f32),
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    }

    #[test]
    fn no_part_on_the_ray_is_left_out() {
        let mut random = SplitMix64::new(11);
        let (mut rays, mut on_it, mut taken) = (0, 0, 0);
        for n in 0..60_000 {
            let axes = [[17, 90, 61], [300, 512, 129], [5, 3, 1 << 21]][n % 3];
            let dims = Dims::new(axes).unwrap();
            let last = axes.map(|n| n - 1);
            let ray = ray(&mut random, last);
            let Some(ray) = ClippedRay::new(&ray, &Region::whole(dims).unwrap()) else { continue };
            rays += 1;
            let mut level = axes.iter().max().unwrap().next_power_of_two().ilog2().next_multiple_of(2);
            let test = BoxTest::new(&ray, f64::from(1u32 << level));
            let facing = Facing::new(ray.backward);
            let mirror = mirror(ray.backward);
            let mut corner = Corner::default();
            let mut entry = test.entry(corner, (1u32 << level) as f32);
            // Down to a cell, by any part that the ray passes through.
            while level >= 2 {
                let part_edge = 1 << (level - 2);
                let (met, entries) = test.met(entry, part_edge as f32);
                let exact = facing.ordered(passed(&ray, corner.coordinates(), part_edge));
                assert_eq!(exact & !met, 0, "{ray:?}: level {level} at {:?}", corner.coordinates());
                on_it += exact.count_ones();
                taken += met.count_ones();
                if exact == 0 {
                    break;
                }
                let nth = random.below(exact.count_ones());
                let number = (0..nth).fold(exact, |rest, _| rest & (rest - 1)).trailing_zeros();
                corner = corner.of_part(number ^ mirror, level - 2);
                level -= 2;
                // As the traversal does it, or from the corner.
                let edge = (1u32 << level) as f32;
                entry = if random.below(2) == 0 { entries.of(number) } else { test.entry(corner, edge) };
            }
        }
        println!("{rays} rays, {on_it} parts on them, {taken} taken");
        assert!(rays > 20_000 && on_it > 200_000);
    }

    #[test]
    fn few_parts_beside_the_ray_are_taken() {
        let dims = Dims::new([512; 3]).unwrap();
        let region = Region::whole(dims).unwrap();
        let mut random = SplitMix64::new(12);
        let (mut on_it, mut taken) = (0, 0);
        for _ in 0..2000 {
            let target = [(); 3].map(|()| random.range(0.0, 511.0));
            let origin = [900.0, -700.0, 1200.0];
            let direction = std::array::from_fn(|a| ((target[a] - f64::from(origin[a])) / 2000.0) as f32);
            let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
            let Some(ray) = ClippedRay::new(&ray, &region) else { continue };
            let test = BoxTest::new(&ray, 1024.0);
            let block = target.map(|c| c as u32 & !3);
            let (met, _) = test.met(test.entry(Corner::new(block), 4.0), 1.0);
            on_it += passed(&ray, block, 1).count_ones();
            taken += met.count_ones();
        }
        println!("{on_it} cells on the rays, {taken} taken");
        assert!(on_it > 5000 && taken <= on_it + on_it / 50);
    }
}
