//! Meshes of all kinds, by a seed.

use glam::DAffine3;
use isoray_amr::{Centering, Patch, Patches};
use isoray_oracle::SplitMix64;

/// What a mesh is refined by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind {
    pub(crate) ratios: &'static [u32],
    /// The chance that a cell is refined, and then its parts.
    pub(crate) chance: f64,
    /// Cells along the edge of what is refined at once.
    pub(crate) group: u32,
}

/// Octrees that are anything but balanced, single octs, patches, ratio 4, both.
pub(crate) const KINDS: [Kind; 5] = [
    Kind { ratios: &[2, 2, 2], chance: 0.3, group: 1 },
    Kind { ratios: &[2], chance: 0.2, group: 1 },
    Kind { ratios: &[2, 2], chance: 0.4, group: 2 },
    Kind { ratios: &[4], chance: 0.2, group: 1 },
    Kind { ratios: &[2, 4, 2], chance: 0.15, group: 1 },
];

/// The lowest cell of the domain, and its cells along each axis.
pub(crate) const DOMAIN: ([i32; 3], [u32; 3]) = ([-2, 0, 3], [4, 3, 4]);

/// A mesh of this kind, with what `value` tells of a cell or a vertex of a level: where it is in coordinates of level 0, and which level.
pub(crate) fn mesh(
    kind: Kind,
    centering: Centering,
    seed: u64,
    value: impl Fn([f64; 3], u32) -> f32,
) -> Patches {
    let mut random = SplitMix64::new(seed);
    let mut boxes = vec![(0, DOMAIN.0, DOMAIN.1)];
    let mut next = 0;
    while next < boxes.len() {
        let (level, low, cells) = boxes[next];
        next += 1;
        let Some(&ratio) = kind.ratios.get(level as usize) else { continue };
        let group = kind.group;
        for z in (0..cells[2]).step_by(group as usize) {
            for y in (0..cells[1]).step_by(group as usize) {
                for x in (0..cells[0]).step_by(group as usize) {
                    if random.range(0.0, 1.0) < kind.chance {
                        let at = [x, y, z];
                        let count: [u32; 3] = std::array::from_fn(|a| group.min(cells[a] - at[a]) * ratio);
                        let low = std::array::from_fn(|a| (low[a] + at[a] as i32) * ratio as i32);
                        boxes.push((level + 1, low, count));
                    }
                }
            }
        }
    }
    let patches = boxes.into_iter().map(|(level, low, cells)| {
        let edge: f64 = kind.ratios[..level as usize].iter().map(|&r| 1.0 / f64::from(r)).product();
        let mut patch = Patch { level, low, cells, values: Vec::new().into() };
        let mut values = Vec::new();
        let [nx, ny, nz] = patch.value_dims(centering);
        let shift = if centering == Centering::Cells { 0.5 } else { 0.0 };
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let at = [x, y, z];
                    let place =
                        std::array::from_fn(|a| (f64::from(low[a]) + f64::from(at[a]) + shift) * edge);
                    values.push(value(place, level));
                }
            }
        }
        patch.values = values.into();
        patch
    });
    let patches = patches.collect();
    let index_to_world = DAffine3::IDENTITY;
    Patches { centering, ratios: kind.ratios.to_vec(), index_to_world, domain: DOMAIN, patches }
}

/// A value that depends on every bit of its place and on the level.
pub(crate) fn noise(place: [f64; 3], level: u32, seed: u64) -> f32 {
    let bits = place.iter().fold(seed ^ u64::from(level) << 7, |h, c| {
        (h ^ c.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
    });
    SplitMix64::new(bits).range(-1.0, 1.0) as f32
}
