//! The cells of one block, in the order of the ray.

use std::ops::ControlFlow;

use isoray_cell::relative;
use isoray_grid::{Scalar, ScalarType};
use isoray_octree::{OctreeView, Path};
use wide::f64x4;

use crate::hit::{Candidate, HitPolicy};
use crate::neighborhood::{Find, Neighborhood};
use crate::place::Place;
use crate::ray::ClippedRay;
use crate::steps::{Cube, Steps};
use crate::work::Counters;

/// What stays the same from block to block of a ray.
pub(crate) struct BlockWalk<'r, 'a, T: Scalar> {
    pub(crate) view: &'a OctreeView<'a, T>,
    pub(crate) ray: &'r ClippedRay,
    pub(crate) isovalue: f32,
    pub(crate) threshold: T,
}

impl<'a, T: Scalar> BlockWalk<'_, 'a, T> {
    /// Hands to `policy` the cells of the neighbourhood's own block on the stretch `[t, t_end]` whose corners lie on both sides of the
    /// isovalue.
    ///
    /// All samples of a block are compared with the isovalue at once; a cell is then told by eight bits of the mask, and
    /// samples are fetched for cells that hold the isovalue only. `mid` is where the ray crosses the block's mid-planes.
    #[expect(
        clippy::too_many_arguments,
        reason = "called from one place, with values that have no common owner"
    )]
    #[inline(never)]
    pub(crate) fn cells(
        &self,
        neighborhood: &mut Neighborhood<'a, T>,
        path: &Path<'a, T>,
        place: Place,
        mid: f64x4,
        t: f64,
        t_end: f64,
        policy: &mut impl HitPolicy,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let find = Find { view: self.view, path, place, threshold: self.threshold };
        let cube = Cube { center: place.center, mid, step: self.ray.step };
        cube.walk(self.ray, [t, t_end], |steps, offset, interval| {
            counters.lookups(8);
            if neighborhood.is_mixed(&find, offset) {
                let samples = neighborhood.corners(&find, offset);
                if T::TYPE != ScalarType::F32 || samples.iter().all(|s| s.is_finite()) {
                    counters.cell();
                    policy.candidate(&self.candidate(&samples, steps, place, offset, interval))?;
                }
            }
            ControlFlow::Continue(())
        })
    }

    #[inline(always)]
    fn candidate(
        &self,
        samples: &[T; 8],
        steps: &Steps,
        place: Place,
        offset: u32,
        interval: [f64; 2],
    ) -> Candidate {
        let corner = place.corner();
        Candidate {
            cell: std::array::from_fn(|a| corner[a] + (offset >> (2 * a) & 3)),
            corners: relative(&samples.map(T::to_f32), self.isovalue),
            segment: steps.segment(self.ray, interval),
            interval,
        }
    }
}
