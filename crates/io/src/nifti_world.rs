//! The three ways in which NIfTI places a lattice in the world.

use glam::{DAffine3, DQuat, DVec3};

use crate::layout::{affine, axis_aligned};

/// The fields that place the lattice.
pub(crate) struct Transforms {
    pub(crate) pixdim: [f64; 8],
    pub(crate) qform_code: i32,
    pub(crate) sform_code: i32,
    pub(crate) quatern: [f64; 3],
    pub(crate) qoffset: [f64; 3],
    pub(crate) srow: [[f64; 4]; 3],
}

/// The sform if its code is positive, else the qform, else the voxel sizes; and the names of those that
/// cannot be inverted and were passed over.
pub(crate) fn world(t: &Transforms) -> (DAffine3, Vec<&'static str>) {
    let mut ignored = Vec::new();
    if t.sform_code > 0 {
        match sform(t) {
            Some(map) => return (map, ignored),
            None => ignored.push("sform"),
        }
    }
    if t.qform_code > 0 {
        match qform(t) {
            Some(map) => return (map, ignored),
            None => ignored.push("qform"),
        }
    }
    let sizes = [t.pixdim[1], t.pixdim[2], t.pixdim[3]].map(f64::abs);
    let map = axis_aligned(sizes, [0.0; 3]).unwrap_or_else(|| {
        ignored.push("pixdim");
        DAffine3::IDENTITY
    });
    (map, ignored)
}

/// The rows of the matrix.
fn sform(t: &Transforms) -> Option<DAffine3> {
    let column = |c: usize| DVec3::new(t.srow[0][c], t.srow[1][c], t.srow[2][c]);
    affine([column(0), column(1), column(2)], column(3))
}

/// Rotation, voxel sizes and, with a negative `pixdim[0]`, a flip of k.
fn qform(t: &Transforms) -> Option<DAffine3> {
    let [b, c, d] = t.quatern;
    // The real part is not stored; rounding may make the others longer than 1.
    let real = (1.0 - (b * b + c * c + d * d)).max(0.0).sqrt();
    let rotation = DQuat::from_xyzw(b, c, d, real).normalize();
    let flip = if t.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    let steps = [
        rotation * DVec3::X * t.pixdim[1],
        rotation * DVec3::Y * t.pixdim[2],
        rotation * DVec3::Z * t.pixdim[3] * flip,
    ];
    affine(steps, t.qoffset.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transforms() -> Transforms {
        Transforms {
            pixdim: [-1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0, 0.0],
            qform_code: 1,
            sform_code: 1,
            // A quarter turn about z.
            quatern: [0.0, 0.0, 0.5f64.sqrt()],
            qoffset: [10.0, 20.0, 30.0],
            srow: [[0.0, 5.0, 0.0, 1.0], [-6.0, 0.0, 0.0, 2.0], [0.0, 0.0, 7.0, 3.0]],
        }
    }

    #[test]
    fn prefers_sform_then_qform_then_sizes() {
        let mut t = transforms();
        let (map, ignored) = world(&t);
        assert_eq!(map.transform_point3(DVec3::ONE), DVec3::new(6.0, -4.0, 10.0));
        assert!(ignored.is_empty());

        t.srow[2] = [0.0; 4];
        let (map, ignored) = world(&t);
        let found = map.transform_point3(DVec3::ONE);
        assert!(found.abs_diff_eq(DVec3::new(7.0, 22.0, 26.0), 1e-12), "{found}");
        assert_eq!(ignored, ["sform"]);

        t.quatern = [f64::NAN; 3];
        let (map, ignored) = world(&t);
        assert_eq!(map.transform_point3(DVec3::ONE), DVec3::new(2.0, 3.0, 4.0));
        assert_eq!(ignored, ["sform", "qform"]);

        t.pixdim = [0.0; 8];
        assert_eq!(world(&t).0, DAffine3::IDENTITY);
    }
}
