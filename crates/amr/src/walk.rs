//! A ray's way through a mesh.

use std::ops::ControlFlow;

use isoray_cell::Segment;
use isoray_trace::Counters;
use isoray_trace::parts::{self, ClippedRay, Cube, Cubes, GridSteps, Strides};
use wide::f64x4;

use crate::block::Block;
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

/// Levels, by the binary logarithm of the edge of their cells: those of 21 bits.
const EXPONENTS: usize = 22;

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
    rays: [Option<ClippedRay>; EXPONENTS],
    known: Known,
}

/// Nobody asks for an index.
const NO_STRIDES: Strides = [0; 8];

impl Walk {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let bricks = vec![KnownBrick::UNKNOWN; mesh.bricks.bricks.len()];
        Self { pending: Vec::new(), rays: [None; EXPONENTS], known: Known { bricks, room: Box::default() } }
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
struct Rays<'r, 'm> {
    mesh: &'m Mesh,
    ray: &'r ClippedRay,
    rays: &'r mut [Option<ClippedRay>; EXPONENTS],
}

impl<'m> Rays<'_, 'm> {
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
            let at = BrickAt { mesh, block, layout, index, numbers };
            let is_met = !V::PASSES || self.visit.wants(at.brick().range);
            let known = if is_met { self.known(&at) } else { KnownBrick::UNKNOWN };
            if !is_met {
                self.visit.passes(at.brick().range)?;
            } else if V::PASSES || known.shown != 0 {
                let center = steps.cube() * f64x4::splat(EDGE.into()) + f64x4::splat(f64::from(EDGE) / 2.0);
                let cube = Cube { center, mid: ray.crossings(center), step: ray.step() };
                self.brick(ray, (known, &at), cube, [t, t_out])?;
            }
            if t_out >= t_end {
                return ControlFlow::Continue(());
            }
            steps.cross(ray, &cubes, &NO_STRIDES, t_out);
            t = t_out;
        }
    }

    /// What is known of a brick, which is found out if need be.
    #[inline(always)]
    fn known(&mut self, at: &BrickAt<'m>) -> KnownBrick {
        let known = self.known.bricks[at.index as usize];
        if known == KnownBrick::UNKNOWN { self.find(at) } else { known }
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

    #[inline(always)]
    fn brick(
        &mut self,
        ray: &ClippedRay,
        (known, at): (KnownBrick, &BrickAt<'m>),
        cube: Cube,
        interval: [f64; 2],
    ) -> ControlFlow<()> {
        let Self { mesh, rays, visit, counters, .. } = self;
        counters.node();
        let KnownBrick { shown, split } = known;
        let own = if V::PASSES { at.brick().own } else { 0 };
        let block = &mesh.skeleton.blocks[at.block as usize];
        let exponent = block.exponent;
        let vertices = Vertices::new(&mesh.values, block, at);
        cube.walk(ray, interval, |steps, offset, interval| {
            if shown >> offset & 1 == 0 {
                return visit.passes_cell((own >> offset & 1 == 1).then(|| vertices.corner(offset)));
            }
            let numbers: [u32; 3] = std::array::from_fn(|a| at.numbers[a] * EDGE + (offset >> (2 * a) & 3));
            if split >> offset & 1 == 1 {
                let split = at.split(offset);
                return rays.parts((split, numbers, exponent), interval, *visit, *counters);
            }
            counters.cell();
            let place = CubeAt { numbers, exponent };
            visit.cell(vertices.corners(offset), || steps.segment(ray, interval), interval, place)
        })
    }
}

/// The vertices of a brick's cells.
struct Vertices<'m> {
    values: &'m [f32],
    /// Where that of the brick's low corner is, or would be if it were of the block.
    first: isize,
    /// From one to the next along y and z.
    strides: [u32; 2],
}

impl<'m> Vertices<'m> {
    #[inline(always)]
    fn new(values: &'m [f32], block: &Block, at: &BrickAt<'_>) -> Self {
        let [low, high] = at.layout.cells;
        let [nx, ny] = [0, 1].map(|a| high[a] - low[a] + 1);
        let from = |a: usize| (at.numbers[a] * EDGE) as isize - low[a] as isize;
        let (y, z) = (nx as isize, nx as isize * ny as isize);
        let first = block.first as isize + from(0) + from(1) * y + from(2) * z;
        Self { values, first, strides: [nx, nx * ny] }
    }

    #[inline(always)]
    fn index(&self, offset: u32) -> usize {
        let [x, y, z] = [offset & 3, offset >> 2 & 3, offset >> 4 & 3];
        (self.first + (x + self.strides[0] * y + self.strides[1] * z) as isize) as usize
    }

    /// The first of the corner values of a cell of the block.
    #[inline(always)]
    fn corner(&self, offset: u32) -> f32 {
        self.values[self.index(offset)]
    }

    /// The corner values of a cell of the block.
    #[inline(always)]
    fn corners(&self, offset: u32) -> Corners<'m> {
        Corners::new(self.values, self.index(offset), self.strides)
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
