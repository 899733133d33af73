//! Means of samples.

use isoray_grid::{Dims, Scalar};

use crate::fidelity::Coarse;

/// The sample of `level` ≥ 1 at `p`, a multiple of `2^level` along each axis, from those of the next finer level; `finer` is asked for
/// places on its lattice only. A uniform region is the caller's business.
pub(super) fn coarsen<T: Scalar>(
    dims: Dims,
    kind: Coarse,
    level: u32,
    p: [u32; 3],
    finer: impl Fn([u32; 3]) -> T,
) -> T {
    let half = 1 << (level - 1);
    let n = dims.axes();
    match kind {
        Coarse::None | Coarse::Injected => finer(p),
        Coarse::Mean => {
            let mut mean = Mean::of(finer(p));
            for octant in 1..8u32 {
                let q = std::array::from_fn(|a| p[a] + half * (octant >> a & 1));
                if dims.contains(q) {
                    mean.add(finer(q), 1.0);
                }
            }
            mean.value()
        }
        Coarse::Filtered if (0..3).any(|a| p[a] < half || p[a] + half >= n[a]) => finer(p),
        Coarse::Filtered => {
            let mut mean = Mean { sum: 0.0, weights: 0.0, ..Mean::of(finer(p)) };
            for n in 0..27 {
                let steps = [n % 3, n / 3 % 3, n / 9];
                let weight = steps.iter().map(|&s| if s == 1 { 2.0 } else { 1.0 }).product();
                mean.add(finer(std::array::from_fn(|a| p[a] + half * steps[a] - half)), weight);
            }
            mean.value()
        }
    }
}

/// A weighted mean of samples.
struct Mean<T> {
    first: T,
    is_uniform: bool,
    is_finite: bool,
    sum: f64,
    weights: f64,
}

impl<T: Scalar> Mean<T> {
    fn of(first: T) -> Self {
        let sum = f64::from(first.to_f32());
        Self { first, is_uniform: true, is_finite: first.is_finite(), sum, weights: 1.0 }
    }

    fn add(&mut self, s: T, weight: f64) {
        self.is_uniform &= s.same_bits(self.first);
        self.is_finite &= s.is_finite();
        self.sum += weight * f64::from(s.to_f32());
        self.weights += weight;
    }

    fn value(self) -> T {
        match (self.is_uniform, self.is_finite) {
            (true, _) => self.first,
            (_, true) => nearest(self.sum / self.weights),
            _ => nearest(f64::NAN),
        }
    }
}

/// The value of the type that is nearest, of two the even one; `v` is NaN, or between two values of the type.
fn nearest<T: Scalar>(v: f64) -> T {
    match T::IS_INTEGER {
        true => T::from_bits((v.round_ties_even() as i32).cast_unsigned()),
        false => T::from_bits((v as f32).to_bits()),
    }
}
