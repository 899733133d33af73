//! The field of a picture with levels of detail, from the volume's samples and the rules at the head of `crates/octree/src/lod`: their `mod.rs`, `detail.rs` and `resolve.rs`.
//! Slow, in double precision, and without a tree.

use anyhow::{Result, ensure};
use glam::DAffine3;
use isoray_octree::Coarse;
use isoray_oracle::DenseLattice;
use rayon::prelude::*;

use super::eye::Eye;
use super::scenes::Levels;

/// A volume as one picture sees it.
pub(crate) struct DetailField<'s> {
    dims: [u32; 3],
    /// By level; the first are the volume's own.
    lattices: Vec<Coarsened<'s>>,
    /// Of the eye, in index space: coordinates are those of `f32`, as rays have them.
    eye: [f64; 3],
    /// What a voxel along an axis counts.
    weights: [f64; 3],
    /// The distances from which levels are drawn.
    starts: Vec<f64>,
    blend: f64,
}

/// Samples of a level, those that are not on its lattice included, of which it has no use.
struct Coarsened<'s>(std::borrow::Cow<'s, [f32]>);

impl<'s> DetailField<'s> {
    /// Of samples of whole numbers: means are rounded to them.
    pub(crate) fn new(
        dims: [u32; 3],
        samples: &'s [f32],
        levels: &Levels,
        index_to_world: &DAffine3,
        eye: &Eye,
    ) -> Result<Self> {
        let axes = [0, 1, 2].map(|a| index_to_world.matrix3.col(a));
        let is_right = |a: usize, b: usize| axes[a].dot(axes[b]).abs() < 1e-12;
        ensure!(is_right(0, 1) && is_right(1, 2) && is_right(2, 0), "edges of voxels at right angles");
        let edges = axes.map(|axis| axis.length());
        let weights = match levels.by_slices {
            false => edges,
            // A plane across the main axis is as far as it is along the view.
            true => {
                let view = eye.forward();
                let along = [0, 1, 2].map(|a| axes[a].dot(view).abs() / edges[a]);
                let main = (0..3).max_by(|&a, &b| along[a].total_cmp(&along[b])).unwrap_or(2);
                [0, 1, 2].map(|a| if a == main { edges[a] / along[a] } else { 0.0 })
            }
        };
        let longest = dims.into_iter().max().unwrap_or(1);
        let coarsest = (longest.next_power_of_two() / 8).max(1).ilog2();
        let voxel = edges.into_iter().fold(0.0, f64::max);
        let (width, is_constant) = eye.pixel_width();
        let wide = |level: u32| voxel * f64::from(1u32 << level) / (levels.ratio * width);
        let starts = (0..=coarsest).map(|level| match (level, is_constant) {
            (0, _) => 0.0,
            (_, false) => wide(level),
            (_, true) => {
                if wide(level) <= 1.0 {
                    0.0
                } else {
                    f64::INFINITY
                }
            }
        });
        let at = index_to_world.inverse().transform_point3(eye.ray([0, 0]).0);
        let eye = if is_constant { [0.0; 3] } else { at.to_array().map(|c| f64::from(c as f32)) };
        let mut field = Self {
            dims,
            lattices: vec![Coarsened(samples.into())],
            eye,
            weights,
            starts: starts.collect(),
            blend: levels.blend,
        };
        for level in 1..=coarsest {
            let coarser = field.coarsened(levels.coarse, level)?;
            field.lattices.push(coarser);
        }
        Ok(field)
    }

    /// All of it, on the finest lattice: of each coarser cell the interpolant is the same there.
    pub(crate) fn lattice(&self) -> Option<DenseLattice<f64>> {
        let [nx, ny, nz] = self.dims;
        let of = |n: u32| self.value([n % nx, n / nx % ny, n / (nx * ny)]);
        DenseLattice::from_vec(self.dims, (0..nx * ny * nz).into_par_iter().map(of).collect())
    }

    /// The level of a cell.
    pub(crate) fn level(&self, cell: [u32; 3]) -> u32 {
        let is_far_enough = |level: u32| {
            let edge = 4u32 << level;
            let square: f64 = (0..3)
                .map(|a| {
                    let low = f64::from(cell[a] / edge * edge);
                    let nearest = (low - self.eye[a]).max(self.eye[a] - low - f64::from(edge)).max(0.0);
                    (self.weights[a] * nearest).powi(2)
                })
                .sum();
            square.sqrt() >= self.starts[level as usize]
        };
        (1..self.starts.len() as u32).rev().find(|&level| is_far_enough(level)).unwrap_or(0)
    }

    /// The level at a point, unless a cell of another one is next to it.
    pub(crate) fn level_at(&self, p: [f64; 3], close: f64) -> Option<u32> {
        let cell = |by: f64| -> [u32; 3] {
            std::array::from_fn(|a| (p[a] + by).clamp(0.0, f64::from(self.dims[a]) - 1.5) as u32)
        };
        let [low, high] = [-close, close].map(cell);
        let level = self.level(low);
        let corners = (1..8).map(|n: u32| [0, 1, 2].map(|a| if n >> a & 1 == 1 { high[a] } else { low[a] }));
        corners.into_iter().all(|cell| self.level(cell) == level).then_some(level)
    }

    /// The coarsest level of the cells that touch a sample.
    fn touching(&self, p: [u32; 3]) -> u32 {
        let cells = (0..8u32).map(|n| [0, 1, 2].map(|a| i64::from(p[a]) - i64::from(n >> a & 1)));
        let inside = cells.filter(|c| (0..3).all(|a| c[a] >= 0 && c[a] + 1 < i64::from(self.dims[a])));
        inside.map(|cell| self.level(cell.map(|c| c as u32))).max().unwrap_or(0)
    }

    /// The value of a sample.
    fn value(&self, p: [u32; 3]) -> f64 {
        let level = self.touching(p);
        if !self.is_on_lattice(level, p) {
            return self.interpolated(level, p, |q| self.value(q));
        }
        let own = self.sample(level, p);
        match self.share_of_next(level, p) {
            0.0 => own,
            share => {
                let next = self.interpolated(level + 1, p, |q| self.sample(level + 1, q));
                own * (1.0 - share) + next * share
            }
        }
    }

    /// The interpolant of the corners of the cell of a level around a place; those that do not count are not asked for.
    fn interpolated(&self, level: u32, p: [u32; 3], value: impl Fn([u32; 3]) -> f64) -> f64 {
        let step = 1u32 << level;
        let ends: [[u32; 2]; 3] = std::array::from_fn(|a| {
            let last = self.dims[a] - 1;
            let low = if p[a] == last { last } else { p[a] / step * step };
            [low, if low == p[a] { low } else { (low + step).min(last) }]
        });
        let weight = |a: usize, end: usize| match ends[a][1] - ends[a][0] {
            0 => {
                if end == 0 {
                    1.0
                } else {
                    0.0
                }
            }
            length => {
                f64::from(if end == 0 { ends[a][1] - p[a] } else { p[a] - ends[a][0] }) / f64::from(length)
            }
        };
        let corner = |n: usize| {
            let of = [0, 1, 2].map(|a| n >> a & 1);
            let weight = (0..3).map(|a| weight(a, of[a])).product::<f64>();
            if weight == 0.0 { 0.0 } else { weight * value([0, 1, 2].map(|a| ends[a][of[a]])) }
        };
        (0..8).map(corner).sum()
    }

    /// How far a sample of a level has gone over to the next one.
    fn share_of_next(&self, level: u32, p: [u32; 3]) -> f64 {
        let Some(&to) = self.starts.get(level as usize + 1) else { return 0.0 };
        let from = self.starts[level as usize];
        if self.blend <= 0.0 || !to.is_finite() || from >= to {
            return 0.0;
        }
        let square = |a: usize| (self.weights[a] * (f64::from(p[a]) - self.eye[a])).powi(2);
        let width = self.blend * (to - from);
        (((0..3).map(square).sum::<f64>().sqrt() - (to - width)) / width).clamp(0.0, 1.0)
    }

    /// The last plane of the finest lattice, along an axis.
    pub(crate) fn last(&self, axis: usize) -> u32 {
        self.dims[axis] - 1
    }

    /// A sample of the lattice of a level as it is there, in coordinates of the finest.
    pub(crate) fn sample(&self, level: u32, p: [u32; 3]) -> f64 {
        self.lattices[level as usize].0[self.number(p)].into()
    }

    fn number(&self, [x, y, z]: [u32; 3]) -> usize {
        let [nx, ny, _] = self.dims.map(|n| n as usize);
        x as usize + nx * (y as usize + ny * z as usize)
    }

    fn is_on_lattice(&self, level: u32, p: [u32; 3]) -> bool {
        (0..3).all(|a| p[a].is_multiple_of(1 << level) || p[a] + 1 == self.dims[a])
    }

    /// The lattice of a level, of that of the one below.
    fn coarsened(&self, kind: Coarse, level: u32) -> Result<Coarsened<'s>> {
        ensure!(kind != Coarse::None, "there are no coarse samples");
        let mut samples = self.lattices[0].0.to_vec();
        let [nx, ny, nz] = self.dims;
        let all = (0..nx * ny * nz).map(|n| [n % nx, n / nx % ny, n / (nx * ny)]);
        let is_aligned = |p: &[u32; 3]| p.iter().all(|c| c.is_multiple_of(1 << level));
        if kind != Coarse::Injected {
            for p in all.filter(is_aligned) {
                samples[self.number(p)] = self.mean(kind, level, p) as f32;
            }
        }
        Ok(Coarsened(samples.into()))
    }

    /// A sample of a kind that is no injected one.
    fn mean(&self, kind: Coarse, level: u32, p: [u32; 3]) -> f64 {
        let step = 1i64 << (level - 1);
        let p = p.map(i64::from);
        let finer = |by: [i64; 3]| {
            let q = [0, 1, 2].map(|a| p[a] + step * by[a]);
            let is_inside = (0..3).all(|a| q[a] >= 0 && q[a] < i64::from(self.dims[a]));
            is_inside.then(|| self.sample(level - 1, q.map(|c| c as u32)))
        };
        let own = finer([0; 3]).unwrap_or(f64::NAN);
        let offsets = |low: i64| {
            (0..27)
                .map(|n| [n % 3, n / 3 % 3, n / 9].map(|c| c - 1))
                .filter(move |by| by.iter().all(|&c| c >= low))
        };
        let values: Option<Vec<([i64; 3], f64)>> = match kind {
            Coarse::Mean => Some(offsets(0).filter_map(|by| Some((by, finer(by)?))).collect()),
            _ => offsets(-1).map(|by| Some((by, finer(by)?))).collect(),
        };
        let is_uniform = || {
            let edge = (1i64 << level).max(4);
            let low = p.map(|c| c / edge * edge);
            let mut all = (0..edge.pow(3))
                .map(|n| [low[0] + n % edge, low[1] + n / edge % edge, low[2] + n / (edge * edge)]);
            let first = self.sample(0, low.map(|c| c as u32));
            all.all(|q| {
                (0..3).any(|a| q[a] >= i64::from(self.dims[a]))
                    || self.sample(0, q.map(|c| c as u32)) == first
            })
        };
        // Where the stencil leaves the domain.
        let Some(values) = values else { return own };
        if kind == Coarse::Filtered && is_uniform() {
            return self.sample(0, p.map(|c| c as u32));
        }
        let weight = |by: [i64; 3]| match kind {
            Coarse::Mean => 1.0,
            _ => by.iter().map(|&c| if c == 0 { 0.5 } else { 0.25 }).product::<f64>(),
        };
        let [sum, of] = values
            .iter()
            .fold([0.0; 2], |[sum, of], &(by, value)| [sum + weight(by) * value, of + weight(by)]);
        (sum / of).round_ties_even()
    }
}
