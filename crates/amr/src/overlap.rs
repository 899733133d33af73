//! Patches of one level that overlap.

use crate::cuboid::Cuboid;
use crate::error::MeshError;
use crate::levels::Levels;
use crate::patches::{Centering, Patch};

/// A patch, or a part of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placed {
    pub(crate) place: Cuboid,
    pub(crate) level: u32,
    pub(crate) patch: u32,
}

/// The patches without what others of their level have, too, if these agree on it.
pub(crate) fn disjoint(
    levels: &Levels,
    patches: &[Patch],
    places: &[Cuboid],
    centering: Centering,
) -> Result<Vec<Placed>, MeshError> {
    let mut order: Vec<usize> = (0..patches.len()).collect();
    order.sort_by_key(|&n| (patches[n].level, places[n].low[0], n));
    let mut found = Vec::new();
    // Those of this level that reach as far as the next one begins.
    let mut active: Vec<usize> = Vec::new();
    for &n in &order {
        active.retain(|&m| patches[m].level == patches[n].level && places[m].high[0] > places[n].low[0]);
        let mut left = vec![places[n]];
        for &m in &active {
            let Some(common) = places[n].common(&places[m]) else { continue };
            agree(levels, patches, places, [m, n], common, centering)?;
            left = left.iter().flat_map(|part| without(part, &common)).collect();
        }
        let (level, patch) = (patches[n].level, n as u32);
        found.extend(left.into_iter().map(|place| Placed { place, level, patch }));
        active.push(n);
    }
    Ok(found)
}

/// For each level, what its cells and finer ones fill, in boxes that do not overlap.
pub(crate) fn filled(placed: &[Placed], levels: u32) -> Vec<Placed> {
    let mut all = Vec::with_capacity(placed.len());
    let mut finer: Vec<Placed> = Vec::new();
    for level in (0..levels).rev() {
        let mut own: Vec<Placed> = placed.iter().filter(|part| part.level == level).copied().collect();
        own.sort_unstable_by_key(|part| part.place.low[0]);
        let widest = own.iter().map(|part| part.place.edges()[0]).max().unwrap_or_default();
        for part in &mut finer {
            part.level = level;
        }
        // What this level does not have itself.
        let mut others = Vec::new();
        for part in finer {
            let from = own.partition_point(|other| other.place.low[0] + widest <= part.place.low[0]);
            let near = own[from..].iter().take_while(|other| other.place.low[0] < part.place.high[0]);
            let left = left_of(part.place, near.map(|other| other.place));
            others.extend(left.into_iter().map(|place| Placed { place, ..part }));
        }
        own.append(&mut others);
        all.extend_from_slice(&own);
        finer = own;
    }
    all
}

/// The parts of a box that are of none of others.
pub(crate) fn left_of(place: Cuboid, others: impl IntoIterator<Item = Cuboid>) -> Vec<Cuboid> {
    others
        .into_iter()
        .fold(vec![place], |left, other| left.iter().flat_map(|rest| without(rest, &other)).collect())
}

/// The parts of a box that are not of another.
fn without(whole: &Cuboid, other: &Cuboid) -> Vec<Cuboid> {
    let Some(common) = whole.common(other) else { return vec![*whole] };
    let mut parts = Vec::new();
    let mut rest = *whole;
    for a in 0..3 {
        if rest.low[a] < common.low[a] {
            let [below, above] = rest.split(a, common.low[a]);
            parts.push(below);
            rest = above;
        }
        if rest.high[a] > common.high[a] {
            let [below, above] = rest.split(a, common.high[a]);
            parts.push(above);
            rest = below;
        }
    }
    parts
}

/// Whether two patches have the same values where they overlap.
fn agree(
    levels: &Levels,
    patches: &[Patch],
    places: &[Cuboid],
    pair: [usize; 2],
    common: Cuboid,
    centering: Centering,
) -> Result<(), MeshError> {
    let level = patches[pair[0]].level;
    let pair = [pair[0].min(pair[1]), pair[0].max(pair[1])];
    let step = 1 << levels.exponent(level);
    let beyond = u32::from(centering == Centering::Vertices);
    let along = |a: usize| (common.low[a]..common.high[a] + beyond).step_by(step);
    for z in along(2) {
        for y in along(1) {
            for x in along(0) {
                let values = pair.map(|n| {
                    let place = &places[n];
                    patches[n].values[index(&patches[n], place, [x, y, z], levels, centering)]
                });
                if values[0] != values[1] && !values.iter().all(|v| v.is_nan()) {
                    let at = levels.numbered(level, [x, y, z]);
                    return Err(MeshError::Overlap { patches: pair, level, values, at });
                }
            }
        }
    }
    Ok(())
}

/// Where the value of the cell or vertex at `point` of the finest lattice is among those of a patch at `place`.
pub(crate) fn index(
    patch: &Patch,
    place: &Cuboid,
    point: [u32; 3],
    levels: &Levels,
    centering: Centering,
) -> usize {
    let own = levels.exponent(patch.level);
    let [x, y, z] = std::array::from_fn(|a| ((point[a] - place.low[a]) >> own) as usize);
    let [nx, ny, _] = patch.value_dims(centering).map(|n| n as usize);
    x + nx * (y + ny * z)
}
