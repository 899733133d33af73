//! The traversal loop: from cube to cube, and from cell to cell, in the order of the ray.
//!
//! A cube of even level is cut into 4³ parts, down to blocks and their cells. The parts that matter are the bits of a word that is remembered from
//! ray to ray; those that a ray may meet are found by one test of all 64 ([`boxes`](crate::boxes)); and in the order of the lattice, each axis
//! reversed along which the ray runs backward, no part comes before one that the ray passes through earlier. So what is to be visited are the bits of
//! both words together, lowest first.

use std::ops::ControlFlow;

use isoray_cell::Segment;
use isoray_grid::{Scalar, ScalarType};
use isoray_octree::OctreeView;

use crate::blocks::{Branches, WAY, Way};
use crate::boxes::{BoxTest, Entries};
use crate::branch::{BLOCK_LEVEL, Branch, STEP};
use crate::content::{Beyond, Content};
use crate::corner::{Corner, Facing, Key};
use crate::cubes::{Cubes, Parent};
use crate::march::FrontCube;
use crate::offset::mirror;
use crate::ray::{ClippedRay, Line};
use crate::region::Region;
use crate::stretch::Crossings;
use crate::thresholds::Thresholds;
use crate::work::Counters;

/// The level of the smallest cubes that are not blocks.
pub(crate) const LOWEST: u32 = BLOCK_LEVEL + STEP;

/// A cell whose corners lie on both sides of an isovalue, and the ray's stretch in it.
pub(crate) struct MixedCell {
    /// Its low corner.
    pub(crate) cell: [u32; 3],
    /// At its corners, x fastest; all are finite.
    pub(crate) samples: [f32; 8],
    /// Cell-local.
    pub(crate) segment: Segment,
    /// Where the stretch begins and ends on the ray.
    pub(crate) interval: [f64; 2],
    /// What comes just before and behind, where other arithmetic goes there.
    pub(crate) beyond: [Option<Beyond>; 2],
}

/// No cube.
pub(crate) const NOWHERE: (Key, u32) = (Key::NONE, BLOCK_LEVEL);

/// What is left to do in a cube.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frame {
    /// In the order of the ray.
    pub(crate) parts: u64,
    pub(crate) corner: Corner,
    entries: Entries,
}

/// The traversal of one volume, and what it found out for the next ray.
#[derive(Clone, Debug)]
pub(crate) struct Walk<'a, T: Scalar, C> {
    pub(crate) view: &'a OctreeView<'a, T>,
    /// What all that is remembered holds for; none yet.
    pub(crate) thresholds: Option<Thresholds<T>>,
    /// Where there can be surface; `None`: nowhere.
    pub(crate) region: Option<Region>,
    /// The level of the cube that holds everything, and its parts that matter, by the rays' directions.
    pub(crate) top_level: u32,
    pub(crate) top: [u64; 8],
    pub(crate) cubes: Cubes<'a, T>,
    pub(crate) content: C,
    /// By half the level.
    pub(crate) stack: [Frame; WAY],
    pub(crate) branches: Branches<'a, T>,
    /// Room for the cubes of a march.
    pub(crate) front: Vec<FrontCube<'a, T>>,
    /// The cube, and its level, whose surroundings are those of the stack still, for the rays of one facing.
    pub(crate) around: (Key, u32),
}

/// Edges of cubes, by level.
const EDGES: [f32; 32] = {
    let mut edges = [1.0; 32];
    let mut level = 1;
    while level < 32 {
        edges[level] = 2.0 * edges[level - 1];
        level += 1;
    }
    edges
};

/// Of a cube of `level`.
#[inline(always)]
pub(crate) fn edge(level: u32) -> f32 {
    EDGES[level as usize % EDGES.len()]
}

impl<'a, T: Scalar, C: Content<'a, T>> Walk<'a, T, C> {
    pub(crate) fn new(view: &'a OctreeView<'a, T>, content: C) -> Self {
        let (top, top_level) = Branch::top(view);
        let mut branches = [Branch::nothing(); WAY];
        branches[at(top_level)] = top;
        Self {
            view,
            thresholds: None,
            region: None,
            top_level,
            top: [0; 8],
            cubes: Cubes::new(),
            content,
            stack: [Frame::default(); WAY],
            branches,
            front: Vec::new(),
            around: NOWHERE,
        }
    }

    /// What is looked for.
    #[inline(always)]
    pub(crate) fn thresholds(&self) -> Option<&Thresholds<T>> {
        self.thresholds.as_ref()
    }

    /// Prepares for other thresholds: forgets what was found out for the last ones.
    #[cold]
    pub(crate) fn turn_to(&mut self, thresholds: Thresholds<T>, isovalues: &[f32]) {
        self.region = self.content.region(self.view, &thresholds);
        self.cubes.forget();
        self.content.turn_to(isovalues);
        self.around = NOWHERE;
        let (branch, level) = Branch::top(self.view);
        let active = match branch.node {
            Some(_) => branch.active(self.view, level, |node| thresholds.active(node)),
            None => 0,
        };
        let active = self.content.parts(Corner::default(), level, active);
        self.top = std::array::from_fn(|backward| Facing::new(backward as u32).ordered(active));
        self.thresholds = Some(thresholds);
    }

    /// Calls `visit` for the mixed cells on the ray's way, in order, until it breaks.
    #[inline(always)]
    pub(crate) fn follow(
        &mut self,
        ray: impl Into<Line>,
        visit: impl FnMut(&MixedCell) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let Some(region) = &self.region else { return ControlFlow::Continue(()) };
        let Some(ray) = &ClippedRay::new(ray, region) else { return ControlFlow::Continue(()) };
        self.descend(ray, visit, counters)
    }

    /// The level of the smallest cube around `begin` that is known, as are those around it. Their branches are filled in, and in their
    /// frames the parts that matter.
    #[inline(always)]
    fn known_around(&mut self, begin: Corner, backward: u32) -> u32 {
        let facing = Facing::new(backward);
        let (key, level) = self.around;
        if key == Key::new(begin.around(level), level, facing) {
            return level;
        }
        let mut level = self.top_level;
        self.stack[at(level)].parts = self.top[backward as usize & 7];
        while level > LOWEST {
            let Some(cube) = self.cubes.known(begin.around(level - STEP), level - STEP, facing) else {
                break;
            };
            level -= STEP;
            self.branches[at(level)] = cube.branch;
            self.stack[at(level)].parts = cube.active;
        }
        self.around = (Key::new(begin.around(level), level, facing), level);
        level
    }

    #[inline(always)]
    fn descend(
        &mut self,
        ray: &ClippedRay,
        mut visit: impl FnMut(&MixedCell) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let course = Course {
            ray,
            test: BoxTest::new(ray, edge(self.top_level).into()),
            facing: Facing::new(ray.backward),
            mirror: mirror(ray.backward),
        };
        let mut level = self.top_level;
        let mut corner = Corner::default();
        let mut active = self.top[ray.backward as usize & 7];
        // Bit `n`: parts are left in the cube of level `2n`; and, that cube has not been looked at, because the ray began in the middle of it.
        let (mut pending, mut unseen) = (0u32, 0u32);
        let mut begin = Corner::default();
        if ray.starts_inside {
            let [x, y, z, _] = ray.at_begin().to_array();
            begin = Corner::new([x, y, z].map(|c| c as u32));
            let lowest = self.known_around(begin, ray.backward);
            if lowest < level && course.test.is_clearly_in_its_cube([x, y, z], lowest) {
                unseen = (2 << (level / STEP)) - (2 << (lowest / STEP));
                pending = unseen;
                (level, corner) = (lowest, begin.around(lowest));
                active = self.stack[at(lowest)].parts;
            }
        }
        let Some(thresholds) = &self.thresholds else { return ControlFlow::Continue(()) };
        counters.node();
        let (met, entries) = course.enter(corner, level);
        let mut parts = met & active;
        self.stack[at(level)].entries = entries;
        loop {
            if parts == 0 {
                if pending == 0 {
                    return ControlFlow::Continue(());
                }
                level = STEP * pending.trailing_zeros();
                pending &= pending - 1;
                let frame = &mut self.stack[at(level)];
                (parts, corner) = (frame.parts, frame.corner);
                if unseen >> (level / STEP) & 1 == 1 {
                    unseen &= unseen - 1;
                    corner = begin.around(level);
                    counters.node();
                    let (met, entries) = course.enter(corner, level);
                    frame.entries = entries;
                    // The part in which the ray began is done, and those before it are behind.
                    let done = begin.offset(level - STEP) ^ course.mirror;
                    parts &= met & u64::MAX << 1 << done;
                }
                continue;
            }
            let number = parts.trailing_zeros();
            parts &= parts - 1;
            let offset = number ^ course.mirror;
            counters.node();
            let frame = &mut self.stack[at(level)];
            let entry = frame.entries.of(number);
            let part = corner.of_part(offset, level - STEP);
            if level > LOWEST {
                (frame.parts, frame.corner) = (parts, corner);
                pending |= u32::from(parts != 0) << (level / STEP);
                self.around = NOWHERE;
                let (met, entries) = course.test.met(entry, edge(level - 2 * STEP));
                let parent = Parent { view: self.view, branch: &self.branches[at(level)], level, offset };
                let cube = self.cubes.part(part, course.facing, &parent, thresholds, &self.content);
                (level, corner) = (level - STEP, part);
                self.stack[at(level)].entries = entries;
                self.branches[at(level)] = cube.branch;
                parts = met & cube.active;
                continue;
            }
            let way = Way { view: self.view, branches: &self.branches, thresholds, corner: part };
            course.block(entry, &way, &mut self.content, &mut visit, counters)?;
        }
    }
}

/// Where the stack has cubes of `level`.
#[inline(always)]
pub(crate) fn at(level: u32) -> usize {
    (level / STEP) as usize % WAY
}

/// What stays the same on all of a ray's way.
struct Course<'r> {
    ray: &'r ClippedRay,
    test: BoxTest,
    facing: Facing,
    /// From numbers in the order of the ray to those in that of the lattice, and back.
    mirror: u32,
}

impl Course<'_> {
    /// The parts of a cube of `level` that the ray may meet, found without those around it.
    #[inline(always)]
    fn enter(&self, corner: Corner, level: u32) -> (u64, Entries) {
        self.test.met(self.test.entry(corner, edge(level)), edge(level - STEP))
    }

    /// Visits the mixed cells on the ray in the block to which `way` leads, and which the ray enters at `entry`.
    #[inline(always)]
    fn block<'a, T: Scalar>(
        &self,
        entry: [f32; 3],
        way: &Way<'_, 'a, T>,
        content: &mut impl Content<'a, T>,
        visit: &mut impl FnMut(&MixedCell) -> ControlFlow<()>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let (met, _) = self.test.met(entry, 1.0);
        let mut cells = content.mixed(met, way, self.facing);
        if cells == 0 {
            return ControlFlow::Continue(());
        }
        let crossings = Crossings::new(self.ray, way.corner);
        while cells != 0 {
            let number = cells.trailing_zeros();
            cells &= cells - 1;
            let offset = number ^ self.mirror;
            let stretch = crossings.stretch(self.ray, number, offset);
            if stretch.is_empty() {
                continue;
            }
            counters.lookups(8);
            let samples = content.samples(offset, way);
            if T::TYPE == ScalarType::F32 && !samples.iter().all(|s| s.is_finite()) {
                continue;
            }
            counters.cell();
            visit(&MixedCell {
                cell: way.corner.of_part(offset, 0).coordinates(),
                samples,
                segment: stretch.segment(self.ray),
                interval: stretch.interval,
                beyond: content.beyond(self.ray, way, offset, stretch.interval),
            })?;
        }
        ControlFlow::Continue(())
    }
}
