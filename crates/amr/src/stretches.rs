//! Stretches of a ray in cubes, kept until there are as many as are integrated together: what is needed of them is then worked out in lanes, and their values are fetched
//! all at once, so that one doesn't wait for the other.

use isoray_preint::{LANES, LanesMut, Segments};
use isoray_trace::parts::ClippedRay;
use wide::{f32x8, f64x8, i32x8};

use crate::visit::{Corners, CubeAt};

/// Consecutive stretches, front to back, a lane each.
#[derive(Clone, Debug)]
pub(crate) struct Stretches<'m> {
    corners: [Corners<'m>; LANES],
    /// The cubes' low corners, in index space.
    low: [[i32; LANES]; 3],
    /// One over their edges.
    slope: [f32; LANES],
    /// Where the ray enters and leaves them.
    interval: [[f64; LANES]; 2],
    count: usize,
}

/// Lanes of half of them.
const HALF: usize = LANES / 2;

impl<'m> Stretches<'m> {
    pub(crate) fn new() -> Self {
        Self {
            corners: [Corners::NONE; LANES],
            low: [[0; LANES]; 3],
            slope: [1.0; LANES],
            interval: [[0.0; LANES]; 2],
            count: 0,
        }
    }

    /// Adds one; there must be room.
    #[inline(always)]
    pub(crate) fn push(&mut self, corners: Corners<'m>, interval: [f64; 2], place: CubeAt) {
        let n = self.count % LANES;
        self.corners[n] = corners;
        for (low, number) in self.low.iter_mut().zip(place.numbers) {
            low[n] = (number << place.exponent) as i32;
        }
        // 2 to the power of minus the exponent.
        self.slope[n] = f32::from_bits((127 - place.exponent) << (f32::MANTISSA_DIGITS - 1));
        (self.interval[0][n], self.interval[1][n]) = (interval[0], interval[1]);
        self.count = n + 1;
    }

    /// Whether there is no room for another.
    #[inline(always)]
    pub(crate) fn is_full(&self) -> bool {
        self.count == LANES
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Makes them segments of `ray`, a unit of whose parameter is `world_per_t` long in the world.
    ///
    /// Where the ray enters and leaves is off by the roundings of its parameter and of its coordinates in double precision, less than `2⁻³⁰` of the finest cells, and by
    /// one of single precision.
    pub(crate) fn write_to(&self, segments: &mut Segments, ray: &ClippedRay, world_per_t: f64) {
        let [origin, direction] = ray.line().map(|v| v.to_array());
        let LanesMut { corners, entry, exit, length, slope } = segments.lanes_mut(self.count);
        let [begin, end] = &self.interval;
        for ((length, begin), end) in length.iter_mut().zip(begin).zip(end) {
            *length = ((end - begin) * world_per_t) as f32;
        }
        *slope = self.slope;
        for half in [0, HALF] {
            let of = half..half + HALF;
            let slope = f32x8::from(&self.slope[of.clone()]);
            for a in 0..3 {
                let low = f64x8::from(i32x8::from(&self.low[a][of.clone()]));
                let [origin, direction] = [origin, direction].map(|v| f64x8::splat(v[a]));
                for (t, local) in [(begin, &mut entry[a]), (end, &mut exit[a])] {
                    let along = f64x8::from(&t[of.clone()]).mul_add(direction, origin) - low;
                    let along = f32x8::new(along.to_array().map(|c| c as f32)) * slope;
                    let along = along.fast_max(f32x8::ZERO).fast_min(f32x8::splat(1.0));
                    local[of.clone()].copy_from_slice(along.as_array());
                }
            }
            let by_cube = std::array::from_fn(|n| f32x8::new(self.corners[half + n].values()));
            for (lanes, of_corner) in corners.iter_mut().zip(f32x8::transpose(by_cube)) {
                lanes[of.clone()].copy_from_slice(of_corner.as_array());
            }
        }
    }
}
