//! The field of a picture with levels of detail: what its samples are.
//!
//! Cells of different levels meet without a gap if they see the same values on their common faces. Every sample `p` takes its value from the coarsest
//! level of all cells that touch it, by a corner alone included: on that level's lattice it is its coarse sample, elsewhere the trilinear interpolant of the
//! corners of the cell of that level in whose closure it lies, each of which is resolved likewise first (and touches no finer levels than that). So all cells at
//! a sample see one value, and what a finer cell interpolates on a face that it shares with a coarser one is that one's bilinear function of the face: the field is
//! continuous, whatever the mix of levels.
//!
//! # The last cells
//!
//! Where `n − 1` is no multiple of `2^l`, the last cell along an axis is shorter. It is given as a whole cell with corners extrapolated along that axis, whose interpolant
//! is that of the short cell in the domain; rays end at its border. An extrapolated corner is rounded by `2⁻²⁴` of itself, which in the domain counts by its weight, the
//! cell's length over `2^l`: off by no more than half an ulp of the corners' largest difference.

use isoray_grid::Scalar;

use super::around::{Around, class, of_next, take_next};
use super::detail::{Detail, PartsDetail};
use super::frame::Frame;
use super::{has_cells, is_averaged};
use crate::fidelity::Coarse;
use crate::geometry::{CAP_EDGE, CAP_LEVEL, CAP_SAMPLES, MAX_LEVELS, NODE_LEVEL, octant_of};
use crate::view::OctreeView;
use crate::{Node, Range, coarse_dims};

/// Samples of a block along each axis, those at its upper faces included.
pub const BLOCK_EDGE: usize = CAP_EDGE as usize + 1;
/// In all.
pub const BLOCK_SAMPLES: usize = BLOCK_EDGE * BLOCK_EDGE * BLOCK_EDGE;

/// By direction: the octants of a block there, as bits, that hold samples at the upper faces of this one.
pub const REACHED: [u32; 8] = {
    let mut reached = [0; 8];
    let mut n = 0;
    while n < 64 {
        if (n / 8) & (n % 8) == 0 {
            reached[n / 8] |= 1 << (n % 8);
        }
        n += 1;
    }
    reached
};

/// A volume as one picture sees it.
#[derive(Clone, Debug)]
pub struct DetailView<'a, T: Scalar> {
    view: OctreeView<'a, T>,
    kind: Coarse,
    detail: Detail,
    /// By level.
    lattices: Vec<OctreeView<'a, T>>,
}

/// A block of a level, ready to be intersected.
#[derive(Clone, Copy, Debug)]
pub struct DetailBlock {
    /// `x + 5y + 25z`.
    pub samples: [f32; BLOCK_SAMPLES],
    /// Bit `x + 4y + 16z`: the cell touches one of another level.
    pub joints: u64,
    /// Bit likewise: the cell is cut short by the border of the domain.
    pub short: u64,
}

impl<'a, T: Scalar> DetailView<'a, T> {
    /// Of the volume behind `view`, whose coarse samples are of `kind`.
    ///
    /// # Panics
    /// If coarse levels may be drawn and there are none ([`Coarse::None`]), or `detail` is another volume's.
    pub fn new(view: &OctreeView<'a, T>, kind: Coarse, detail: Detail) -> Self {
        assert!(detail.coarsest() == 0 || kind != Coarse::None, "there are no coarse samples");
        assert_eq!(detail.dims(), view.dims(), "made for a volume of another size");
        let lattices = (0..=detail.coarsest()).map(|level| view.above(level)).collect();
        Self { view: *view, kind, detail, lattices }
    }

    /// The volume.
    pub fn volume(&self) -> &OctreeView<'a, T> {
        &self.view
    }

    /// Which level is where.
    pub fn detail(&self) -> &Detail {
        &self.detail
    }

    /// The nodes above the lattice of `level`, one of those drawn: ranges, and no samples.
    pub fn lattice(&self, level: u32) -> &OctreeView<'a, T> {
        &self.lattices[level as usize]
    }

    /// The upper corner of the domain, on the lattice of `level`: the last cells may be cut short.
    pub fn last(&self, level: u32) -> [f64; 3] {
        self.view.dims().axes().map(|n| f64::from(n - 1) / (1u64 << level) as f64)
    }

    /// The value at sample `p`, slowly.
    pub fn vertex(&self, p: [u32; 3]) -> f32 {
        self.at_level(self.detail.touching(p), p)
    }

    /// The value at `p`, which touches cells of `level` and of no coarser one.
    fn at_level(&self, level: u32, p: [u32; 3]) -> f32 {
        match self.is_on_lattice(level, p) {
            true => self.sample(level, p),
            false => self.in_cell(level, p, |q| self.vertex(q)),
        }
    }

    /// The interpolant, at `p`, of the cell of `level` in whose closure it lies; `value` is asked for the cell's corners that count.
    fn in_cell(&self, level: u32, p: [u32; 3], value: impl Fn([u32; 3]) -> f32) -> f32 {
        let step = 1u32 << level;
        let last = self.view.dims().axes().map(|n| n - 1);
        // Along an axis on whose planes it lies, it is the plane's value alone.
        let low: [u32; 3] = std::array::from_fn(|a| if p[a] == last[a] { p[a] } else { p[a] & !(step - 1) });
        let high: [u32; 3] =
            std::array::from_fn(|a| if low[a] == p[a] { p[a] } else { (low[a] + step).min(last[a]) });
        let share = |a: usize| f64::from(p[a] - low[a]) / f64::from((high[a] - low[a]).max(1));
        let corner = |n: usize| std::array::from_fn(|a| if n >> a & 1 == 1 { high[a] } else { low[a] });
        trilinear(|n| value(corner(n)), [0, 1, 2].map(share))
    }

    /// The sample of the lattice of `level` at `p`, which is on it, on its way to the next level's value.
    fn sample(&self, level: u32, p: [u32; 3]) -> f32 {
        let own = self.view.coarse(level, p, self.kind).to_f32();
        match self.detail.share_of_next(level, p) {
            0.0 => own,
            share => {
                let next = |q| self.view.coarse(level + 1, q, self.kind).to_f32();
                blended(own, self.in_cell(level + 1, p, next), share)
            }
        }
    }

    /// Gets samples of the lattice of `level` from `corner` on, of those 4³ that are in the domain; `corner` counts samples of that lattice, and is a multiple of 4. Of these, those in
    /// the `octants` given, as bits, are needed; the octants are returned that are there then. They are looked for below `from`, a node around all of them and its level; by default, the
    /// root.
    pub fn plain(
        &self,
        level: u32,
        corner: [u32; 3],
        octants: u32,
        from: Option<(&'a Node<T::Stored>, u32)>,
        samples: &mut [T; CAP_SAMPLES],
    ) -> u32 {
        const ALL: u32 = 0xff;
        let origin = corner.map(|c| c << level);
        if !self.view.dims().contains(origin) {
            return ALL;
        }
        if level == 0 {
            let block = match from {
                Some((node, above)) => self.view.descend(node, above, origin),
                None => self.view.locate(origin),
            };
            *samples = block.samples();
            return ALL;
        }
        if level < CAP_LEVEL && is_averaged(self.kind) {
            *samples = super::cube::half(&self.view, origin, self.kind);
            return ALL;
        }
        let block = match self.below(from, origin, level + CAP_LEVEL) {
            Ok(node) => node,
            Err(value) => {
                samples.fill(value);
                return ALL;
            }
        };
        for octant in (0..8).filter(|octant| octants >> octant & 1 == 1) {
            match level {
                1 => {
                    let values = self.view.block(block, origin, octant).every_other();
                    each_of_octant(octant, |n, at| samples[at] = values[n]);
                }
                _ => {
                    let is_stored = block.is_stored(octant);
                    let below = || self.view.nodes(level + 1).get(block.child(octant));
                    let values = match is_stored.then(below).flatten() {
                        Some(child) => child.values.map(Into::into),
                        None => [block.value(octant); 8],
                    };
                    each_of_octant(octant, |n, at| samples[at] = values[n]);
                }
            }
        }
        octants
    }

    /// The node of `level` at `origin`, below one and its level or the root; or the value of the scalar leaf in which that lies.
    fn below(
        &self,
        from: Option<(&'a Node<T::Stored>, u32)>,
        origin: [u32; 3],
        level: u32,
    ) -> Result<&'a Node<T::Stored>, T> {
        let root = || self.view.root().map(|root| (root, self.view.root_level()));
        let (mut node, mut above) = from.or_else(root).ok_or_else(T::default)?;
        while above > level {
            let octant = octant_of(origin, above);
            if !node.is_stored(octant) {
                return Err(node.value(octant));
            }
            above -= 1;
            node = self.view.nodes(above).get(node.child(octant)).ok_or_else(T::default)?;
        }
        Ok(node)
    }

    /// The block of `level` at `corner`, in samples of its lattice, from the plain samples of it and of the seven above it, in the order of octants; those that are not in the domain do
    /// not matter.
    pub fn block(&self, level: u32, corner: [u32; 3], plain: &[&[T; CAP_SAMPLES]; 8]) -> DetailBlock {
        let frame = Frame::new(self.view.dims(), level, corner);
        let mut block = DetailBlock { samples: joined(plain), joints: 0, short: frame.short };
        let at = |p| self.view.coarse(level, p, self.kind).to_f32();
        frame.take_border(at, &mut block.samples);
        let plain = block.samples;
        let origin = corner.map(|c| c << level);
        // Where samples have values of coarser levels.
        let mut coarser = 0;
        let is_simple = self.kind == Coarse::Injected && frame.beyond == [None; 3];
        if !self.detail.is_amid(level, origin) {
            let around = Around::new(&self.detail, level, corner, frame.last);
            block.joints = around.joints();
            let is_next_plain = self.detail.is_unblended(level + 1, origin, level + CAP_LEVEL);
            if is_simple && is_next_plain && !around.is_steep {
                coarser = around.reached();
                take_next(coarser, &mut block.samples);
            } else {
                let around = frame.levels_around(&self.detail);
                let coarsest = reaching(around.map(|other| other.unwrap_or(level)));
                coarser = (0..27).filter(|&n| coarsest[n] != level).fold(0, |all, n| all | 1 << n);
                self.resolve(&frame, &coarsest, &mut block.samples);
            }
        }
        if !self.detail.is_unblended(level, origin, level + CAP_LEVEL) {
            let next = if is_simple { of_next(&plain) } else { self.next_in_block(&frame, &plain) };
            each_sample(|n, index| {
                let share = self.detail.share_of_next(level, frame.place(index));
                if share > 0.0 && coarser >> class(index, BLOCK_EDGE - 1) & 1 == 0 {
                    block.samples[n] = blended(block.samples[n], next[n], share);
                }
            });
        }
        frame.extend(&mut block.samples);
        block
    }

    /// The same, fetching what it takes.
    pub fn block_alone(&self, level: u32, corner: [u32; 3]) -> DetailBlock {
        let mut plain = [[T::default(); CAP_SAMPLES]; 8];
        for (n, samples) in plain.iter_mut().enumerate() {
            let at = [0, 1, 2].map(|a| corner[a] + (n as u32 >> a & 1) * CAP_EDGE);
            self.plain(level, at, REACHED[n], None, samples);
        }
        self.block(level, corner, &plain.each_ref())
    }

    /// The interpolant of the next level's cells at the samples of a block.
    fn next_in_block(&self, frame: &Frame, plain: &[f32; BLOCK_SAMPLES]) -> [f32; BLOCK_SAMPLES] {
        let mut lattice = *plain;
        if is_averaged(self.kind) {
            each_sample(|n, index| {
                let p = frame.place(index);
                if self.is_on_lattice(frame.level + 1, p) {
                    lattice[n] = self.view.coarse(frame.level + 1, p, self.kind).to_f32();
                }
            });
        }
        let mut next = lattice;
        each_sample(|n, index| {
            next[n] = self.in_cell(frame.level + 1, frame.place(index), |q| lattice[frame.number(q)]);
        });
        next
    }

    /// Gives samples the values of the coarser levels that they touch, told by direction: the same as [`vertex`](Self::vertex).
    fn resolve(&self, frame: &Frame, coarsest: &[u32; 27], samples: &mut [f32; BLOCK_SAMPLES]) {
        let own = frame.level;
        let top = coarsest.iter().fold(own, |top, &other| top.max(other));
        // What a sample is interpolated from touches levels that are as coarse, and is on their lattice if they are no coarser.
        for level in (own + 1..=top).rev() {
            let each = |of: &mut dyn FnMut(usize, [usize; 3])| {
                each_sample(|n, index| {
                    if coarsest[class(index, BLOCK_EDGE - 1)] == level {
                        of(n, index);
                    }
                });
            };
            each(&mut |n, index| {
                let p = frame.place(index);
                let is_plain = self.kind == Coarse::Injected && self.detail.share_of_next(level, p) == 0.0;
                if !is_plain && self.is_on_lattice(level, p) {
                    samples[n] = self.sample(level, p);
                }
            });
            each(&mut |n, index| {
                let p = frame.place(index);
                if self.is_on_lattice(level, p) {
                    return;
                }
                samples[n] = match level - own <= CAP_LEVEL {
                    true => self.in_cell(level, p, |q| samples[frame.number(q)]),
                    // Its cells are larger than the block.
                    false => self.at_level(level, p),
                };
            });
        }
    }

    fn is_on_lattice(&self, level: u32, p: [u32; 3]) -> bool {
        let n = self.view.dims().axes();
        (0..3).all(|a| p[a] & ((1 << level) - 1) == 0 || p[a] + 1 == n[a])
    }

    /// What the 4³ parts of edge `2^part` of the cube at `corner` have of `level`, by bit `x + 4y + 16z`, if by their ranges those `active` matter: the parts that do. Those of which
    /// it takes [`can_hold`](Self::can_hold) to tell are among them.
    pub fn parts(&self, level: u32, corner: [u32; 3], part: u32, active: u64) -> u64 {
        let are_faces_told = self.are_faces_told();
        let is_told = are_faces_told || self.are_bounded(level, part, corner, part + CAP_LEVEL);
        let last = self.view.dims().axes().map(|n| n - 1);
        let is_in_domain = |n: u32| (0..3).all(|a| corner[a] + ((n >> (2 * a) & 3) << part) < last[a]);
        // A leaf that the border cuts has one range for all its parts.
        let domain = match is_in_domain(63) {
            true => u64::MAX,
            false => (0..64).filter(|&n| is_in_domain(n)).fold(0, |parts, n| parts | 1u64 << n),
        };
        if is_told && self.detail.is_all(level, corner, part + CAP_LEVEL) {
            return active & domain;
        }
        let PartsDetail { there, see_coarser } = self.detail.parts(level, corner, part);
        let others = match (are_faces_told, is_told) {
            (true, _) => 0,
            (false, true) => see_coarser,
            (false, false) => u64::MAX,
        };
        there & domain & (active | others)
    }

    /// Whether the samples of the block of `level` at `corner` are those of the lattice as they are, and so are those of all around it.
    pub fn is_plain(&self, level: u32, corner: [u32; 3]) -> bool {
        let origin = corner.map(|c| c << level);
        self.detail.is_amid(level, origin) && self.detail.is_unblended(level, origin, level + CAP_LEVEL)
    }

    /// Whether the block of `level` at `corner`, in samples of its lattice, is drawn, and whether ranges of regions of its size bound its values.
    pub fn state(&self, level: u32, corner: [u32; 3]) -> [bool; 2] {
        let origin = corner.map(|c| c << level);
        let block = level + CAP_LEVEL;
        let is_told = self.are_faces_told()
            || self.are_bounded(level, block, origin, block)
                && !self.detail.sees_coarser(level, origin, block);
        // Whatever ranges say of what lies beyond.
        [has_cells(&self.view, origin) && self.detail.level(origin) == level, is_told]
    }

    /// Whether a block's own samples bound all its values, also those that it shares with coarser levels: all cells that it touches have corners among them.
    fn are_faces_told(&self) -> bool {
        self.kind == Coarse::Injected && self.detail.is_gradual()
    }

    /// Whether the ranges of regions of edge `2^region` bound the values of cells of `level` in the cube of edge `2^cube` at `corner`, as far as they touch no coarser ones.
    fn are_bounded(&self, level: u32, region: u32, corner: [u32; 3], cube: u32) -> bool {
        // Those of edge 4 tell nothing about coarse samples.
        region >= NODE_LEVEL || !is_averaged(self.kind) || self.detail.is_unblended(level, corner, cube)
    }

    /// Whether any cell of the block of `level` at `corner`, in samples of its lattice, may hold one of some isovalues, by the ranges in and around it: values of coarser levels that it
    /// touches are told too.
    pub fn can_hold(&self, level: u32, corner: [u32; 3], is_held: impl Fn(Range<T>) -> bool) -> bool {
        let frame = Frame::new(self.view.dims(), level, corner);
        let is_near = self.detail.levels().end() - level <= CAP_LEVEL;
        // Ranges of regions of edge 4 tell nothing about coarse samples.
        let regions = (level + CAP_LEVEL).max(NODE_LEVEL);
        let mut range = Range::EMPTY;
        // Of regions so large that there are eight of them at most; then of those of the block's size.
        let large = regions + CAP_LEVEL;
        if is_near && large < self.view.root_level() {
            let edge = i64::from(CAP_EDGE) << level;
            for n in 0..8usize {
                let cell = std::array::from_fn(|a| {
                    let step = if n >> a & 1 == 1 { edge } else { -edge };
                    let at = (i64::from(corner[a]) << level) + step;
                    at.clamp(0, i64::from(frame.last[a]) - 1) as u32
                });
                range = range.union(self.view.range_of_region(large, cell));
            }
            if !is_held(range) {
                return false;
            }
            range = Range::EMPTY;
        }
        for n in 0..27 {
            let Some(cell) = frame.cell_towards(n) else { continue };
            if !is_near && self.detail.level(cell) > level + CAP_LEVEL {
                return true;
            }
            range = range.union(self.view.range_of_region(regions, cell));
            if is_held(range) {
                return true;
            }
        }
        false
    }
}

impl<'a, T: Scalar> OctreeView<'a, T> {
    /// The nodes above the lattice of `level`, one that leaves a root above it, as those of a volume of that lattice. Ranges are what they were; there are no samples above
    /// level 0.
    fn above(&self, level: u32) -> Self {
        if level == 0 {
            return *self;
        }
        let mut levels: [&[Node<T::Stored>]; MAX_LEVELS] = [&[]; MAX_LEVELS];
        let kept = self.levels.iter().skip(level as usize);
        levels.iter_mut().zip(kept).for_each(|(slot, &nodes)| *slot = nodes);
        let dims = isoray_grid::Dims::new(coarse_dims(self.dims, level)).unwrap_or(self.dims);
        Self { dims, root_level: self.root_level - level, levels, caps: &[] }
    }
}

/// The samples of a block and those at its upper faces, from those of it and of the seven above it.
fn joined<T: Scalar>(plain: &[&[T; CAP_SAMPLES]; 8]) -> [f32; BLOCK_SAMPLES] {
    const EDGE: usize = CAP_EDGE as usize;
    let mut samples = [0.0; BLOCK_SAMPLES];
    for z in 0..BLOCK_EDGE {
        for y in 0..BLOCK_EDGE {
            let octant = (y / EDGE) << 1 | (z / EDGE) << 2;
            let first = y % EDGE * EDGE + z % EDGE * EDGE * EDGE;
            let row = &mut samples[BLOCK_EDGE * (y + BLOCK_EDGE * z)..][..BLOCK_EDGE];
            for x in 0..EDGE {
                row[x] = plain[octant][first + x].to_f32();
            }
            row[EDGE] = plain[octant | 1][first].to_f32();
        }
    }
    samples
}

/// Calls `of` with the number and the indices of every sample of a block.
pub(super) fn each_sample(mut of: impl FnMut(usize, [usize; 3])) {
    for n in 0..BLOCK_SAMPLES {
        of(n, [n % BLOCK_EDGE, n / BLOCK_EDGE % BLOCK_EDGE, n / (BLOCK_EDGE * BLOCK_EDGE)]);
    }
}

/// By the number of an octant: of its first sample among 4³, if they are one apart.
fn spread(octant: usize) -> usize {
    octant & 1 | (octant & 2) << 1 | (octant & 4) << 2
}

/// Calls `of` with the eight numbers in octant `octant` of 4³ samples, and those among all of them.
fn each_of_octant(octant: u32, mut of: impl FnMut(usize, usize)) {
    for n in 0..8 {
        of(n, (2 * spread(octant as usize & 7) + spread(n)) % CAP_SAMPLES);
    }
}

/// Between two values; NaN unless both are finite.
fn blended(own: f32, next: f32, share: f64) -> f32 {
    if !(own.is_finite() && next.is_finite()) {
        return f32::NAN;
    }
    let (from, to) = (f64::from(own), f64::from(next));
    let value = from + share * (to - from);
    (value as f32).clamp(own.min(next), own.max(next))
}

/// Between eight corners, x fastest; those without weight are not asked for. No value lies beyond the corners, so that where they are all on one side of an
/// isovalue, it is too. NaN if a corner that counts is not finite.
fn trilinear(corner: impl Fn(usize) -> f32, shares: [f64; 3]) -> f32 {
    let needed = (0..3).filter(|&a| shares[a] != 0.0).fold(0, |axes, a| axes | 1usize << a);
    let mut values = [0.0; 8];
    let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
    for n in (0..8).filter(|n| n & !needed == 0) {
        let value = corner(n);
        if !value.is_finite() {
            return f32::NAN;
        }
        values[n] = f64::from(value);
        (least, most) = (least.min(value), most.max(value));
    }
    for a in (0..3).filter(|a| needed >> a & 1 == 1) {
        for n in (0..8).filter(|n| n >> a & 1 == 0 && n & !needed == 0) {
            values[n] += shares[a] * (values[n | 1 << a] - values[n]);
        }
    }
    (values[0] as f32).clamp(least, most)
}

/// By direction: all together of what lies in it and in the directions that it is made of.
fn reaching(around: [u32; 27]) -> [u32; 27] {
    let mut all = around;
    for stride in [1, 3, 9] {
        for n in (0..27).filter(|n| n / stride % 3 != 1) {
            let middle = n + stride - n / stride % 3 * stride;
            all[n] = all[n].max(all[middle]);
        }
    }
    all
}
