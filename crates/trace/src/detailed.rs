//! The blocks of a level of detail.
//!
//! The lattice of a level is traversed as a volume of its own, with rays that are scaled by a power of two, exactly: its blocks and cells are those of any volume, and so
//! is all that goes through them. Blocks that are drawn at another level are found to hold nothing.

use isoray_grid::Scalar;
use isoray_octree::lod::{BLOCK_EDGE, BLOCK_SAMPLES, DetailBlock, DetailView, REACHED};
use isoray_octree::{CAP_EDGE, CAP_SAMPLES, Node, OctreeView, Range};
use wide::{f32x16, f64x4};

use crate::blocks::Way;
use crate::branch::{BLOCK_LEVEL, STEP};
use crate::content::{Beyond, Content, Finest};
use crate::corner::{Corner, Facing, Key};
use crate::offset::mirror;
use crate::ray::ClippedRay;
use crate::region::Region;
use crate::stretch::Crossings;
use crate::thresholds::Thresholds;

/// Blocks that are remembered, those of a window of 4 by 16 by 16: half a MB, and their plain samples 64 to 256 KB; see [`Corner::block_slot`].
const SLOTS: usize = 1024;

/// A block as its cells are intersected.
#[derive(Clone, Copy, Debug)]
struct KnownBlock {
    key: Key,
    /// The cells that hold an isovalue, in the order of the rays that it is kept for.
    mixed: u64,
    /// Of the finest level, and as the volume has it: left to what knows all of it.
    is_finest: bool,
    block: DetailBlock,
}

/// A node of the volume, and its level.
type Above<'a, T> = (&'a Node<<T as Scalar>::Stored>, u32);

/// The samples of a block as the volume has them.
#[derive(Clone, Copy, Debug)]
struct PlainBlock<T> {
    corner: Corner,
    /// Which octants of them are there, as bits.
    octants: u32,
    samples: [T; CAP_SAMPLES],
}

/// What is drawn of a volume at one level.
#[derive(Clone, Debug)]
pub struct Detailed<'a, T: Scalar> {
    view: &'a DetailView<'a, T>,
    level: u32,
    isovalues: Vec<f32>,
    /// At the finest level.
    finest: Option<Box<Finest<'a, T>>>,
    blocks: Box<[KnownBlock]>,
    plain: Box<[PlainBlock<T>]>,
}

impl<'a, T: Scalar> Detailed<'a, T> {
    pub(crate) fn new(view: &'a DetailView<'a, T>, level: u32) -> Self {
        let block = DetailBlock { samples: [0.0; BLOCK_SAMPLES], joints: 0, short: 0 };
        let plain = PlainBlock { corner: Corner::NONE, octants: 0, samples: [T::default(); CAP_SAMPLES] };
        Self {
            view,
            level,
            isovalues: Vec::new(),
            finest: (level == 0).then(|| Box::new(Finest::new())),
            blocks: vec![KnownBlock { key: Key::NONE, mixed: 0, is_finest: false, block }; SLOTS]
                .into_boxed_slice(),
            plain: vec![plain; SLOTS].into_boxed_slice(),
        }
    }

    /// On the finest lattice.
    fn origin(&self, corner: Corner) -> [u32; 3] {
        corner.coordinates().map(|c| c << self.level)
    }

    fn block(&self, corner: Corner) -> &KnownBlock {
        &self.blocks[corner.block_slot() % SLOTS]
    }

    /// The samples at the corners of a cell of this lattice that is drawn, x fastest.
    pub(crate) fn cell(&mut self, cell: [u32; 3]) -> [f32; 8] {
        let corner = Corner::new(cell).around(BLOCK_LEVEL);
        if self.level == 0 && self.view.is_plain(0, corner.coordinates()) {
            return self.view.volume().corners(cell).map(T::to_f32);
        }
        let key = Key::new(corner, BLOCK_LEVEL, self.block(corner).key.facing());
        if self.block(corner).key != key {
            self.find(corner, key, |_| None);
        }
        corners(&self.block(corner).block, Corner::new(cell).offset(0))
    }

    #[inline(never)]
    fn turn_to(&mut self, key: Key, way: &Way<'_, 'a, T>) {
        let (corner, lower) = (way.corner, self.level);
        let known = &mut self.blocks[corner.block_slot() % SLOTS];
        if known.key.is_of_same_cube(key) {
            known.mixed = key.facing().ordered(known.key.facing().ordered(known.mixed));
            known.key = key;
        } else {
            // The levels of the lattice are so much lower than those of nodes.
            self.find(corner, key, |corner| way.node(corner).map(|(node, level)| (node, level + lower)));
        }
    }

    /// Finds out about a block; `above` gives a node above the block at a corner.
    fn find(&mut self, corner: Corner, key: Key, above: impl Fn(Corner) -> Option<Above<'a, T>>) {
        let slot = corner.block_slot() % SLOTS;
        if self.level == 0 && self.view.is_plain(0, corner.coordinates()) {
            (self.blocks[slot].key, self.blocks[slot].is_finest) = (key, true);
            return;
        }
        let [is_drawn, is_told] = self.view.state(self.level, corner.coordinates());
        let can_hold = || {
            let is_held = |range: Range<T>| self.isovalues.iter().any(|&v| range.straddles(v));
            self.view.can_hold(self.level, corner.coordinates(), is_held)
        };
        if !is_drawn || (!is_told && !can_hold()) {
            let known = &mut self.blocks[slot];
            (known.key, known.is_finest, known.mixed) = (key, false, 0);
            return;
        }
        let around: [Corner; 8] = std::array::from_fn(|octant| corner.neighbor(octant as u32, BLOCK_LEVEL));
        around.iter().zip(REACHED).for_each(|(&block, octants)| self.fetch(block, octants, above(block)));
        // Eight neighbours do not displace each other.
        let plain = around.each_ref().map(|block| &self.plain[block.block_slot() % SLOTS].samples);
        let block = self.view.block(self.level, corner.coordinates(), &plain);
        let mixed = key.facing().ordered(mixed(&block.samples, &self.isovalues));
        self.blocks[slot] = KnownBlock { key, mixed, is_finest: false, block };
    }

    /// The sample of the lattice at `p`, in the domain, whichever level is drawn there.
    pub(crate) fn sample(&mut self, p: [u32; 3]) -> f32 {
        let corner = Corner::new(p);
        let block = corner.around(BLOCK_LEVEL);
        self.fetch(block, 0xff, None);
        self.plain[block.block_slot() % SLOTS].samples[corner.offset(0) as usize].to_f32()
    }

    /// Gets the plain samples of octants of a block, unless they are there.
    fn fetch(&mut self, corner: Corner, octants: u32, above: Option<Above<'a, T>>) {
        let plain = &mut self.plain[corner.block_slot() % SLOTS];
        if plain.corner != corner {
            (plain.corner, plain.octants) = (corner, 0);
        }
        let missing = octants & !plain.octants;
        if missing != 0 {
            let (corner, samples) = (corner.coordinates(), &mut plain.samples);
            plain.octants |= self.view.plain(self.level, corner, missing, above, samples);
        }
    }

    /// The cell of the finest lattice in which the ray, of this lattice, is just before `t` or just behind.
    fn finest_cell(&self, ray: &ClippedRay, t: f64, is_behind: bool) -> [u32; 3] {
        let width = (1u64 << self.level) as f64;
        let at = f64x4::splat(t).mul_add(ray.direction, ray.origin) * f64x4::splat(width);
        let last = self.view.volume().dims().axes();
        let mut cell: [f64; 3] = std::array::from_fn(|a| {
            at.to_array()[a].floor().clamp(0.0, f64::from(last[a].saturating_sub(2)))
        });
        let planes = |cell: [f64; 3]| {
            let [x, y, z] = cell;
            [0.0, 1.0].map(|side| {
                let planes = (f64x4::new([x, y, z, 0.0]) + f64x4::splat(side)) * f64x4::splat(1.0 / width);
                ray.crossings(planes).to_array()
            })
        };
        let step = ray.step.to_array();
        let direction = ray.direction.to_array();
        // The estimate is off by one at most.
        for _ in 0..2 {
            let [low, high] = planes(cell);
            for a in (0..3).filter(|&a| direction[a] != 0.0) {
                let (enters, leaves) = if step[a] > 0.0 { (low[a], high[a]) } else { (high[a], low[a]) };
                let is_beyond = if is_behind { t >= leaves } else { t > leaves };
                let is_before = if is_behind { t < enters } else { t <= enters };
                cell[a] += if is_beyond {
                    step[a]
                } else if is_before {
                    -step[a]
                } else {
                    0.0
                };
            }
        }
        std::array::from_fn(|a| (cell[a].max(0.0) as u32).min(last[a].saturating_sub(2)))
    }

    /// The ray's stretch just before `t` or just behind, if it is at another level.
    #[cold]
    fn across(&self, ray: &ClippedRay, t: f64, is_behind: bool) -> Option<Beyond> {
        let cell = self.finest_cell(ray, t, is_behind);
        let level = self.view.detail().level(cell);
        if level == self.level {
            return None;
        }
        let cell = Corner::new(cell.map(|c| c >> level));
        let corner = cell.around(BLOCK_LEVEL);
        let offset = cell.offset(0);
        let samples = corners(&self.view.block_alone(level, corner.coordinates()), offset);
        let scale = (1u64 << self.level) as f64 / (1u64 << level) as f64;
        let ray = ray.scaled(scale, planes(self.view.last(level)));
        let stretch = Crossings::new(&ray, corner).stretch(&ray, offset ^ mirror(ray.backward), offset);
        let is_there = !stretch.is_empty() && samples.iter().all(|s| s.is_finite());
        is_there.then(|| Beyond { samples, segment: stretch.segment(&ray) })
    }
}

fn planes([x, y, z]: [f64; 3]) -> f64x4 {
    f64x4::new([x, y, z, 0.0])
}

/// Of the cell at `offset`.
#[inline(always)]
fn corners(block: &DetailBlock, offset: u32) -> [f32; 8] {
    let at = |a: u32| (offset >> (2 * a) & 3) as usize;
    let first = at(0) + BLOCK_EDGE * (at(1) + BLOCK_EDGE * at(2));
    std::array::from_fn(|n| {
        let step = (n & 1) + BLOCK_EDGE * ((n >> 1 & 1) + BLOCK_EDGE * (n >> 2));
        block.samples[(first + step) % BLOCK_SAMPLES]
    })
}

/// The cells whose corners lie on both sides of any of the isovalues, in the order of the lattice.
fn mixed(samples: &[f32; BLOCK_SAMPLES], isovalues: &[f32]) -> u64 {
    const LAYER: usize = BLOCK_EDGE * BLOCK_EDGE;
    let mut mixed = 0;
    for &isovalue in isovalues {
        // Bit `x + 5y` of a layer: inside.
        let layers: [u32; BLOCK_EDGE] = std::array::from_fn(|z| {
            let layer = &samples[LAYER * z..][..LAYER];
            let inside = |first: usize| {
                let some = std::array::from_fn(|n| layer[first + n]);
                f32x16::new(some).simd_ge(f32x16::splat(isovalue)).to_bitmask()
            };
            inside(0) | inside(LAYER - 16) << (LAYER - 16)
        });
        for z in 0..CAP_EDGE as usize {
            let fold = |of: fn(u32, u32) -> u32| {
                let both = of(layers[z], layers[z + 1]);
                let along_x = of(both, both >> 1);
                of(along_x, along_x >> BLOCK_EDGE)
            };
            let cells = fold(|a, b| a | b) & !fold(|a, b| a & b);
            for y in 0..CAP_EDGE as usize {
                let row = cells >> (BLOCK_EDGE * y) & 0xf;
                mixed |= u64::from(row) << (4 * y + 16 * z);
            }
        }
    }
    mixed
}

impl<'a, T: Scalar> Content<'a, T> for Detailed<'a, T> {
    fn is_for(&self, isovalues: &[f32]) -> bool {
        self.isovalues == isovalues
    }

    fn turn_to(&mut self, isovalues: &[f32]) {
        self.isovalues.clear();
        self.isovalues.extend_from_slice(isovalues);
        self.blocks.iter_mut().for_each(|block| block.key = Key::NONE);
        if let Some(finest) = &mut self.finest {
            finest.turn_to(isovalues);
        }
    }

    fn region(&self, view: &'a OctreeView<'a, T>, thresholds: &Thresholds<T>) -> Option<Region> {
        let last = planes(self.view.last(self.level));
        let levels = self.view.detail().levels();
        match levels.start() == levels.end() {
            true => Region::up_to(view, last, |node| thresholds.active(node)),
            // At a coarser level's cells values can lie beyond the ranges of what is below.
            // It is less than the widths of two cells of the coarsest level away from where ranges tell of surface: both sides are among the samples that a cell's values
            // are made of, and all samples on a way from the one to the other are in range; unless those between are not finite.
            false if !T::IS_INTEGER => Region::all(last),
            false => {
                let width = (4u64 << levels.end()) as f64 / (1u64 << self.level) as f64;
                Region::up_to(view, last, |node| thresholds.active(node)).map(|region| region.grown(width))
            }
        }
    }

    fn parts(&self, corner: Corner, level: u32, active: u64) -> u64 {
        self.view.parts(self.level, self.origin(corner), level - STEP + self.level, active)
    }

    #[inline(always)]
    fn mixed(&mut self, met: u64, way: &Way<'_, 'a, T>, facing: Facing) -> u64 {
        let key = Key::new(way.corner, BLOCK_LEVEL, facing);
        if self.block(way.corner).key != key {
            self.turn_to(key, way);
        }
        let known = &self.blocks[way.corner.block_slot() % SLOTS];
        match &mut self.finest {
            Some(finest) if known.is_finest => finest.mixed(met, way, facing),
            _ => known.mixed & met,
        }
    }

    #[inline(always)]
    fn samples(&mut self, offset: u32, way: &Way<'_, 'a, T>) -> [f32; 8] {
        let known = &self.blocks[way.corner.block_slot() % SLOTS];
        match &mut self.finest {
            Some(finest) if known.is_finest => finest.samples(offset, way),
            _ => corners(&known.block, offset),
        }
    }

    #[inline(always)]
    fn peculiar(&self, way: &Way<'_, 'a, T>) -> u64 {
        let known = self.block(way.corner);
        if known.is_finest { 0 } else { known.block.joints | known.block.short }
    }

    #[inline(always)]
    fn beyond(
        &mut self,
        ray: &ClippedRay,
        way: &Way<'_, 'a, T>,
        offset: u32,
        [begin, end]: [f64; 2],
    ) -> [Option<Beyond>; 2] {
        let known = self.block(way.corner);
        if known.is_finest || known.block.joints >> offset & 1 == 0 {
            return [None, None];
        }
        let before = if begin > ray.t_begin { self.across(ray, begin, false) } else { None };
        let behind = if end < ray.t_end { self.across(ray, end, true) } else { None };
        [before, behind]
    }
}
