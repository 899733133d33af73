//! Rays in lanes of double precision, which cross planes where each of them alone does, bit for bit.

use wide::f64x8;

use crate::quotient::quotient;
use crate::ray::ClippedRay;

/// Rays that share lanes.
pub(crate) const GROUP: usize = 8;

/// A number of each ray.
pub(crate) type Lanes = f64x8;

/// Planes across each axis of a block.
const PLANES: usize = 5;

/// Stretches: where rays enter and leave.
pub(crate) type Stretches = [Lanes; 2];

/// Where rays enter and leave a cell, cell-local, by axis.
pub(crate) type Ends = [[[f32; GROUP]; 3]; 2];

/// Rays that run to the same sides; some lanes may be idle.
#[derive(Clone, Debug)]
pub(crate) struct RayLanes {
    origin: [Lanes; 3],
    direction: [Lanes; 3],
    /// As in [`ClippedRay`].
    plane_origin: [Lanes; 3],
    plane_direction: [Lanes; 3],
    inverse: [Lanes; 3],
    begin: Lanes,
    /// Before all beginnings in lanes that are idle.
    end: Lanes,
    backward: u32,
}

impl RayLanes {
    /// Of those of the rays that run to these sides.
    pub(crate) fn new(rays: &[Option<ClippedRay>; GROUP], backward: u32) -> Self {
        let lanes = |idle: f64, of: &dyn Fn(&ClippedRay) -> f64| {
            Lanes::new(std::array::from_fn(|n| match &rays[n] {
                Some(ray) if ray.backward == backward => of(ray),
                _ => idle,
            }))
        };
        let axes = [0, 1, 2];
        Self {
            origin: axes.map(|a| lanes(0.0, &|ray| ray.origin.to_array()[a])),
            direction: axes.map(|a| lanes(1.0, &|ray| ray.direction.to_array()[a])),
            plane_origin: axes.map(|a| lanes(0.0, &|ray| ray.held_at().to_array()[a])),
            plane_direction: axes.map(|a| lanes(1.0, &|ray| ray.plane_direction().to_array()[a])),
            inverse: axes.map(|a| lanes(1.0, &|ray| ray.inverse().to_array()[a])),
            begin: lanes(f64::INFINITY, &|ray| ray.t_begin),
            end: lanes(f64::NEG_INFINITY, &|ray| ray.t_end),
            backward,
        }
    }

    /// The ray in this lane goes no further.
    pub(crate) fn end(&mut self, lane: usize) {
        let mut end = self.end.to_array();
        end[lane] = f64::NEG_INFINITY;
        self.end = Lanes::new(end);
    }

    /// Where they cross a plane of axis `a`, as [`ClippedRay::crossings`].
    #[inline(always)]
    fn crossing(&self, a: usize, plane: f64) -> Lanes {
        let from = Lanes::splat(plane) - self.plane_origin[a];
        quotient(from, self.plane_direction[a], self.inverse[a])
    }

    /// By axis: where they cross the planes that divide the cube at `corner` into `N - 1` layers of this edge, in their own order.
    #[inline(always)]
    fn planes<const N: usize>(&self, corner: [u32; 3], edge: u32) -> [[Lanes; N]; 3] {
        std::array::from_fn(|a| {
            std::array::from_fn(|n| {
                let n = if self.backward >> a & 1 == 1 { N - 1 - n } else { n };
                self.crossing(a, f64::from(corner[a] + n as u32 * edge))
            })
        })
    }

    /// Of the children of a cube, by their numbers in the order of the rays, those of the `active` ones that any ray passes through.
    #[inline(always)]
    pub(crate) fn children(&self, corner: [u32; 3], half: u32, active: u32) -> [bool; 8] {
        let at: [[Lanes; 3]; 3] = self.planes(corner, half);
        let halves = |a: usize| [0, 1].map(|n| [at[a][n], at[a][n + 1]]);
        let x = halves(0).map(|half| both(half, self.all()));
        let (y, z) = (halves(1), halves(2));
        std::array::from_fn(|n| {
            let octant = n as u32 ^ self.backward;
            active >> octant & 1 == 1 && met(both(both(x[n & 1], y[n >> 1 & 1]), z[n >> 2])) != 0
        })
    }

    /// Their stretches in a cube.
    #[inline(always)]
    pub(crate) fn stretches(&self, corner: [u32; 3], edge: u32) -> Stretches {
        let at: [Stretches; 3] = self.planes(corner, edge);
        at.into_iter().fold(self.all(), both)
    }

    /// Their stretches in the volume.
    #[inline(always)]
    fn all(&self) -> Stretches {
        [self.begin, self.end]
    }
}

/// The part of stretches that is in others, too.
#[inline(always)]
pub(crate) fn both([begin, end]: Stretches, [from, to]: Stretches) -> Stretches {
    [begin.fast_max(from), end.fast_min(to)]
}

/// The rays whose stretches have a length.
#[inline(always)]
pub(crate) fn met([begin, end]: Stretches) -> u32 {
    begin.simd_lt(end).to_bitmask()
}

/// Rays in the cells of a block.
pub(crate) struct InBlock<'r> {
    rays: &'r RayLanes,
    at: [[Lanes; PLANES]; 3],
}

impl<'r> InBlock<'r> {
    #[inline(always)]
    pub(crate) fn new(rays: &'r RayLanes, corner: [u32; 3]) -> Self {
        Self { rays, at: rays.planes(corner, 1) }
    }

    /// Their stretches in the block.
    #[inline(always)]
    pub(crate) fn all(&self) -> Stretches {
        self.at.iter().fold(self.rays.all(), |all, at| both(all, [at[0], at[PLANES - 1]]))
    }

    /// What of `stretches` is in a layer of cells, of this number in the order of the rays, across axis `a`.
    #[inline(always)]
    pub(crate) fn layer(&self, stretches: Stretches, a: usize, n: u32) -> Stretches {
        let at = &self.at[a];
        let n = n as usize % (PLANES - 1);
        both(stretches, [at[n], at[n + 1]])
    }

    /// Where they enter and leave a cell of the block at `corner`, of this offset and of these numbers along the axes, cell-local; as
    /// [`ClippedRay::local`].
    #[inline(always)]
    pub(crate) fn ends(
        &self,
        corner: [u32; 3],
        offset: u32,
        numbers: [u32; 3],
        stretches: Stretches,
    ) -> Ends {
        let (zero, one) = (Lanes::ZERO, Lanes::splat(1.0));
        let RayLanes { origin, direction, backward, .. } = self.rays;
        let from_low = [0, 1, 2].map(|a| {
            let low = corner[a] + (offset >> (2 * a) & 3);
            origin[a] - Lanes::splat(low.into())
        });
        [0, 1].map(|side| {
            let t = stretches[side];
            [0, 1, 2].map(|a: usize| {
                let inside = t.mul_add(direction[a], from_low[a]).fast_max(zero).fast_min(one);
                let plane = self.at[a][numbers[a] as usize % (PLANES - 1) + side];
                let is_upper = (backward >> a & 1) as usize != side;
                let exact = if is_upper { one } else { zero };
                plane.simd_eq(t).select(exact, inside).to_array().map(|c| c as f32)
            })
        })
    }
}
