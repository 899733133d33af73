//! Rays in lanes of single precision, which tell the cells that each may meet: none too few, some too many.

use isoray_trace::{Beam, Ray};

use crate::lanes::{F32s, LANES, columns, greatest, least};
use crate::pairs::Rays;

/// What ends a ray before it begins.
const NOWHERE: f32 = f32::NEG_INFINITY;

/// The least component of directions: times are then finite.
pub(crate) const SLOWEST: f32 = 1.0 / (1u128 << 80) as f32;

/// Up to as many rays as there are lanes, and which of them are still on their way.
///
/// # The margin
///
/// A ray is held at its origin, for entries moved on along every axis by the [`margin`](isoray_trace::Tracer::margin), for exits moved back. With `u = 2⁻²⁴`
/// and `D` the largest distance of a plane from an origin, in voxels: `uD` each for moving the origin, its distance from the plane, the reciprocal, the
/// product, the length of the cells before and their sum, and `uD` for the length of one cell more: less than the `32uD` of the margin.
#[derive(Clone, Debug)]
pub(crate) struct Packlet {
    origin: [F32s; 3],
    direction: [F32s; 3],
    t_min: F32s,
    t_max: F32s,
    inverse: [F32s; 3],
    /// As `t_max`, of current rays only.
    end: [f32; LANES],
    /// Those that packets cannot have and that may hit something.
    unusual: u32,
    /// Of the others, those that have not hit anything.
    alive: u32,
    /// Those of them that are to be looked at yet.
    waiting: u32,
    /// Those that are looked at now, which run to the same side along all axes.
    current: u32,
    /// Those that were when it turned to them.
    turned_to: u32,
    /// By axis: those that run towards smaller coordinates.
    backward: [u32; 3],
}

/// Cells along the edge of a block.
const EDGE: usize = 4;

/// When rays enter and leave the layers of a block across each axis.
#[derive(Clone, Debug)]
pub(crate) struct Layers {
    enter: [[F32s; EDGE]; 3],
    leave: [[F32s; EDGE]; 3],
}

impl Packlet {
    /// Of these rays, no more than there are lanes.
    #[inline(always)]
    pub(crate) fn new(rays: &[Ray]) -> Self {
        // Of lanes without a ray: nothing.
        let nothing = Ray { origin: [0.0; 3], direction: [1.0; 3], t_min: 1.0, t_max: 0.0 };
        let [x, y, z, u, v, w, t_min, t_max] = columns(|n| {
            let Ray { origin: [x, y, z], direction: [u, v, w], t_min, t_max } =
                *rays.get(n).unwrap_or(&nothing);
            [x, y, z, u, v, w, t_min, t_max]
        });
        let (origin, direction) = ([x, y, z], [u, v, w]);
        let axes = [0, 1, 2];
        let [zero, one, least, largest] = [0.0, 1.0, SLOWEST, f32::MAX].map(F32s::splat);
        let has_length = t_min.simd_lt(t_max).to_bitmask();
        // Neither parallel to a plane, or nearly, nor without a number.
        let usual = axes.into_iter().fold(has_length, |usual, a| {
            let speed = direction[a].abs();
            let is_usual = least.simd_le(speed) & speed.simd_le(largest) & origin[a].abs().simd_le(largest);
            usual & is_usual.to_bitmask()
        });
        Self {
            origin,
            direction,
            t_min,
            t_max,
            inverse: direction.map(|d| one / d),
            end: [NOWHERE; LANES],
            alive: usual,
            unusual: has_length & !usual,
            waiting: 0,
            current: 0,
            turned_to: 0,
            backward: direction.map(|d| d.simd_lt(zero).to_bitmask()),
        }
    }

    pub(crate) fn current(&self) -> u32 {
        self.current
    }

    /// Those that packets cannot have and that may hit something.
    pub(crate) fn unusual(&self) -> impl Iterator<Item = usize> + use<> {
        let unusual = self.unusual;
        (0..LANES).filter(move |n| unusual >> n & 1 == 1)
    }

    /// How many have not hit anything.
    pub(crate) fn count(&self) -> usize {
        self.alive.count_ones() as usize
    }

    pub(crate) fn is_alive(&self, n: usize) -> bool {
        self.alive >> n & 1 == 1
    }

    /// All that have not hit anything are to be looked at.
    #[inline(always)]
    pub(crate) fn wait(&mut self) {
        (self.waiting, self.current) = (self.alive, 0);
    }

    /// To which sides the first ray runs that waits.
    pub(crate) fn facing(&self) -> Option<u32> {
        let lane = (self.waiting != 0).then(|| self.waiting.trailing_zeros())?;
        Some((0..3).map(|a| (self.backward[a] >> lane & 1) << a).sum())
    }

    /// Turns to the rays that run to these sides.
    pub(crate) fn turn_to(&mut self, facing: u32) {
        let same = (0..3).map(|a| if facing >> a & 1 == 1 { self.backward[a] } else { !self.backward[a] });
        self.current = same.fold(self.waiting, |current, same| current & same);
        self.waiting &= !self.current;
        self.turned_to = self.current;
        let end = self.t_max.to_array();
        self.end = std::array::from_fn(|n| if self.current >> n & 1 == 1 { end[n] } else { NOWHERE });
    }

    /// Goes to a lattice on which lengths are that many times as large, a power of two.
    pub(crate) fn scale(&mut self, by: f32) {
        let scaled = |of: [F32s; 3], by: f32| of.map(|c| c * F32s::splat(by));
        (self.origin, self.direction) = (scaled(self.origin, by), scaled(self.direction, by));
        self.inverse = scaled(self.inverse, by.recip());
    }

    /// Ray `n` is not looked at any more.
    #[inline(always)]
    pub(crate) fn end(&mut self, n: usize) {
        self.alive &= !(1 << n);
        self.current &= !(1 << n);
        self.end[n] = NOWHERE;
    }

    /// In double precision.
    pub(crate) fn exactly(&self) -> Rays {
        Rays::from_lanes(self.origin, self.direction, [self.t_min, self.t_max])
    }

    /// Widens `beam` to the current rays.
    pub(crate) fn widen(&self, beam: &mut Beam) {
        let is_current = self.counting(false);
        let [nothing, all] = [f32::INFINITY, f32::NEG_INFINITY].map(F32s::splat);
        let range = |x: F32s| {
            [least(is_current.select(x, nothing)), greatest(is_current.select(x, all))].map(f64::from)
        };
        let widen = |to: &mut [[f64; 3]; 2], a: usize, [least, most]: [f64; 2]| {
            to[0][a] = to[0][a].min(least);
            to[1][a] = to[1][a].max(most);
        };
        for a in 0..3 {
            widen(&mut beam.origins, a, range(self.origin[a]));
            widen(&mut beam.speeds, a, range(self.direction[a].abs()));
        }
        beam.interval[0] = beam.interval[0].min(range(self.t_min)[0]);
        beam.interval[1] = beam.interval[1].max(range(self.t_max)[1]);
    }

    /// When the rays pass the plane of axis `a` by which they enter the cube of this edge at `corner`, early by the margin.
    #[inline(always)]
    fn entry(&self, a: usize, corner: [u32; 3], edge: f32, backward: u32, margin: f32) -> F32s {
        let [plane, on] = match backward >> a & 1 {
            0 => [corner[a] as f32, margin],
            _ => [corner[a] as f32 + edge, -margin],
        };
        (F32s::splat(plane - on) - self.origin[a]) * self.inverse[a]
    }

    /// Whether any of the current rays may meet the cube of this edge at `corner`.
    #[inline(always)]
    pub(crate) fn meets(&self, corner: [u32; 3], edge: f32, backward: u32, margin: f32) -> bool {
        let (mut first, mut last) = (self.t_min, F32s::new(self.end));
        for a in 0..3 {
            let at = self.entry(a, corner, edge, backward, margin);
            first = first.fast_max(at);
            last = last.fast_min(self.inverse[a].abs().mul_add(F32s::splat(edge + 2.0 * margin), at));
        }
        first.simd_le(last).any()
    }

    /// Of all lanes, those that are looked at now, or `all` that were.
    #[inline(always)]
    pub(crate) fn counting(&self, all: bool) -> F32s {
        if !all {
            return F32s::new(self.end).simd_gt(F32s::splat(NOWHERE));
        }
        let turned_to = |n: usize| f32::from(self.turned_to >> n & 1 == 1);
        F32s::new(std::array::from_fn(turned_to)).simd_gt(F32s::ZERO)
    }

    /// Where rays begin and end along axis `a`, in the direction in which they run along it, that of `step`.
    #[inline(always)]
    pub(crate) fn ends_along(&self, a: usize, step: f32) -> [F32s; 2] {
        [self.t_min, self.t_max].map(|t| F32s::splat(step) * t.mul_add(self.direction[a], self.origin[a]))
    }

    /// Where they pass a plane across axis `a`, along the two others.
    #[inline(always)]
    pub(crate) fn at_plane(&self, a: usize, plane: F32s) -> [F32s; 2] {
        let t = (plane - self.origin[a]) * self.inverse[a];
        [1, 2].map(|n| (a + n) % 3).map(|a| t.mul_add(self.direction[a], self.origin[a]))
    }

    /// Finds out when the current rays pass the layers of the block at `corner`; whether any may meet it.
    #[inline(always)]
    pub(crate) fn enter(&self, corner: [u32; 3], backward: u32, margin: f32, layers: &mut Layers) -> bool {
        let end = F32s::new(self.end);
        let (mut first, mut last) = (self.t_min, end);
        for a in 0..3 {
            let time = self.inverse[a].abs();
            let at = self.entry(a, corner, EDGE as f32, backward, margin);
            let stretch = time * F32s::splat(1.0 + 2.0 * margin);
            let enter: [F32s; EDGE] = std::array::from_fn(|n| F32s::splat(n as f32).mul_add(time, at));
            let leave = enter.map(|enter| enter + stretch);
            first = first.fast_max(enter[0]);
            last = last.fast_min(leave[EDGE - 1]);
            (layers.enter[a], layers.leave[a]) = (enter, leave);
        }
        first.simd_le(last).any()
    }
}

impl Layers {
    pub(crate) const NONE: Self = Self { enter: [[F32s::ZERO; EDGE]; 3], leave: [[F32s::ZERO; EDGE]; 3] };

    /// The rays that may meet the cell of this number in their order, as far as the cell alone tells.
    #[inline(always)]
    pub(crate) fn met(&self, number: u32) -> u32 {
        let n = number as usize;
        let [i, j, k] = [n & 3, n >> 2 & 3, n >> 4 & 3];
        let enter = self.enter[0][i].fast_max(self.enter[1][j]).fast_max(self.enter[2][k]);
        let leave = self.leave[0][i].fast_min(self.leave[1][j]).fast_min(self.leave[2][k]);
        enter.simd_le(leave).to_bitmask()
    }
}
