//! Coarse lattices of a dense array, from their definition alone.

use isoray_build::{FileOptions, build_with};
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_octree::{Coarse, OctreeVolume};

use crate::octree::volumes::{at, points};

/// Those that there are coarse samples of.
pub(crate) const KINDS: [Coarse; 3] = [Coarse::Injected, Coarse::Mean, Coarse::Filtered];

/// Sizes of several levels, odd ones and flat ones among them; the last has subtrees of more than one task.
pub(crate) const SIZES: [[u32; 3]; 7] =
    [[1, 1, 1], [2, 9, 4], [8, 8, 8], [17, 16, 15], [33, 31, 5], [40, 35, 33], [131, 3, 21]];

pub(crate) fn octree<T: Scalar>(size: [u32; 3], samples: &[T], coarse: Coarse) -> OctreeVolume<T> {
    let dims = Dims::new(size).unwrap();
    let options = FileOptions { coarse, ..FileOptions::default() };
    build_with(&mut DenseVolume::new(dims, samples).unwrap(), &options, |_| {}).unwrap()
}

/// The highest level of which the whole volume is not one cell, and one more.
pub(crate) fn top(size: [u32; 3]) -> u32 {
    size.into_iter().max().unwrap().next_power_of_two().ilog2() + 1
}

/// Places along an axis of `n` samples.
pub(crate) fn places(n: u32, level: u32) -> Vec<u32> {
    let mut places: Vec<u32> = (0..n).step_by(1 << level).collect();
    if places.last() != Some(&(n - 1)) {
        places.push(n - 1);
    }
    places
}

/// Coarse samples at the multiples of `2^level`, x fastest; of all levels up to one.
pub(crate) struct Pyramid<T> {
    size: [u32; 3],
    levels: Vec<Vec<T>>,
}

impl<T: Scalar> Pyramid<T> {
    pub(crate) fn new(size: [u32; 3], samples: &[T], kind: Coarse, top: u32) -> Self {
        let mut pyramid = Self { size, levels: vec![samples.to_vec()] };
        for level in 1..=top {
            let places = points(pyramid.counts(level)).map(|i| i.map(|c| c << level));
            let next = places.map(|p| pyramid.coarsened(level, p, kind)).collect();
            pyramid.levels.push(next);
        }
        pyramid
    }

    fn counts(&self, level: u32) -> [u32; 3] {
        self.size.map(|n| n.div_ceil(1 << level))
    }

    /// The coarse sample of `level` at `p`, which is on that lattice.
    pub(crate) fn at(&self, level: u32, p: [u32; 3]) -> T {
        match p.iter().all(|c| c % (1 << level) == 0) {
            true => at(&self.levels[level as usize], self.counts(level), p.map(|c| c >> level)),
            false => at(&self.levels[0], self.size, p),
        }
    }

    fn is_inside(&self, p: [i64; 3]) -> bool {
        (0..3).all(|a| (0..i64::from(self.size[a])).contains(&p[a]))
    }

    fn is_uniform(&self, edge: u32, p: [u32; 3]) -> bool {
        let low = p.map(|c| c / edge * edge);
        let counts = std::array::from_fn(|a| edge.min(self.size[a] - low[a]));
        let sample = |q| at(&self.levels[0], self.size, q);
        points(counts).all(|i| sample(std::array::from_fn(|a| low[a] + i[a])).same_bits(sample(low)))
    }

    fn coarsened(&self, level: u32, p: [u32; 3], kind: Coarse) -> T {
        let h = 1i64 << (level - 1);
        let sample = |q: [i64; 3]| self.at(level - 1, q.map(|c| c as u32));
        let p64 = p.map(i64::from);
        let weighted: Vec<([i64; 3], f64)> = match kind {
            Coarse::None | Coarse::Injected => vec![(p64, 1.0)],
            Coarse::Mean => points([2; 3])
                .map(|i| (std::array::from_fn(|a| p64[a] + h * i64::from(i[a])), 1.0))
                .filter(|(q, _)| self.is_inside(*q))
                .collect(),
            Coarse::Filtered => points([3; 3])
                .map(|i| {
                    let weight = i.iter().map(|&i| [1.0, 2.0, 1.0][i as usize]).product();
                    (std::array::from_fn(|a| p64[a] + h * (i64::from(i[a]) - 1)), weight)
                })
                .collect(),
        };
        if kind == Coarse::Filtered && self.is_uniform(4.max(1 << level), p) {
            return at(&self.levels[0], self.size, p);
        }
        if weighted.iter().any(|(q, _)| !self.is_inside(*q)) {
            return self.at(level - 1, p);
        }
        let all: Vec<(T, f64)> = weighted.into_iter().map(|(q, weight)| (sample(q), weight)).collect();
        if all.iter().all(|(s, _)| s.same_bits(all[0].0)) {
            return all[0].0;
        }
        let weights: f64 = all.iter().map(|(_, weight)| weight).sum();
        let mean = match all.iter().all(|(s, _)| s.is_finite()) {
            true => all.iter().map(|(s, weight)| weight * f64::from(s.to_f32())).sum::<f64>() / weights,
            false => f64::NAN,
        };
        if T::IS_INTEGER {
            T::from_bits((mean.round_ties_even() as i32).cast_unsigned())
        } else {
            T::from_bits((mean as f32).to_bits())
        }
    }
}

/// The same bits, but that of sums of numbers of both signs of zero, or in another order, the last one can differ.
pub(crate) fn agree<T: Scalar>(a: T, b: T) -> bool {
    let [x, y] = [a, b].map(|s| f64::from(s.to_f32()));
    a.same_bits(b) || (x.is_nan() && y.is_nan()) || (!T::IS_INTEGER && (x - y).abs() <= x.abs() * 1.2e-7)
}
