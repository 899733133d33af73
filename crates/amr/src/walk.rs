//! A ray's way through a mesh.

use std::ops::ControlFlow;

use isoray_cell::Segment;
use isoray_trace::Counters;
use isoray_trace::parts::{self, ClippedRay, Cube, Cubes, GridSteps, Strides};
use wide::f64x4;

use crate::block::Block;
use crate::bricks::{Brick, EDGE, Layout, corners_at};
use crate::hybrid::{Split, part_corners};
use crate::mesh::Mesh;
use crate::tree::Node;

/// What passes through a mesh along a ray.
pub(crate) trait Visit {
    /// Whether anything below this node matters.
    fn wants_node(&self, node: u32) -> bool;

    /// Whether anything of this range matters.
    fn wants(&self, range: [f32; 2]) -> bool;

    /// Finds out which cells of a brick matter; `brick` is room for its samples.
    fn find(&self, brick: &mut parts::Brick, at: &BrickAt<'_>, counters: &mut impl Counters) -> u64;

    /// Passes by what is of this range, all of it on one side of what matters; none of it has a value if the first is larger.
    fn passes(&mut self, range: [f32; 2]) -> ControlFlow<()>;

    /// Passes by a cell, with one of its values; `None` if it is empty.
    fn passes_cell(&mut self, value: Option<f32>) -> ControlFlow<()>;

    /// Passes through a cube with the edge `1 << exponent` in which the field is trilinear.
    fn cell(
        &mut self,
        corners: &[f32; 8],
        segment: Segment,
        interval: [f64; 2],
        place: CubeAt,
    ) -> ControlFlow<()>;
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
    pub(crate) brick: &'m Brick,
    /// Its numbers on the lattice of its level.
    pub(crate) numbers: [u32; 3],
}

/// Levels, by the binary logarithm of the edge of their cells: those of 21 bits.
const EXPONENTS: usize = 22;

/// Which cells of bricks matter, of those that rays have met.
#[derive(Clone, Debug)]
struct Known {
    /// A bit for each brick that is known.
    is_known: Vec<u64>,
    cells: Vec<u64>,
    room: Box<parts::Brick>,
}

impl Known {
    #[inline(always)]
    fn of(&mut self, index: u32, find: impl FnOnce(&mut parts::Brick) -> u64) -> u64 {
        let Self { is_known, cells, room } = self;
        let (word, bit) = (&mut is_known[index as usize / 64], 1 << (index % 64));
        let cells = &mut cells[index as usize];
        if *word & bit == 0 {
            *word |= bit;
            *cells = find(room);
        }
        *cells
    }
}

/// Room for a ray's way, and what is known of bricks.
#[derive(Clone, Debug)]
pub(crate) struct Walk {
    /// Nodes behind the one at hand, and where the ray is in them.
    pending: Vec<(u32, [f64; 2])>,
    rays: [Option<ClippedRay>; EXPONENTS],
    known: Known,
}

/// Nobody asks for an index.
const NO_STRIDES: Strides = [0; 8];

impl Walk {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let count = mesh.bricks.bricks.len();
        let is_known = vec![0; count.div_ceil(64)];
        let known = Known { is_known, cells: vec![0; count], room: Box::default() };
        Self { pending: Vec::new(), rays: [None; EXPONENTS], known }
    }

    /// Forgets what it knows of bricks.
    pub(crate) fn forget(&mut self) {
        self.known.is_known.fill(0);
    }

    /// Takes `visit` through all that matters on the way of `ray`, in order, until it breaks.
    pub(crate) fn follow(
        &mut self,
        mesh: &Mesh,
        ray: &ClippedRay,
        visit: &mut impl Visit,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let Self { pending, rays, known } = self;
        *rays = [None; EXPONENTS];
        let mut way = Way { mesh, rays: Rays { mesh, ray, rays }, known, visit, counters };
        pending.clear();
        pending.push((0, ray.interval()));
        while let Some((mut node, [t, mut t_end])) = pending.pop() {
            loop {
                if !way.visit.wants_node(node) {
                    way.visit.passes(mesh.ranges[node as usize])?;
                    break;
                }
                match mesh.skeleton.nodes[node as usize] {
                    Node::Leaf(block) => {
                        way.block(block, [t, t_end])?;
                        break;
                    }
                    Node::Split { axis, plane, parts } => {
                        let crossed = ray.crossings(f64x4::splat(plane.into())).to_array()[axis as usize % 4];
                        let first = (ray.backward() >> axis & 1) as usize;
                        let [near, far] = [parts[first], parts[1 - first]];
                        if crossed >= t_end {
                            node = near;
                        } else if crossed <= t {
                            node = far;
                        } else {
                            pending.push((far, [crossed, t_end]));
                            (node, t_end) = (near, crossed);
                        }
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// The ray on the lattice of each level, if it has been there.
struct Rays<'r> {
    mesh: &'r Mesh,
    ray: &'r ClippedRay,
    rays: &'r mut [Option<ClippedRay>; EXPONENTS],
}

impl Rays<'_> {
    #[inline]
    fn on_level(&mut self, exponent: u32) -> ClippedRay {
        *self.rays[exponent as usize % EXPONENTS].get_or_insert_with(|| {
            let by = (-f64::from(exponent)).exp2();
            self.ray.scaled(by, vector(self.mesh.skeleton.domain.high) * f64x4::splat(by))
        })
    }

    /// Passes through the parts of a cell that is taken apart.
    #[inline(never)]
    fn parts(
        &mut self,
        (split, low, exponent): (&Split, [u32; 3], u32),
        [mut t, t_end]: [f64; 2],
        visit: &mut impl Visit,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let Some(exponent) = exponent.checked_sub(1) else { return ControlFlow::Continue(()) };
        let on_level = self.on_level(exponent);
        let low = low.map(|c| 2 * c);
        let mid = on_level.crossings(vector(low.map(|c| c + 1))).to_array();
        loop {
            let mut octant = on_level.backward();
            let mut t_out = t_end;
            for (a, &mid) in mid.iter().take(3).enumerate() {
                if mid <= t {
                    octant ^= 1 << a;
                } else if mid < t_out {
                    t_out = mid;
                }
            }
            let low = std::array::from_fn(|a| low[a] + (octant >> a & 1));
            match split.part(octant, &self.mesh.bricks.splits) {
                Some(split) => self.parts((split, low, exponent), [t, t_out], visit, counters)?,
                None => {
                    let corners = part_corners(&split.values, octant as usize);
                    match range(&corners) {
                        Some(range) if visit.wants(range) => {
                            counters.cell();
                            let segment = on_level.segment(vector(low), [t, t_out]);
                            let place = CubeAt { numbers: low, exponent };
                            visit.cell(&corners, segment, [t, t_out], place)?;
                        }
                        range => visit.passes_cell(range.map(|range| range[0]))?,
                    }
                }
            }
            if t_out >= t_end {
                return ControlFlow::Continue(());
            }
            t = t_out;
        }
    }
}

/// What goes along.
struct Way<'r, V, C> {
    mesh: &'r Mesh,
    rays: Rays<'r>,
    known: &'r mut Known,
    visit: &'r mut V,
    counters: &'r mut C,
}

impl<V: Visit, C: Counters> Way<'_, V, C> {
    #[inline(never)]
    fn block(&mut self, block: u32, [mut t, t_end]: [f64; 2]) -> ControlFlow<()> {
        self.counters.node();
        let mesh = self.mesh;
        let of = &mesh.skeleton.blocks[block as usize];
        let ray = &self.rays.on_level(of.exponent);
        let layout = Layout::new(of);
        let cubes = Cubes::new(ray, EDGE.into(), 1.0 / f64::from(EDGE));
        let last = std::array::from_fn(|a| layout.first[a] + layout.count[a] - 1);
        let mut steps = GridSteps::at(ray, &cubes, [vector(layout.first), vector(last)], t, |_| 0);
        loop {
            let leaves = steps.leaves();
            let t_out = if leaves < t_end { leaves } else { t_end };
            let [x, y, z, _] = steps.cube().to_array();
            let numbers = [x, y, z].map(|c| c as u32);
            let index = mesh.bricks.first[block as usize] + layout.index(numbers);
            let brick = &mesh.bricks.bricks[index as usize];
            if self.visit.wants(brick.range) {
                let at = BrickAt { mesh, block, layout, brick, numbers };
                let center = steps.cube() * f64x4::splat(EDGE.into()) + f64x4::splat(f64::from(EDGE) / 2.0);
                let cube = Cube { center, mid: ray.crossings(center), step: ray.step() };
                self.brick(ray, (index, &at), cube, [t, t_out])?;
            } else {
                self.visit.passes(brick.range)?;
            }
            if t_out >= t_end {
                return ControlFlow::Continue(());
            }
            steps.cross(ray, &cubes, &NO_STRIDES, t_out);
            t = t_out;
        }
    }

    #[inline(always)]
    fn brick(
        &mut self,
        ray: &ClippedRay,
        (index, at): (u32, &BrickAt<'_>),
        cube: Cube,
        interval: [f64; 2],
    ) -> ControlFlow<()> {
        let Self { mesh, rays, known, visit, counters } = self;
        counters.node();
        let shown = known.of(index, |room| visit.find(room, at, *counters));
        let (split, own) = (at.brick.split, at.brick.own);
        let block = &mesh.skeleton.blocks[at.block as usize];
        let exponent = block.exponent;
        let vertices = Vertices::new(&mesh.values, block, at);
        cube.walk(ray, interval, |steps, offset, interval| {
            let numbers: [u32; 3] = std::array::from_fn(|a| at.numbers[a] * EDGE + (offset >> (2 * a) & 3));
            if shown >> offset & 1 == 0 {
                return visit.passes_cell((own >> offset & 1 == 1).then(|| vertices.corner(offset)));
            }
            if split >> offset & 1 == 1 {
                let before = split & ((1 << offset) - 1);
                let split = &mesh.bricks.splits[(at.brick.first + before.count_ones()) as usize];
                return rays.parts((split, numbers, exponent), interval, *visit, *counters);
            }
            counters.cell();
            let place = CubeAt { numbers, exponent };
            visit.cell(&vertices.corners(offset), steps.segment(ray, interval), interval, place)
        })
    }
}

/// The vertices of a brick's cells.
struct Vertices<'m> {
    values: &'m [f32],
    /// Where that of the brick's low corner is, or would be if it were of the block.
    first: isize,
    /// From one to the next along y and z.
    strides: [usize; 2],
}

impl<'m> Vertices<'m> {
    #[inline(always)]
    fn new(values: &'m [f32], block: &Block, at: &BrickAt<'_>) -> Self {
        let [low, high] = at.layout.cells;
        let [nx, ny] = [0, 1].map(|a| (high[a] - low[a]) as usize + 1);
        let from = |a: usize| (at.numbers[a] * EDGE) as isize - low[a] as isize;
        let (y, z) = (nx as isize, (nx * ny) as isize);
        let first = block.first as isize + from(0) + from(1) * y + from(2) * z;
        Self { values, first, strides: [nx, nx * ny] }
    }

    #[inline(always)]
    fn index(&self, offset: u32) -> usize {
        let [x, y, z] = [offset & 3, offset >> 2 & 3, offset >> 4 & 3].map(|c| c as usize);
        (self.first + (x + self.strides[0] * y + self.strides[1] * z) as isize) as usize
    }

    /// The first of the corner values of a cell of the block.
    #[inline(always)]
    fn corner(&self, offset: u32) -> f32 {
        self.values[self.index(offset)]
    }

    /// The corner values of a cell of the block, x fastest.
    #[inline(always)]
    fn corners(&self, offset: u32) -> [f32; 8] {
        corners_at(self.values, self.index(offset), self.strides)
    }
}

/// The range of values, if all of them are finite.
pub(crate) fn range(values: &[f32]) -> Option<[f32; 2]> {
    let fold = |of: fn(f32, f32) -> f32| values.iter().copied().reduce(of);
    let [low, high] = [fold(f32::min)?, fold(f32::max)?];
    // What is not a number is passed over by both.
    values.iter().all(|value| value.is_finite()).then_some([low, high])
}

fn vector([x, y, z]: [u32; 3]) -> f64x4 {
    f64x4::new([x.into(), y.into(), z.into(), 0.0])
}
