//! What rays extend to, plane by plane across an axis (Knoll 2009, section 5.2).
//!
//! Where a ray passes the plane at `k` is linear in `k`, and so are all bounds on rays that are right at two planes: the greatest of linear functions is convex, and lies
//! below its chord. For rays from one point, or side by side, the chord is what they extend to.

use crate::lanes::{F32s, greatest, least};
use crate::packlet::Packlet;

/// What some rays extend to between two planes across an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frustum {
    axis: usize,
    /// 1, or -1 if the rays run towards smaller coordinates along the axis.
    step: f64,
    /// The planes, in the direction of the rays.
    first: f64,
    last: f64,
    /// By other axis: the least and the greatest coordinate at the first plane, and what is added to them from plane to plane.
    at_first: [[f64; 2]; 2],
    slopes: [[f64; 2]; 2],
}

impl Frustum {
    /// Of those rays of `packlets` that are on their way, or of `all` that were when they turned to their side, from one plane across `axis` to another; `None` if none gets there.
    ///
    /// With `u = 2⁻²⁴`: planes moved apart by the `margin` cover `uD` each for the distance from the origin, the reciprocal and the product, with `D` as for [`Packlet`].
    /// Where a ray is at a plane then has an error of `2u` times the sum of that coordinate and the origin's: less than the `margin` and `16u` times the coordinate.
    pub(crate) fn new(
        packlets: &[Packlet],
        axis: usize,
        [enter, leave]: [f64; 2],
        all: bool,
        margin: f32,
    ) -> Option<Self> {
        let step = if enter < leave { 1.0 } else { -1.0 };
        // Where the first ray begins and the last one ends, if that is nearer.
        let [begin, end] = extremes(packlets, all, |packlet| packlet.ends_along(axis, step as f32));
        let margin = f64::from(margin);
        let first = (step * enter).max(f64::from(begin[0])) - margin;
        let last = (step * leave).min(f64::from(end[1])) + margin;
        if first.is_nan() || last.is_nan() || first > last {
            return None;
        }
        let at_plane = |plane: f64| {
            let plane = F32s::splat((step * plane) as f32);
            extremes(packlets, all, |packlet| packlet.at_plane(axis, plane))
        };
        let (near, far) = (at_plane(first), at_plane(last));
        let margin_at = |c: f32| margin + f64::from(c.abs()) / (1u32 << 20) as f64;
        let widened = |[least, most]: [f32; 2]| {
            [f64::from(least) - margin_at(least), f64::from(most) + margin_at(most)]
        };
        let (at_first, at_last) = (near.map(widened), far.map(widened));
        // Of no length where it begins and ends in one plane.
        let length = (last - first).max(f64::MIN_POSITIVE);
        let slopes = [0, 1].map(|n| [0, 1].map(|side| (at_last[n][side] - at_first[n][side]) / length));
        Some(Self { axis, step, first, last, at_first, slopes })
    }

    /// The two other axes.
    pub(crate) fn others(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// By other axis, the least and the greatest coordinate between two planes, in the order of the rays; `None` if there is nothing of it.
    #[inline(always)]
    pub(crate) fn between(&self, planes: [u32; 2]) -> Option<[[f64; 2]; 2]> {
        let [enter, leave] = planes.map(|plane| self.step * f64::from(plane));
        if enter > self.last || leave < self.first {
            return None;
        }
        let (enter, leave) = (enter.max(self.first) - self.first, leave.min(self.last) - self.first);
        Some(std::array::from_fn(|n| {
            let at = |t: f64, side: usize| t * self.slopes[n][side] + self.at_first[n][side];
            let (least, most) = (at(enter, 0).min(at(leave, 0)), at(enter, 1).max(at(leave, 1)));
            // Numbers that are not finite bound nothing.
            let is_bound = least.is_finite() && most.is_finite();
            if is_bound { [least, most] } else { [f64::NEG_INFINITY, f64::INFINITY] }
        }))
    }
}

/// By what is told of each ray, twice: the least and the greatest of all.
fn extremes(packlets: &[Packlet], all: bool, of: impl Fn(&Packlet) -> [F32s; 2]) -> [[f32; 2]; 2] {
    let [mut low, mut high] = [f32::INFINITY, f32::NEG_INFINITY].map(|c| [F32s::splat(c); 2]);
    for packlet in packlets {
        let (counts, told) = (packlet.counting(all), of(packlet));
        for n in 0..2 {
            low[n] = low[n].fast_min(counts.select(told[n], F32s::splat(f32::INFINITY)));
            high[n] = high[n].fast_max(counts.select(told[n], F32s::splat(f32::NEG_INFINITY)));
        }
    }
    std::array::from_fn(|n| [least(low[n]), greatest(high[n])])
}

#[cfg(test)]
mod tests {
    use isoray_oracle::SplitMix64;
    use isoray_trace::Ray;

    use super::*;
    use crate::lanes::LANES;

    const EDGE: f64 = 256.0;
    /// That of [`Tracer::margin`](isoray_trace::Tracer::margin) in a cube of that edge, for origins at most as far away as here.
    const MARGIN: f32 = 5.0 * EDGE as f32 / (1u32 << 19) as f32;

    /// Rays close to each other or not, from one point or from many, that run to the same side as `to` along every axis.
    fn rays(random: &mut SplitMix64, to: [f64; 3]) -> Vec<Ray> {
        let width = random.range(-12.0, 0.0).exp2();
        // They pass somewhere through the cube.
        let back = random.range(-1.0, 4.0) * EDGE / to.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        let from = to.map(|c| random.range(0.0, EDGE) - back * c);
        let is_parallel = random.coin();
        let ray = |random: &mut SplitMix64| {
            let apart = [(); 3].map(|()| random.range(-width, width));
            let (shift, turn) = if is_parallel { (EDGE, 0.0) } else { (0.0, 1.0) };
            Ray {
                origin: [0, 1, 2].map(|a| (from[a] + shift * apart[a]) as f32),
                direction: [0, 1, 2].map(|a| (to[a] * (1.0 + turn * 0.9 * apart[a])) as f32),
                t_min: if random.coin() { 0.0 } else { random.range(0.0, EDGE) as f32 },
                t_max: if random.coin() { f32::INFINITY } else { random.range(EDGE, 8.0 * EDGE) as f32 },
            }
        };
        (0..1 + random.below(40)).map(|_| ray(random)).collect()
    }

    #[test]
    fn what_rays_pass_lies_in_their_frustum() {
        let mut random = SplitMix64::new(5);
        let (mut passed, mut area, mut least_area) = (0, 0.0, 0.0);
        for _ in 0..4000 {
            let to = [(); 3].map(|()| random.sign() * random.range(-6.0, 0.0).exp2());
            let rays = rays(&mut random, to);
            let axis = random.below(3) as usize;
            let is_forward = to[axis] > 0.0;
            let mut packlets: Vec<Packlet> = rays.chunks(LANES).map(Packlet::new).collect();
            let backward = (0..3).map(|a| u32::from(to[a] < 0.0) << a).sum();
            for packlet in &mut packlets {
                packlet.wait();
                packlet.turn_to(backward);
            }
            let ends = if is_forward { [0.0, EDGE] } else { [EDGE, 0.0] };
            let frustum = Frustum::new(&packlets, axis, ends, random.coin(), MARGIN);
            for _ in 0..20 {
                let [low, high] = [random.below(EDGE as u32), 1 + random.below(16)];
                let high = (low + high).min(EDGE as u32);
                let planes = if is_forward { [low, high] } else { [high, low] };
                let extents = frustum.and_then(|frustum| frustum.between(planes));
                let mut exact = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
                for ray in &rays {
                    let at = |k: u32| {
                        (f64::from(k) - f64::from(ray.origin[axis])) / f64::from(ray.direction[axis])
                    };
                    let (begin, end) =
                        (at(planes[0]).max(ray.t_min.into()), at(planes[1]).min(ray.t_max.into()));
                    if begin > end {
                        continue;
                    }
                    for t in [begin, end] {
                        let along = |n: usize| {
                            let a = (axis + 1 + n) % 3;
                            f64::from(ray.origin[a]) + t * f64::from(ray.direction[a])
                        };
                        for n in 0..2 {
                            exact[n] = [exact[n][0].min(along(n)), exact[n][1].max(along(n))];
                        }
                        if (0..2).all(|n| (0.0..=EDGE).contains(&along(n))) {
                            let extents = extents.expect("a ray passes");
                            let is_in =
                                (0..2).all(|n| extents[n][0] <= along(n) && along(n) <= extents[n][1]);
                            assert!(is_in, "{ray:?} between {planes:?} of axis {axis}: {extents:?}");
                            passed += 1;
                        }
                    }
                }
                if let Some(extents) = extents.filter(|_| exact[0][0].is_finite()) {
                    let of = |e: [[f64; 2]; 2]| e.map(|[low, high]| high - low + 1.0).iter().product::<f64>();
                    (area, least_area) = (area + of(extents), least_area + of(exact));
                }
            }
        }
        println!("{passed} points, {:.3} times the least area", area / least_area);
        // Where some begin in the middle, or end there, chords hold more.
        assert!(passed > 200_000 && area < 2.5 * least_area);
    }
}
