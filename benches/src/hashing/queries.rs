//! What is looked up: points, and steps from them to their neighbours.

use std::ops::ControlFlow;

use isoray_grid::{Dims, Scalar};
use isoray_octree::{CAP_EDGE, Path, octant_of};
use isoray_oracle::SplitMix64;

use super::{Trail, Tree};
use crate::path;
use crate::views::{TILE_EDGE, View};

/// From a lattice point, to which a trail leads, to another beside it.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The index of the trail.
    pub trail: u32,
    /// Where it starts.
    pub from: [u32; 3],
    /// Where it ends; no coordinate differs by more than one.
    pub to: [u32; 3],
}

/// Points, and steps between neighbours with the ways to where they start, which a traversal has.
#[derive(Clone, Debug)]
pub struct Queries<'a, T: Scalar> {
    /// Lattice points.
    pub points: Vec<[u32; 3]>,
    /// Steps.
    pub steps: Vec<Step>,
    /// The ways from the root to where steps start.
    pub trails: Vec<Trail<T>>,
    /// The same ways, as ours are kept.
    pub paths: Vec<Path<'a, T>>,
}

/// Pixels along the side of the picture whose rays are taken.
const SIZE: u32 = 256;

impl<'a, T: Scalar> Queries<'a, T> {
    fn new() -> Self {
        Self { points: Vec::new(), steps: Vec::new(), trails: Vec::new(), paths: Vec::new() }
    }

    /// Anywhere; and of cells anywhere, from the low corner to the seven others (2006, Figure 4).
    pub fn random(tree: &Tree<'a, T>, dims: Dims, count: usize) -> Self {
        let mut queries = Self::new();
        let mut random = SplitMix64::new(2006);
        let mut point = || dims.axes().map(|n| random.below(n));
        queries.points = (0..count).map(|_| point()).collect();
        while queries.steps.len() < count {
            let from = point();
            let trail = queries.way(tree, from);
            let corners = (1..8u32).map(|n| std::array::from_fn(|a| from[a] + (n >> a & 1)));
            let inside = corners.filter(|&to| dims.contains(to));
            queries.steps.extend(inside.map(|to| Step { trail, from, to }));
        }
        queries
    }

    /// The cells that the rays of the far view go through, one after the other.
    pub fn along_rays(tree: &Tree<'a, T>, dims: Dims, count: usize) -> Self {
        let mut queries = Self::new();
        let view = View::far(dims, SIZE, SIZE);
        // Pixels side by side, from those that see the middle of the volume: directions are in rows of square tiles, of which one begins in the middle of the picture.
        let middle = (view.directions.len() + (SIZE * TILE_EDGE) as usize) / 2;
        for &direction in &view.directions[middle..] {
            let mut last = None;
            path::follow(&view.ray(direction), dims, |stop| {
                if let Some(from) = last.replace(stop.cell) {
                    queries.step_along(tree, from, stop.cell);
                }
                queries.points.push(stop.cell);
                ControlFlow::Continue(())
            });
            if queries.points.len() >= count {
                break;
            }
        }
        queries
    }

    /// A step on a ray, which is in the same block still for some steps.
    fn step_along(&mut self, tree: &Tree<'a, T>, from: [u32; 3], to: [u32; 3]) {
        let block = |p: [u32; 3]| p.map(|c| c / CAP_EDGE);
        let trail = match self.steps.last() {
            Some(before) if block(before.from) == block(from) => before.trail,
            _ => self.way(tree, from),
        };
        self.steps.push(Step { trail, from, to });
    }

    /// Adds the way to a point.
    fn way(&mut self, tree: &Tree<'a, T>, p: [u32; 3]) -> u32 {
        let (trail, nodes) = tree.trail(p);
        let mut path = Path::default();
        for (level, &node) in tree.levels().zip(&nodes) {
            path.enter_node(level, node);
        }
        if let (Some((level, _)), Some(&parent)) = (trail.leaf(), nodes.last()) {
            path.enter_leaf(level, parent, octant_of(p, level + 1));
        }
        self.trails.push(trail);
        self.paths.push(path);
        self.trails.len() as u32 - 1
    }
}
