//! The traversal of beams by slabs (Knoll 2009, sections 5.1 to 5.4): along the axis on which the rays are fastest, one layer of cubes after the other, in
//! which the rays themselves tell how far they extend; and so on inside the cubes with surface, down to slices of cells.
//!
//! What [`sweep`](crate::sweep) asks of each cube, whether a ray may meet it, is asked here once for a layer, of all rays. A layer is of cubes of 4³ parts, so the
//! macrocells of the paper are there without being built; the branches that lead to them are kept, and neighbours are found from the lowest common one.

use std::ops::{ControlFlow, Range};

use isoray_grid::Scalar;
use isoray_octree::CAP_EDGE;

use crate::beam::Beam;
use crate::blocks::Way;
use crate::branch::{BLOCK_LEVEL, Branch, STEP};
use crate::content::Content;
use crate::corner::{Corner, Facing};
use crate::cubes::Parent;
use crate::offset::{mirror, parts_between};
use crate::sweep::{SurfaceBlock, Sweep, cells_before};
use crate::walk::{LOWEST, NOWHERE, Walk, at};

/// What a march makes use of: each with all before it, as they are added in turn in Table 2 of Knoll 2009.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Slicing {
    /// In the cubes of edge 16 with surface, all cells to which the rays extend are looked up, each from the root.
    Extents,
    /// Samples of blocks, once read, are kept for the next cells and slices.
    Kept,
    /// Blocks without surface are left out.
    Macrocells,
    /// Rays that have ended do not count for what the others extend to.
    Active,
    /// The cells with surface are told by comparing blocks as a whole, and no others are looked up.
    #[default]
    Mixed,
}

/// The lowest and the highest cells along each axis.
pub type Extents = [[u32; 2]; 3];

/// What goes through a volume by slabs.
pub trait March<T: Scalar>: Sweep<T> {
    /// It now goes along `axis`, from one plane to another: nothing matters elsewhere.
    fn begin(&mut self, axis: usize, planes: [f64; 2]);

    /// The cells that the rays may meet between two planes across that axis, in the order in which they pass them; along the axis, those between the
    /// planes. `None` if there are no such cells. Planes never come again before those that were asked for.
    fn extents(&mut self, planes: [u32; 2]) -> Option<Extents>;

    /// A cube above the blocks was entered.
    fn cube(&mut self);

    /// The samples at the corners of a cell were looked up, to see whether it holds surface.
    fn looked_up(&mut self);
}

/// A cube, of those in the same layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrontCube<'a, T: Scalar> {
    corner: Corner,
    level: u32,
    /// The parts that matter, in the order of the rays.
    active: u64,
    branch: Branch<'a, T>,
    /// Where the cube is that it is a part of.
    above: usize,
}

/// What is the same all the way.
struct Course {
    axis: usize,
    backward: u32,
    facing: Facing,
    mirror: u32,
    /// The upper planes of the domain.
    last: [u32; 3],
    slicing: Slicing,
}

impl Course {
    /// The planes of layer `number`, in the order of the rays, of parts of edge `edge` of a cube at `corner`: those by which they enter and leave it.
    fn planes(&self, corner: Corner, number: u32, edge: u32) -> [u32; 2] {
        let is_backward = self.backward >> self.axis & 1;
        let low = corner.coordinates()[self.axis] + (number ^ (3 * is_backward)) * edge;
        if is_backward == 0 { [low, low + edge] } else { [low + edge, low] }
    }

    /// The parts of that layer, in the order of the rays.
    fn layer(&self, number: u32) -> u64 {
        parts_between(self.axis, number, number)
    }

    /// What the rays extend to between two planes, if any of it is in the domain.
    fn extents<T: Scalar>(&self, planes: [u32; 2], rays: &mut impl March<T>) -> Option<Extents> {
        if planes[0].min(planes[1]) >= self.last[self.axis] {
            return None;
        }
        rays.extents(planes)
    }
}

/// The parts, of edge 2^`level`, of the cube at `corner` that reach into `extents`, in the order of the lattice.
#[inline(always)]
fn parts_in(corner: [u32; 3], level: u32, extents: &Extents) -> u64 {
    let along = |a: usize| {
        let [low, high] = extents[a];
        let before = low.saturating_sub(corner[a]) >> level;
        if high < corner[a] || before > 3 {
            return 0;
        }
        let through = (high - corner[a]) >> level;
        parts_between(a, before, through.min(3))
    };
    along(0) & along(1) & along(2)
}

impl<'a, T: Scalar, C: Content<'a, T>> Walk<'a, T, C> {
    /// What [`sweep`](Self::sweep) does, by slabs.
    // Never inlined, so that crates share what one of them has compiled: it takes long.
    #[inline(never)]
    pub(crate) fn march(
        &mut self,
        beam: &Beam,
        slicing: Slicing,
        rays: &mut impl March<T>,
    ) -> Option<ControlFlow<()>> {
        let (Some(_), Some(region)) = (&self.thresholds, &self.region) else {
            return Some(ControlFlow::Continue(()));
        };
        if !beam.is_ordinary(self.outermost_edge()) {
            return None;
        }
        self.around = NOWHERE;
        let [slowest, _] = beam.speeds;
        let axis = (0..3).max_by(|&a, &b| slowest[a].total_cmp(&slowest[b])).unwrap_or_default();
        let [low, high] = [region.low, region.high].map(|planes| planes.to_array()[axis]);
        rays.begin(axis, if beam.backward >> axis & 1 == 0 { [low, high] } else { [high, low] });
        let course = Course {
            axis,
            backward: beam.backward,
            facing: Facing::new(beam.backward),
            mirror: mirror(beam.backward),
            last: self.view.dims().axes().map(|n| n - 1),
            slicing,
        };
        let mut front = std::mem::take(&mut self.front);
        front.clear();
        front.push(FrontCube {
            corner: Corner::default(),
            level: self.top_level,
            active: self.top[beam.backward as usize & 7],
            branch: self.branches[at(self.top_level)],
            above: 0,
        });
        let end = self.layers(&course, &mut front, 0, rays);
        self.front = front;
        Some(end)
    }

    /// Sends the rays through the layers of the cubes from the `first` on, which are of one layer.
    fn layers(
        &mut self,
        course: &Course,
        front: &mut Vec<FrontCube<'a, T>>,
        first: usize,
        rays: &mut impl March<T>,
    ) -> ControlFlow<()> {
        let end = front.len();
        let FrontCube { corner, level, .. } = front[first];
        let level = level - STEP;
        let active = front[first..].iter().fold(0, |active, cube| active | cube.active);
        for number in 0..4 {
            let layer = course.layer(number);
            if active & layer == 0 {
                continue;
            }
            let planes = course.planes(corner, number, 1 << level);
            let Some(extents) = course.extents(planes, rays) else { continue };
            if level == BLOCK_LEVEL {
                self.slab(course, front, first..end, (layer, planes, extents), rays)?;
                continue;
            }
            for above in first..end {
                let cube = front[above];
                let met = course.facing.ordered(parts_in(cube.corner.coordinates(), level, &extents));
                self.push_parts(course, front, above, cube.active & layer & met, rays);
            }
            if front.len() > end {
                self.layers(course, front, end, rays)?;
                front.truncate(end);
            }
        }
        ControlFlow::Continue(())
    }

    /// Adds `parts` of the cube at `above` that hold surface.
    fn push_parts(
        &mut self,
        course: &Course,
        front: &mut Vec<FrontCube<'a, T>>,
        above: usize,
        mut parts: u64,
        rays: &mut impl March<T>,
    ) {
        let Some(thresholds) = &self.thresholds else { return };
        let FrontCube { corner, level, branch, .. } = front[above];
        while parts != 0 {
            let offset = parts.trailing_zeros() ^ course.mirror;
            parts &= parts - 1;
            rays.cube();
            let part = corner.of_part(offset, level - STEP);
            let parent = Parent { view: self.view, branch: &branch, level, offset };
            let cube = self.cubes.part(part, course.facing, &parent, thresholds, &self.content);
            if cube.active != 0 {
                let is_unclipped = level - STEP == LOWEST && course.slicing < Slicing::Macrocells;
                let active = if is_unclipped { u64::MAX } else { cube.active };
                front.push(FrontCube {
                    corner: part,
                    level: level - STEP,
                    active,
                    branch: cube.branch,
                    above,
                });
            }
        }
    }

    /// Sends the rays to the blocks of one layer of the cubes in `range`.
    fn slab(
        &mut self,
        course: &Course,
        front: &[FrontCube<'a, T>],
        range: Range<usize>,
        (layer, planes, extents): (u64, [u32; 2], Extents),
        rays: &mut impl March<T>,
    ) -> ControlFlow<()> {
        let mut slices = None;
        for n in range {
            let cube = &front[n];
            let met = course.facing.ordered(parts_in(cube.corner.coordinates(), BLOCK_LEVEL, &extents));
            let mut parts = cube.active & layer & met;
            if parts == 0 {
                continue;
            }
            self.lead_to(front, n);
            while parts != 0 {
                let part = cube.corner.of_part(parts.trailing_zeros() ^ course.mirror, BLOCK_LEVEL);
                parts &= parts - 1;
                let low = part.coordinates();
                if !rays.meets(low, CAP_EDGE) && course.slicing == Slicing::Mixed {
                    continue;
                }
                let slices = slices.get_or_insert_with(|| slices_of(course, planes, rays));
                let met = slices.iter().flatten().fold(0, |met, slice| met | parts_in(low, 0, slice));
                self.block(course, part, met, rays)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Fills in the branches that lead to the cube at `n`.
    fn lead_to(&mut self, front: &[FrontCube<'a, T>], mut n: usize) {
        loop {
            let FrontCube { level, branch, above, .. } = front[n];
            self.branches[at(level)] = branch;
            if n == above {
                return;
            }
            n = above;
        }
    }

    /// Sends the rays to the block at `corner`, of whose cells they may meet those `met`, in the order of the lattice.
    #[inline(always)]
    fn block(
        &mut self,
        course: &Course,
        corner: Corner,
        met: u64,
        rays: &mut impl March<T>,
    ) -> ControlFlow<()> {
        let (Some(thresholds), Some(region)) = (&self.thresholds, &self.region) else {
            return ControlFlow::Continue(());
        };
        let &Course { facing, mirror, slicing, .. } = course;
        let way = Way { view: self.view, branches: &self.branches, thresholds, corner };
        let met = facing.ordered(met & cells_before(corner, course.last));
        let content = &mut self.content;
        let cells = match slicing {
            Slicing::Mixed => content.mixed(met, &way, facing),
            _ => looked_up(content, &way, met, course, rays),
        };
        if cells == 0 {
            return ControlFlow::Continue(());
        }
        rays.block(&mut SurfaceBlock { way, cells, mirror, facing, content, region })
    }
}

/// What the rays extend to in each slice of cells between two planes a block apart.
fn slices_of<T: Scalar>(
    course: &Course,
    [enter, leave]: [u32; 2],
    rays: &mut impl March<T>,
) -> [Option<Extents>; CAP_EDGE as usize] {
    std::array::from_fn(|n| {
        let n = n as u32;
        let planes = if enter < leave { [enter + n, enter + n + 1] } else { [enter - n, enter - n - 1] };
        course.extents(planes, rays)
    })
}

/// Of the cells `met` of a block those that hold surface, each looked up.
fn looked_up<'a, T: Scalar, C: Content<'a, T>>(
    content: &mut C,
    way: &Way<'_, 'a, T>,
    mut met: u64,
    course: &Course,
    rays: &mut impl March<T>,
) -> u64 {
    let threshold = way.thresholds.first.to_f32();
    let own = content.mixed(met, way, course.facing);
    // Those that cannot be told by their samples alone.
    let mut mixed = course.facing.ordered(content.peculiar(way));
    while met != 0 {
        let number = met.trailing_zeros();
        met &= met - 1;
        let offset = number ^ course.mirror;
        let samples = match course.slicing {
            Slicing::Extents => content.samples_afresh(offset, way),
            _ => content.samples(offset, way),
        };
        rays.looked_up();
        let inside = samples.iter().filter(|&&s| s >= threshold).count();
        mixed |= u64::from(!matches!(inside, 0 | 8)) << number;
    }
    mixed & own
}
