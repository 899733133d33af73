//! The isosurface in one cell (section 4.4).

use isoray_cell::fma;

/// Linear interpolations of the root finder.
const INTERPOLATIONS: usize = 3;

/// The ray's stretch in a cell: cell-local entry, and from there to the exit.
#[derive(Clone, Copy)]
pub(super) struct Stretch {
    pub(super) entry: [f32; 3],
    pub(super) along: [f32; 3],
}

/// A cubic in power basis, `((a·s + b)·s + c)·s + d`.
struct Cubic {
    a: f32,
    b: f32,
    c: f32,
    d: f32,
}

impl Cubic {
    /// The trilinear interpolant of `corners` (octant order: x is bit 2) on the stretch, `s` from 0 to 1.
    #[inline(always)]
    fn new(corners: &[f32; 8], stretch: &Stretch) -> Self {
        let v = corners;
        let ([px, py, pz], [dx, dy, dz]) = (stretch.entry, stretch.along);
        // Along x the four edges are linear in s, along y the two faces quadratic, along z it is a cubic.
        let edge = |n: usize| {
            let slope = v[n + 4] - v[n];
            [fma(slope, px, v[n]), slope * dx]
        };
        let face = |low: [f32; 2], high: [f32; 2]| {
            let (e0, e1) = (high[0] - low[0], high[1] - low[1]);
            [fma(e0, py, low[0]), fma(e0, dy, fma(e1, py, low[1])), e1 * dy]
        };
        let (near, far) = (face(edge(0), edge(2)), face(edge(1), edge(3)));
        let e: [f32; 3] = std::array::from_fn(|n| far[n] - near[n]);
        Self {
            a: e[2] * dz,
            b: fma(e[1], dz, fma(e[2], pz, near[2])),
            c: fma(e[0], dz, fma(e[1], pz, near[1])),
            d: fma(e[0], pz, near[0]),
        }
    }

    #[inline(always)]
    fn at(&self, s: f32) -> f32 {
        fma(fma(fma(self.a, s, self.b), s, self.c), s, self.d)
    }

    /// Where the derivative vanishes, ascending; NaN, or out of order, if nowhere.
    #[inline(always)]
    fn extrema(&self) -> [f32; 2] {
        let discriminant = fma(self.b, self.b, -3.0 * self.a * self.c);
        if discriminant < 0.0 {
            return [f32::NAN; 2];
        }
        let q = -(self.b + discriminant.sqrt().copysign(self.b));
        let (r0, r1) = (q / (3.0 * self.a), self.c / q);
        if r0 <= r1 { [r0, r1] } else { [r1, r0] }
    }
}

/// The first change of side on the stretch, as a fraction of it: Neubauer's method as Marmitt et al. (2004)
/// give it. The stretch is split at the extrema; in the first piece whose ends differ in side, regula falsi
/// approaches the root.
#[inline(always)]
pub(super) fn first_root(corners: &[f32; 8], stretch: &Stretch) -> Option<f32> {
    let cubic = Cubic::new(corners, stretch);
    let is_inside = |f: f32| f >= 0.0;
    let (mut s0, mut f0) = (0.0, cubic.d);
    let (mut s1, mut f1) = (1.0, cubic.at(1.0));
    for s in cubic.extrema() {
        if s > s0 && s < s1 {
            let f = cubic.at(s);
            if is_inside(f) == is_inside(f0) {
                (s0, f0) = (s, f);
            } else {
                (s1, f1) = (s, f);
            }
        }
    }
    if is_inside(f0) == is_inside(f1) {
        return None;
    }
    let starts_inside = is_inside(f0);
    let interpolate = |s0: f32, f0: f32, s1: f32, f1: f32| fma(s1 - s0, f0 / (f0 - f1), s0);
    for _ in 1..INTERPOLATIONS {
        let s = interpolate(s0, f0, s1, f1);
        let f = cubic.at(s);
        if is_inside(f) == starts_inside {
            (s0, f0) = (s, f);
        } else {
            (s1, f1) = (s, f);
        }
    }
    Some(interpolate(s0, f0, s1, f1))
}

/// Gradient of the trilinear interpolant of `corners` (octant order) at cell-local `p`.
#[inline(always)]
pub(super) fn gradient(corners: &[f32; 8], [x, y, z]: [f32; 3]) -> [f32; 3] {
    let v = corners;
    let lerp = |a: f32, b: f32, t: f32| fma(b - a, t, a);
    let slope_x = |n: usize| v[n + 4] - v[n];
    let edge: [f32; 4] = std::array::from_fn(|n| fma(slope_x(n), x, v[n]));
    [
        lerp(lerp(slope_x(0), slope_x(2), y), lerp(slope_x(1), slope_x(3), y), z),
        lerp(edge[2] - edge[0], edge[3] - edge[1], z),
        lerp(edge[1] - edge[0], edge[3] - edge[2], y),
    ]
}
