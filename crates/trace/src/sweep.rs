//! The traversal loop for beams, down to blocks: what the cells in them are to single rays, blocks are to packets.

use std::ops::ControlFlow;

use isoray_grid::{Scalar, ScalarType};
use isoray_octree::CAP_EDGE;

use crate::beam::{Beam, BeamTest};
use crate::blocks::Way;
use crate::branch::STEP;
use crate::content::Content;
use crate::corner::{Corner, Facing};
use crate::cubes::Parent;
use crate::hit::{FirstHit, Hit, HitPolicy};
use crate::offset::{first_parts, mirror};
use crate::ray::{ClippedRay, DepartingRay, Line, Ray};
use crate::region::Region;
use crate::stretch::Crossings;
use crate::trace::Occlusion;
use crate::tracer::offer;
use crate::walk::{LOWEST, MixedCell, NOWHERE, Walk, at, edge};

/// What goes through a volume with a beam.
pub trait Sweep<T: Scalar> {
    /// Whether any ray may meet the cube at `corner`, which the beam does. It may say so of one that none meets.
    fn meets(&mut self, corner: [u32; 3], edge: u32) -> bool;

    /// Takes the next block, which was just said to be met; `Break` ends the traversal.
    fn block<'a, C: Content<'a, T>>(&mut self, block: &mut SurfaceBlock<'_, 'a, T, C>) -> ControlFlow<()>;
}

/// A block of 4³ cells, some of which hold an isovalue and may be met by some ray of a beam.
pub struct SurfaceBlock<'s, 'a, T: Scalar, C> {
    pub(crate) way: Way<'s, 'a, T>,
    pub(crate) cells: u64,
    pub(crate) mirror: u32,
    pub(crate) facing: Facing,
    pub(crate) content: &'s mut C,
    pub(crate) region: &'s Region,
}

impl<'a, T: Scalar, C: Content<'a, T>> SurfaceBlock<'_, 'a, T, C> {
    /// Its low corner, on the lattice.
    pub fn corner(&self) -> [u32; 3] {
        self.way.corner.coordinates()
    }

    /// The cells, by their numbers in the order of the rays: `x + 4y + 16z`, each counted in the direction in which they run. No ray of the beam meets
    /// one after another of higher number.
    pub fn cells(&self) -> u64 {
        self.cells
    }

    /// From its corner to the low corner of the cell of this number.
    #[inline(always)]
    pub fn offset(&self, number: u32) -> [u32; 3] {
        let offset = number ^ self.mirror;
        [offset & 3, offset >> 2 & 3, offset >> 4 & 3]
    }

    /// The samples at the corners of the cell of this number, x fastest; `None` unless all are finite.
    #[inline(always)]
    pub fn corners(&mut self, number: u32) -> Option<[f32; 8]> {
        let offset = (number ^ self.mirror) & 63;
        let samples = self.content.samples(offset, &self.way);
        let is_empty = T::TYPE == ScalarType::F32 && !samples.iter().all(|s| s.is_finite());
        (!is_empty).then_some(samples)
    }

    /// The cells, by the same numbers, that take [`first_hit`](Self::first_hit): cut short by the domain's border, or beside others of another level of detail.
    #[inline(always)]
    pub fn peculiar(&self) -> u64 {
        let cells = self.content.peculiar(&self.way);
        if cells == 0 { 0 } else { self.facing.ordered(cells) }
    }

    /// The first hit of a ray alone in the cell of this number, as [`Trace`](crate::Trace) gives it.
    pub fn first_hit(&mut self, ray: &Ray, number: u32, isovalue: f32) -> Option<Hit> {
        let mut first = FirstHit::default();
        self.offer(ray.into(), number, isovalue, &mut first);
        first.0
    }

    /// Whether a ray that starts on the isosurface is occluded in the cell of this number, of the lattice of `level`; see [`Trace::occluded`](crate::Trace::occluded).
    pub fn occludes(&mut self, ray: &DepartingRay, level: u32, number: u32, isovalue: f32) -> bool {
        let mut policy = Occlusion::of(ray);
        self.offer(Line::from(ray).on_level(level), number, isovalue, &mut policy);
        policy.is_occluded
    }

    fn offer(&mut self, line: Line, number: u32, isovalue: f32, policy: &mut impl HitPolicy) {
        let Some(samples) = self.corners(number) else { return };
        let offset = (number ^ self.mirror) & 63;
        let Some(ray) = ClippedRay::new(line, self.region) else { return };
        let stretch = Crossings::new(&ray, self.way.corner).stretch(&ray, number, offset);
        if stretch.is_empty() {
            return;
        }
        let mixed = MixedCell {
            cell: self.way.corner.of_part(offset, 0).coordinates(),
            samples,
            segment: stretch.segment(&ray),
            interval: stretch.interval,
            beyond: self.content.beyond(&ray, &self.way, offset, stretch.interval),
        };
        let _ = offer(&mixed, isovalue, policy);
    }
}

impl<'a, T: Scalar, C: Content<'a, T>> Walk<'a, T, C> {
    /// Of the cube that holds everything.
    pub(crate) fn outermost_edge(&self) -> f64 {
        edge(self.top_level).into()
    }

    /// Sends `rays`, which are those of `beam`, to the blocks with surface that any may meet, until they break, in an order that suits them all. `None` if single
    /// precision does not do.
    #[inline(always)]
    pub(crate) fn sweep(&mut self, beam: &Beam, rays: &mut impl Sweep<T>) -> Option<ControlFlow<()>> {
        let (Some(thresholds), Some(region)) = (&self.thresholds, &self.region) else {
            return Some(ControlFlow::Continue(()));
        };
        let outermost = self.outermost_edge();
        if !beam.is_ordinary(outermost) {
            return None;
        }
        let test = BeamTest::new(beam, outermost);
        let facing = Facing::new(beam.backward);
        let mirror = mirror(beam.backward);
        let last = self.view.dims().axes().map(|n| n - 1);
        let (mut level, mut corner) = (self.top_level, Corner::default());
        let mut parts = test.met(corner, edge(level - STEP)) & self.top[beam.backward as usize & 7];
        // Bit `n`: parts are left in the cube of level `2n`.
        let mut pending = 0u32;
        loop {
            if parts == 0 {
                if pending == 0 {
                    return Some(ControlFlow::Continue(()));
                }
                level = STEP * pending.trailing_zeros();
                pending &= pending - 1;
                let frame = &self.stack[at(level)];
                (parts, corner) = (frame.parts, frame.corner);
                continue;
            }
            let offset = parts.trailing_zeros() ^ mirror;
            parts &= parts - 1;
            let part = corner.of_part(offset, level - STEP);
            if !rays.meets(part.coordinates(), 1 << (level - STEP)) {
                continue;
            }
            if level > LOWEST {
                let frame = &mut self.stack[at(level)];
                (frame.parts, frame.corner) = (parts, corner);
                pending |= u32::from(parts != 0) << (level / STEP);
                self.around = NOWHERE;
                let met = test.met(part, edge(level - 2 * STEP));
                let parent = Parent { view: self.view, branch: &self.branches[at(level)], level, offset };
                let cube = self.cubes.part(part, facing, &parent, thresholds, &self.content);
                (level, corner) = (level - STEP, part);
                self.branches[at(level)] = cube.branch;
                parts = met & cube.active;
                continue;
            }
            let way = Way { view: self.view, branches: &self.branches, thresholds, corner: part };
            let in_domain = facing.ordered(cells_before(part, last));
            let cells = self.content.mixed(test.met(part, 1.0) & in_domain, &way, facing);
            if cells != 0 {
                let mut block =
                    SurfaceBlock { way, cells, mirror, facing, content: &mut self.content, region };
                if rays.block(&mut block).is_break() {
                    return Some(ControlFlow::Break(()));
                }
            }
        }
    }
}

/// Of the cells of the block at `corner`, in the order of the lattice, those whose coordinates are below `last`: the others are not of the domain.
#[inline(always)]
pub(crate) fn cells_before(corner: Corner, last: [u32; 3]) -> u64 {
    let corner = corner.coordinates();
    let mut cells = u64::MAX;
    for a in 0..3 {
        if corner[a] + CAP_EDGE > last[a] {
            cells &= first_parts(a, last[a].saturating_sub(corner[a]));
        }
    }
    cells
}
