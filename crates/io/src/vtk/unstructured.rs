//! Legacy VTK files of unstructured hexahedra: `.vtk`.
//!
//! Up to version 4, `CELLS N SIZE` is followed by the number of points of each cell and these points. From version
//! 5 on, `N` is one more than the number of cells, and two arrays follow: `OFFSETS` and `CONNECTIVITY`.

use std::path::Path;

use super::legacy::{Parser, stored};
use super::numbers::{Numbers, PIECE};
use super::{Array, Place, Span};
use crate::error::ReadError;
use crate::sample::{Losses, SampleType, to_f32};

/// The data set.
pub(super) const KIND: &str = "DATASET UNSTRUCTURED_GRID";
/// Version from which on cells are two arrays.
const ARRAYS_OF_CELLS: u32 = 5;
/// Corners of a cell.
const CORNERS: usize = 8;
/// VTK's numbers of cells with eight corners and axis-aligned faces: hexahedron and voxel.
const TYPES: [u64; 2] = [12, 11];

/// The sections of a mesh.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    points: Option<Numbers>,
    /// Corners; from version 5 on, ends of cells stand before them.
    cells: Option<(Option<Numbers>, Numbers, u64)>,
    types: Option<Numbers>,
}

/// Points, cells and arrays of a file.
#[derive(Clone, Debug)]
pub(crate) struct Unstructured {
    pub(crate) points: Vec<[f64; 3]>,
    /// The points at the corners of each cell, in the order of the file.
    pub(crate) cells: Vec<[u32; CORNERS]>,
    pub(crate) arrays: Vec<Array>,
    /// How many decimal digits of the coordinates are right at least.
    pub(crate) precision: Precision,
}

/// How exactly coordinates are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Precision {
    Text,
    Float,
    Double,
}

impl Parser {
    /// Takes up a section of the mesh.
    pub(super) fn mesh_section(&mut self, keyword: &str) -> Result<(), ReadError> {
        let known = match keyword {
            "points" => self.mesh.points.is_some(),
            "cells" => self.mesh.cells.is_some(),
            _ => self.mesh.types.is_some(),
        };
        if known {
            return Err(ReadError::field(&self.path, "section", "each section once", keyword));
        }
        match keyword {
            "points" => {
                let count: u64 = self.words.number("POINTS")?;
                let kind = self.words.required("the type of POINTS")?.to_ascii_lowercase();
                self.words.line()?;
                self.mesh.points = Some(self.numbers("POINTS", &kind, u128::from(count) * 3)?);
            }
            "cells" => {
                let [count, size] = self.words.numbers::<u64, 2>("CELLS")?;
                self.words.line()?;
                self.mesh.cells = Some(if self.version < ARRAYS_OF_CELLS {
                    (None, self.numbers("CELLS", "int", u128::from(size))?, count)
                } else {
                    let ends = self.cell_array("OFFSETS", count)?;
                    let corners = self.cell_array("CONNECTIVITY", size)?;
                    (Some(ends), corners, count.saturating_sub(1))
                });
            }
            _ => {
                let count: u64 = self.words.number("CELL_TYPES")?;
                self.words.line()?;
                self.mesh.types = Some(self.numbers("CELL_TYPES", "int", u128::from(count))?);
            }
        }
        Ok(())
    }

    /// One of the two arrays that cells are from version 5 on.
    fn cell_array(&mut self, name: &'static str, count: u64) -> Result<Numbers, ReadError> {
        let found = self.words.required(name)?;
        if !found.eq_ignore_ascii_case(name) {
            return Err(ReadError::field(&self.path, "CELLS", name, found));
        }
        let kind = self.words.required("the type of the array")?.to_ascii_lowercase();
        self.words.line()?;
        self.numbers(name, &kind, u128::from(count))
    }

    /// Passes over `count` numbers, and notes where they are.
    fn numbers(&mut self, what: &'static str, kind: &str, count: u128) -> Result<Numbers, ReadError> {
        let expected = "integers of 8 to 64 bits, float or double";
        let known = stored(kind).and_then(|(bits, sample)| Some((bits, sample?)));
        let (bits, sample) =
            known.ok_or_else(|| ReadError::unsupported(&self.path, "this type", expected, kind))?;
        let start = self.words.position();
        self.pass(count, bits, what)?;
        let count = u64::try_from(count)
            .map_err(|_| ReadError::field(&self.path, what, "fewer than 2^64 numbers", count))?;
        Ok(Numbers { sample, count, span: [start, self.words.position()], ascii: self.ascii })
    }

    /// Checks the number of samples that `POINT_DATA` or `CELL_DATA` states.
    pub(super) fn check_samples(
        &self,
        place: Place,
        what: &'static str,
        stated: u64,
    ) -> Result<(), ReadError> {
        let (expected, count) = match place {
            Place::Points => ("as many as POINTS say", self.mesh.points.map(|p| p.count / 3)),
            Place::Cells => ("as many as CELLS say", self.mesh.cells.as_ref().map(|c| c.2)),
        };
        if count == Some(stated) {
            return Ok(());
        }
        let found = format!("{stated} for {}", count.map_or("none".to_owned(), |n| n.to_string()));
        Err(ReadError::field(&self.path, what, expected, found))
    }
}

/// Reads points and cells of `path`, and where its arrays are.
pub(crate) fn read(path: &Path) -> Result<Unstructured, ReadError> {
    let mut parser = Parser::open(path, KIND)?;
    parser.run()?;
    let Mesh { points, cells, types } = std::mem::take(&mut parser.mesh);
    let missing = |field| ReadError::missing(path, field);
    let points = points.ok_or_else(|| missing("POINTS"))?;
    let (ends, corners, count) = cells.ok_or_else(|| missing("CELLS"))?;
    let types = types.ok_or_else(|| missing("CELL_TYPES"))?;
    if types.count != count {
        let found = format!("{} for {count} cells", types.count);
        return Err(ReadError::field(path, "CELL_TYPES", "as many as CELLS say", found));
    }
    check_types(path, types)?;
    let precision = match (points.ascii, points.sample) {
        (true, _) => Precision::Text,
        (false, SampleType::F64) => Precision::Double,
        _ => Precision::Float,
    };
    let cells = match ends {
        None => counted_cells(path, corners, count, points.count / 3)?,
        Some(ends) => {
            check_ends(path, ends)?;
            ended_cells(path, corners, count, points.count / 3)?
        }
    };
    let mut list = Vec::new();
    let mut point = Vec::new();
    points.each(path, |value| {
        point.push(value);
        if let &[x, y, z] = point.as_slice() {
            list.push([x, y, z]);
            point.clear();
        }
        Ok(())
    })?;
    Ok(Unstructured { points: list, cells, arrays: parser.arrays, precision })
}

fn check_types(path: &Path, types: Numbers) -> Result<(), ReadError> {
    let mut number = 0;
    types.each(path, |found| {
        if !TYPES.iter().any(|&t| t as f64 == found) {
            let expected = "a hexahedron (type 12) or voxel (type 11)";
            return Err(ReadError::mesh(path, format!("cell {number}"), expected, format!("type {found}")));
        }
        number += 1;
        Ok(())
    })
}

/// Checks that all cells have eight corners.
fn check_ends(path: &Path, ends: Numbers) -> Result<(), ReadError> {
    let mut number = 0u64;
    ends.each(path, |found| {
        let expected = number * CORNERS as u64;
        if found != expected as f64 {
            let what = format!("OFFSETS, number {number}");
            return Err(ReadError::mesh(path, what, format!("{expected}, with eight corners a cell"), found));
        }
        number += 1;
        Ok(())
    })
}

/// Checks that a cell's corner is one of `points` points.
fn corner(path: &Path, cell: usize, found: f64, points: u64) -> Result<u32, ReadError> {
    let whole = found as u32;
    if f64::from(whole) == found && u64::from(whole) < points {
        return Ok(whole);
    }
    let expected = format!("points from 0 to {}", points.saturating_sub(1));
    Err(ReadError::mesh(path, format!("corners of cell {cell}"), expected, found))
}

/// Cells before each of which its number of corners stands.
fn counted_cells(
    path: &Path,
    numbers: Numbers,
    count: u64,
    points: u64,
) -> Result<Vec<[u32; CORNERS]>, ReadError> {
    if u128::from(numbers.count) != u128::from(count) * (CORNERS as u128 + 1) {
        let found = format!("{} numbers for {count} cells", numbers.count);
        return Err(ReadError::field(path, "CELLS", "nine numbers for each cell", found));
    }
    let mut cells = Vec::new();
    let mut cell = [0; CORNERS];
    let mut at = 0;
    numbers.each(path, |found| {
        if at == 0 {
            if found != CORNERS as f64 {
                let what = format!("cell {}", cells.len());
                return Err(ReadError::mesh(path, what, "8 corners", found));
            }
        } else {
            cell[at - 1] = corner(path, cells.len(), found, points)?;
        }
        at += 1;
        if at > CORNERS {
            cells.push(cell);
            at = 0;
        }
        Ok(())
    })?;
    Ok(cells)
}

/// Cells one after the other.
fn ended_cells(
    path: &Path,
    numbers: Numbers,
    count: u64,
    points: u64,
) -> Result<Vec<[u32; CORNERS]>, ReadError> {
    if u128::from(numbers.count) != u128::from(count) * CORNERS as u128 {
        let found = format!("{} for {count} cells", numbers.count);
        return Err(ReadError::field(path, "CONNECTIVITY", "eight numbers for each cell", found));
    }
    let mut cells = Vec::new();
    let mut cell = [0; CORNERS];
    let mut at = 0;
    numbers.each(path, |found| {
        cell[at] = corner(path, cells.len(), found, points)?;
        at += 1;
        if at == CORNERS {
            cells.push(cell);
            at = 0;
        }
        Ok(())
    })?;
    Ok(cells)
}

/// One component of `array` of `path`, which has been read by [`read`].
pub(crate) fn values(
    path: &Path,
    array: &Array,
    component: usize,
    losses: &mut Losses,
) -> Result<Vec<f32>, ReadError> {
    let expected = "integers of 8 to 64 bits, float or double";
    let unsupported = || ReadError::unsupported(path, "this type", expected, &array.type_name);
    let sample = array.sample.ok_or_else(unsupported)?;
    let (span, ascii) = match array.span {
        Span::Binary(span) => (span, false),
        Span::Text(span) | Span::Base64(span) => (span, true),
        Span::Appended(_) => return Err(ReadError::missing(path, "array")),
    };
    let numbers = Numbers { sample, count: array.samples * array.components, span, ascii };
    let components = array.components as usize;
    let mut values = Vec::new();
    let mut floats = vec![0.0; PIECE];
    let mut at = 0;
    numbers.pieces(path, |bytes| {
        let floats = &mut floats[..bytes.len() / sample.size()];
        // Only the component asked for counts.
        if components == 1 {
            *losses += to_f32(bytes, sample, None, floats);
            values.extend_from_slice(floats);
            return Ok(());
        }
        for one in bytes.chunks_exact(sample.size()) {
            if at % components == component {
                *losses += to_f32(one, sample, None, &mut floats[..1]);
                values.push(floats[0]);
            }
            at += 1;
        }
        Ok(())
    })?;
    Ok(values)
}
