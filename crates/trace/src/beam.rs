//! Many rays as one: what a traversal needs to leave out only what none of them meets.
//!
//! Let `c` be a coordinate along an axis, counted in the direction in which the rays run, `o` the origin of a ray and `i` the magnitude of its
//! reciprocal direction. It passes the plane at `c` at `(c − o)·i`. Over all rays `o` and `i` lie in intervals, and so does this product: its least
//! value is that of the greatest `o` and of the least or the greatest `i`, its greatest that of the least `o`. A part of a cube is left out if the
//! greatest of the three least entries is beyond the least of the three greatest exits.
//!
//! # The margin
//!
//! That of [`boxes`](crate::boxes), with fewer roundings: nothing is handed down from cube to cube. With `u = 2⁻²⁴` and `D` the largest distance of a
//! plane from an origin, in voxels along the axis: `uD` each for rounding the origin, its distance from the plane, the length of the parts before,
//! their sum, the edge added for the exit, the reciprocal and the product, and `uD` for the ends of the stretch. Entries are early, and exits
//! late, by `32uD`.

use wide::{f32x4, f32x16};

use crate::boxes::{BEFORE, MARGIN, NEAR, SPEEDS, STEEPEST};
use crate::corner::Corner;

/// Rays that run to the same side along every axis, in index space, by what they have at most.
///
/// It does not matter how many there are, or whether they are close to each other; but the less they have in common, the more is met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Least and greatest origin along each axis; along one that a ray is parallel to, the middle of its cell.
    pub origins: [[f64; 3]; 2],
    /// Least and greatest magnitude of the direction's components.
    pub speeds: [[f64; 3]; 2],
    /// Bit `a`: they run towards smaller coordinates of axis `a`.
    pub backward: u32,
    /// Where the first begins, and the last ends.
    pub interval: [f64; 2],
}

impl Beam {
    /// An interval that holds all of any ray.
    pub const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// Of no rays that would run to these sides, to be widened.
    pub fn nothing(backward: u32) -> Self {
        let nothing = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        Self { origins: nothing, speeds: nothing, backward, interval: [f64::INFINITY, f64::NEG_INFINITY] }
    }

    /// Of rays whose origins and directions lie between these, component by component; `None` unless all run to the same side along every axis.
    pub fn between(origins: [[f64; 3]; 2], [low, high]: [[f64; 3]; 2], interval: [f64; 2]) -> Option<Self> {
        let is_backward = high.map(|h| h < 0.0);
        let speeds = |a: usize| if is_backward[a] { [-high[a], -low[a]] } else { [low[a], high[a]] };
        let speeds = [0, 1].map(|n| [0, 1, 2].map(|a| speeds(a)[n]));
        let backward = (0..3).map(|a| u32::from(is_backward[a]) << a).sum();
        speeds[0].iter().all(|&slowest| slowest > 0.0).then_some(Self { origins, speeds, backward, interval })
    }

    /// By how many voxels entries are early and exits late for cubes in one of edge `edge` at the lattice's origin.
    pub(crate) fn margin(&self, edge: f64) -> f64 {
        let largest = self.origins.iter().flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
        MARGIN * (edge + largest)
    }

    /// Whether numbers are of such a size that single precision does for cubes in one of this edge.
    pub(crate) fn is_ordinary(&self, edge: f64) -> bool {
        let [slowest, fastest] = self.speeds;
        let is_near = self.origins.iter().flatten().all(|c| c.abs() <= NEAR * edge);
        let fastest_axis = slowest.into_iter().fold(0.0, f64::max);
        is_near && fastest.iter().all(|&s| s <= SPEEDS[1]) && fastest_axis >= SPEEDS[0]
    }
}

/// A beam as the test of 4³ parts needs it.
pub(crate) struct BeamTest {
    /// 1 for an axis on which the rays run towards smaller coordinates.
    behind: f32x4,
    /// -1 there, 1 elsewhere.
    step: f32x4,
    /// Of the origins, in the direction of the rays, and by the margin beyond.
    nearest: f32x4,
    farthest: f32x4,
    /// Magnitudes of reciprocals, the least and the greatest: along x and y, and along z.
    times: [[f32x16; 2]; 2],
    times_z: [f32x4; 2],
    begin: f32x4,
    end: f32x4,
}

impl BeamTest {
    /// For cubes in one of edge `edge` at the lattice's origin.
    pub(crate) fn new(beam: &Beam, edge: f64) -> Self {
        let is_backward = |a: usize| beam.backward >> a & 1 == 1;
        let margin = beam.margin(edge);
        let along = |sign: f64| {
            let origin = |a: usize| match is_backward(a) {
                false => beam.origins[usize::from(sign > 0.0)][a],
                true => -beam.origins[usize::from(sign < 0.0)][a],
            };
            f32x4::new([0, 1, 2, 2].map(|a| (origin(a) + sign * margin) as f32))
        };
        let reciprocals = beam.speeds.map(|speeds| speeds.map(|s| (1.0 / s).min(STEEPEST) as f32));
        let [most, least] = reciprocals;
        let [begin, end] = beam.interval.map(|t| f32x4::splat(t as f32));
        let each = [0, 1, 2, 2];
        Self {
            behind: f32x4::new(each.map(|a| if is_backward(a) { 1.0 } else { 0.0 })),
            step: f32x4::new(each.map(|a| if is_backward(a) { -1.0 } else { 1.0 })),
            nearest: along(-1.0),
            farthest: along(1.0),
            times: [0, 1].map(|a| [least, most].map(|times| f32x16::splat(times[a]))),
            times_z: [least, most].map(|times| f32x4::splat(times[2])),
            begin,
            end,
        }
    }

    /// Of the parts, of edge `edge`, of the cube at `corner` those that a ray may meet, in the order of the rays.
    #[inline(always)]
    pub(crate) fn met(&self, corner: Corner, edge: f32) -> u64 {
        let [x, y, z] = corner.coordinates().map(|c| c as f32);
        let planes = self.behind.mul_add(f32x4::splat(4.0 * edge), f32x4::new([x, y, z, 0.0])) * self.step;
        let [least_x, least_y, least_z, _] = (planes - self.farthest).to_array();
        let [most_x, most_y, most_z, _] = (planes - self.nearest + f32x4::splat(edge)).to_array();
        let across = |a: usize, least: f32, most: f32| {
            let before = f32x16::new(BEFORE[a]) * f32x16::splat(edge);
            let [least, most] = [least, most].map(|c| before + f32x16::splat(c));
            let [shortest, longest] = self.times[a];
            let enter = (least * shortest).fast_min(least * longest);
            (enter, (most * shortest).fast_max(most * longest))
        };
        let (enter_x, leave_x) = across(0, least_x, most_x);
        let (enter_y, leave_y) = across(1, least_y, most_y);
        let (enter, leave) = (enter_x.fast_max(enter_y), leave_x.fast_min(leave_y));
        let before = f32x4::new([0.0, 1.0, 2.0, 3.0]) * f32x4::splat(edge);
        let [least, most] = [least_z, most_z].map(|c| before + f32x4::splat(c));
        let [shortest, longest] = self.times_z;
        let enter_z = (least * shortest).fast_min(least * longest).fast_max(self.begin).to_array();
        let leave_z = (most * shortest).fast_max(most * longest).fast_min(self.end).to_array();
        let layer = |n: usize| {
            let enter = enter.fast_max(f32x16::splat(enter_z[n]));
            let leave = leave.fast_min(f32x16::splat(leave_z[n]));
            u64::from(enter.simd_le(leave).to_bitmask())
        };
        layer(0) | layer(1) << 16 | layer(2) << 32 | layer(3) << 48
    }
}
