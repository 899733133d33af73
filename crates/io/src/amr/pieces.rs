//! VTK overlapping AMR: a file that lists boxes, and a `.vti` file for each of them.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use isoray_amr::{Centering, Patch};
use isoray_grid::{Scalar, ScalarType, SlabSource};

use super::levels::{PRINTED, check_inside, check_ratio};
use super::{AmrField, AmrLevel, IndexBox, Outline, patch};
use crate::dataset::{Dataset, OpenOptions};
use crate::error::{ReadError, Warning};
use crate::layout::affine;
use crate::sample::Losses;
use crate::vtk::hierarchy::{self, Hierarchy, HierarchyLevel, PieceFile};
use crate::vtk::image_data::{self, Piece};
use crate::vtk::{Array, MARKS, Place};

/// Name of the format.
const FORMAT: &str = "VTK overlapping AMR";

/// The boxes of all levels, and the fields.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    path: PathBuf,
    levels: Vec<Vec<PieceFile>>,
    components: Vec<Component>,
}

/// A component of an array.
#[derive(Clone, Debug)]
struct Component {
    array: String,
    place: Place,
    number: usize,
}

impl Pieces {
    /// Reads `path` and the headers of its pieces.
    pub(super) fn open(path: &Path) -> Result<(Outline, Self), ReadError> {
        let mut hierarchy = hierarchy::read(path)?;
        // Writers list levels that have no boxes yet.
        while hierarchy.levels.last().is_some_and(|level| level.pieces.is_empty()) {
            hierarchy.levels.pop();
        }
        let first = hierarchy.levels.first().and_then(|level| level.pieces.first());
        let first = first.ok_or_else(|| ReadError::missing(path, "DataSet of level 0"))?;
        let coarsest = piece(path, first)?;
        let low = DVec3::from(first.cells.low().map(f64::from));
        let origin = hierarchy.origin.unwrap_or(coarsest.low - coarsest.edges * low);
        let steps = [0, 1, 2].map(|i| coarsest.edges.col(i));
        let map = affine(steps, origin).ok_or_else(|| {
            ReadError::mesh(&first.file, "Spacing and Direction", "finite, independent steps", steps[0])
        })?;
        let domain = hierarchy.levels[0].pieces.iter().fold(first.cells, |all, p| all.union(&p.cells));
        let (fields, components) = fields(&coarsest.arrays);
        let levels = levels(path, &hierarchy, map, domain)?;
        let outline = Outline { format: FORMAT, fields, levels, domain, index_to_world: map };
        let levels = hierarchy.levels.into_iter().map(|level| level.pieces).collect();
        Ok((outline, Self { path: path.to_owned(), levels, components }))
    }

    /// Reads field `chosen`.
    pub(super) fn read(&self, chosen: usize, losses: &mut Losses) -> Result<Vec<Patch>, ReadError> {
        let Component { array, place, number } = &self.components[chosen];
        let mut patches = Vec::new();
        for (level, pieces) in self.levels.iter().enumerate() {
            for PieceFile { cells, file } in pieces {
                let components = piece(&self.path, &PieceFile { cells: *cells, file: file.clone() })?;
                let same = components.arrays.iter().find(|a| a.name == *array && a.place == *place);
                let component = same.filter(|a| a.components > 1).map(|_| *number);
                let options = OpenOptions { component, field: Some(array.clone()), ..Default::default() };
                let dataset = Dataset::open(file, &options)?;
                let size = cells.size().map(|n| if *place == Place::Points { n + 1 } else { n });
                if dataset.dims().axes() != size {
                    let what = format!("array '{}'", crate::error::shown(array));
                    let expected = format!("{size:?} values, as in the first piece");
                    return Err(ReadError::mesh(
                        file,
                        what,
                        expected,
                        format!("{:?}", dataset.dims().axes()),
                    ));
                }
                patches.push(patch(level, cells, values(&dataset, losses)?.into()));
            }
        }
        Ok(patches)
    }
}

/// Reads the header of a piece of the mesh in `path`.
fn piece(path: &Path, piece: &PieceFile) -> Result<Piece, ReadError> {
    let data = piece.file.clone();
    std::fs::File::open(&data).map_err(|source| ReadError::DataFile {
        path: path.to_owned(),
        data,
        source,
    })?;
    image_data::piece(&piece.file)
}

/// Checks all levels.
fn levels(
    path: &Path,
    hierarchy: &Hierarchy,
    map: DAffine3,
    mut domain: IndexBox,
) -> Result<Vec<AmrLevel>, ReadError> {
    let mut levels = Vec::new();
    let mut edges = map.matrix3;
    for (number, level) in hierarchy.levels.iter().enumerate() {
        if level.pieces.is_empty() {
            let what = format!("level {number}");
            return Err(ReadError::mesh(path, what, "at least one DataSet", "none"));
        }
        check_pieces(path, number, level, (edges, map.translation), &domain)?;
        let next = hierarchy.levels.get(number + 1);
        let ratio = next.map(|next| ratio(path, number, level, next, edges)).transpose()?;
        let cells = level.pieces.iter().fold(0u64, |sum, p| sum.saturating_add(p.cells.cells()));
        levels.push(AmrLevel { ratio, boxes: level.pieces.len(), cells });
        if let Some(ratio) = ratio {
            let expected = "fewer than 2^30 cells along each axis";
            let refined = domain.refine(ratio);
            domain = refined.ok_or_else(|| {
                ReadError::mesh(path, format!("domain of level {number}"), expected, domain)
            })?;
            edges *= 1.0 / f64::from(ratio);
        }
    }
    Ok(levels)
}

/// The ratio of a level with cells of `edges` to the `next` one.
fn ratio(
    path: &Path,
    number: usize,
    level: &HierarchyLevel,
    next: &HierarchyLevel,
    edges: DMat3,
) -> Result<u32, ReadError> {
    let Some(first) = next.pieces.first() else {
        let what = format!("level {}", number + 1);
        return Err(ReadError::mesh(path, what, "at least one DataSet", "none"));
    };
    let finer = piece(path, first)?.edges;
    let found = [0, 1, 2].map(|i| edges.col(i).length() / finer.col(i).length());
    let whole = found.map(|r| if (r - r.round()).abs() <= PRINTED * r { r.round() } else { r });
    let ratio = check_ratio(path, number, &whole)?;
    match level.ratio {
        Some(stated) if stated != ratio => {
            let (what, expected) =
                (format!("refinement ratio of level {number}"), format!("{ratio}, as the spacings say"));
            Err(ReadError::mesh(path, what, expected, stated))
        }
        _ => Ok(ratio),
    }
}

/// Checks the pieces of level `number` against the list, the domain, and the edges of its cells and their origin.
fn check_pieces(
    path: &Path,
    number: usize,
    level: &HierarchyLevel,
    (edges, origin): (DMat3, DVec3),
    domain: &IndexBox,
) -> Result<(), ReadError> {
    let spacing = DVec3::from([0, 1, 2].map(|i| edges.col(i).length()));
    if let Some(stated) = level.spacing
        && !(stated - spacing).abs().cmple(PRINTED * spacing).all()
    {
        let expected = format!("{spacing}, as the pieces say");
        return Err(ReadError::mesh(path, format!("spacing of level {number}"), expected, stated));
    }
    for (index, listed) in level.pieces.iter().enumerate() {
        check_inside(path, number, index, &listed.cells, domain)?;
        let found = piece(path, listed)?;
        let size = listed.cells.size().map(u64::from);
        if found.cells != size {
            let expected = format!("{size:?}, as the amr_box {} says", listed.cells);
            return Err(ReadError::mesh(&listed.file, "cells", expected, format!("{:?}", found.cells)));
        }
        // Over the length of the piece, the difference would add up to a part of a cell.
        let steps = found.edges - edges;
        let different = (0..3).map(|i| steps.col(i).length() / spacing[i]).sum::<f64>();
        if different.is_nan() || different > PRINTED {
            let expected = format!("{spacing}, as on all of level {number}");
            let lengths = DVec3::from([0, 1, 2].map(|i| found.edges.col(i).length()));
            return Err(ReadError::mesh(&listed.file, "Spacing and Direction", expected, lengths));
        }
        let low = origin + edges * DVec3::from(listed.cells.low().map(f64::from));
        let rounding = PRINTED * (low.abs() + origin.abs()).max_element() + 0.5 * spacing.min_element();
        let off = (found.low - low).length();
        if off.is_nan() || off > rounding {
            let expected = format!("{low}, as the amr_box {} says", listed.cells);
            return Err(ReadError::mesh(&listed.file, "lowest corner", expected, found.low));
        }
    }
    Ok(())
}

/// The fields that arrays hold, without marks of covered cells.
fn fields(arrays: &[Array]) -> (Vec<AmrField>, Vec<Component>) {
    let mut all = (Vec::new(), Vec::new());
    for array in arrays.iter().filter(|a| !MARKS.contains(&a.name.as_str())) {
        let centering = match array.place {
            Place::Points => Centering::Vertices,
            Place::Cells => Centering::Cells,
        };
        for (name, number) in super::component_names(&array.name, array.components) {
            let active = array.active && array.components == 1;
            all.0.push(AmrField { name, centering, active });
            all.1.push(Component { array: array.name.clone(), place: array.place, number });
        }
    }
    all
}

/// All values of a piece.
fn values(dataset: &Dataset, losses: &mut Losses) -> Result<Vec<f32>, ReadError> {
    fn exact<T: Scalar + Into<f32>>(dataset: &Dataset) -> Result<Vec<f32>, ReadError> {
        let mut samples = vec![T::default(); dataset.dims().samples()];
        dataset.slabs::<T>()?.read_layers(0, &mut samples)?;
        Ok(samples.into_iter().map(Into::into).collect())
    }
    match dataset.scalar() {
        ScalarType::U8 => exact::<u8>(dataset),
        ScalarType::I8 => exact::<i8>(dataset),
        ScalarType::U16 => exact::<u16>(dataset),
        ScalarType::I16 => exact::<i16>(dataset),
        ScalarType::F32 => {
            let mut slabs = dataset.slabs::<f32>()?;
            let mut samples = vec![0.0; dataset.dims().samples()];
            slabs.read_layers(0, &mut samples)?;
            for warning in slabs.warnings() {
                match warning {
                    Warning::Rounded { samples, .. } => losses.rounded += samples,
                    Warning::Overflowed { samples, .. } => losses.overflowed += samples,
                    _ => {}
                }
            }
            Ok(samples)
        }
    }
}
