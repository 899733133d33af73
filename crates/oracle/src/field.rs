//! Analytic fields in index space, with values and gradients in closed form.

use std::f64::consts::{PI, TAU};

/// A scalar field of lattice coordinates whose value and gradient are known everywhere.
pub trait Field: Sync {
    /// The value at a point.
    fn value(&self, p: [f64; 3]) -> f64;

    /// The gradient at a point, per voxel.
    fn gradient(&self, p: [f64; 3]) -> [f64; 3];
}

/// The distance from a point: the isosurface of value `r` is the sphere of radius `r`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, in lattice coordinates.
    pub centre: [f64; 3],
}

impl Field for Sphere {
    fn value(&self, p: [f64; 3]) -> f64 {
        (0..3).map(|axis| (p[axis] - self.centre[axis]).powi(2)).sum::<f64>().sqrt()
    }

    /// The unit vector away from the centre; zero at the centre itself.
    fn gradient(&self, p: [f64; 3]) -> [f64; 3] {
        let distance = self.value(p);
        std::array::from_fn(
            |axis| if distance > 0.0 { (p[axis] - self.centre[axis]) / distance } else { 0.0 },
        )
    }
}

/// A linear field, which trilinear interpolation reproduces exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Value at the lattice's origin.
    pub offset: f64,
    /// The gradient, per voxel.
    pub slope: [f64; 3],
}

impl Field for Ramp {
    fn value(&self, p: [f64; 3]) -> f64 {
        self.offset + (0..3).map(|axis| self.slope[axis] * p[axis]).sum::<f64>()
    }

    fn gradient(&self, _p: [f64; 3]) -> [f64; 3] {
        self.slope
    }
}

/// The test signal of Marschner and Lobb ("An evaluation of reconstruction filters for volume
/// rendering", 1994), with `f_M = 6` and `α = 0.25`, over a lattice of `n³` samples, scaled to 0..=255.
///
/// Rounded to u8 it is the usual Marschner-Lobb volume, whose isovalue is 127.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarschnerLobb {
    /// Samples along each axis, at least two.
    pub n: u32,
}

impl MarschnerLobb {
    const FREQUENCY: f64 = 6.0;
    const ALPHA: f64 = 0.25;
    const FULL_SCALE: f64 = 255.0;

    /// From a lattice coordinate to the signal's `[-1, 1]`.
    fn signal(&self, coordinate: f64) -> f64 {
        coordinate * self.step() - 1.0
    }

    /// Length of a voxel in the signal's coordinates.
    fn step(&self) -> f64 {
        2.0 / f64::from(self.n.max(2) - 1)
    }

    /// `FULL_SCALE` over the range of `1 - sin + α(1 + cos)`.
    fn scale() -> f64 {
        Self::FULL_SCALE / (2.0 * (1.0 + Self::ALPHA))
    }
}

impl Field for MarschnerLobb {
    fn value(&self, p: [f64; 3]) -> f64 {
        let [x, y, z] = p.map(|c| self.signal(c));
        let ripple = (TAU * Self::FREQUENCY * (PI * x.hypot(y) / 2.0).cos()).cos();
        Self::scale() * (1.0 - (PI * z / 2.0).sin() + Self::ALPHA * (1.0 + ripple))
    }

    fn gradient(&self, p: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = p.map(|c| self.signal(c));
        let r = x.hypot(y);
        let phase = TAU * Self::FREQUENCY * (PI * r / 2.0).cos();
        let phase_by_r = -TAU * Self::FREQUENCY * (PI * r / 2.0).sin() * (PI / 2.0);
        let by_r = -Self::ALPHA * phase.sin() * phase_by_r;
        let along = |c: f64| if r > 0.0 { by_r * c / r } else { 0.0 };
        let by_z = -(PI * z / 2.0).cos() * (PI / 2.0);
        [along(x), along(y), by_z].map(|g| g * Self::scale() * self.step())
    }
}

/// The gyroid `sin x cos y + sin y cos z + sin z cos x`, a surface with handles everywhere; values in
/// about ±1.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gyroid {
    /// Voxels per period.
    pub period: f64,
}

impl Field for Gyroid {
    fn value(&self, p: [f64; 3]) -> f64 {
        let [x, y, z] = p.map(|c| c * TAU / self.period);
        x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
    }

    fn gradient(&self, p: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = p.map(|c| c * TAU / self.period);
        [
            x.cos() * y.cos() - z.sin() * x.sin(),
            y.cos() * z.cos() - x.sin() * y.sin(),
            z.cos() * x.cos() - y.sin() * z.sin(),
        ]
        .map(|g| g * TAU / self.period)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gradient against central differences of the value, at points off any symmetry.
    fn check(field: &impl Field) {
        const STEP: f64 = 1e-4;
        for k in 0..50 {
            let p = [1.3 + 0.61 * f64::from(k), 2.7 + 0.37 * f64::from(k), 0.9 + 0.23 * f64::from(k)];
            let gradient = field.gradient(p);
            for axis in 0..3 {
                let at = |offset: f64| {
                    let mut q = p;
                    q[axis] += offset;
                    field.value(q)
                };
                let numeric = (at(STEP) - at(-STEP)) / (2.0 * STEP);
                let error = (numeric - gradient[axis]).abs();
                assert!(error < 1e-5 * (1.0 + gradient[axis].abs()), "{p:?} {axis}: {numeric} {gradient:?}");
            }
        }
    }

    #[test]
    fn gradients_are_those_of_the_values() {
        check(&Sphere { centre: [10.0, 9.0, 4.5] });
        check(&Ramp { offset: -3.0, slope: [0.5, -2.0, 7.0] });
        check(&MarschnerLobb { n: 64 });
        check(&Gyroid { period: 13.0 });
    }

    #[test]
    fn marschner_lobb_spans_its_scale() {
        let field = MarschnerLobb { n: 41 };
        assert!((field.value([20.0, 20.0, 0.0]) - 255.0).abs() < 1e-9);
        assert!((field.value([20.0, 20.0, 40.0]) - 51.0).abs() < 1e-9);
    }
}
