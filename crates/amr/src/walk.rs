//! A ray's way through a mesh.

use std::cell::OnceCell;
use std::ops::ControlFlow;

use isoray_trace::Counters;
use isoray_trace::parts::{self, CORNER_STRIDES, ClippedRay, Corner, Cubes, GridSteps};
use wide::f64x4;

use crate::block_at::BlockAt;
use crate::bricks::{EDGE, Layout};
use crate::level_rays::LevelRays;
use crate::mesh::Mesh;
use crate::tree::Node;
use crate::visit::{BrickAt, CubeAt, Visit};

/// The binary logarithm of a brick's edge.
const BRICK_LEVEL: u32 = EDGE.ilog2();

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
    pub(crate) fn follow<'m, V: Visit<'m>>(
        &mut self,
        mesh: &'m Mesh,
        ray: &ClippedRay,
        visit: &mut V,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let Self { pending, rays, known } = self;
        rays.iter_mut().for_each(|ray| *ray = OnceCell::new());
        let mut way = Way { mesh, rays: LevelRays { mesh, ray, rays }, known, visit, counters };
        pending.clear();
        pending.push((0, ray.interval()));
        while let Some((mut node, [t, mut t_end])) = pending.pop() {
            loop {
                // Where it is empty tells from which side the ray comes to what follows.
                let is_passed_by_parts = V::PASSES && mesh.has_gaps(node);
                if !is_passed_by_parts && !way.visit.wants_node(node) {
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

/// What goes along.
struct Way<'r, 'm, V, C> {
    mesh: &'m Mesh,
    rays: LevelRays<'r, 'm>,
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
            let at = block.brick(Corner(steps.index()).coordinates().map(|c| c / EDGE));
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
            let brick = at.brick();
            if !self.visit.wants(brick.range) {
                if self.mesh.may_have_gaps(brick) {
                    return ControlFlow::Continue(Some(KnownBrick { shown: 0, split: 0 }));
                }
                self.visit.passes(brick.range)?;
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
        let strides = &CORNER_STRIDES[block.ray.backward() as usize & 7];
        loop {
            let t_out = steps.leaves();
            if t_out >= t_end {
                return ControlFlow::Continue(None);
            }
            steps.cross(block.ray, &bricks, strides, t_out);
            if self.matters(&block.brick(Corner(steps.index()).coordinates()))?.is_some() {
                return ControlFlow::Continue(Some(t_out));
            }
        }
    }

    /// Goes from cell to cell of a brick, and tells where the ray leaves it, if that is in the block.
    #[inline(always)]
    fn brick(
        &mut self,
        (block, at, known): (&BlockAt<'_, 'm>, &BrickAt<'m>, KnownBrick),
        (cells, position): (&Cubes, &mut GridSteps),
        [mut t, t_end]: [f64; 2],
    ) -> ControlFlow<(), Option<f64>> {
        let Self { rays, visit, counters, .. } = self;
        // In registers.
        let mut steps = *position;
        counters.node();
        let KnownBrick { shown, split } = known;
        let own = if V::PASSES { at.brick().own } else { 0 };
        let (ray, exponent) = (block.ray, block.exponent);
        let strides = &CORNER_STRIDES[ray.backward() as usize & 7];
        loop {
            let leaves = steps.leaves();
            let t_out = if leaves < t_end { leaves } else { t_end };
            let cell = Corner(steps.index());
            let offset = cell.offset(0);
            if shown >> offset & 1 == 0 {
                if V::PASSES {
                    let corners = || block.corners(cell.coordinates()).values();
                    visit.passes_cell((own >> offset & 1 == 1).then(|| corners()[0]))?;
                }
            } else if split >> offset & 1 == 1 {
                let parts = (at.split(offset), cell.coordinates(), exponent);
                rays.parts(parts, [t, t_out], *visit, *counters)?;
            } else {
                counters.cell();
                let numbers = cell.coordinates();
                let segment = || steps.segment(ray, [t, t_out]);
                visit.cell(block.corners(numbers), segment, [t, t_out], CubeAt { numbers, exponent })?;
            }
            if t_out >= t_end {
                return ControlFlow::Continue(None);
            }
            steps.cross(ray, cells, strides, t_out);
            t = t_out;
            if cell.around(BRICK_LEVEL) != Corner(steps.index()).around(BRICK_LEVEL) {
                *position = steps;
                return ControlFlow::Continue(Some(t));
            }
        }
    }
}
