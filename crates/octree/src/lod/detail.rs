//! Which level of detail is where, in one picture.
//!
//! # The rule
//!
//! A *block of level* `l` is an aligned cube of 4³ cells of the lattice of level `l`, of edge `4·2^l` voxels. It is *far enough* if it is at least
//! [`Detail::start`]`(l)` from the eye, at its nearest point: there a cell of the level is as wide as the wanted number of pixels. What is
//! far enough for a level is so for all finer ones, since starts grow with the level and a cube is nowhere nearer than one that holds it. So the largest blocks
//! that are far enough, and level 0 where none is, divide space: a point's level depends on where it is and on nothing else, whichever ray
//! or packet comes there, and along a ray from the eye it never falls.
//!
//! # Distance
//!
//! Along axis `a` of the lattice a voxel counts `w[a]`, and the distance of a point at `d` voxels from the eye is `√Σ(w[a]·d[a])²`. With the
//! lengths of the voxel's edges that is the *true distance* if the edges are at right angles; if they are oblique, the smallest singular value of
//! the matrix of their directions bounds how much shorter it can be, and starts are that much farther.
//!
//! *By slices* (Knoll 2009, section 6.2), only the axis along which the view mostly runs counts: a plane across it has one level. A pixel is a constant width on planes
//! across the direction of view, not across an axis. At an angle of `φ` from the direction of view, which is at `θ` from the axis, a slice takes
//! points for `cos(φ + θ)/(cos φ cos θ)` to `cos(φ − θ)/(cos φ cos θ)`, that is `1 ∓ tan φ tan θ`, times as far along the direction of view as they are.

use std::ops::RangeInclusive;

use glam::{DAffine3, DVec3};
use isoray_grid::Dims;

use crate::geometry::{CAP_EDGE, CAP_LEVEL, NODE_LEVEL, root_level};

/// How wide a pixel is, in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PixelWidth {
    /// So much at a distance of one from the eye, which is here in world space, and more in proportion.
    PerDistance(f64, DVec3),
    /// The same everywhere: parallel rays.
    Constant(f64),
}

/// What counts as distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DistanceMeasure {
    /// That of the point from the eye.
    #[default]
    True,
    /// That of its slice across the axis of the lattice along which a direction, in world space, mostly runs.
    Slices(DVec3),
}

/// What level of detail is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailRequest {
    /// A pixel's width.
    pub pixel: PixelWidth,
    /// How many pixels wide the cells may be that are drawn in place of finer ones; zero: there are none.
    pub ratio: f64,
    /// What counts as distance.
    pub measure: DistanceMeasure,
    /// Over which share of the stretch from a level's start to that of the next its values go over into the next one's, the last part of it; zero: at once.
    pub blend: f64,
}

/// The level of detail at every place, as the module describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Detail {
    /// In index space.
    eye: [f64; 3],
    weights: [f64; 3],
    /// By level; the first is 0.
    starts: Vec<f64>,
    /// Those that may be drawn in the domain.
    drawn: [u32; 2],
    blend: f64,
    dims: Dims,
    is_gradual: bool,
}

impl Detail {
    /// For a volume of this size and place. No level leaves less of it than 8 samples on its longest axis.
    pub fn new(dims: Dims, index_to_world: &DAffine3, request: &DetailRequest) -> Self {
        let axes = index_to_world.matrix3;
        let edges = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length);
        let voxel = edges.iter().fold(0.0, |m: f64, &e| m.max(e));
        let (eye, width, is_constant) = match request.pixel {
            PixelWidth::PerDistance(width, eye) => {
                (index_to_world.inverse().transform_point3(eye).to_array(), width, false)
            }
            PixelWidth::Constant(width) => ([0.0; 3], width, true),
        };
        let (weights, shrink) = match request.measure {
            DistanceMeasure::True => (edges, least_stretch(index_to_world, edges)),
            DistanceMeasure::Slices(view) => (slice_weights(index_to_world, view), 1.0),
        };
        let coarsest = root_level(dims) - NODE_LEVEL;
        // Where the cells of a level are as wide as is wanted; for parallel rays the pixel's width stands in for that at any distance.
        let needed = |level: u32| voxel * (1u64 << level) as f64 / (request.ratio * width);
        let starts = (1..=coarsest).map_while(|level| match (needed(level), is_constant) {
            (needed, true) => (needed <= 1.0).then_some(0.0),
            (needed, false) => (needed / shrink).is_finite().then_some(needed / shrink),
        });
        let starts = std::iter::once(0.0).chain(starts).collect();
        // The eye as rays have it.
        let eye = eye.map(|c| f64::from(c as f32));
        let blend = request.blend;
        Self { eye, weights, starts, drawn: [0, 0], blend, dims, is_gradual: false }.bounded()
    }

    /// Finds which levels may be drawn.
    fn bounded(mut self) -> Self {
        let bounds = |level: u32| {
            let block = 1u64 << (CAP_LEVEL + level);
            [[0.0; 3], self.dims.axes().map(|n| u64::from(n).next_multiple_of(block) as f64)]
        };
        let is_everywhere = |&level: &u32| self.squares_in(bounds(level))[0] >= self.square(level);
        let is_somewhere = |&level: &u32| self.squares_in(bounds(0))[1] >= self.square(level);
        let finest = (0..=self.coarsest()).rev().find(is_everywhere).unwrap_or(0);
        let coarsest = (0..=self.coarsest()).rev().find(is_somewhere).unwrap_or(0).max(finest);
        self.drawn = [finest, coarsest];
        // Cells as large as the block, two levels coarser, have its corners; where values go over into the next level, one level coarser.
        let most = if self.is_abrupt() { CAP_LEVEL } else { CAP_LEVEL - 1 };
        let has_farther = |&level: &u32| level + most < coarsest;
        self.is_gradual =
            (finest..coarsest).filter(has_farther).all(|level| self.is_far_from(level, level + most + 1));
        self
    }

    /// Whether no block of `level` touches a cell of level `other`, which is coarser. The next larger block around it is not far enough for the next level: so all of that is
    /// nearer than the start of that level and the block's diagonal together. That is to be nearer than any cell of the other level is.
    fn is_far_from(&self, level: u32, other: u32) -> bool {
        const ROUNDING: f64 = 1e-9;
        let diagonal = self.length(|_| f64::from(CAP_EDGE << 1) * (1u64 << level) as f64);
        self.start(other) >= (self.start(level + 1) + diagonal) * (1.0 + ROUNDING)
    }

    /// Whether all coarser cells that a block touches have on their common face no corners that the block has not, those that their values go over into included.
    pub(crate) fn is_gradual(&self) -> bool {
        self.is_gradual
    }

    /// Whether values go over at once from a level to the next.
    fn is_abrupt(&self) -> bool {
        self.blend <= 0.0
    }

    /// Of the block of `level` that holds coordinate `at` of axis `a`: its part of the square of the distance of its nearest point.
    pub(crate) fn square_to_block(&self, a: usize, level: u32, at: i64) -> f64 {
        let block = CAP_LEVEL + level;
        let low = (at >> block << block) as f64;
        self.squares(a, low, low + (1u64 << block) as f64)[0]
    }

    /// The size of the volume.
    pub fn dims(&self) -> Dims {
        self.dims
    }

    /// The eye, in index space: coordinates are those of `f32`, as rays have them.
    pub fn eye(&self) -> [f64; 3] {
        self.eye
    }

    /// The distance from which on blocks of a level are drawn; infinite for a level that never is.
    pub fn start(&self, level: u32) -> f64 {
        self.starts.get(level as usize).copied().unwrap_or(f64::INFINITY)
    }

    /// The coarsest level that may be drawn anywhere.
    pub fn coarsest(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// Of `offset`, in voxels.
    pub fn length(&self, offset: impl Fn(usize) -> f64) -> f64 {
        (0..3).map(|a| (self.weights[a] * offset(a)).powi(2)).sum::<f64>().sqrt()
    }

    /// The squares of the distances of the nearest and of the farthest coordinate from the eye, along axis `a`.
    fn squares(&self, a: usize, low: f64, high: f64) -> [f64; 2] {
        let nearest = (low - self.eye[a]).max(self.eye[a] - high).max(0.0);
        let farthest = (self.eye[a] - low).max(high - self.eye[a]);
        [nearest, farthest].map(|d| (self.weights[a] * d).powi(2))
    }

    /// The squares of the distances of the nearest and of the farthest point.
    fn squares_in(&self, [low, high]: [[f64; 3]; 2]) -> [f64; 2] {
        let [x, y, z] = [0, 1, 2].map(|a| self.squares(a, low[a], high[a]));
        [0, 1].map(|n| x[n] + y[n] + z[n])
    }

    /// In the cube of edge `2^cube` at `corner`.
    fn squares_in_cube(&self, corner: [u32; 3], cube: u32) -> [f64; 2] {
        let low = corner.map(f64::from);
        self.squares_in([low, low.map(|c| c + (1u64 << cube) as f64)])
    }

    /// The square of a level's start.
    fn square(&self, level: u32) -> f64 {
        self.start(level).powi(2)
    }

    /// The level of a cell of the finest lattice.
    pub fn level(&self, cell: [u32; 3]) -> u32 {
        let [finest, coarsest] = self.drawn;
        (finest + 1..=coarsest).rev().find(|&level| self.is_far_enough(level, cell)).unwrap_or(finest)
    }

    /// Whether the block of `level` around `p` is.
    fn is_far_enough(&self, level: u32, p: [u32; 3]) -> bool {
        let block = CAP_LEVEL + level;
        level == 0 || self.squares_in_cube(p.map(|c| c >> block << block), block)[0] >= self.square(level)
    }

    /// The coarsest level of all cells that touch sample `p`, by a corner alone included.
    pub fn touching(&self, p: [u32; 3]) -> u32 {
        let n = self.dims.axes();
        (0..8u32)
            .filter_map(|octant| {
                let mut cell = [0; 3];
                for a in 0..3 {
                    cell[a] = p[a].checked_sub(octant >> a & 1)?;
                    if cell[a] + 1 >= n[a] {
                        return None;
                    }
                }
                Some(self.level(cell))
            })
            .max()
            .unwrap_or(0)
    }

    /// What the 4³ parts of edge `2^part` of the cube at `corner` have of `level`, and which of their cells may see values of a coarser one, by bit `x + 4y + 16z`. Parts that are blocks are told
    /// exactly.
    pub(crate) fn parts(&self, level: u32, corner: [u32; 3], part: u32) -> PartsDetail {
        let edge = (1u64 << part) as f64;
        let along = |a: usize, n: usize, width: f64| {
            let low = f64::from(corner[a]) + n as f64 * edge;
            self.squares(a, low, low + width)
        };
        let own: [[[f64; 2]; 4]; 3] = std::array::from_fn(|a| std::array::from_fn(|n| along(a, n, edge)));
        // Of the blocks of the next level, if the parts are blocks.
        let next: [[f64; 2]; 3] = std::array::from_fn(|a| [0, 2].map(|n| along(a, n, 2.0 * edge)[0]));
        let (start, next_start) = (self.square(level), self.square(level + 1));
        let is_block = part == level + CAP_LEVEL;
        let mut parts = PartsDetail { there: 0, see_coarser: 0 };
        for n in 0..64usize {
            let [i, j, k] = [n & 3, n >> 2 & 3, n >> 4];
            let [nearest, farthest] = [0, 1].map(|end| own[0][i][end] + own[1][j][end] + own[2][k][end]);
            let next_nearest = next[0][i / 2] + next[1][j / 2] + next[2][k / 2];
            let is_coarser = if is_block { next_nearest >= next_start } else { nearest >= next_start };
            let is_finer = if is_block { nearest < start } else { farthest < start };
            parts.there |= u64::from(!is_coarser & !is_finer) << n;
            parts.see_coarser |= u64::from(farthest >= next_start) << n;
        }
        parts
    }

    /// Whether all of a cube is at `level`, and none of its cells can see values of a coarser one.
    pub(crate) fn is_all(&self, level: u32, corner: [u32; 3], cube: u32) -> bool {
        let [nearest, farthest] = self.squares_in_cube(corner, cube);
        nearest >= self.square(level) && farthest < self.square(level + 1)
    }

    /// Whether a cell of `level` in a cube may touch one of a coarser level.
    pub(crate) fn sees_coarser(&self, level: u32, corner: [u32; 3], cube: u32) -> bool {
        self.squares_in_cube(corner, cube)[1] >= self.square(level + 1)
    }

    /// Whether the block of `level` at `corner` and all around it are of that level.
    pub(crate) fn is_amid(&self, level: u32, corner: [u32; 3]) -> bool {
        let edge = f64::from(1u32 << (CAP_LEVEL + level));
        let low = corner.map(|c| f64::from(c) - edge);
        let [nearest, farthest] = self.squares_in([low, low.map(|c| c + 3.0 * edge)]);
        nearest >= self.square(level) && farthest < self.square(level + 1)
    }

    /// The levels that may be drawn in the domain.
    pub fn levels(&self) -> RangeInclusive<u32> {
        self.drawn[0]..=self.drawn[1]
    }

    /// The distances between which a point of a block of `level` can be, a little more than that.
    pub fn reach(&self, level: u32) -> [f64; 2] {
        const ROUNDING: f64 = 1e-6;
        // A block of the next level, in which it lies, is nearer than that one's start.
        let diagonal = self.length(|_| (1u64 << (CAP_LEVEL + level + 1)) as f64);
        let [from, to] = [self.start(level), self.start(level + 1) + diagonal];
        [from * (1.0 - ROUNDING), to * (1.0 + ROUNDING)]
    }

    /// The share of the next level's value in that of a sample of `level` at `p`.
    pub fn share_of_next(&self, level: u32, p: [u32; 3]) -> f64 {
        let (from, to) = (self.start(level), self.start(level + 1));
        if self.blend <= 0.0 || !to.is_finite() || from >= to {
            return 0.0;
        }
        let begin = to - self.blend * (to - from);
        ((self.length(|a| f64::from(p[a]) - self.eye[a]) - begin) / (to - begin)).clamp(0.0, 1.0)
    }

    /// Whether that is zero for all samples of the cube of edge `2^cube` at `corner`.
    pub(crate) fn is_unblended(&self, level: u32, corner: [u32; 3], cube: u32) -> bool {
        let (from, to) = (self.start(level), self.start(level + 1));
        let begin = to - self.blend * (to - from);
        self.blend <= 0.0
            || !to.is_finite()
            || self.squares_in_cube(corner, cube)[1] <= begin.max(0.0).powi(2)
    }
}

/// What the 4³ parts of a cube have of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartsDetail {
    /// Blocks of the level may be in them.
    pub there: u64,
    /// Their cells may see values of a coarser level that the ranges of the parts do not bound.
    pub see_coarser: u64,
}

/// The least length of a vector in the world over that of its components measured along the edges, the lengths of which are given.
fn least_stretch(index_to_world: &DAffine3, edges: [f64; 3]) -> f64 {
    let directions =
        index_to_world.matrix3 * glam::DMat3::from_diagonal(DVec3::from_array(edges.map(|e| 1.0 / e)));
    let inverse = directions.inverse();
    // The Frobenius norm bounds the largest singular value of the inverse; for edges at right angles, that is one.
    let columns = [inverse.x_axis, inverse.y_axis, inverse.z_axis];
    const ORTHOGONAL: f64 = 1e-9;
    let skew =
        directions.x_axis.dot(directions.y_axis).abs().max(directions.y_axis.dot(directions.z_axis).abs());
    match skew.max(directions.z_axis.dot(directions.x_axis).abs()) < ORTHOGONAL {
        true => 1.0,
        false => columns.iter().map(|c| c.length_squared()).sum::<f64>().sqrt().recip(),
    }
}

/// The axis along which `view` mostly runs, and how far along the view a voxel on it is.
fn slice_weights(index_to_world: &DAffine3, view: DVec3) -> [f64; 3] {
    let view = view.normalize_or(DVec3::Z);
    let axes = index_to_world.matrix3;
    // Along the view, a step of the slice across axis `a` is one over the gradient of that index along it.
    let along = index_to_world.matrix3.inverse() * view;
    let size = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length);
    let share = |a: usize| (along[a] * size[a]).abs();
    let main = (0..3).max_by(|&a, &b| share(a).total_cmp(&share(b))).unwrap_or(2);
    std::array::from_fn(|a| if a == main { 1.0 / along[main].abs() } else { 0.0 })
}
