//! Where the parts of a mesh lie.

use crate::block::Block;
use crate::cuboid::Cuboid;
use crate::mesh::Mesh;
use crate::patches::{Patch, Patches};

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

impl Mesh {
    /// Where the patches lie that it was made of, in their order. Those of other meshes may have no place.
    pub fn places<'p>(&'p self, patches: &'p Patches) -> impl Iterator<Item = LevelBox> + 'p {
        let place = move |(number, patch): (usize, &Patch)| {
            let place = self.levels.place(number, patch, patches.centering).ok()?;
            Some(LevelBox::new(place, self.levels.exponent(patch.level)))
        };
        patches.patches.iter().enumerate().filter_map(place)
    }

    /// The boxes that the tree cuts the domain into, each of leaves of one level.
    pub fn blocks(&self) -> impl Iterator<Item = LevelBox> + '_ {
        let blocks = self.skeleton.blocks.iter();
        blocks.map(|&Block { place, exponent, .. }| LevelBox::new(place, exponent))
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::mesh::MeshOptions;
    use crate::patches::Centering;

    #[test]
    fn patches_lie_where_they_are_and_blocks_fill_the_domain() {
        let patch = |level: u32, low: i32, cells: u32| Patch {
            level,
            low: [low; 3],
            cells: [cells; 3],
            values: vec![1.0; cells.pow(3) as usize],
        };
        let patches = Patches {
            centering: Centering::Cells,
            ratios: vec![4],
            index_to_world: DAffine3::IDENTITY,
            domain: ([-2; 3], [4; 3]),
            patches: vec![patch(0, -2, 4), patch(1, 0, 4)],
        };
        let mesh = Mesh::new(&patches, MeshOptions::default()).unwrap();
        let of = |low: u32, high: u32, exponent| LevelBox { low: [low; 3], high: [high; 3], exponent };
        assert_eq!(mesh.places(&patches).collect::<Vec<_>>(), [of(0, 16, 2), of(8, 12, 0)]);
        let blocks: Vec<_> = mesh.blocks().collect();
        let volume = |b: &LevelBox| (0..3).map(|a| b.high[a] - b.low[a]).product::<u32>();
        assert_eq!(blocks.iter().map(volume).sum::<u32>(), 16u32.pow(3));
        assert!(blocks.contains(&of(8, 12, 0)));
    }
}
