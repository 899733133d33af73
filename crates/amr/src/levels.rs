//! Levels, and where patches lie on the finest lattice.

use glam::{DAffine3, DVec3};
use isoray_grid::Dims;

use crate::cuboid::Cuboid;
use crate::error::MeshError;
use crate::patches::{Centering, Patch, Patches};

/// The levels of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Levels {
    /// By level: the binary logarithm of its cells' edge, in those of the finest.
    exponents: Vec<u32>,
    /// The lowest cell of level 0.
    origin: [i64; 3],
    /// The domain.
    pub(crate) domain: Cuboid,
}

impl Levels {
    pub(crate) fn new(patches: &Patches) -> Result<Self, MeshError> {
        let mut exponents = vec![0u32];
        for (level, &ratio) in patches.ratios.iter().enumerate().rev() {
            let steps = match ratio {
                2 => 1,
                4 => 2,
                _ => return Err(MeshError::Ratio { level, ratio }),
            };
            exponents.push(exponents[exponents.len() - 1] + steps);
        }
        exponents.reverse();
        let (low, cells) = patches.domain;
        // Too large is refused by the lattice, with the number that it was given.
        let edge = 1u32.checked_shl(exponents[0]).unwrap_or(u32::MAX);
        let high = cells.map(|n| n.saturating_mul(edge));
        Dims::new(high.map(|n| n.saturating_add(1)))?;
        if high.contains(&0) {
            return Err(MeshError::Gap {
                level: 0,
                cells: [low.map(i64::from), low.map(|c| i64::from(c) - 1)],
            });
        }
        Ok(Self { exponents, origin: low.map(i64::from), domain: Cuboid { low: [0; 3], high } })
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.exponents.len()
    }

    /// The binary logarithm of the edge of a cell of `level`.
    pub(crate) fn exponent(&self, level: u32) -> u32 {
        self.exponents[level as usize]
    }

    /// Points of the finest lattice.
    pub(crate) fn dims(&self) -> Result<Dims, MeshError> {
        Ok(Dims::new(self.domain.high.map(|n| n + 1))?)
    }

    /// From the finest lattice to the world.
    pub(crate) fn index_to_world(&self, of_level_0: DAffine3) -> DAffine3 {
        let scale = (-f64::from(self.exponents[0])).exp2();
        let origin = DVec3::from_array(self.origin.map(|c| c as f64));
        of_level_0 * DAffine3::from_translation(origin) * DAffine3::from_scale(DVec3::splat(scale))
    }

    /// A point of the lattice of `level`, as the patches count.
    pub(crate) fn numbered(&self, level: u32, point: [u32; 3]) -> [i64; 3] {
        let (own, coarsest) = (self.exponent(level), self.exponents[0]);
        std::array::from_fn(|a| (self.origin[a] << (coarsest - own)) + i64::from(point[a] >> own))
    }

    /// A point of the finest lattice in coordinates of level 0.
    pub(crate) fn in_level_0(&self, point: [u32; 3]) -> [f64; 3] {
        let edge = (-f64::from(self.exponents[0])).exp2();
        std::array::from_fn(|a| self.origin[a] as f64 + f64::from(point[a]) * edge)
    }

    /// Where a patch lies, if its cells are of the domain, and its values as many as it needs.
    pub(crate) fn place(
        &self,
        number: usize,
        patch: &Patch,
        centering: Centering,
    ) -> Result<Cuboid, MeshError> {
        let Patch { level, low, cells, ref values } = *patch;
        if level as usize >= self.count() {
            return Err(MeshError::Level { patch: number, level, levels: self.count() });
        }
        if cells.contains(&0) {
            return Err(MeshError::Empty { patch: number, level, cells });
        }
        let own = self.exponent(level);
        let first = self.numbered(level, [0; 3]);
        let count = self.domain.high.map(|n| i64::from(n >> own));
        let begin: [i64; 3] = std::array::from_fn(|a| i64::from(low[a]) - first[a]);
        let end: [i64; 3] = std::array::from_fn(|a| begin[a] + i64::from(cells[a]));
        if (0..3).any(|a| begin[a] < 0 || end[a] > count[a]) {
            let last = |of: [i64; 3], n: [i64; 3]| std::array::from_fn(|a| of[a] + n[a] - 1);
            return Err(MeshError::Outside {
                patch: number,
                level,
                cells: [low.map(i64::from), last(low.map(i64::from), cells.map(i64::from))],
                domain: [first, last(first, count)],
            });
        }
        let expected: usize = patch.value_dims(centering).iter().map(|&n| n as usize).product();
        if values.len() != expected {
            return Err(MeshError::Values { patch: number, level, expected, found: values.len() });
        }
        // Of the domain, whose coordinates have 21 bits.
        Ok(Cuboid { low: begin.map(|c| (c as u32) << own), high: end.map(|c| (c as u32) << own) })
    }
}
