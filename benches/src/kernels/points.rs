//! Samples of an octree volume, and their neighbours.

use isoray_octree::{OctreeView, OctreeVolume};

use super::{Answer, dims, octree};
use crate::hashing::lookups::{by, located, neighbors, stepped, sum};
use crate::hashing::queries::Queries;
use crate::hashing::{Method, Tree};
use crate::volumes::turbulence;

/// Random points of the turbulent mixing layer, parts of which are constant, and steps from the low corners of random cells to the others.
#[derive(Debug)]
pub struct Points {
    samples: Vec<u8>,
    view: OctreeView<'static, u8>,
    tree: Tree<'static, u8>,
    queries: Queries<'static, u8>,
}

impl Points {
    /// Points.
    pub const COUNT: usize = 1 << 14;

    /// Always the same. The octree is kept as long as the program runs.
    pub fn generate() -> Self {
        let samples = turbulence(super::EDGE);
        let volume: &'static OctreeVolume<u8> = Box::leak(Box::new(octree(&samples)));
        let tree = Tree::new(volume.view());
        let queries = Queries::random(&tree, dims(), Self::COUNT);
        Self { samples, view: volume.view(), tree, queries }
    }

    /// How many steps there are.
    pub fn steps(&self) -> u64 {
        self.queries.steps.len() as u64
    }

    /// Finds the samples at all points.
    #[inline(never)]
    pub fn locate(&self) -> Answer {
        self.answer(self.queries.points.len(), located(&self.view, &self.queries.points, false))
    }

    /// The same by the method of a paper.
    pub fn locate_by(&self, method: Method) -> Answer {
        self.answer(self.queries.points.len(), by(&self.tree, method, &self.queries.points))
    }

    /// Finds the samples at the ends of all steps.
    #[inline(never)]
    pub fn step(&self) -> Answer {
        self.answer(self.queries.steps.len(), neighbors(&self.view, &self.queries))
    }

    /// The same by the method of a paper.
    pub fn step_by(&self, method: Method) -> Answer {
        self.answer(self.queries.steps.len(), stepped(&self.tree, method, &self.queries))
    }

    /// What [`locate`](Self::locate) and [`step`](Self::step) must find, from the samples themselves.
    pub fn expected(&self) -> [Answer; 2] {
        let at = |p: [u32; 3]| self.samples[dims().linear(p)];
        let Queries { points, steps, .. } = &self.queries;
        [
            self.answer(points.len(), sum(points.iter().map(|&p| at(p)))),
            self.answer(steps.len(), sum(steps.iter().map(|step| at(step.to)))),
        ]
    }

    fn answer(&self, count: usize, sum: u64) -> Answer {
        Answer { found: count as u64, sum: sum as f64 }
    }
}
