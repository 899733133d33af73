//! The cells of one block, in the order of the ray.

use std::ops::ControlFlow;

use isoray_cell::{Segment, relative};
use isoray_grid::{Scalar, ScalarType};
use isoray_octree::{Block, CAP_EDGE, OctreeView, Path};

use crate::hit::{Candidate, HitPolicy};
use crate::ray::ClippedRay;
use crate::work::Counters;

/// All three upper faces.
pub(crate) const ALL_BORDERS: u32 = 0b111;

/// Offset of the last cell of a block along an axis: the one that touches the next block.
const LAST: u32 = CAP_EDGE - 1;

/// What stays the same from block to block of a ray.
pub(crate) struct BlockWalk<'a, T: Scalar> {
    pub(crate) view: &'a OctreeView<'a, T>,
    pub(crate) ray: &'a ClippedRay,
    pub(crate) isovalue: f32,
    pub(crate) threshold: T,
}

/// A ray's position among the cells of a block (Amanatides and Woo 1987).
struct Steps {
    /// Offset of the cell in the block.
    offset: [u32; 3],
    /// Where the ray crosses the cell's planes: behind it, and ahead.
    near: [f64; 3],
    far: [f64; 3],
}

impl Steps {
    /// The cell at `t`: along each axis as many planes on as the ray has crossed by then.
    #[inline(always)]
    fn at(ray: &ClippedRay, origin: [u32; 3], t: f64) -> Self {
        let mut steps = Self { offset: [0; 3], near: [0.0; 3], far: [0.0; 3] };
        for a in 0..3 {
            let inner: [f64; LAST as usize] =
                std::array::from_fn(|k| ray.crossing(a, origin[a] + 1 + k as u32));
            let crossed: u32 = inner.iter().map(|&plane| u32::from(plane <= t)).sum();
            let offset = if ray.is_backward(a) { LAST - crossed } else { crossed };
            steps.offset[a] = offset;
            let (low, high) = (ray.crossing(a, origin[a] + offset), ray.crossing(a, origin[a] + offset + 1));
            (steps.near[a], steps.far[a]) = if ray.is_backward(a) { (high, low) } else { (low, high) };
        }
        steps
    }

    /// Steps across every plane that is crossed at `t`.
    #[inline(always)]
    fn cross(&mut self, ray: &ClippedRay, origin: [u32; 3], t: f64) {
        for a in 0..3 {
            if self.far[a] == t {
                self.near[a] = t;
                if ray.is_backward(a) {
                    // Stepping out of the block ends the walk before the offset is used.
                    self.offset[a] = self.offset[a].wrapping_sub(1);
                    self.far[a] = ray.crossing(a, origin[a].wrapping_add(self.offset[a]));
                } else {
                    self.offset[a] += 1;
                    self.far[a] = ray.crossing(a, origin[a] + self.offset[a] + 1);
                }
            }
        }
    }
}

impl<'a, T: Scalar> BlockWalk<'a, T> {
    /// Hands to `policy` the cells of the block at `origin` on the stretch `[t, t_end]` whose corners lie on both
    /// sides of the isovalue. In a constant block only cells at the upper faces in `borders` are looked at: the
    /// corners of all others are equal.
    #[expect(
        clippy::too_many_arguments,
        reason = "called from one place, with values that have no common owner"
    )]
    #[inline]
    pub(crate) fn cells(
        &self,
        path: &Path<T>,
        block: Block<'a, T>,
        origin: [u32; 3],
        borders: u32,
        [mut t, t_end]: [f64; 2],
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let mut neighborhood = Neighborhood { walk: self, path, origin, blocks: [block; 8], known: 1 };
        let is_constant = matches!(block, Block::Constant(_));
        let mut steps = Steps::at(self.ray, origin, t);
        while t < t_end {
            let ahead = steps.far[0].min(steps.far[1]).min(steps.far[2]);
            let t_out = ahead.min(t_end);
            let at_last = (0..3).map(|a| u32::from(steps.offset[a] == LAST) << a).fold(0, |m, b| m | b);
            if !is_constant || at_last & borders != 0 {
                let samples = neighborhood.corners(steps.offset, at_last);
                counters.lookups(8);
                if self.is_mixed(&samples) {
                    counters.cell();
                    policy.candidate(&self.candidate(&samples, &steps, origin, [t, t_out]))?;
                }
            }
            steps.cross(self.ray, origin, t_out);
            t = t_out;
        }
        ControlFlow::Continue(())
    }

    /// Whether the corners lie on both sides, and are all finite.
    #[inline(always)]
    fn is_mixed(&self, samples: &[T; 8]) -> bool {
        let inside: u32 = (0..8).map(|n| u32::from(samples[n] >= self.threshold)).sum();
        inside != 0 && inside != 8 && (T::TYPE != ScalarType::F32 || samples.iter().all(|s| s.is_finite()))
    }

    #[inline(always)]
    fn candidate(&self, samples: &[T; 8], steps: &Steps, origin: [u32; 3], interval: [f64; 2]) -> Candidate {
        let cell: [u32; 3] = std::array::from_fn(|a| origin[a] + steps.offset[a]);
        let mut segment = Segment { entry: [0.0; 3], exit: [0.0; 3] };
        for a in 0..3 {
            let (behind, ahead) = if self.ray.is_backward(a) { (1.0, 0.0) } else { (0.0, 1.0) };
            let [begin, end] = interval;
            segment.entry[a] =
                if steps.near[a] == begin { behind } else { self.ray.local(a, cell[a], begin) };
            segment.exit[a] = if steps.far[a] == end { ahead } else { self.ray.local(a, cell[a], end) };
        }
        let corners = relative(&samples.map(T::to_f32), self.isovalue);
        Candidate { cell, corners, segment, interval }
    }
}

/// A block and its seven forward neighbours, found when they are first needed.
struct Neighborhood<'w, 'a, T: Scalar> {
    walk: &'w BlockWalk<'a, T>,
    path: &'w Path<T>,
    origin: [u32; 3],
    /// By direction: bit 0 the next block along x, bit 1 y, bit 2 z.
    blocks: [Block<'a, T>; 8],
    /// Bit `n`: `blocks[n]` is known.
    known: u32,
}

impl<T: Scalar> Neighborhood<'_, '_, T> {
    /// The eight corner samples of the cell at `offset`, x fastest; `at_last` tells along which axes the cell touches the next block.
    #[inline(always)]
    fn corners(&mut self, offset: [u32; 3], at_last: u32) -> [T; 8] {
        if at_last == 0 {
            let own = &self.blocks[0];
            return std::array::from_fn(|n| own.sample(corner(offset, n as u32)));
        }
        std::array::from_fn(|n| {
            let n = n as u32;
            let direction = n & at_last;
            self.find(direction);
            self.blocks[direction as usize].sample(corner(offset, n).map(|c| c & LAST))
        })
    }

    #[inline(always)]
    fn find(&mut self, direction: u32) {
        if self.known >> direction & 1 == 0 {
            let to = std::array::from_fn(|a| self.origin[a] + (direction >> a & 1) * CAP_EDGE);
            self.blocks[direction as usize] = self.path.neighbor(self.walk.view, self.origin, to);
            self.known |= 1 << direction;
        }
    }
}

#[inline(always)]
fn corner(offset: [u32; 3], n: u32) -> [u32; 3] {
    [offset[0] + (n & 1), offset[1] + (n >> 1 & 1), offset[2] + (n >> 2 & 1)]
}
