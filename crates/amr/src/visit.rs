//! What passes through a mesh along a ray, and what it meets.

use std::ops::ControlFlow;

use isoray_cell::Segment;
use isoray_trace::Counters;
use isoray_trace::parts;

use crate::bricks::{Brick, Layout, corners_at};
use crate::hybrid::Split;
use crate::mesh::Mesh;

/// What passes through a mesh along a ray.
pub(crate) trait Visit<'m> {
    /// Whether it passes by what does not matter, too, instead of leaving it out.
    const PASSES: bool;

    /// Whether anything below this node matters.
    fn wants_node(&self, node: u32) -> bool;

    /// Whether anything of this range matters.
    fn wants(&self, range: [f32; 2]) -> bool;

    /// Finds out which cells of a brick matter; `brick` is room for its samples.
    fn find(&self, brick: &mut parts::Brick, at: &BrickAt<'m>, counters: &mut impl Counters) -> u64;

    /// Passes by what is of this range, all of it on one side of what matters; none of it has a value if the first is larger.
    fn passes(&mut self, range: [f32; 2]) -> ControlFlow<()>;

    /// Passes by a cell, with one of its values; `None` if it is empty.
    fn passes_cell(&mut self, value: Option<f32>) -> ControlFlow<()>;

    /// Passes through a cube in which the field is trilinear.
    fn cell(
        &mut self,
        corners: Corners<'m>,
        segment: impl FnOnce() -> Segment,
        interval: [f64; 2],
        place: CubeAt,
    ) -> ControlFlow<()>;
}

/// Where the values at the corners of a cube are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corners<'m> {
    /// From the first to the last.
    near: &'m [f32],
    /// From one to the next along y and z.
    strides: [u32; 2],
}

impl<'m> Corners<'m> {
    /// None yet.
    pub(crate) const NONE: Self = Self { near: &[0.0; 3], strides: [0, 1] };

    #[inline(always)]
    pub(crate) fn new(values: &'m [f32], first: usize, strides: [u32; 2]) -> Self {
        Self { near: &values[first..first + (strides[0] + strides[1]) as usize + 2], strides }
    }

    /// X fastest.
    #[inline(always)]
    pub(crate) fn values(&self) -> [f32; 8] {
        corners_at(self.near, 0, self.strides.map(|stride| stride as usize))
    }
}

/// Which cube.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CubeAt {
    /// Its numbers on the lattice of cubes of its size.
    pub(crate) numbers: [u32; 3],
    /// The binary logarithm of its edge.
    pub(crate) exponent: u32,
}

/// Which brick.
#[derive(Clone, Copy)]
pub(crate) struct BrickAt<'m> {
    pub(crate) mesh: &'m Mesh,
    pub(crate) block: u32,
    pub(crate) layout: Layout,
    /// Its number among those of all blocks.
    pub(crate) index: u32,
    /// Its numbers on the lattice of its level.
    pub(crate) numbers: [u32; 3],
}

impl<'m> BrickAt<'m> {
    #[inline(always)]
    pub(crate) fn brick(&self) -> &'m Brick {
        &self.mesh.bricks.bricks[self.index as usize]
    }

    /// That of its cell at `offset`, which is taken apart.
    pub(crate) fn split(&self, offset: u32) -> &'m Split {
        let brick = self.brick();
        let before = brick.split & ((1 << offset) - 1);
        &self.mesh.bricks.splits[(brick.first + before.count_ones()) as usize]
    }
}
