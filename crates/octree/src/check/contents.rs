//! Whether values and ranges are those of the samples, in a structure whose links are sound.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use isoray_grid::Scalar;
use rayon::prelude::*;

use super::block::Cube;
use super::{Malformed, Statistics};
use crate::cap::Block;
use crate::counts::Counts;
use crate::fidelity::Coarse;
use crate::geometry::{CAP_LEVEL, NODE_LEVEL, child_origin, extent, product};
use crate::lod::{Cube as CoarseCube, TASK_LEVEL, expected_value, has_cells, is_averaged, widened};
use crate::node::{Node, Range};
use crate::view::OctreeView;

/// A part of the domain, or what lies beside it.
#[derive(Clone, Copy)]
pub(super) enum Region<'a, T: Scalar> {
    Node(&'a Node<T::Stored>),
    Cap(Block<'a, T>),
    Constant(T),
    /// Outside the domain, or where a link leads nowhere.
    Nothing,
}

/// A region, and its seven neighbours in the directions of the axes: bit 0 of an index is the next one along x, bit 1 y, bit 2 z.
#[derive(Clone, Copy)]
pub(super) struct Around<'a, T: Scalar> {
    pub(super) regions: [Region<'a, T>; 8],
    pub(super) level: u32,
    pub(super) origin: [u32; 3],
}

pub(super) fn check<T: Scalar>(
    view: &OctreeView<'_, T>,
    root: &Node<T::Stored>,
    kind: Coarse,
    progress: &mut (dyn FnMut(f64) + Send),
) -> Result<Statistics<T>, Malformed> {
    let mut regions = [Region::Nothing; 8];
    regions[0] = Region::Node(root);
    let whole = Around { regions, level: view.root_level(), origin: [0; 3] };
    let mut tasks = Vec::new();
    let mut top = Contents::new(view, kind);
    top.begin(&whole);
    top.check(&whole, 0, TASK_LEVEL, &mut |around, index| tasks.push((*around, index)))?;
    let (pool, done, progress) = (Mutex::new(vec![top]), AtomicUsize::new(0), Mutex::new(progress));
    tasks.par_iter().try_for_each(|(around, index)| {
        let free = pool.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut contents = free.unwrap_or_else(|| Contents::new(view, kind));
        contents.begin(around);
        contents.check(around, *index, 0, &mut |_, _| {})?;
        pool.lock().unwrap_or_else(PoisonError::into_inner).push(contents);
        let share = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / tasks.len() as f64;
        if let Ok(mut progress) = progress.try_lock() {
            progress(share);
        }
        Ok(())
    })?;
    let mut all = Statistics { range: Range::EMPTY, counts: Counts::default() };
    for part in pool.into_inner().unwrap_or_else(PoisonError::into_inner) {
        all.range = all.range.union(part.statistics.range);
        all.counts.join(&part.statistics.counts);
    }
    Ok(all)
}

/// Verification by one thread.
pub(super) struct Contents<'v, 'a, T: Scalar> {
    pub(super) view: &'v OctreeView<'a, T>,
    kind: Coarse,
    pub(super) statistics: Statistics<T>,
    pub(super) cube: Cube<T>,
    /// Of the subtree at hand, if coarse samples are means and it is small enough.
    pub(super) coarse: Option<CoarseCube<T>>,
}

impl<'a, T: Scalar> Contents<'_, 'a, T> {
    fn new<'v>(view: &'v OctreeView<'a, T>, kind: Coarse) -> Contents<'v, 'a, T> {
        let statistics = Statistics { range: Range::EMPTY, counts: Counts::default() };
        Contents { view, kind, statistics, cube: Cube::default(), coarse: None }
    }

    /// Prepares for the subtree at `around`.
    fn begin(&mut self, around: &Around<'a, T>) {
        let is_small = is_averaged(self.kind) && around.level <= TASK_LEVEL;
        self.coarse = is_small.then(|| CoarseCube::new(self.view, around.origin, around.level, self.kind));
    }

    /// What the value and range of a stored child, or the range of a scalar leaf, of `level` at `corner` are to be, from what they would be with injection.
    fn averaged(
        &self,
        child: &Region<'a, T>,
        (level, corner): (u32, [u32; 3]),
        (first, range): (T, Range<T>),
    ) -> (T, Range<T>) {
        let is_leaf = matches!(child, Region::Constant(_));
        let value = if is_leaf { first } else { expected_value(self.view, level, corner, self.kind) };
        let finer = match &self.coarse {
            Some(cube) if level == NODE_LEVEL && has_cells(self.view, corner) => cube.range(corner),
            _ => Range::EMPTY,
        };
        (value, widened(self.view, range.union(finer), is_leaf, level, corner, self.kind))
    }

    /// The node at `around`, and those below it that are above `level` `last`; `later` is given those of that level.
    fn check(
        &mut self,
        around: &Around<'a, T>,
        index: usize,
        last: u32,
        later: &mut dyn FnMut(&Around<'a, T>, usize),
    ) -> Result<(), Malformed> {
        let Around { regions: [Region::Node(node), ..], level, origin } = *around else { return Ok(()) };
        let error = |what| Err(Malformed { level, index, what });
        if level == NODE_LEVEL {
            return self.check_caps(around, index);
        }
        for octant in 0..8 {
            let corner = child_origin(origin, level, octant);
            if !self.view.dims().contains(corner) {
                if node.range::<T>(octant as usize) != Range::EMPTY {
                    return error("a child outside the domain has a range");
                }
                continue;
            }
            let child = self.view.around_child(around, octant);
            let value: T = node.value(octant);
            let (mut first, mut range) = match child.regions[0] {
                Region::Node(below) => {
                    (below.value::<T>(0), (0..8).map(|n| below.range(n)).fold(Range::EMPTY, Range::union))
                }
                Region::Constant(value) => {
                    let count = product(extent(self.view.dims(), corner, level - 1)) as u64;
                    self.statistics.take(value, count);
                    (value, self.view.leaf_range(&child, value))
                }
                Region::Cap(_) | Region::Nothing => return error("a link leads outside its array"),
            };
            if is_averaged(self.kind) {
                (first, range) = self.averaged(&child.regions[0], (level - 1, corner), (first, range));
            }
            if !first.same_bits(value) {
                return error("a child's value is not that of its low corner");
            }
            if range != node.range(octant as usize) {
                return error("a child's range is not that of its samples");
            }
            if let Region::Node(_) = child.regions[0] {
                let index = node.child(octant);
                if level - 1 > last {
                    self.check(&child, index, last, later)?;
                } else {
                    later(&child, index);
                }
            }
        }
        Ok(())
    }
}

impl<T: Scalar> Statistics<T> {
    /// Takes in `times` samples of value `s`.
    #[inline(always)]
    pub(super) fn take(&mut self, s: T, times: u64) {
        self.counts.add(s, times);
        self.range.include(s);
    }
}

impl<'a, T: Scalar> OctreeView<'a, T> {
    /// What child `octant` of `region` is; `region` is of `level` and lies at `origin`.
    pub(super) fn child_region(
        &self,
        region: &Region<'a, T>,
        level: u32,
        origin: [u32; 3],
        octant: u32,
    ) -> Region<'a, T> {
        if !self.dims().contains(child_origin(origin, level, octant)) {
            return Region::Nothing;
        }
        match *region {
            Region::Node(node) if !node.is_stored(octant) => Region::Constant(node.value(octant)),
            Region::Node(node) if level == NODE_LEVEL => Region::Cap(self.block(node, origin, octant)),
            Region::Node(node) => {
                self.nodes(level - 1).get(node.child(octant)).map_or(Region::Nothing, Region::Node)
            }
            Region::Constant(value) => Region::Constant(value),
            Region::Cap(_) | Region::Nothing => Region::Nothing,
        }
    }

    /// Child `octant` of the region in the middle, and its neighbours.
    fn around_child(&self, around: &Around<'a, T>, octant: u32) -> Around<'a, T> {
        let Around { regions, level, origin } = around;
        let region = |direction: usize| {
            // Along an axis the neighbour of a lower child is its upper sibling, that of an upper one a child of the neighbour.
            let direction = direction as u32;
            let (beyond, child) = (octant & direction, octant ^ direction);
            let corner = std::array::from_fn(|a| origin[a] + ((beyond >> a & 1) << level));
            self.child_region(&regions[beyond as usize], *level, corner, child)
        };
        Around {
            regions: std::array::from_fn(region),
            level: level - 1,
            origin: child_origin(*origin, *level, octant),
        }
    }

    /// The range of the cells of a constant leaf: its value, and the samples of its neighbours on its faces.
    fn leaf_range(&self, around: &Around<'a, T>, value: T) -> Range<T> {
        let (origin, level) = (around.origin, around.level);
        let mut range = Range::EMPTY;
        if (0..3).all(|a| origin[a] + 1 < self.dims().axes()[a]) {
            range.include(value);
            for direction in 1..8u32 {
                let corner = std::array::from_fn(|a| origin[a] + ((direction >> a & 1) << level));
                self.include_face(&around.regions[direction as usize], level, corner, direction, &mut range);
            }
        }
        range
    }

    /// Extends `range` by the samples of a region that are its first along the axes of `direction`.
    fn include_face(
        &self,
        region: &Region<'a, T>,
        level: u32,
        origin: [u32; 3],
        direction: u32,
        range: &mut Range<T>,
    ) {
        match region {
            Region::Constant(value) if self.dims().contains(origin) => range.include(*value),
            Region::Constant(_) | Region::Nothing => {}
            Region::Cap(block) => {
                let size = extent(self.dims(), origin, CAP_LEVEL);
                let [nx, ny, nz] =
                    std::array::from_fn(|a| if direction >> a & 1 == 1 { size[a].min(1) } else { size[a] });
                for n in 0..nx * ny * nz {
                    range.include(block.sample([n % nx, n / nx % ny, n / nx / ny]));
                }
            }
            Region::Node(_) => {
                for octant in (0..8).filter(|octant| octant & direction == 0) {
                    let child = self.child_region(region, level, origin, octant);
                    let corner = child_origin(origin, level, octant);
                    self.include_face(&child, level - 1, corner, direction, range);
                }
            }
        }
    }
}
