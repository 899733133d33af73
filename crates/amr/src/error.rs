//! What is wrong with a mesh.

use isoray_grid::DimsError;

/// Why patches do not make a mesh.
///
/// Patches are named by their numbers in [`Patches::patches`](crate::Patches::patches), from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A ratio of refinement other than 2 and 4.
    #[error("level {level}: expected 2 or 4 cells of the next level along the edge of a cell, found {ratio}")]
    Ratio {
        /// The coarser of the two levels.
        level: usize,
        /// The ratio.
        ratio: u32,
    },
    /// The finest lattice would be too large.
    #[error("cells of the finest level")]
    Dims(#[from] DimsError),
    /// A patch on a level that does not exist.
    #[error("patch {patch}: expected a level below {levels}, found {level}")]
    Level {
        /// The patch.
        patch: usize,
        /// Its level.
        level: u32,
        /// How many levels there are.
        levels: usize,
    },
    /// A patch without cells.
    #[error("patch {patch} of level {level}: expected cells along each axis, found {}", times(*cells))]
    Empty {
        /// The patch.
        patch: usize,
        /// Its level.
        level: u32,
        /// Its cells along each axis.
        cells: [u32; 3],
    },
    /// A patch with another number of values than its cells or vertices.
    #[error("patch {patch} of level {level}: expected {expected} values, found {found}")]
    Values {
        /// The patch.
        patch: usize,
        /// Its level.
        level: u32,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A patch that reaches out of the domain.
    #[error(
        "patch {patch} of level {level}: expected cells of the domain, {} to {}, found {} to {}",
        place(domain[0]), place(domain[1]), place(cells[0]), place(cells[1])
    )]
    Outside {
        /// The patch.
        patch: usize,
        /// Its level.
        level: u32,
        /// Its lowest and highest cell.
        cells: [[i64; 3]; 2],
        /// Those of the domain on this level.
        domain: [[i64; 3]; 2],
    },
    /// Patches of one level that overlap, and do not agree there.
    #[error(
        "patches {} and {} of level {level}: expected the same values where they overlap, found {} and {} at {}",
        patches[0], patches[1], values[0], values[1], place(*at)
    )]
    Overlap {
        /// The patches.
        patches: [usize; 2],
        /// Their level.
        level: u32,
        /// The values.
        values: [f32; 2],
        /// The cell or vertex that has them.
        at: [i64; 3],
    },
    /// A patch that covers some of a coarser cell, the rest of which no finer patch covers.
    #[error("patch {patch} of level {level}: expected to cover whole cells of level {coarser}, found that it cuts {}", place(*cell))]
    Cuts {
        /// The patch.
        patch: usize,
        /// Its level.
        level: u32,
        /// The coarser level.
        coarser: u32,
        /// The cell that is cut.
        cell: [i64; 3],
    },
    /// A part of the domain that no patch covers.
    #[error(
        "expected patches all over the domain, found none over the cells {} to {} of level {level}",
        place(cells[0]), place(cells[1])
    )]
    Gap {
        /// The finest level, in the cells of which the gap is told.
        level: u32,
        /// Its lowest and highest cell.
        cells: [[i64; 3]; 2],
    },
}

fn times([x, y, z]: [u32; 3]) -> String {
    format!("{x}x{y}x{z}")
}

fn place([x, y, z]: [i64; 3]) -> String {
    format!("({x}, {y}, {z})")
}
