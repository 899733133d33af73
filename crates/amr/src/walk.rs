//! A ray's way through a mesh.

use std::cell::OnceCell;
use std::ops::ControlFlow;

use isoray_cell::Segment;
use isoray_trace::Counters;
use isoray_trace::parts::{self, ClippedRay, Cubes, GridSteps, Strides};
use wide::f64x4;

use crate::bricks::{Brick, EDGE, Layout, corners_at};
use crate::hybrid::{PART_STRIDES, Split, part_corner};
use crate::mesh::Mesh;
use crate::range::range_of_corners;
use crate::tree::Node;

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
    fn new(values: &'m [f32], first: usize, strides: [u32; 2]) -> Self {
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
    index: u32,
    /// Its numbers on the lattice of its level.
    pub(crate) numbers: [u32; 3],
}

impl<'m> BrickAt<'m> {
    #[inline(always)]
    pub(crate) fn brick(&self) -> &'m Brick {
        &self.mesh.bricks.bricks[self.index as usize]
    }

    /// That of its cell at `offset`, which is taken apart.
    fn split(&self, offset: u32) -> &'m Split {
        let brick = self.brick();
        let before = brick.split & ((1 << offset) - 1);
        &self.mesh.bricks.splits[(brick.first + before.count_ones()) as usize]
    }
}

/// What is known of a brick: the cells that matter, and those of them that are taken apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct KnownBrick {
    shown: u64,
    split: u64,
}

impl KnownBrick {
    /// Nothing.
    const UNKNOWN: Self = Self { shown: 0, split: u64::MAX };
}

/// What is known of bricks, of those that rays have met.
#[derive(Clone, Debug)]
struct Known {
    bricks: Vec<KnownBrick>,
    room: Box<parts::Brick>,
}

/// Room for a ray's way, and what is known of bricks.
#[derive(Clone, Debug)]
pub(crate) struct Walk {
    /// Nodes behind the one at hand, and where the ray is in them.
    pending: Vec<(u32, [f64; 2])>,
    /// By the exponent of a level: the ray on its lattice, if it has been there.
    rays: Vec<OnceCell<ClippedRay>>,
    known: Known,
}

impl Walk {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let bricks = vec![KnownBrick::UNKNOWN; mesh.bricks.bricks.len()];
        let coarsest = mesh.skeleton.blocks.iter().map(|block| block.exponent).max();
        Self {
            pending: Vec::new(),
            rays: vec![OnceCell::new(); coarsest.map_or(0, |exponent| exponent as usize + 1)],
            known: Known { bricks, room: Box::default() },
        }
    }

    /// Forgets what it knows of bricks.
    pub(crate) fn forget(&mut self) {
        self.known.bricks.fill(KnownBrick::UNKNOWN);
    }

    /// Takes `visit` through all that matters on the way of `ray`, in order, until it breaks.
    pub(crate) fn follow<'m>(
        &mut self,
        mesh: &'m Mesh,
        ray: &ClippedRay,
        visit: &mut impl Visit<'m>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let Self { pending, rays, known } = self;
        rays.iter_mut().for_each(|ray| *ray = OnceCell::new());
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
struct Rays<'r, 'm> {
    mesh: &'m Mesh,
    ray: &'r ClippedRay,
    rays: &'r [OnceCell<ClippedRay>],
}

impl<'r, 'm> Rays<'r, 'm> {
    #[inline]
    fn on_level(&self, exponent: u32) -> &'r ClippedRay {
        self.rays[exponent as usize].get_or_init(|| {
            let by = (-f64::from(exponent)).exp2();
            self.ray.scaled(by, vector(self.mesh.skeleton.domain.high) * f64x4::splat(by))
        })
    }

    /// Passes through the parts of a cell that is taken apart.
    #[inline(never)]
    fn parts(
        &self,
        (split, low, exponent): (&'m Split, [u32; 3], u32),
        [mut t, t_end]: [f64; 2],
        visit: &mut impl Visit<'m>,
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
                    let corners = Corners::new(&split.values, part_corner(octant), PART_STRIDES);
                    match range_of_corners(&corners.values()) {
                        Some(range) if visit.wants(range) => {
                            counters.cell();
                            let segment = || on_level.segment(vector(low), [t, t_out]);
                            let place = CubeAt { numbers: low, exponent };
                            visit.cell(corners, segment, [t, t_out], place)?;
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

/// The numbers of a cell in one word, so that a step is one addition.
#[derive(Clone, Copy, Debug)]
struct Packed(u64);

/// Bits of a number.
const BITS: u32 = 21;

/// Steps along each axis, by the axes along which a ray runs backward. A borrow that one number takes from the next is given back by the sum.
const STRIDES: [Strides; 8] = parts::strides([1, 1 << BITS, 1 << (2 * BITS)]);

impl Packed {
    #[inline(always)]
    fn new([x, y, z]: [u32; 3]) -> Self {
        Self(u64::from(x) | u64::from(y) << BITS | u64::from(z) << (2 * BITS))
    }

    #[inline(always)]
    fn numbers(self) -> [u32; 3] {
        [0, 1, 2].map(|a| (self.0 >> (BITS * a)) as u32 & ((1 << BITS) - 1))
    }

    /// Of the brick that it is in.
    #[inline(always)]
    fn brick(self) -> [u32; 3] {
        self.numbers().map(|number| number / EDGE)
    }

    /// Where it is in that.
    #[inline(always)]
    fn offset(self) -> u32 {
        let part = |a: u32| ((self.0 >> (BITS * a)) as u32 % EDGE) << (2 * a);
        part(0) | part(1) | part(2)
    }

    #[inline(always)]
    fn is_of_same_brick(self, other: Self) -> bool {
        const BRICK: u64 = !((EDGE as u64 - 1) * (1 | 1 << BITS | 1 << (2 * BITS)));
        (self.0 ^ other.0) & BRICK == 0
    }
}

/// A block that the ray passes through.
struct BlockAt<'r, 'm> {
    mesh: &'m Mesh,
    number: u32,
    exponent: u32,
    layout: Layout,
    /// On the lattice of its level.
    ray: &'r ClippedRay,
    /// Where the value at the low corner of the domain would be, if the block were as large.
    first: isize,
    /// From one value to the next along y and z.
    strides: [u32; 2],
}

impl<'r, 'm> BlockAt<'r, 'm> {
    #[inline(always)]
    fn new(mesh: &'m Mesh, number: u32, rays: &Rays<'r, 'm>) -> Self {
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
            ray: rays.on_level(block.exponent),
            first,
            strides,
        }
    }

    #[inline(always)]
    fn brick(&self, numbers: [u32; 3]) -> BrickAt<'m> {
        let Self { mesh, number, layout, .. } = *self;
        BrickAt {
            mesh,
            block: number,
            layout,
            index: mesh.bricks.first[number as usize] + layout.index(numbers),
            numbers,
        }
    }

    /// The ray in the cubes of this edge, of those that the block has.
    #[inline(always)]
    fn steps(&self, cubes: &Cubes, [low, high]: [[u32; 3]; 2], t: f64) -> GridSteps {
        let last = high.map(|c| c - 1);
        GridSteps::at(self.ray, cubes, [vector(low), vector(last)], t, |numbers| Packed::new(numbers).0)
    }

    /// The values at the corners of a cell.
    #[inline(always)]
    fn corners(&self, cell: [u32; 3]) -> Corners<'m> {
        let [x, y, z] = cell.map(|c| c as isize);
        let [along_y, along_z] = self.strides.map(|stride| stride as isize);
        let first = self.first + x + along_y * y + along_z * z;
        Corners::new(&self.mesh.values, first as usize, self.strides)
    }
}

/// What goes along.
struct Way<'r, 'm, V, C> {
    mesh: &'m Mesh,
    rays: Rays<'r, 'm>,
    known: &'r mut Known,
    visit: &'r mut V,
    counters: &'r mut C,
}

impl<'m, V: Visit<'m>, C: Counters> Way<'_, 'm, V, C> {
    #[inline(never)]
    fn block(&mut self, block: u32, [mut t, t_end]: [f64; 2]) -> ControlFlow<()> {
        self.counters.node();
        let block = &BlockAt::new(self.mesh, block, &self.rays);
        let cells = &Cubes::new(block.ray, 1.0, 1.0);
        let mut steps = block.steps(cells, block.layout.cells, t);
        loop {
            let at = block.brick(Packed(steps.index()).brick());
            let end = match self.matters(&at)? {
                Some(known) => self.brick((block, &at, known), (cells, &mut steps), [t, t_end])?,
                None => self
                    .skip(block, [t, t_end])?
                    .inspect(|&t| steps = block.steps(cells, block.layout.cells, t)),
            };
            match end {
                Some(t_out) => t = t_out,
                None => return ControlFlow::Continue(()),
            }
        }
    }

    /// What is known of a brick if anything in it matters or is to be passed by cell by cell; else it is passed by.
    #[inline(always)]
    fn matters(&mut self, at: &BrickAt<'m>) -> ControlFlow<(), Option<KnownBrick>> {
        if V::PASSES {
            let range = at.brick().range;
            if !self.visit.wants(range) {
                self.visit.passes(range)?;
                return ControlFlow::Continue(None);
            }
        }
        let known = self.known.bricks[at.index as usize];
        let known = if known == KnownBrick::UNKNOWN { self.find(at) } else { known };
        ControlFlow::Continue((V::PASSES || known.shown != 0).then_some(known))
    }

    #[inline(never)]
    fn find(&mut self, at: &BrickAt<'m>) -> KnownBrick {
        let brick = at.brick();
        let is_met = self.visit.wants(brick.range);
        let shown = if is_met { self.visit.find(&mut self.known.room, at, self.counters) } else { 0 };
        let known = KnownBrick { shown, split: brick.split & shown };
        self.known.bricks[at.index as usize] = known;
        known
    }

    /// Goes on from a brick that does not matter to the first that does, and tells where the ray enters that, if it does.
    #[inline(never)]
    fn skip(&mut self, block: &BlockAt<'_, 'm>, [t, t_end]: [f64; 2]) -> ControlFlow<(), Option<f64>> {
        let Layout { first, count, .. } = block.layout;
        let bricks = Cubes::new(block.ray, EDGE.into(), 1.0 / f64::from(EDGE));
        let end = std::array::from_fn(|a| first[a] + count[a]);
        let mut steps = block.steps(&bricks, [first, end], t);
        let strides = &STRIDES[block.ray.backward() as usize & 7];
        loop {
            let t_out = steps.leaves();
            if t_out >= t_end {
                return ControlFlow::Continue(None);
            }
            steps.cross(block.ray, &bricks, strides, t_out);
            if self.matters(&block.brick(Packed(steps.index()).numbers()))?.is_some() {
                return ControlFlow::Continue(Some(t_out));
            }
        }
    }

    /// Goes from cell to cell of a brick, and tells where the ray leaves it, if that is in the block.
    #[inline(always)]
    fn brick(
        &mut self,
        (block, at, known): (&BlockAt<'_, 'm>, &BrickAt<'m>, KnownBrick),
        (cells, steps): (&Cubes, &mut GridSteps),
        [mut t, t_end]: [f64; 2],
    ) -> ControlFlow<(), Option<f64>> {
        let Self { rays, visit, counters, .. } = self;
        counters.node();
        let KnownBrick { shown, split } = known;
        let own = if V::PASSES { at.brick().own } else { 0 };
        let (ray, exponent) = (block.ray, block.exponent);
        let strides = &STRIDES[ray.backward() as usize & 7];
        loop {
            let leaves = steps.leaves();
            let t_out = if leaves < t_end { leaves } else { t_end };
            let cell = Packed(steps.index());
            let offset = cell.offset();
            if shown >> offset & 1 == 0 {
                if V::PASSES {
                    let corners = || block.corners(cell.numbers()).values();
                    visit.passes_cell((own >> offset & 1 == 1).then(|| corners()[0]))?;
                }
            } else if split >> offset & 1 == 1 {
                let parts = (at.split(offset), cell.numbers(), exponent);
                rays.parts(parts, [t, t_out], *visit, *counters)?;
            } else {
                counters.cell();
                let numbers = cell.numbers();
                let segment = || steps.segment(ray, [t, t_out]);
                visit.cell(block.corners(numbers), segment, [t, t_out], CubeAt { numbers, exponent })?;
            }
            if t_out >= t_end {
                return ControlFlow::Continue(None);
            }
            steps.cross(ray, cells, strides, t_out);
            t = t_out;
            if !cell.is_of_same_brick(Packed(steps.index())) {
                return ControlFlow::Continue(Some(t));
            }
        }
    }
}

fn vector([x, y, z]: [u32; 3]) -> f64x4 {
    f64x4::new([x.into(), y.into(), z.into(), 0.0])
}
