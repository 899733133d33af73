//! What a loss must keep, as [`Loss`] and its crate say: samples, and where surfaces are.

use anyhow::{Result, ensure};
use isoray_benches::views::View;
use isoray_build::{Changes, Loss};
use isoray_grid::{Dims, Samples, Scalar};
use isoray_octree::OctreeVolume;
use isoray_oracle::{FnLattice, Lattice, OracleHit, OracleRay, first_hit};
use rayon::prelude::*;

use crate::for_oracle::apart;

/// To both sides of a hit, in voxels, where the oracle looks for the same one: more than the hundredth that depths may be off.
const WINDOW: f32 = 1.0 / 64.0;
/// What the oracle's hits may be off, and what a line through them is farther from the surface for that, in voxels. Lattices reach to some thousands, so that a position is off by some
/// 10⁻¹² at most; slopes across a line that a displacement is measured along are, of integers of 16 bits, less than 2¹⁶ times those along it.
const SLACK: f64 = 1e-6;
/// One in so many hits may be one that the oracle does not find: a ray that grazes passes twice within rounding, or not at all.
const GRAZING: u64 = 1000;

/// All samples of a volume, x fastest.
pub(super) fn decoded<T: Scalar>(volume: &OctreeVolume<T>) -> Vec<T> {
    let view = volume.view();
    let dims = volume.meta().dims;
    let mut samples = vec![T::default(); dims.samples()];
    let layers = samples.par_chunks_mut(dims.layer()).enumerate();
    layers.for_each(|(z, layer)| Samples::read_rows(&view, z as u32, 0, layer));
    samples
}

/// Each sample is within the loss's tolerance, or in its range and as it was, and as many have changed, and as far, as is told.
pub(super) fn samples<T: Scalar + Into<f64>>(
    source: &[T],
    found: &[T],
    loss: &Loss,
    told: Changes,
) -> Result<()> {
    ensure!(source.len() == found.len(), "expected {} samples, found {}", source.len(), found.len());
    let is_kept = |s: f64| {
        // What is not finite is kept, too.
        !s.is_finite() || loss.range.is_some_and(|[low, high]| low <= s && s <= high)
    };
    let changed = source.par_iter().zip(found).filter(|(old, new)| !old.same_bits(**new));
    let one = |(&old, &new): (&T, &T)| {
        let (old, new): (f64, f64) = (old.into(), new.into());
        let by = apart(old, new);
        // Rounding is monotone, and the tolerance a number: what is within it in exact arithmetic is so here.
        let is_broken = is_kept(old) || !new.is_finite() || by > loss.tolerance;
        (Changes { samples: 1, largest: by }, u64::from(is_broken))
    };
    let (changes, broken) = changed.map(one).reduce(
        || (Changes::default(), 0),
        |(a, m), (b, n)| {
            let samples = a.samples + b.samples;
            (Changes { samples, largest: a.largest.max(b.largest) }, m + n)
        },
    );
    ensure!(broken == 0, "expected samples within {loss:?}, found {broken} that are not; {changes:?}");
    ensure!(changes == told, "expected the changes that are told, {told:?}, found {changes:?}");
    Ok(())
}

/// An isosurface without and with loss, along the rays of a view.
pub(super) struct Surfaces<'a, T> {
    pub(super) dims: Dims,
    pub(super) view: &'a View,
    pub(super) isovalue: f32,
    pub(super) samples: [&'a [T]; 2],
    /// Of the first hit, infinite where there is none.
    pub(super) depths: [&'a [f64]; 2],
}

/// Of hits, or of those whose depth another hit of the same ray does not have.
#[derive(Clone, Copy, Default)]
struct Tally {
    hits: u64,
    doubtful: u64,
    far: u64,
}

impl Tally {
    fn join(self, other: Self) -> Self {
        Self {
            hits: self.hits + other.hits,
            doubtful: self.doubtful + other.doubtful,
            far: self.far + other.far,
        }
    }
}

impl<T: Scalar + Into<f64>> Surfaces<'_, T> {
    /// Every point that is hit of either surface has one of the other within so many voxels along a lattice axis. Along the ray it may be anywhere, and need not be.
    pub(super) fn check(&self, displacement: f64) -> Result<()> {
        let [nx, ny, _] = self.dims.axes().map(|n| n as usize);
        let lattices = self.samples.map(|samples| {
            FnLattice::new(self.dims.axes(), move |p: [u32; 3]| {
                let [x, y, z] = p.map(|c| c as usize);
                samples[(z * ny + y) * nx + x].into()
            })
        });
        // More than 1 acts as 1.
        let reach = displacement.min(1.0);
        let look = |(n, &direction): (usize, &[f32; 3])| {
            let depths = self.depths.map(|of| of[n]);
            let hits = depths.iter().filter(|t| t.is_finite()).count() as u64;
            let all = Tally { hits, ..Tally::default() };
            // Where both are at one place, or nowhere, there is nothing to look for.
            if depths[0] == depths[1] {
                return all;
            }
            let of = |on: usize| self.look(direction, depths[on], [&lattices[on], &lattices[1 - on]], reach);
            all.join(of(0)).join(of(1))
        };
        let rays = self.view.directions.par_iter().enumerate();
        let Tally { hits, doubtful, far } = rays.map(look).reduce(Tally::default, Tally::join);
        let of = self.isovalue;
        ensure!(far == 0, "isovalue {of}: of {hits} hits {far} are farther than {displacement} voxels");
        ensure!(doubtful * GRAZING <= hits, "isovalue {of}: of {hits} hits {doubtful} are not the oracle's");
        Ok(())
    }

    /// At a hit on the first of two lattices, if there is one.
    fn look(&self, direction: [f32; 3], depth: f64, [on, other]: [&impl Lattice; 2], reach: f64) -> Tally {
        if !depth.is_finite() {
            return Tally::default();
        }
        let t = depth as f32;
        let ray = OracleRay { origin: self.view.origin, direction, t_min: t - WINDOW, t_max: t + WINDOW };
        let v = f64::from(self.isovalue);
        match first_hit(on, &ray, v) {
            None => Tally { doubtful: 1, ..Tally::default() },
            Some(hit) => {
                Tally { far: u64::from(!is_near(&hit, [on, other], v, reach + SLACK)), ..Tally::default() }
            }
        }
    }
}

/// Whether a hit on the first lattice's isosurface has the second one's within `reach` along an axis.
fn is_near(hit: &OracleHit, [on, other]: [&impl Lattice; 2], v: f64, reach: f64) -> bool {
    let corner = |n: u32| std::array::from_fn(|a| hit.cell[a] + (n >> a & 1));
    let is_same_cell = (0..8).all(|n| on.sample(corner(n)) == other.sample(corner(n)));
    is_same_cell || (0..3).any(|axis| passes(other, hit.position, axis, v, reach))
}

/// Whether the field passes the isovalue on the stretch of this length to both sides of `p`. There is a field everywhere between finite samples, as those of scans are.
fn passes(l: &impl Lattice, p: [f64; 3], axis: usize, v: f64, reach: f64) -> bool {
    let last = f64::from(l.dims()[axis] - 1);
    let ends = [(p[axis] - reach).max(0.0), (p[axis] + reach).min(last)];
    // It is linear from plane to plane of the lattice.
    let planes = (ends[0].ceil() as u32..=ends[1].floor() as u32).map(f64::from);
    let mut seen = [false; 2];
    for at in ends.into_iter().chain(planes) {
        let mut q = p;
        q[axis] = at;
        seen[usize::from(value(l, q) >= v)] = true;
    }
    seen == [true; 2]
}

/// The trilinear field at a point of the lattice, which has cells.
fn value(l: &impl Lattice, q: [f64; 3]) -> f64 {
    let dims = l.dims();
    let low: [u32; 3] = std::array::from_fn(|a| (q[a] as u32).min(dims[a].saturating_sub(2)));
    let part = |n: u32| {
        let corner: [u32; 3] = std::array::from_fn(|a| low[a] + (n >> a & 1));
        let weight: f64 = (0..3).map(|a| 1.0 - (q[a] - f64::from(corner[a])).abs()).product();
        weight * l.sample(corner)
    };
    (0..8).map(part).sum()
}

#[cfg(test)]
mod tests {
    use isoray_oracle::DenseLattice;

    use super::*;

    #[test]
    fn what_is_lost_is_held_against_the_loss() {
        let loss = Loss { tolerance: 2.0, ..Loss::default() };
        let told = Changes { samples: 1, largest: 2.0 };
        assert!(samples(&[1u8, 5, 9], &[1, 7, 9], &loss, told).is_ok());
        assert!(samples(&[1u8, 5, 9], &[1, 8, 9], &loss, Changes { largest: 3.0, ..told }).is_err());
        assert!(samples(&[1u8, 5, 9], &[1, 7, 9], &loss, Changes::default()).is_err());
        let range = Loss { range: Some([4.0, 6.0]), ..Loss::default() };
        assert!(samples(&[1u8, 5, 9], &[3, 5, 9], &range, told).is_ok());
        assert!(samples(&[1u8, 5, 9], &[1, 7, 9], &range, told).is_err());
        assert!(samples(&[1.0, f32::NAN], &[1.0, 2.0], &range, told).is_err());
    }

    #[test]
    fn surfaces_are_looked_for_along_axes() {
        // The plane x = 2.5 of 2.5, and the same 0.75 farther on.
        let lattice = |by: f64| DenseLattice::from_fn([6, 3, 3], |p| f64::from(p[0]) - by);
        let [here, there] = [lattice(0.0), lattice(0.75)];
        let ray = OracleRay { origin: [0.0, 0.5, 0.5], direction: [1.0, 0.25, 0.0], t_min: 0.0, t_max: 6.0 };
        let hit = first_hit(&here, &ray, 2.5).expect("the plane is hit");
        assert!(is_near(&hit, [&here, &here], 2.5, 0.0));
        assert!(is_near(&hit, [&here, &there], 2.5, 0.76));
        assert!(!is_near(&hit, [&here, &there], 2.5, 0.74));
    }
}
