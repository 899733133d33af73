//! One row of blocks: what their samples may become, and which of them become one value.

use isoray_grid::Scalar;
use isoray_octree::CAP_EDGE;

use super::BLOCK_EDGE;
use super::layers::Layers;
use super::limits::{Window, linear};
use super::rules::Rules;
use super::values::{Interval, sample};

/// Samples along x that are dealt with at a time: enough that those beyond the ends hardly count, few enough for a core's cache.
const PIECE: usize = 32 * BLOCK_EDGE;

/// How many samples have changed, and how far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Changes {
    /// Samples whose bits are not those of the source.
    pub samples: u64,
    /// The greatest difference of a sample from the source, in the data's units.
    pub largest: f64,
}

impl Changes {
    pub(super) fn join(self, other: Self) -> Self {
        Self { samples: self.samples + other.samples, largest: self.largest.max(other.largest) }
    }
}

/// What a task needs memory for.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    window: Window,
    limits: Vec<f64>,
    /// What the samples of one piece may become, x fastest.
    allowed: Vec<Interval>,
}

/// A row of blocks in the making.
pub(super) struct Row<'a, T> {
    pub(super) rules: &'a Rules,
    pub(super) layers: Layers<'a, T>,
    /// Its first sample's y and z.
    pub(super) origin: [usize; 2],
    /// Its samples along each axis.
    pub(super) size: [usize; 3],
    /// What they become, x fastest.
    pub(super) out: &'a mut [T],
}

impl<T: Scalar> Row<'_, T> {
    /// Makes all of it.
    pub(super) fn fill(&mut self, scratch: &mut Scratch) -> Changes {
        let mut changes = Changes::default();
        for x in (0..self.size[0]).step_by(PIECE) {
            let size = [PIECE.min(self.size[0] - x), self.size[1], self.size[2]];
            let origin = [x, self.origin[0], self.origin[1]];
            self.find_allowed(origin, size, scratch);
            for corner in corners(size, BLOCK_EDGE) {
                changes = changes.join(self.block(origin, size, corner, &scratch.allowed));
            }
        }
        changes
    }

    /// What the samples of the piece at `origin` may become.
    fn find_allowed(&self, origin: [usize; 3], size: [usize; 3], scratch: &mut Scratch) {
        let Scratch { window, limits, allowed } = scratch;
        let halo = self.rules.halo();
        let first = origin.map(|o| o.saturating_sub(halo));
        let n = self.layers.dims.axes().map(|n| n as usize);
        window.size = std::array::from_fn(|a| n[a].min(origin[a] + size[a] + halo) - first[a]);
        window.samples.clear();
        for (z, y) in rows(window.size) {
            let row = self.layers.row([first[0], first[1] + y, first[2] + z], window.size[0]);
            window.samples.extend(row.iter().map(|s| s.to_f32()));
        }
        limits.clear();
        limits.resize(window.samples.len(), f64::INFINITY);
        for surfaces in &self.rules.surfaces {
            window.limit(surfaces, limits);
        }
        allowed.clear();
        for (z, y) in rows(size) {
            let at = [origin[0] - first[0], origin[1] - first[1] + y, origin[2] - first[2] + z];
            let start = linear(window.size, at);
            let row = start..start + size[0];
            let samples = window.samples[row.clone()].iter().zip(&limits[row]);
            allowed.extend(samples.map(|(&s, &limit)| self.rules.allowed(s, limit)));
        }
    }

    /// Writes the block at `corner` of a piece: one value, or as many as its caps need.
    fn block(
        &mut self,
        origin: [usize; 3],
        size: [usize; 3],
        corner: [usize; 3],
        allowed: &[Interval],
    ) -> Changes {
        let extent = |corner: [usize; 3], edge: usize| std::array::from_fn(|a| edge.min(size[a] - corner[a]));
        let piece = Piece { origin, size, allowed };
        let block = extent(corner, BLOCK_EDGE);
        let common = piece.common(corner, block);
        if !common.is_empty() {
            return self.write(&piece, corner, block, Some(common));
        }
        let mut changes = Changes::default();
        for offset in corners(block, CAP_EDGE as usize) {
            let corner = std::array::from_fn(|a| corner[a] + offset[a]);
            let cap = extent(corner, CAP_EDGE as usize);
            let common = Some(piece.common(corner, cap)).filter(|common| !common.is_empty());
            changes = changes.join(self.write(&piece, corner, cap, common));
        }
        changes
    }

    /// Writes a box of a piece, whose samples all become a value of `common`, or each what it may alone; if they already are equal, to the
    /// bit, they stay.
    fn write(
        &mut self,
        piece: &Piece,
        corner: [usize; 3],
        size: [usize; 3],
        common: Option<Interval>,
    ) -> Changes {
        let is_constant = self.is_constant(std::array::from_fn(|a| piece.origin[a] + corner[a]), size);
        let value = common.map(|common| self.rules.value(common));
        // Where there is no choice, samples that have the value keep it to the bit: it may be a zero of either sign.
        let is_forced = common.is_some_and(|common| common.low == common.high);
        let mut changes = Changes::default();
        for (z, y) in rows(size) {
            let [x, y, z] = [corner[0], corner[1] + y, corner[2] + z];
            let allowed = &piece.allowed[linear(piece.size, [x, y, z])..][..size[0]];
            let x = piece.origin[0] + x;
            let source = self.layers.row([x, piece.origin[1] + y, piece.origin[2] + z], size[0]);
            let start = linear(self.size, [x, y, z]);
            for ((out, &old), &allowed) in self.out[start..].iter_mut().zip(source).zip(allowed) {
                let s = old.to_f32();
                let new = value.unwrap_or_else(|| self.rules.alone(s, allowed));
                let is_kept = is_constant || !s.is_finite() || (new == s && (is_forced || value.is_none()));
                *out = if is_kept { old } else { sample(new) };
                if !out.same_bits(old) {
                    let change = (f64::from(new) - f64::from(s)).abs();
                    changes = changes.join(Changes { samples: 1, largest: change });
                }
            }
        }
        changes
    }

    /// Whether the source's samples in a box are bitwise equal.
    fn is_constant(&self, origin: [usize; 3], size: [usize; 3]) -> bool {
        let row = |(z, y)| self.layers.row([origin[0], origin[1] + y, origin[2] + z], size[0]);
        let Some(&first) = rows(size).next().and_then(|at| row(at).first()) else { return true };
        rows(size).all(|at| row(at).iter().all(|s| s.same_bits(first)))
    }
}

/// A piece of a row, and what its samples may become.
struct Piece<'a> {
    origin: [usize; 3],
    size: [usize; 3],
    allowed: &'a [Interval],
}

impl Piece<'_> {
    /// What all samples of a box may become.
    fn common(&self, corner: [usize; 3], size: [usize; 3]) -> Interval {
        let mut common = Interval::ALL;
        for (z, y) in rows(size) {
            let start = linear(self.size, [corner[0], corner[1] + y, corner[2] + z]);
            for &allowed in &self.allowed[start..start + size[0]] {
                common = common.and(allowed);
            }
        }
        common
    }
}

/// The rows of a box: z and y.
fn rows([_, ny, nz]: [usize; 3]) -> impl Iterator<Item = (usize, usize)> {
    (0..nz).flat_map(move |z| (0..ny).map(move |y| (z, y)))
}

/// The low corners of the cubes of this edge that a box consists of.
fn corners([nx, ny, nz]: [usize; 3], edge: usize) -> impl Iterator<Item = [usize; 3]> {
    let axis = move |n: usize| (0..n).step_by(edge);
    axis(nz).flat_map(move |z| axis(ny).flat_map(move |y| axis(nx).map(move |x| [x, y, z])))
}
