//! A ray's way through all cells of a volume, whatever is in them.

use std::ops::ControlFlow;

use isoray_cell::{Segment, relative};
use isoray_grid::{Dims, Samples, Scalar};
use isoray_trace::parts::{CORNER_STRIDES, ClippedRay, Corner, Cubes, GridSteps, Region};
use isoray_trace::{Candidate, Counters, FirstHit, Hit, HitPolicy, Ray};
use wide::f64x4;

/// A cell on the way.
pub struct Stop<'r> {
    /// Its low corner.
    pub cell: [u32; 3],
    /// Where the ray's stretch in it begins and ends.
    pub interval: [f64; 2],
    steps: &'r GridSteps,
    ray: &'r ClippedRay,
}

impl Stop<'_> {
    /// The stretch, cell-local.
    #[inline(always)]
    pub fn segment(&self) -> Segment {
        self.steps.segment(self.ray, self.interval)
    }
}

/// Calls `visit` for every cell on the way of `ray`, in order, until it breaks: the cells and stretches of every traversal that skips some of them.
#[inline(always)]
pub fn follow(ray: &Ray, dims: Dims, mut visit: impl FnMut(&Stop<'_>) -> ControlFlow<()>) {
    let clipped = Region::whole(dims).and_then(|region| ClippedRay::of(ray, &region));
    let Some(ray) = &clipped else { return };
    let cubes = Cubes::new(ray, 1.0, 1.0);
    let strides = &CORNER_STRIDES[ray.backward() as usize & 7];
    let [x, y, z] = dims.axes().map(|n| f64::from(n.saturating_sub(2)));
    let [mut t, t_end] = ray.interval();
    let all = [f64x4::ZERO, f64x4::new([x, y, z, 0.0])];
    let mut steps = GridSteps::at(ray, &cubes, all, t, |at| Corner::new(at).0);
    loop {
        let leaves = steps.leaves();
        let out = if leaves < t_end { leaves } else { t_end };
        // Where two planes of an axis are crossed at once, there is no way between them.
        if t < out {
            let cell = Corner(steps.index()).coordinates();
            let stop = Stop { cell, interval: [t, out], steps: &steps, ray };
            if visit(&stop).is_break() {
                return;
            }
        }
        if out >= t_end {
            return;
        }
        steps.cross(ray, &cubes, strides, out);
        t = out;
    }
}

/// The first hit of a ray, by looking at the samples of every cell on its way: there are no ranges, and nothing is passed by.
#[inline(always)]
pub fn first_hit(
    samples: &impl Samples,
    ray: &Ray,
    isovalue: f32,
    counters: &mut impl Counters,
) -> Option<Hit> {
    let mut policy = FirstHit::default();
    follow(ray, samples.dims(), |stop| {
        counters.lookups(8);
        let corners = samples.corners(stop.cell).map(Scalar::to_f32);
        let inside = corners.iter().filter(|&&s| s >= isovalue).count();
        if matches!(inside, 0 | 8) || !corners.iter().all(|s| s.is_finite()) {
            return ControlFlow::Continue(());
        }
        counters.cell();
        policy.candidate(&Candidate {
            level: 0,
            cell: stop.cell,
            corners: relative(&corners, isovalue),
            segment: stop.segment(),
            interval: stop.interval,
        })
    });
    policy.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_cell_is_left_out() {
        let dims = Dims::new([4, 4, 4]).unwrap();
        let way = |origin, direction| {
            let mut cells = Vec::new();
            follow(&Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }, dims, |stop| {
                cells.push(stop.cell);
                ControlFlow::Continue(())
            });
            cells
        };
        assert_eq!(way([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]), [[0, 0, 0], [1, 0, 0], [2, 0, 0]]);
        // Through vertices, and backward.
        assert_eq!(way([4.0; 3], [-1.0; 3]), [[2; 3], [1; 3], [0; 3]]);
        assert_eq!(
            way([2.5, 0.25, 1.5], [-1.0, 1.0, 0.0]),
            [[2, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0, 2, 1]]
        );
        assert!(way([-1.0, 5.0, 0.5], [1.0, 0.0, 0.0]).is_empty());
    }
}
