//! Coarser cells where they are fine enough.
//!
//! The cut is made among patches, before there is a mesh: the field of what is left is as continuous as that of any mesh, and nothing that is not wanted costs memory, or time of rays.
//!
//! # The rule
//!
//! From the finest level to the coarsest but one, a box of cells is *left out* if the next coarser level is fine enough there and it is made of whole cells of that level. Below it lies what
//! that level has there, or, where it has nothing, what is made of the box: values at vertices stay those at the vertices that are left, values at cells become means. That may be left out
//! in its turn. Patches that are fine enough in part only are cut into boxes of [`PIECE`] cells along each axis. Small patches that fill a cell of the next coarser level
//! together, as the eight leaves of an octree that have one parent, are taken for one.
//!
//! What cells of a level and of finer ones fill is made of whole cells of the next coarser level in every mesh. It stays so: a box stays where a finer one does, or one of its
//! level that is not made of whole coarser cells, so that all others that share a coarser cell with what is left out are left out with it. Coarser levels fill what they filled
//! before: there is no gap.

use std::collections::BTreeMap;

use crate::bins::Bins;
use crate::cuboid::Cuboid;
use crate::error::MeshError;
use crate::levels::Levels;
use crate::overlap::left_of;
use crate::part::{Making, Part};
use crate::patches::Patches;

/// Cells along the edge of the boxes that patches are cut into: with fewer the cut would follow a distance more closely, and a mesh would have more boxes. A multiple of both ratios, so that
/// boxes are made of whole coarser cells.
const PIECE: u32 = 16;

impl Patches {
    /// Coarser ones wherever cells of a coarser level are fine enough. `is_fine_enough` tells that of a level, all over a box, which has its low and its high corner in coordinates of
    /// level 0; it should do so of all boxes in one of which it does, and of finer levels, else more stays than needs to.
    ///
    /// The lattice stays that of the whole, even if no patch of the finest level is left: places in a [`Mesh`](crate::Mesh), in index space and in the world, are the same. Patches that
    /// make a mesh make one afterwards. A patch all of which is finite stays over cells that are not.
    ///
    /// # Errors
    /// Patches that [`Mesh::new`](crate::Mesh::new) does not take each by itself: those of a wrong level or size, or out of the domain.
    pub fn coarsened(self, is_fine_enough: impl Fn(u32, [[f64; 3]; 2]) -> bool) -> Result<Self, MeshError> {
        let levels = Levels::new(&self)?;
        let making = Making { levels: &levels, centering: self.centering };
        let mut parts: Vec<Vec<Part>> = (0..levels.count()).map(|_| Vec::new()).collect();
        for (number, patch) in self.patches.into_iter().enumerate() {
            let place = levels.place(number, &patch, self.centering)?;
            parts[patch.level as usize].push(Part::new(place, patch, number));
        }
        let mut finer = Vec::new();
        for level in (1..levels.count()).rev() {
            let exponent = levels.exponent(level as u32 - 1);
            let own = std::mem::take(&mut parts[level]);
            let below = std::mem::take(&mut parts[level - 1]);
            let bins = Bins::new(below.iter().map(|part| part.place), exponent);
            let below = Below { making, parts: below, bins };
            let mut cut = Cut { making, level: level as u32, finer, below, is_fine_enough: &is_fine_enough };
            parts[level] = cut.kept(own);
            finer = cut.finer;
            finer.push(Bins::new(parts[level].iter().map(|part| part.place), exponent));
            parts[level - 1] = cut.below.parts;
        }
        let mut parts: Vec<Part> = parts.into_iter().flatten().collect();
        parts.sort_by_key(|part| part.number);
        let patches = parts.into_iter().map(|part| part.patch).collect();
        Ok(Self { patches, ..self })
    }
}

/// The level below the one that is cut.
struct Below<'l> {
    making: Making<'l>,
    parts: Vec<Part>,
    bins: Bins,
}

/// One level, as it is cut.
struct Cut<'l, F> {
    making: Making<'l>,
    level: u32,
    /// What stays of all finer levels; then also what of this one is not made of whole coarser cells.
    finer: Vec<Bins>,
    below: Below<'l>,
    is_fine_enough: &'l F,
}

impl Below<'_> {
    /// Whether it is finite in all of a box, as far as it is there.
    fn is_finite(&self, place: &Cuboid) -> bool {
        let mut parts = self.bins.over(place).into_iter();
        !parts.any(|number| self.making.is_empty_somewhere(&self.parts[number as usize], place))
    }

    /// Takes over a box of a part of the level above.
    fn take_over(&mut self, part: &Part, place: Cuboid) {
        let over = self.bins.over(&place);
        let left = left_of(place, over.into_iter().map(|number| self.parts[number as usize].place));
        for place in left {
            self.parts.push(self.making.restricted(part, place));
            self.bins.push(place);
        }
    }
}

impl<F: Fn(u32, [[f64; 3]; 2]) -> bool> Cut<'_, F> {
    /// What stays of the level.
    fn kept(&mut self, own: Vec<Part>) -> Vec<Part> {
        let coarser = self.making.levels.exponent(self.level - 1);
        let is_whole =
            |place: &Cuboid| (0..3).all(|a| (place.low[a] | place.high[a]) & ((1 << coarser) - 1) == 0);
        let (whole, others): (Vec<_>, Vec<_>) = own.into_iter().partition(|part| is_whole(&part.place));
        let (groups, mut kept) = self.groups(others, coarser);
        let obstacles = Bins::new(kept.iter().map(|part| part.place), coarser);
        self.finer.push(obstacles);
        for (place, parts) in groups {
            match self.making.joined(&parts, place).filter(|part| self.may_go(part, &place)) {
                Some(part) => self.below.take_over(&part, place),
                None => kept.extend(parts),
            }
        }
        for part in whole {
            let (mut stay, mut go) = (Vec::new(), Vec::new());
            self.divide(&part, part.place, &mut stay, &mut go);
            go.iter().for_each(|&place| self.below.take_over(&part, place));
            match go.is_empty() {
                true => kept.push(part),
                false => kept.extend(stay.into_iter().map(|place| self.making.within(&part, place))),
            }
        }
        self.finer.pop();
        kept
    }

    /// Those of `parts` that fill a cell of the next coarser level together, which would be fine enough; and all others.
    fn groups(&self, parts: Vec<Part>, coarser: u32) -> (Vec<(Cuboid, Vec<Part>)>, Vec<Part>) {
        let mut by_cell: BTreeMap<[u32; 3], Vec<Part>> = BTreeMap::new();
        let (mut groups, mut others) = (Vec::new(), Vec::new());
        for part in parts {
            let cell = part.place.low.map(|c| c >> coarser);
            match part.place.high.map(|c| (c - 1) >> coarser) == cell {
                true => by_cell.entry(cell).or_default().push(part),
                false => others.push(part),
            }
        }
        for (cell, parts) in by_cell {
            let place = Cuboid { low: cell.map(|c| c << coarser), high: cell.map(|c| (c + 1) << coarser) };
            let left = left_of(place, parts.iter().map(|part| part.place));
            match left.is_empty() && self.would_do(&place) {
                true => groups.push((place, parts)),
                false => others.extend(parts),
            }
        }
        (groups, others)
    }

    /// Whether the next coarser level is fine enough in a box.
    fn would_do(&self, place: &Cuboid) -> bool {
        let corners = [place.low, place.high].map(|p| self.making.levels.in_level_0(p));
        (self.is_fine_enough)(self.level - 1, corners)
    }

    /// Whether a box of a part, of whole coarser cells, may be left out.
    fn may_go(&self, part: &Part, place: &Cuboid) -> bool {
        self.would_do(place)
            && self.finer.iter().all(|bins| bins.over(place).is_empty())
            && (!part.is_finite || self.below.is_finite(place))
    }

    /// Which boxes of a part stay and which go.
    fn divide(&self, part: &Part, place: Cuboid, stay: &mut Vec<Cuboid>, go: &mut Vec<Cuboid>) {
        if self.may_go(part, &place) {
            go.push(place);
            return;
        }
        let before = [stay.len(), go.len()];
        for half in self.halves(&place) {
            self.divide(part, half, stay, go);
        }
        // All of it stays: in one.
        if go.len() == before[1] {
            stay.truncate(before[0]);
            stay.push(place);
        }
    }

    /// The parts of a box on both sides of a plane of the lattice of boxes, across its longest edge; none if there is no such plane.
    fn halves(&self, place: &Cuboid) -> Vec<Cuboid> {
        let piece = PIECE << self.making.levels.exponent(self.level);
        let edges = place.edges();
        let Some(axis) = (0..3).max_by_key(|&a| edges[a]) else { return Vec::new() };
        let plane = (place.low[axis] + edges[axis].div_ceil(2)).next_multiple_of(piece);
        let plane = if plane < place.high[axis] { plane } else { plane.saturating_sub(piece) };
        match plane > place.low[axis] && plane < place.high[axis] {
            true => place.split(axis, plane).to_vec(),
            false => Vec::new(),
        }
    }
}
