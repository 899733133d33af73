//! Rays and cells, exactly, in lanes.

use isoray_cell::{Cubic, Segment};
use isoray_trace::{Candidate, Doubles, Hit, Ray, quotient};

use crate::lanes::{F32s, F64s, LANES, columns};

/// A cell that holds the isovalue.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Its low corner.
    pub(crate) corner: [u32; 3],
    /// At its corners, less the isovalue.
    pub(crate) values: [f32; 8],
}

/// To which side all rays run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facing {
    /// Cell-local coordinate of the plane by which they enter a cell, and of that by which they leave.
    behind: [f64; 3],
    ahead: [f64; 3],
}

impl Facing {
    /// Bit `a` of `backward`: towards smaller coordinates of axis `a`.
    pub(crate) fn new(backward: u32) -> Self {
        let behind = [0, 1, 2].map(|a| f64::from(backward >> a & 1));
        Self { behind, ahead: behind.map(|b| 1.0 - b) }
    }
}

/// As many rays as there are lanes, in double precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rays {
    origin: [F64s; 3],
    direction: [F64s; 3],
    /// Correctly rounded.
    inverse: [F64s; 3],
    t_min: F64s,
    t_max: F64s,
}

impl Rays {
    /// On a lattice whose cells are of another length, a power of two.
    #[inline(always)]
    pub(crate) fn new(ray: impl Fn(usize) -> Ray, by: f32) -> Self {
        let of_rays = columns(|n| {
            let Ray { origin: [x, y, z], direction: [u, v, w], t_min, t_max } = ray(n);
            [x, y, z, u, v, w, t_min, t_max]
        });
        let [ox, oy, oz, dx, dy, dz, t_min, t_max] = of_rays;
        let scaled = |of: [F32s; 3]| of.map(|c| c * F32s::splat(by));
        Self::from_lanes(scaled([ox, oy, oz]), scaled([dx, dy, dz]), [t_min, t_max])
    }

    #[inline(always)]
    pub(crate) fn from_lanes(origin: [F32s; 3], direction: [F32s; 3], interval: [F32s; 2]) -> Self {
        let (origin, direction) = (origin.map(F64s::from_f32s), direction.map(F64s::from_f32s));
        Self::from_exact(origin, direction, interval.map(F64s::from_f32s))
    }

    /// Directions are those of single precision.
    #[inline(always)]
    pub(crate) fn from_exact(origin: [F64s; 3], direction: [F64s; 3], [t_min, t_max]: [F64s; 2]) -> Self {
        Self { origin, direction, inverse: direction.map(|d| F64s::splat(1.0) / d), t_min, t_max }
    }

    /// Where they cross the planes at `k` of axis `a`; see the single ray's `ClippedRay::crossings`, whose bits these are.
    #[inline(always)]
    fn crossings(&self, a: usize, k: F64s) -> F64s {
        quotient(k - self.origin[a], self.direction[a], self.inverse[a])
    }
}

/// What rays hit in cells.
pub(crate) struct Hits {
    /// Bit `n`: lane `n` hits.
    pub(crate) lanes: u32,
    /// Bit `n`: lane `n` begins in the cell, and starts on the surface; whether it hits is not told.
    pub(crate) starting: u32,
    segment: Segment<F32s>,
    interval: [F64s; 2],
    t: [f32; LANES],
    local: [[f32; LANES]; 3],
    entering: u32,
}

impl Hits {
    /// That of a lane that does, in `cell`.
    #[inline(always)]
    pub(crate) fn of(&self, lane: usize, cell: &Cell) -> Hit {
        Hit {
            t: self.t[lane],
            level: 0,
            cell: cell.corner,
            local: self.local.map(|axis| axis[lane]),
            corners: cell.values,
            is_entering: self.entering >> lane & 1 == 1,
        }
    }

    /// The stretch of a lane.
    pub(crate) fn candidate(&self, lane: usize, cell: &Cell) -> Candidate {
        let Segment { entry, exit } = self.segment;
        let [entry, exit] = [entry, exit].map(|end| end.map(|axis| axis.to_array()[lane]));
        Candidate {
            level: 0,
            cell: cell.corner,
            corners: cell.values,
            segment: Segment { entry, exit },
            interval: self.interval.map(|end| end.lane(lane)),
        }
    }
}

/// Intersects each ray with a cell, those of `lanes`; `None` if none hits. Where they `depart` from the surface, the cell in which a ray begins is left out.
#[inline(always)]
pub(crate) fn intersect(
    rays: &Rays,
    corner: [F64s; 3],
    values: &[F32s; 8],
    facing: &Facing,
    lanes: u32,
    depart: bool,
) -> Option<Hits> {
    let planes: [[F64s; 2]; 3] = std::array::from_fn(|a| {
        [facing.behind[a], facing.ahead[a]].map(|side| rays.crossings(a, corner[a] + F64s::splat(side)))
    });
    let begin = planes.iter().fold(rays.t_min, |t, [near, _]| t.max(*near));
    let end = planes.iter().fold(rays.t_max, |t, [_, far]| t.min(*far));
    let is_met = begin.lt(end);
    let local = |a: usize, t: F64s, plane: F64s, exact: f64| {
        let along = t.mul_add(rays.direction[a], rays.origin[a] - corner[a]);
        let inside = along.max(F64s::splat(0.0)).min(F64s::splat(1.0));
        plane.eq(t).select(F64s::splat(exact), inside)
    };
    let entry: [F64s; 3] = std::array::from_fn(|a| local(a, begin, planes[a][0], facing.behind[a]));
    // Rays that miss the cell have a stretch of no length, in which there is nothing.
    let exit: [F64s; 3] =
        std::array::from_fn(|a| is_met.select(local(a, end, planes[a][1], facing.ahead[a]), entry[a]));
    let segment = Segment { entry: entry.map(F64s::to_f32s), exit: exit.map(F64s::to_f32s) };
    let cubic = Cubic::along(values, &segment);
    let root = cubic.first_root();
    let met = is_met.bits() & lanes;
    let starting = if depart { met & !F64s::splat(0.0).lt(begin).bits() } else { 0 };
    let lanes = root.found.to_bitmask() & met & !starting;
    (lanes | starting != 0).then(|| Hits {
        lanes,
        starting,
        segment,
        interval: [begin, end],
        t: (begin + F64s::from_f32s(root.s) * (end - begin)).to_f32s().to_array(),
        local: segment.at(root.s).map(F32s::to_array),
        entering: !cubic.starts_inside().to_bitmask(),
    })
}
