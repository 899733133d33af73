//! A ray, and its plane crossings.

use isoray_cell::fma64;
use isoray_grid::Dims;
use wide::f64x4;

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

/// A ray clipped to a domain, ready to be compared with lattice planes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClippedRay {
    origin: [f64; 3],
    direction: [f64; 3],
    /// As `origin`, but for an axis the ray is parallel to: the middle of its cell. The fourth lane is idle.
    plane_origin: f64x4,
    /// As `direction`, without negative zeros.
    plane_direction: f64x4,
    /// Bit `a`: the ray runs towards smaller coordinates of axis `a`.
    pub(crate) backward: u32,
    /// The stretch inside the domain; of positive length.
    pub(crate) t_begin: f64,
    pub(crate) t_end: f64,
}

impl ClippedRay {
    /// `None` if the ray has no positive length in the domain, or is not made of finite numbers.
    #[inline]
    pub(crate) fn new(ray: &Ray, dims: Dims) -> Option<Self> {
        let n = dims.axes();
        let origin = ray.origin.map(f64::from);
        let direction = ray.direction.map(f64::from);
        if ray.direction == [0.0; 3] || !origin.iter().chain(&direction).all(|c| c.is_finite()) {
            return None;
        }
        let mut plane_origin = [0.0; 4];
        let mut plane_direction = [1.0; 4];
        for a in 0..3 {
            let last = f64::from(n[a] - 1);
            if last < 1.0 || (direction[a] == 0.0 && !(0.0..=last).contains(&origin[a])) {
                return None;
            }
            let is_parallel = direction[a] == 0.0;
            plane_origin[a] = if is_parallel { origin[a].floor().min(last - 1.0) + 0.5 } else { origin[a] };
            // The sum of -0.0 and 0.0 is 0.0: planes ahead of a parallel ray are at +inf, those behind at -inf.
            plane_direction[a] = direction[a] + 0.0;
        }
        let mut clipped = Self {
            origin,
            direction,
            plane_origin: f64x4::new(plane_origin),
            plane_direction: f64x4::new(plane_direction),
            backward: (0..3).fold(0, |m, a| m | u32::from(direction[a] < 0.0) << a),
            t_begin: f64::from(ray.t_min),
            t_end: f64::from(ray.t_max),
        };
        let low = clipped.crossings(f64x4::splat(0.0)).to_array();
        let last = n.map(|n| f64::from(n - 1));
        let high = clipped.crossings(f64x4::new([last[0], last[1], last[2], 0.0])).to_array();
        for a in 0..3 {
            clipped.t_begin = clipped.t_begin.max(low[a].min(high[a]));
            clipped.t_end = clipped.t_end.min(low[a].max(high[a]));
        }
        (clipped.t_begin < clipped.t_end).then_some(clipped)
    }

    /// Where the ray crosses planes `k` of the three axes: the one expression that decides every order. Infinite, on the
    /// side that tells in which half the ray runs, if it is parallel to the plane.
    #[inline(always)]
    pub(crate) fn crossings(&self, k: f64x4) -> f64x4 {
        (k - self.plane_origin) / self.plane_direction
    }

    #[inline(always)]
    pub(crate) fn is_backward(&self, axis: usize) -> bool {
        self.backward >> axis & 1 == 1
    }

    /// Cell-local coordinate at `t` along an axis whose planes the ray does not cross there.
    #[inline(always)]
    pub(crate) fn local(&self, axis: usize, cell: u32, t: f64) -> f32 {
        let local = fma64(t, self.direction[axis], self.origin[axis] - f64::from(cell));
        local.clamp(0.0, 1.0) as f32
    }
}
