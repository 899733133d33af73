//! Where samples come from.

use crate::Field;

/// A volume of samples at integer coordinates, as the oracle sees it.
pub trait Lattice: Sync {
    /// Number of samples along x, y and z. An axis with fewer than two has no cells.
    fn dims(&self) -> [u32; 3];

    /// The sample at index coordinates `p`, each less than the axis' dimension; it may be non-finite.
    ///
    /// Finite samples should stay below 1e300 in magnitude, so that differences do not overflow.
    fn sample(&self, p: [u32; 3]) -> f64;
}

impl<L: Lattice> Lattice for &L {
    fn dims(&self) -> [u32; 3] {
        (**self).dims()
    }

    fn sample(&self, p: [u32; 3]) -> f64 {
        (**self).sample(p)
    }
}

/// A lattice that computes each sample with a closure, on every use.
#[derive(Clone, Copy, Debug)]
pub struct FnLattice<F> {
    dims: [u32; 3],
    sample: F,
}

impl<F: Fn([u32; 3]) -> f64 + Sync> FnLattice<F> {
    /// Wraps `sample`, which is called with coordinates inside `dims` only.
    pub fn new(dims: [u32; 3], sample: F) -> Self {
        Self { dims, sample }
    }
}

impl<F: Fn([u32; 3]) -> f64 + Sync> Lattice for FnLattice<F> {
    fn dims(&self) -> [u32; 3] {
        self.dims
    }

    fn sample(&self, p: [u32; 3]) -> f64 {
        (self.sample)(p)
    }
}

/// A lattice that owns its samples, x fastest, in any type that converts to f64 without loss.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseLattice<T> {
    dims: [u32; 3],
    samples: Vec<T>,
}

impl<T> DenseLattice<T> {
    /// Takes samples with x fastest; `None` if their number is not the product of `dims`.
    pub fn from_vec(dims: [u32; 3], samples: Vec<T>) -> Option<Self> {
        let expected = dims.iter().try_fold(1_usize, |n, &d| n.checked_mul(d as usize))?;
        (samples.len() == expected).then_some(Self { dims, samples })
    }

    /// Calls `sample` once for each lattice point, x fastest.
    pub fn from_fn(dims: [u32; 3], mut sample: impl FnMut([u32; 3]) -> T) -> Self {
        let mut samples = Vec::new();
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                samples.extend((0..dims[0]).map(|x| sample([x, y, z])));
            }
        }
        Self { dims, samples }
    }

    /// Samples an analytic field at the lattice points; `quantise` turns its value into a sample.
    pub fn from_field(dims: [u32; 3], field: &impl Field, quantise: impl Fn(f64) -> T) -> Self {
        Self::from_fn(dims, |p| quantise(field.value(p.map(f64::from))))
    }

    /// The samples, x fastest.
    pub fn samples(&self) -> &[T] {
        &self.samples
    }
}

impl<T: Copy + Into<f64> + Sync> Lattice for DenseLattice<T> {
    fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// Outside the lattice the sample is NaN, which is to say empty.
    fn sample(&self, p: [u32; 3]) -> f64 {
        let [x, y, z] = p.map(|c| c as usize);
        let [nx, ny, _] = self.dims.map(|c| c as usize);
        if x >= nx || y >= ny {
            return f64::NAN;
        }
        self.samples.get((z * ny + y) * nx + x).map_or(f64::NAN, |&s| s.into())
    }
}
