//! The checked size of a lattice.

/// Largest number of samples along one axis: cell coordinates then stay exact in `f32` arithmetic
/// (24-bit significand, three bits left for fractions) and node coordinates fit an `i32`.
pub const MAX_AXIS: u32 = 1 << 21;

/// Number of samples along x, y and z, each at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Dims([u32; 3]);

/// A lattice size that no volume can have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DimsError {
    /// An axis has no samples, or more than [`MAX_AXIS`].
    #[error("dimensions {0}x{1}x{2}: expected 1 to {MAX_AXIS} samples along each axis")]
    Axis(u32, u32, u32),
    /// The product of the three is not addressable on this machine.
    #[error("dimensions {0}x{1}x{2}: their product overflows the address space")]
    Product(u32, u32, u32),
}

impl Dims {
    /// Checks `[nx, ny, nz]`.
    ///
    /// # Errors
    /// An axis outside `1..=MAX_AXIS`, or a product that cannot be addressed with 16 bytes a sample.
    pub fn new(n: [u32; 3]) -> Result<Self, DimsError> {
        if n.iter().any(|&a| a == 0 || a > MAX_AXIS) {
            return Err(DimsError::Axis(n[0], n[1], n[2]));
        }
        let product: u128 = n.iter().map(|&a| u128::from(a)).product();
        if product > (isize::MAX as u128) / 16 {
            return Err(DimsError::Product(n[0], n[1], n[2]));
        }
        Ok(Self(n))
    }

    /// `[nx, ny, nz]`.
    pub fn axes(self) -> [u32; 3] {
        self.0
    }

    /// Number of samples.
    pub fn samples(self) -> usize {
        self.0.iter().map(|&a| a as usize).product()
    }

    /// Number of samples in one layer of constant `k`.
    pub fn layer(self) -> usize {
        self.0[0] as usize * self.0[1] as usize
    }

    /// Number of cells; zero where an axis has a single sample.
    pub fn cells(self) -> usize {
        self.0.iter().map(|&a| a as usize - 1).product()
    }

    /// Whether `p` is a lattice point.
    pub fn contains(self, p: [u32; 3]) -> bool {
        p[0] < self.0[0] && p[1] < self.0[1] && p[2] < self.0[2]
    }

    /// Position of sample `(i, j, k)` in an array with `i` fastest; `p` must be inside.
    pub fn linear(self, p: [u32; 3]) -> usize {
        (p[2] as usize * self.0[1] as usize + p[1] as usize) * self.0[0] as usize + p[0] as usize
    }
}

impl std::fmt::Display for Dims {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x}x{y}x{z}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_empty_and_overflowing() {
        assert!(matches!(Dims::new([0, 1, 1]), Err(DimsError::Axis(0, 1, 1))));
        assert!(matches!(Dims::new([MAX_AXIS + 1, 1, 1]), Err(DimsError::Axis(..))));
        assert!(matches!(Dims::new([MAX_AXIS; 3]), Err(DimsError::Product(..))));
    }

    #[test]
    fn counts() {
        let d = Dims::new([4, 3, 2]).unwrap();
        assert_eq!((d.samples(), d.layer(), d.cells()), (24, 12, 6));
        assert_eq!(d.linear([3, 2, 1]), 23);
        assert_eq!(Dims::new([1, 5, 5]).unwrap().cells(), 0);
        assert_eq!(d.to_string(), "4x3x2");
    }
}
