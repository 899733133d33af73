//! The same formulas in `f64`, from their definitions; its own errors are 10⁻⁹ of those under test.

pub(crate) fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

/// The trilinear interpolant.
pub(crate) fn trilinear(c: &[f64; 8], [x, y, z]: [f64; 3]) -> f64 {
    let along_x = |n: usize| lerp(c[n], c[n + 1], x);
    let along_y = |n: usize| lerp(along_x(n), along_x(n + 2), y);
    lerp(along_y(0), along_y(4), z)
}

/// Its gradient: along each axis, the difference of its values on the two faces across it.
pub(crate) fn gradient(c: &[f64; 8], p: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let on_face = |side: f64| {
            let mut q = p;
            q[axis] = side;
            trilinear(c, q)
        };
        on_face(1.0) - on_face(0.0)
    })
}
