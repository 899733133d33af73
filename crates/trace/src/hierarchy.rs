//! Macrocells in the form that a traversal uses.

use isoray_grid::{Dims, MacrocellLevel, Macrocells, Scalar, ValueRange};
use wide::f64x4;

use crate::grid_steps::{Strides, strides};
use crate::region::Region;

/// All levels of macrocells.
#[derive(Clone, Debug)]
pub(crate) struct Hierarchy<'a, T> {
    dims: Dims,
    /// The smallest first.
    levels: Box<[Level<'a, T>]>,
}

/// The macrocells of one size.
#[derive(Clone, Debug)]
pub(crate) struct Level<'a, T> {
    ranges: &'a [ValueRange<T>],
    blocks: [u32; 3],
    /// Cells along an edge, and the reciprocal.
    pub(crate) edge: f64,
    pub(crate) inverse: f64,
    /// Along an edge, macrocells of the level below, or cells.
    parts: u32,
    /// Of indices.
    pub(crate) strides: [Strides; 8],
}

impl<'a, T: Scalar> Level<'a, T> {
    fn new(level: &'a MacrocellLevel<T>, edge_below: u32) -> Self {
        let [nx, ny, _] = level.blocks().map(u64::from);
        Self {
            ranges: level.ranges(),
            blocks: level.blocks(),
            edge: level.edge().into(),
            inverse: 1.0 / f64::from(level.edge()),
            parts: level.edge() / edge_below,
            strides: strides([1, nx, nx * ny]),
        }
    }

    #[inline(always)]
    pub(crate) fn index(&self, number: [u32; 3]) -> u64 {
        let [x, y, z] = number.map(u64::from);
        let [nx, ny, _] = self.blocks.map(u64::from);
        x + nx * (y + ny * z)
    }

    #[inline(always)]
    pub(crate) fn range(&self, index: u64) -> Option<&'a ValueRange<T>> {
        self.ranges.get(index as usize)
    }

    /// The numbers of the first and of the last macrocell.
    #[inline(always)]
    pub(crate) fn all(&self) -> [f64x4; 2] {
        [f64x4::ZERO, floats(self.blocks.map(|n| n - 1))]
    }

    /// Those of the parts of macrocell `number`.
    #[inline(always)]
    pub(crate) fn parts(&self, number: f64x4) -> [f64x4; 2] {
        let first = number * f64x4::splat(self.parts.into());
        [first, first + f64x4::splat(f64::from(self.parts - 1))]
    }
}

impl<'a, T: Scalar> Hierarchy<'a, T> {
    pub(crate) fn new(dims: Dims, macrocells: &'a Macrocells<T>) -> Self {
        let mut below = 1;
        let level =
            |level: &'a MacrocellLevel<T>| Level::new(level, std::mem::replace(&mut below, level.edge()));
        Self { dims, levels: macrocells.levels().iter().map(level).collect() }
    }

    /// The levels, smallest macrocells first.
    #[inline(always)]
    pub(crate) fn levels(&self) -> &[Level<'a, T>] {
        &self.levels
    }

    /// The box around all macrocells of the lowest level that matter. `None` if there are none.
    pub(crate) fn region(&self, is_active: impl Fn(&ValueRange<T>) -> bool) -> Option<Region> {
        let number = self.levels.len().checked_sub(1)?;
        let mut grown = Grown { levels: &self.levels, is_active, low: [u32::MAX; 3], high: [0; 3] };
        grown.by_macrocells(number, [0; 3], self.levels[number].blocks);
        let last = self.dims.axes().map(|n| n - 1);
        let edge = self.levels[0].edge as u32;
        let low = grown.low.map(|c| c.saturating_mul(edge));
        let high: [u32; 3] = std::array::from_fn(|a| last[a].min(grown.high[a].saturating_mul(edge)));
        (0..3).all(|a| low[a] < high[a]).then(|| Region {
            low: floats(low),
            high: floats(high),
            last: floats(last),
        })
    }
}

/// The box around what has been found so far, in macrocells of the lowest level.
struct Grown<'l, 'a, T, A> {
    levels: &'l [Level<'a, T>],
    is_active: A,
    low: [u32; 3],
    high: [u32; 3],
}

impl<T: Scalar, A: Fn(&ValueRange<T>) -> bool> Grown<'_, '_, T, A> {
    /// By the macrocells of a level from `low` to before `high`. What lies in the box already is not looked at.
    fn by_macrocells(&mut self, number: usize, low: [u32; 3], high: [u32; 3]) {
        let levels = self.levels;
        let level = &levels[number];
        // So many of the lowest along an edge.
        let scale = levels[1..=number].iter().fold(1u32, |scale, level| scale.saturating_mul(level.parts));
        let [x, y, z] = std::array::from_fn(|a| low[a]..high[a].min(level.blocks[a]));
        let rows = z.flat_map(|z| y.clone().map(move |y| [y, z]));
        for place in rows.flat_map(|[y, z]| x.clone().map(move |x| [x, y, z])) {
            let from = place.map(|c| c.saturating_mul(scale));
            let to: [u32; 3] =
                std::array::from_fn(|a| from[a].saturating_add(scale).min(levels[0].blocks[a]));
            let is_known = (0..3).all(|a| from[a] >= self.low[a] && to[a] <= self.high[a]);
            if is_known || !level.range(level.index(place)).is_some_and(&self.is_active) {
                continue;
            }
            if number == 0 {
                self.low = std::array::from_fn(|a| self.low[a].min(from[a]));
                self.high = std::array::from_fn(|a| self.high[a].max(to[a]));
            } else {
                let first = place.map(|c| c * level.parts);
                self.by_macrocells(number - 1, first, first.map(|c| c + level.parts));
            }
        }
    }
}

/// As numbers to compute with; the fourth lane is idle.
#[inline(always)]
fn floats([x, y, z]: [u32; 3]) -> f64x4 {
    f64x4::new([x.into(), y.into(), z.into(), 0.0])
}
