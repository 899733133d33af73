//! Patches made of others.

use crate::block::for_all;
use crate::cuboid::Cuboid;
use crate::levels::Levels;
use crate::overlap::index;
use crate::patches::{Centering, Patch};

/// A patch where it lies.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) place: Cuboid,
    pub(crate) patch: Patch,
    /// The number of the patch that it is, or is made of.
    pub(crate) number: usize,
    /// Whether all of its values are finite.
    pub(crate) is_finite: bool,
}

/// What patches have in common.
#[derive(Clone, Copy)]
pub(crate) struct Making<'l> {
    pub(crate) levels: &'l Levels,
    pub(crate) centering: Centering,
}

impl Part {
    pub(crate) fn new(place: Cuboid, patch: Patch, number: usize) -> Self {
        let is_finite = patch.values.iter().all(|value| value.is_finite());
        Self { place, patch, number, is_finite }
    }
}

impl Making<'_> {
    /// The value of the cell with its low corner at `p`, or of the vertex there.
    fn value(&self, part: &Part, p: [u32; 3]) -> f32 {
        part.patch.values[index(&part.patch, &part.place, p, self.levels, self.centering)]
    }

    /// A part of `level`; `value` is told the low corners of its cells, or its vertices.
    fn part(&self, level: u32, place: Cuboid, number: usize, value: impl Fn([u32; 3]) -> f32) -> Part {
        let exponent = self.levels.exponent(level);
        // Of the domain, the numbers of which are `i32`.
        let low = self.levels.numbered(level, place.low).map(|c| c as i32);
        let cells = place.edges().map(|n| n >> exponent);
        let mut patch = Patch { level, low, cells, values: Vec::new().into() };
        let mut values = Vec::new();
        for_all(patch.value_dims(self.centering), |at| {
            values.push(value(std::array::from_fn(|a| place.low[a] + (at[a] << exponent))));
        });
        patch.values = values.into();
        Part::new(place, patch, number)
    }

    /// What a part has in a box of whole cells of it.
    pub(crate) fn within(&self, part: &Part, place: Cuboid) -> Part {
        self.part(part.patch.level, place, part.number, |p| self.value(part, p))
    }

    /// Parts of a level that fill a box, as one.
    pub(crate) fn joined(&self, parts: &[Part], place: Cuboid) -> Option<Part> {
        let first = parts.first()?;
        let has = |part: &Part, p: [u32; 3]| {
            (0..3).all(|a| {
                let is_last = self.centering == Centering::Vertices && p[a] == part.place.high[a];
                part.place.low[a] <= p[a] && p[a] < part.place.high[a] || is_last
            })
        };
        let value = |p| parts.iter().find(|part| has(part, p)).map_or(f32::NAN, |part| self.value(part, p));
        Some(self.part(first.patch.level, place, first.number, value))
    }

    /// What a part has in a box of whole cells of the next coarser level, in those cells: the values at their vertices as they are, and of cells the means of those that are finite.
    pub(crate) fn restricted(&self, part: &Part, place: Cuboid) -> Part {
        let level = part.patch.level;
        let exponent = self.levels.exponent(level);
        let ratio = 1 << (self.levels.exponent(level - 1) - exponent);
        let mean = |p: [u32; 3]| {
            let (mut sum, mut count) = (0.0, 0);
            for_all([ratio; 3], |at| {
                let value = self.value(part, std::array::from_fn(|a| p[a] + (at[a] << exponent)));
                if value.is_finite() {
                    sum += f64::from(value);
                    count += 1;
                }
            });
            (sum / f64::from(count)) as f32
        };
        match self.centering {
            Centering::Vertices => self.part(level - 1, place, part.number, |p| self.value(part, p)),
            Centering::Cells => self.part(level - 1, place, part.number, mean),
        }
    }

    /// Whether some value that a part has in a box is not finite.
    pub(crate) fn is_empty_somewhere(&self, part: &Part, place: &Cuboid) -> bool {
        let Some(common) = part.place.common(place).filter(|_| !part.is_finite) else { return false };
        !self.within(part, common).is_finite
    }
}
