//! Where the parts of a mesh lie.

use crate::cuboid::Cuboid;
use crate::levels::Levels;
use crate::patches::Patches;
use crate::skeleton::Skeleton;

/// A box of cells of one level, in index space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelBox {
    /// Its low corner.
    pub low: [u32; 3],
    /// Its high corner.
    pub high: [u32; 3],
    /// The binary logarithm of the edge of its cells.
    pub exponent: u32,
}

impl LevelBox {
    fn new(Cuboid { low, high }: Cuboid, exponent: u32) -> Self {
        Self { low, high, exponent }
    }
}

/// Those of the patches, or of the blocks, if all patches are single cells.
pub(crate) fn outlines(
    levels: &Levels,
    patches: &Patches,
    places: &[Cuboid],
    skeleton: &Skeleton,
) -> Vec<LevelBox> {
    let patches = &patches.patches;
    if patches.iter().all(|patch| patch.cells == [1; 3]) {
        return skeleton.blocks.iter().map(|block| LevelBox::new(block.place, block.exponent)).collect();
    }
    let levels = patches.iter().map(|patch| levels.exponent(patch.level));
    places.iter().zip(levels).map(|(&place, exponent)| LevelBox::new(place, exponent)).collect()
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::mesh::{Mesh, MeshOptions};
    use crate::patches::{Centering, Patch};

    fn mesh(patches: Vec<Patch>) -> Mesh {
        let (centering, index_to_world) = (Centering::Cells, DAffine3::IDENTITY);
        let patches =
            Patches { centering, ratios: vec![4], index_to_world, domain: ([-2; 3], [4; 3]), patches };
        Mesh::new(patches, MeshOptions::default()).unwrap()
    }

    fn patch(level: u32, low: [i32; 3], cells: u32) -> Patch {
        Patch { level, low, cells: [cells; 3], values: vec![1.0; cells.pow(3) as usize].into() }
    }

    #[test]
    fn patches_lie_where_they_are() {
        let mesh = mesh(vec![patch(0, [-2; 3], 4), patch(1, [0; 3], 4)]);
        let of = |low: u32, high: u32, exponent| LevelBox { low: [low; 3], high: [high; 3], exponent };
        assert_eq!(mesh.outlines(), [of(0, 16, 2), of(8, 12, 0)]);
    }

    #[test]
    fn of_single_cells_boxes_fill_the_domain() {
        let cells = (0..64).map(|n| patch(0, [n % 4 - 2, n / 4 % 4 - 2, n / 16 - 2], 1));
        let mesh = mesh(cells.collect());
        let volume = |b: &LevelBox| (0..3).map(|a| b.high[a] - b.low[a]).product::<u32>();
        assert!(mesh.outlines().len() < 64);
        assert_eq!(mesh.outlines().iter().map(volume).sum::<u32>(), 16u32.pow(3));
    }
}
