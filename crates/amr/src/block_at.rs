//! A block as a ray meets it.

use isoray_trace::parts::{ClippedRay, Corner, Cubes, GridSteps};

use crate::bricks::Layout;
use crate::level_rays::{LevelRays, vector};
use crate::mesh::Mesh;
use crate::visit::{BrickAt, Corners};

/// A block that the ray passes through.
pub(crate) struct BlockAt<'r, 'm> {
    mesh: &'m Mesh,
    number: u32,
    pub(crate) exponent: u32,
    pub(crate) layout: Layout,
    /// The first of its bricks among those of all.
    first_brick: u32,
    /// On the lattice of its level.
    pub(crate) ray: &'r ClippedRay,
    /// Where the value at the low corner of the domain would be, if the block were as large.
    first: isize,
    /// From one value to the next along y and z.
    strides: [u32; 2],
}

impl<'r, 'm> BlockAt<'r, 'm> {
    #[inline(always)]
    pub(crate) fn new(mesh: &'m Mesh, number: u32, rays: &LevelRays<'r, 'm>) -> Self {
        let block = &mesh.skeleton.blocks[number as usize];
        let layout = Layout::new(block);
        let [low, high] = layout.cells;
        let [nx, ny] = [0, 1].map(|a| high[a] - low[a] + 1);
        let strides = [nx, nx * ny];
        let from_low = [1, strides[0], strides[1]]
            .into_iter()
            .zip(low)
            .map(|(stride, low)| i64::from(stride) * i64::from(low));
        let first = block.first as isize - from_low.sum::<i64>() as isize;
        Self {
            mesh,
            number,
            exponent: block.exponent,
            layout,
            first_brick: mesh.bricks.first[number as usize],
            ray: rays.on_level(block.exponent),
            first,
            strides,
        }
    }

    #[inline(always)]
    pub(crate) fn brick(&self, numbers: [u32; 3]) -> BrickAt<'m> {
        let Self { mesh, number, layout, .. } = *self;
        BrickAt { mesh, block: number, layout, index: self.first_brick + layout.index(numbers), numbers }
    }

    /// The ray in the cubes of this edge, of those that the block has, their numbers as corners.
    #[inline(always)]
    pub(crate) fn steps(&self, cubes: &Cubes, [low, high]: [[u32; 3]; 2], t: f64) -> GridSteps {
        let last = high.map(|c| c - 1);
        GridSteps::at(self.ray, cubes, [vector(low), vector(last)], t, |numbers| Corner::new(numbers).0)
    }

    /// The values at the corners of a cell.
    #[inline(always)]
    pub(crate) fn corners(&self, cell: [u32; 3]) -> Corners<'m> {
        let [x, y, z] = cell.map(|c| c as isize);
        let [along_y, along_z] = self.strides.map(|stride| stride as isize);
        let first = self.first + x + along_y * y + along_z * z;
        Corners::new(&self.mesh.values, first as usize, self.strides)
    }
}
