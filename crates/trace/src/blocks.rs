//! What rays found out about blocks, for the next ray: which of their cells hold an isovalue, and what that took.

use isoray_grid::Scalar;
use isoray_octree::{Around, Block, OctreeView};

use crate::branch::{BLOCK_LEVEL, Branch, STEP};
use crate::corner::{Corner, Facing, Key};
use crate::offset::{LAST_PARTS, SPREAD, axes, lasts};
use crate::thresholds::Thresholds;

/// Cubes on the way from the top to a block, by half their level.
pub(crate) type Branches<'a, T> = [Branch<'a, T>; WAY];
pub(crate) const WAY: usize = 16;

/// A block, and the way that leads to it.
pub(crate) struct Way<'w, 'a, T: Scalar> {
    pub(crate) view: &'a OctreeView<'a, T>,
    pub(crate) branches: &'w Branches<'a, T>,
    pub(crate) thresholds: &'w Thresholds<T>,
    pub(crate) corner: Corner,
}

impl<'a, T: Scalar> Way<'_, 'a, T> {
    /// The smallest cube on the way that holds the block's neighbour in `direction`, its level, and the neighbour's corner.
    fn common(&self, direction: u32) -> (&Branch<'a, T>, u32, [u32; 3]) {
        let from = self.corner.coordinates();
        let to = self.corner.neighbor(direction, BLOCK_LEVEL).coordinates();
        let differing = (from[0] ^ to[0]) | (from[1] ^ to[1]) | (from[2] ^ to[2]);
        let level = (u32::BITS - differing.leading_zeros()).next_multiple_of(STEP).max(BLOCK_LEVEL + STEP);
        (&self.branches[(level / STEP) as usize % WAY], level, to)
    }

    #[inline(never)]
    fn neighbor(&self, direction: u32) -> Block<'a, T> {
        let (branch, level, to) = self.common(direction);
        branch.descend(self.view, level, to)
    }

    #[inline(never)]
    fn side_or_neighbor(&self, direction: u32) -> Around<'a, T> {
        let (branch, level, to) = self.common(direction);
        branch.side_or_block(self.view, level, to, self.thresholds.first)
    }

    /// The block itself.
    fn own(&self) -> Block<'a, T> {
        let parent = self.corner.around(BLOCK_LEVEL + STEP);
        let branch = &self.branches[((BLOCK_LEVEL + STEP) / STEP) as usize];
        branch.block(self.view, parent, self.corner.offset(BLOCK_LEVEL))
    }
}

/// By direction, of a block and its seven forward neighbours (bit 0 the next along x, bit 1 y, bit 2 z): their samples that are inside, as
/// far as they are known.
type Inside = [u64; 8];

/// What is known about a block.
#[derive(Clone, Debug)]
#[repr(C)]
struct KnownBlock<'a, T: Scalar> {
    key: Key,
    /// The cells that hold an isovalue, and those of which it is known, in the order of the rays that it is kept for.
    mixed: u64,
    valid: u64,
    /// Bit `n`: `inside[n]` is known.
    known: u64,
    block: Block<'a, T>,
    /// For the first threshold.
    inside: Inside,
}

/// The cells, by offset, whose corners lie in blocks of `known` directions.
const VALID: [u64; 256] = {
    let mut valid = [0; 256];
    let mut known = 0;
    while known < 256 {
        // By the axes along which cells are the last.
        let mut at_last = 0;
        while at_last < 8 {
            let mut is_valid = true;
            let mut direction = 0;
            while direction < 8 {
                is_valid &= direction & !at_last != 0 || known >> direction & 1 == 1;
                direction += 1;
            }
            let mut cells = u64::MAX;
            let mut a = 0;
            while a < 3 {
                cells &= if at_last >> a & 1 == 1 { LAST_PARTS[a] } else { !LAST_PARTS[a] };
                a += 1;
            }
            valid[known] |= if is_valid { cells } else { 0 };
            at_last += 1;
        }
        known += 1;
    }
    valid
};

/// The cells whose corners lie on both sides, all at once: some corner is inside, and not all.
fn mixed(inside: &Inside) -> u64 {
    let [last_x, last_y, last_z] = LAST_PARTS;
    // The samples one on along an axis, from a block and the next one.
    let on_x = |own: u64, next: u64| own >> 1 & !last_x | next << 3 & last_x;
    let on_y = |own: u64, next: u64| own >> 4 & !last_y | next << 12 & last_y;
    let on_z = |own: u64, next: u64| own >> 16 & !last_z | next << 48 & last_z;
    let fold = |of: fn(u64, u64) -> u64| {
        let along_x = |n: usize| of(inside[n], on_x(inside[n], inside[n + 1]));
        let x = [along_x(0), along_x(2), along_x(4), along_x(6)];
        let y = [of(x[0], on_y(x[0], x[1])), of(x[2], on_y(x[2], x[3]))];
        of(y[0], on_z(y[0], y[1]))
    };
    fold(|a, b| a | b) & !fold(|a, b| a & b)
}

/// Blocks that are remembered, 0.5 MB of them; see [`Corner::block_slot`].
const SLOTS: usize = 4096;

/// Blocks, direct-mapped by place, so that those of one window of the volume do not displace each other.
#[derive(Clone, Debug)]
pub(crate) struct Blocks<'a, T: Scalar> {
    entries: Box<[KnownBlock<'a, T>; SLOTS]>,
}

impl<'a, T: Scalar> Blocks<'a, T> {
    pub(crate) fn new() -> Self {
        let nobody = KnownBlock {
            key: Key::NONE,
            mixed: 0,
            valid: 0,
            known: 0,
            block: Block::default(),
            inside: [0; 8],
        };
        let entries = vec![nobody; SLOTS].into_boxed_slice();
        let Ok(entries) = entries.try_into() else { unreachable!("made of that many") };
        Self { entries }
    }

    /// Forgets all that was found out.
    pub(crate) fn forget(&mut self) {
        self.entries.iter_mut().for_each(|entry| entry.key = Key::NONE);
    }

    /// Of the cells `met` of the block on the way, those that hold an isovalue; in the order of rays of this `facing`.
    #[inline(always)]
    pub(crate) fn mixed(&mut self, met: u64, way: &Way<'_, 'a, T>, facing: Facing) -> u64 {
        let slot = way.corner.block_slot() % SLOTS;
        let key = Key::new(way.corner, BLOCK_LEVEL, facing);
        if self.entries[slot].key != key {
            self.entries[slot].turn_to(key, way);
        }
        if met & !self.entries[slot].valid != 0 {
            self.find(met, way, facing);
        }
        self.entries[slot].mixed & met
    }

    /// The samples at the corners of the cell at `offset` of the block on the way, x fastest; that block has just been asked for its
    /// mixed cells.
    #[inline(always)]
    pub(crate) fn corners(&self, offset: u32, way: &Way<'_, 'a, T>) -> [f32; 8] {
        if lasts(offset) == 0 {
            self.entries[way.corner.block_slot() % SLOTS].block.corners(offset).map(T::to_f32)
        } else {
            self.border_corners(offset, way)
        }
    }

    /// The neighbour in `direction`, if it is known.
    fn known_neighbor(&self, direction: u32, way: &Way<'_, 'a, T>) -> Option<&KnownBlock<'a, T>> {
        let corner = way.corner.neighbor(direction, BLOCK_LEVEL);
        let entry = &self.entries[corner.block_slot() % SLOTS];
        entry.key.is_of_same_cube(Key::new(corner, BLOCK_LEVEL, entry.key.facing())).then_some(entry)
    }

    #[inline(never)]
    fn border_corners(&self, offset: u32, way: &Way<'_, 'a, T>) -> [f32; 8] {
        let at_last = axes(lasts(offset));
        let mut blocks = [self.entries[way.corner.block_slot() % SLOTS].block; 8];
        // The subsets of the axes along which the corners lie in the next block, the largest first.
        let mut direction = at_last;
        while direction != 0 {
            let known = self.known_neighbor(direction, way);
            blocks[direction as usize & 7] = known.map_or_else(|| way.neighbor(direction), |n| n.block);
            direction = direction.wrapping_sub(1) & at_last;
        }
        std::array::from_fn(|n| {
            // Along those axes the corner is the first of its block, along the others as far on as it is in the cell.
            let direction = n as u32 & at_last;
            let lowest = offset & !(3 * SPREAD[direction as usize & 7]);
            let at = lowest + SPREAD[(n as u32 ^ direction) as usize & 7];
            blocks[direction as usize & 7].sample_at(at).to_f32()
        })
    }

    /// Finds out about those neighbours of the block on the way that the `met` cells reach into.
    #[inline(never)]
    fn find(&mut self, met: u64, way: &Way<'_, 'a, T>, facing: Facing) {
        let slot = way.corner.block_slot() % SLOTS;
        let cells = facing.ordered(met);
        let [x, y, z] = LAST_PARTS.map(|last| cells & last);
        let reached = [x, y, x & y, z, x & z, y & z, x & y & z];
        let reached = (1..).zip(reached).fold(0, |all, (n, cells)| all | u64::from(cells != 0) << n);
        let mut missing = reached & !self.entries[slot].known;
        while missing != 0 {
            let direction = missing.trailing_zeros();
            missing &= missing - 1;
            let inside = self.neighbor_inside(direction, way, facing);
            self.entries[slot].inside[direction as usize & 7] = inside;
            self.entries[slot].known |= 1 << direction;
        }
        let others = self.mixed_for_others(self.entries[slot].known, way);
        let entry = &mut self.entries[slot];
        entry.valid = facing.ordered(VALID[entry.known as usize & 255]);
        entry.mixed = facing.ordered(mixed(&entry.inside) | others);
    }

    /// The neighbour's samples that are inside. A neighbour that lies on both sides is remembered: other rays will meet it.
    fn neighbor_inside(&mut self, direction: u32, way: &Way<'_, 'a, T>, facing: Facing) -> u64 {
        if let Some(known) = self.known_neighbor(direction, way) {
            return known.inside[0];
        }
        match way.side_or_neighbor(direction) {
            Around::OneSide { is_inside } => {
                if is_inside {
                    u64::MAX
                } else {
                    0
                }
            }
            Around::Block(block) => {
                let corner = way.corner.neighbor(direction, BLOCK_LEVEL);
                let entry = &mut self.entries[corner.block_slot() % SLOTS];
                entry.start(Key::new(corner, BLOCK_LEVEL, facing), block, way.thresholds.first);
                entry.inside[0]
            }
        }
    }

    /// The cells that hold the isovalues of the other thresholds, if their corners lie in blocks of these directions.
    fn mixed_for_others(&self, known: u64, way: &Way<'_, 'a, T>) -> u64 {
        if way.thresholds.others.is_empty() {
            return 0;
        }
        let block = |direction: u32| match direction {
            0 => self.entries[way.corner.block_slot() % SLOTS].block,
            _ if known >> direction & 1 == 0 => Block::default(),
            _ => self.known_neighbor(direction, way).map_or_else(|| way.neighbor(direction), |n| n.block),
        };
        let blocks: [Block<'a, T>; 8] = std::array::from_fn(|direction| block(direction as u32));
        let of = |&threshold: &T| mixed(&blocks.map(|block| block.at_least(threshold)));
        way.thresholds.others.iter().map(of).fold(0, |all, mixed| all | mixed)
    }
}

impl<'a, T: Scalar> KnownBlock<'a, T> {
    /// Turns to the block on the way, or to another order of its cells.
    #[inline(never)]
    fn turn_to(&mut self, key: Key, way: &Way<'_, 'a, T>) {
        if self.key.is_of_same_cube(key) {
            let reordered = |cells| key.facing().ordered(self.key.facing().ordered(cells));
            (self.mixed, self.valid) = (reordered(self.mixed), reordered(self.valid));
            self.key = key;
        } else {
            self.start(key, way.own(), way.thresholds.first);
        }
    }

    /// Begins with a block, of no cell of which anything is known yet.
    fn start(&mut self, key: Key, block: Block<'a, T>, threshold: T) {
        self.inside[0] = block.at_least(threshold);
        self.block = block;
        self.key = key;
        self.known = 1;
        (self.mixed, self.valid) = (0, 0);
    }
}
