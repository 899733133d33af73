//! A ray, and its plane crossings.

use isoray_cell::fma64;
use isoray_grid::Dims;

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
    /// As `origin`, but for an axis the ray is parallel to: the middle of its cell.
    plane_origin: [f64; 3],
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
        let mut clipped = Self {
            origin: ray.origin.map(f64::from),
            direction: ray.direction.map(f64::from),
            plane_origin: [0.0; 3],
            backward: 0,
            t_begin: f64::from(ray.t_min),
            t_end: f64::from(ray.t_max),
        };
        if ray.direction == [0.0; 3] {
            return None;
        }
        for a in 0..3 {
            let (o, d) = (clipped.origin[a], clipped.direction[a]);
            let last = f64::from(n[a] - 1);
            if !(o.is_finite() && d.is_finite()) || n[a] < 2 {
                return None;
            }
            if d == 0.0 {
                clipped.direction[a] = 0.0; // -0.0 would put planes ahead behind
                if !(0.0..=last).contains(&o) {
                    return None;
                }
                clipped.plane_origin[a] = o.floor().min(last - 1.0) + 0.5;
            } else {
                clipped.plane_origin[a] = o;
                clipped.backward |= u32::from(d < 0.0) << a;
                let (low, high) = (clipped.crossing(a, 0), clipped.crossing(a, n[a] - 1));
                clipped.t_begin = clipped.t_begin.max(low.min(high));
                clipped.t_end = clipped.t_end.min(low.max(high));
            }
        }
        (clipped.t_begin < clipped.t_end).then_some(clipped)
    }

    /// Where the ray crosses plane `k` of `axis`: the one expression that decides every order. Infinite, on the
    /// side that tells in which half the ray runs, if it is parallel to the plane.
    #[inline(always)]
    pub(crate) fn crossing(&self, axis: usize, k: u32) -> f64 {
        (f64::from(k) - self.plane_origin[axis]) / self.direction[axis]
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
