//! The part of the volume that what is looked for can lie in.

use isoray_grid::{Dims, Scalar};
use isoray_octree::{Node, OctreeView, child_origin};
use wide::f64x4;

/// How many levels below the root are looked at: regions of a 128th of its edge. A turn from one isovalue to another takes 2 to 11 µs on
/// noise, heptane and a ball of 256³.
const DEPTH: u32 = 7;

/// A box of whole cells that holds all cells that matter.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// Its planes.
    pub(crate) low: f64x4,
    pub(crate) high: f64x4,
    /// The upper planes of the domain.
    pub(crate) last: f64x4,
}

impl Region {
    /// By the children of a node that matter, as `active` tells. `None` if there are no such cells.
    pub(crate) fn new<T: Scalar>(
        view: &OctreeView<'_, T>,
        active: impl Fn(&Node<T::Stored>) -> u32,
    ) -> Option<Self> {
        Self::up_to(view, planes(view.dims().axes().map(|n| n - 1)), active)
    }

    /// The same, where the upper planes of the domain need not be of the lattice.
    pub(crate) fn up_to<T: Scalar>(
        view: &OctreeView<'_, T>,
        last: f64x4,
        active: impl Fn(&Node<T::Stored>) -> u32,
    ) -> Option<Self> {
        let mut grown = Grown { view, active, low: [u32::MAX; 3], high: [0; 3] };
        let level = view.root_level();
        grown.by_node(view.root()?, level, level.saturating_sub(DEPTH), [0; 3]);
        let (low, high) = (planes(grown.low), planes(grown.high).fast_min(last));
        let has_length = low.simd_lt(high).to_bitmask() & 7 == 7;
        has_length.then_some(Self { low, high, last })
    }
}

impl Region {
    /// The whole domain. `None` if it has no cells.
    pub fn whole(dims: Dims) -> Option<Self> {
        Self::all(planes(dims.axes().map(|n| n - 1)))
    }

    /// From one plane to another along each axis, in the whole domain. `None` if it has no cells.
    pub fn between(low: [u32; 3], high: [u32; 3], dims: Dims) -> Option<Self> {
        let whole = Self::whole(dims)?;
        let (low, high) = (planes(low), planes(high).fast_min(whole.last));
        let has_length = low.simd_lt(high).to_bitmask() & 7 == 7;
        has_length.then_some(Self { low, high, ..whole })
    }

    /// With what is nearer than `width` along each axis.
    pub(crate) fn grown(self, width: f64) -> Self {
        let width = f64x4::new([width, width, width, 0.0]);
        let (low, high) = (self.low - width, self.high + width);
        Self { low: low.fast_max(f64x4::ZERO), high: high.fast_min(self.last), ..self }
    }

    /// All that is below the planes at `last`.
    pub(crate) fn all(last: f64x4) -> Option<Self> {
        let has_length = last.simd_gt(f64x4::ZERO).to_bitmask() & 7 == 7;
        has_length.then_some(Self { low: f64x4::ZERO, high: last, last })
    }
}

/// As coordinates of planes; the fourth lane is idle.
fn planes([x, y, z]: [u32; 3]) -> f64x4 {
    f64x4::new([x.into(), y.into(), z.into(), 0.0])
}

/// The box around what has been found so far.
struct Grown<'v, 'a, T: Scalar, A> {
    view: &'v OctreeView<'a, T>,
    active: A,
    low: [u32; 3],
    high: [u32; 3],
}

impl<'a, T: Scalar, A: Fn(&Node<T::Stored>) -> u32> Grown<'_, 'a, T, A> {
    /// By the children of `node` that matter, or by those of level `lowest` below it. What lies in the box
    /// already is not looked at.
    fn by_node(&mut self, node: &'a Node<T::Stored>, level: u32, lowest: u32, origin: [u32; 3]) {
        let active = (self.active)(node);
        let level_below = level - 1;
        for octant in (0..8).filter(|octant| active >> octant & 1 == 1) {
            let low = child_origin(origin, level, octant);
            // A cell's upper corners are the first samples of the next region.
            let high = low.map(|c| c + (1 << level_below));
            if (0..3).all(|a| low[a] >= self.low[a] && high[a] <= self.high[a]) {
                continue;
            }
            let child = (level_below > lowest && node.is_stored(octant))
                .then(|| self.view.nodes(level_below).get(node.child(octant)))
                .flatten();
            match child {
                Some(child) => self.by_node(child, level_below, lowest, low),
                None => {
                    for a in 0..3 {
                        self.low[a] = self.low[a].min(low[a]);
                        self.high[a] = self.high[a].max(high[a]);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use isoray_build::build;
    use isoray_grid::{DenseVolume, Threshold};
    use isoray_oracle::SplitMix64;

    use super::*;

    /// The box of the cells with corners on both sides of `threshold`.
    fn mixed_box(dims: Dims, samples: &[u8], threshold: u8) -> Option<[[u32; 3]; 2]> {
        let [nx, ny, nz] = dims.axes().map(|n| n - 1);
        let cells = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let is_mixed = |cell: &[u32; 3]| {
            let inside = (0..8u32).filter(|n| {
                let corner = std::array::from_fn(|a| cell[a] + (n >> a & 1));
                samples[dims.linear(corner)] >= threshold
            });
            !matches!(inside.count(), 0 | 8)
        };
        cells.filter(is_mixed).fold(None, |grown, cell| {
            let [low, high] = grown.unwrap_or([cell, cell]);
            Some([
                std::array::from_fn(|a| low[a].min(cell[a])),
                std::array::from_fn(|a| high[a].max(cell[a] + 1)),
            ])
        })
    }

    fn region(dims: Dims, samples: &[u8], isovalue: f32) -> Option<[[f64; 3]; 2]> {
        let mut source = DenseVolume::new(dims, samples).unwrap();
        let volume = build(&mut source, glam::DAffine3::IDENTITY, |_| {}).unwrap();
        let Threshold::AtLeast(threshold) = u8::threshold(isovalue) else { panic!("no threshold") };
        let Region { low, high, .. } = Region::new(&volume.view(), |node| node.active(threshold))?;
        Some([low, high].map(|planes| planes.to_array()[..3].try_into().unwrap()))
    }

    #[test]
    fn the_region_holds_every_mixed_cell() {
        let mut random = SplitMix64::new(3);
        let mut tested = 0;
        for _ in 0..300 {
            let dims = Dims::new([(); 3].map(|()| 1 + random.below(40))).unwrap();
            let mut samples = vec![0u8; dims.samples()];
            for _ in 0..random.below(4) {
                let at = random.below(dims.samples() as u32);
                samples[at as usize] = 1 + random.below(255) as u8;
            }
            let Some([low, high]) = mixed_box(dims, &samples, 100) else { continue };
            let found = region(dims, &samples, 100.0).expect("there is surface");
            for a in 0..3 {
                assert!(found[0][a] <= low[a].into() && found[1][a] >= high[a].into(), "{dims:?}: {found:?}");
                assert!(found[1][a] < f64::from(dims.axes()[a]), "{dims:?}: {found:?}");
            }
            tested += 1;
        }
        assert!(tested > 100, "only {tested}");
    }

    #[test]
    fn the_region_is_no_larger_than_the_leaves_at_the_surface() {
        let dims = Dims::new([128; 3]).unwrap();
        let mut random = SplitMix64::new(4);
        let mut samples = vec![0u8; dims.samples()];
        for z in 40..60 {
            for y in 40..60 {
                (40..60).for_each(|x| samples[dims.linear([x, y, z])] = 1 + random.below(255) as u8);
            }
        }
        // Cells 39 lie in leaves of edge 8 that span 32 to 40 along one axis, and may span 56 to 64 along another.
        assert_eq!(region(dims, &samples, 0.5), Some([[32.0; 3], [64.0; 3]]));
        assert_eq!(region(dims, &vec![0; dims.samples()], 0.5), None);
    }
}
