//! A ray on the lattices of the levels, and its way through cells that are taken apart.

use std::cell::OnceCell;
use std::ops::ControlFlow;

use isoray_trace::Counters;
use isoray_trace::parts::ClippedRay;
use wide::f64x4;

use crate::hybrid::{PART_STRIDES, Split, part_corner};
use crate::mesh::Mesh;
use crate::range::range_of_corners;
use crate::visit::{Corners, CubeAt, Visit};

/// The ray on the lattice of each level, if it has been there.
pub(crate) struct LevelRays<'r, 'm> {
    pub(crate) mesh: &'m Mesh,
    pub(crate) ray: &'r ClippedRay,
    pub(crate) rays: &'r [OnceCell<ClippedRay>],
}

impl<'r, 'm> LevelRays<'r, 'm> {
    #[inline]
    pub(crate) fn on_level(&self, exponent: u32) -> &'r ClippedRay {
        self.rays[exponent as usize].get_or_init(|| {
            let by = (-f64::from(exponent)).exp2();
            self.ray.scaled(by, vector(self.mesh.skeleton.domain.high) * f64x4::splat(by))
        })
    }

    /// Passes through the parts of a cell that is taken apart.
    #[inline(never)]
    pub(crate) fn parts(
        &self,
        (split, low, exponent): (&'m Split, [u32; 3], u32),
        [mut t, t_end]: [f64; 2],
        visit: &mut impl Visit<'m>,
        counters: &mut impl Counters,
    ) -> ControlFlow<()> {
        let Some(exponent) = exponent.checked_sub(1) else { return ControlFlow::Continue(()) };
        let on_level = self.on_level(exponent);
        let low = low.map(|c| 2 * c);
        let mid = on_level.crossings(vector(low.map(|c| c + 1))).to_array();
        loop {
            let mut octant = on_level.backward();
            let mut t_out = t_end;
            for (a, &mid) in mid.iter().take(3).enumerate() {
                if mid <= t {
                    octant ^= 1 << a;
                } else if mid < t_out {
                    t_out = mid;
                }
            }
            let low = std::array::from_fn(|a| low[a] + (octant >> a & 1));
            match split.part(octant, &self.mesh.bricks.splits) {
                Some(split) => self.parts((split, low, exponent), [t, t_out], visit, counters)?,
                None => {
                    let corners = Corners::new(&split.values, part_corner(octant), PART_STRIDES);
                    match range_of_corners(&corners.values()) {
                        Some(range) if visit.wants(range) => {
                            counters.cell();
                            let segment = || on_level.segment(vector(low), [t, t_out]);
                            let place = CubeAt { numbers: low, exponent };
                            visit.cell(corners, segment, [t, t_out], place)?;
                        }
                        range => visit.passes_cell(range.map(|range| range[0]))?,
                    }
                }
            }
            if t_out >= t_end {
                return ControlFlow::Continue(());
            }
            t = t_out;
        }
    }
}

pub(crate) fn vector([x, y, z]: [u32; 3]) -> f64x4 {
    f64x4::new([x.into(), y.into(), z.into(), 0.0])
}
