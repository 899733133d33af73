//! VTK image data: XML files (`.vti`) and legacy ones (`.vtk`).
//!
//! Definition of both formats: <https://docs.vtk.org/en/latest/vtk_file_formats/>.

mod base64;
pub(crate) mod blocks;
pub(crate) mod hierarchy;
pub(crate) mod image_data;
pub(crate) mod legacy;
mod numbers;
pub(crate) mod unstructured;
mod words;
mod xml;

use std::io::{BufRead, BufReader};
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use isoray_grid::Dims;

use crate::decode::{FILE_BUFFER, open_between};
use crate::error::{ReadError, listed};
use crate::layout;
use crate::sample::SampleType;
use base64::Base64Reader;

/// Bytes of `path` from byte `start` up to `end`, decoded from base64 text if they are one.
pub(crate) fn section(
    path: &Path,
    start: u64,
    end: Option<u64>,
    base64: bool,
) -> Result<Box<dyn BufRead + Send>, ReadError> {
    let input = BufReader::with_capacity(FILE_BUFFER, open_between(path, start, end)?);
    Ok(if base64 { Box::new(BufReader::new(Base64Reader::new(input))) } else { Box::new(input) })
}

/// The lattice of points that a file describes.
#[derive(Clone, Copy, Debug)]
struct Grid {
    /// First and last point along each axis.
    extent: [[i64; 2]; 3],
    /// World position of the point with all indices 0, which the extent need not contain.
    origin: DVec3,
    spacing: DVec3,
    /// World directions of the index axes, as columns.
    direction: DMat3,
}

/// Points or cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Points,
    /// Their centres are a lattice, too: one sample fewer along each axis that has several points.
    Cells,
}

impl Grid {
    /// Samples at `place` along each axis.
    fn samples(&self, path: &Path, place: Place) -> Result<[u64; 3], ReadError> {
        let points = self.extent.map(|[first, last]| {
            last.checked_sub(first).and_then(|n| u64::try_from(n).ok()).and_then(|n| n.checked_add(1))
        });
        let [Some(x), Some(y), Some(z)] = points else {
            let expected = "a first and a last point along each axis, the first not beyond the last";
            return Err(ReadError::field(path, "extent", expected, format!("{:?}", self.extent)));
        };
        Ok(match place {
            Place::Points => [x, y, z],
            Place::Cells => [x, y, z].map(|n| n.saturating_sub(1).max(1)),
        })
    }

    /// Size of the lattice at `place`, and the map to the world.
    fn lattice(&self, path: &Path, place: Place) -> Result<(Dims, DAffine3), ReadError> {
        let dims = layout::dims(path, self.samples(path, place)?)?;
        let first = DVec3::from_array(self.extent.map(|[first, last]| {
            let half = if place == Place::Cells && last > first { 0.5 } else { 0.0 };
            first as f64 + half
        }));
        let steps = [0, 1, 2].map(|i| self.direction.col(i) * self.spacing[i]);
        let origin = self.origin + self.direction * (self.spacing * first);
        let map = layout::affine(steps, origin).ok_or_else(|| {
            let found = format!("steps {}, {}, {}, origin {origin}", steps[0], steps[1], steps[2]);
            ReadError::field(path, "Spacing and Direction", "finite, independent steps", found)
        })?;
        Ok((dims, map))
    }
}

/// Where the numbers of an array are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Span {
    /// In the section at the end of the file, from this byte of it on.
    Appended(u64),
    Text([u64; 2]),
    Base64([u64; 2]),
    Binary([u64; 2]),
}

/// A named array of a file.
#[derive(Clone, Debug)]
pub(crate) struct Array {
    pub(crate) name: String,
    pub(crate) place: Place,
    /// The file says that it is the one to look at.
    pub(crate) active: bool,
    type_name: String,
    /// None if samples of this type are not read.
    sample: Option<SampleType>,
    pub(crate) components: u64,
    /// Samples of each component, where the array says so.
    samples: u64,
    span: Span,
}

/// Arrays that VTK adds to mark points and cells, and that nobody means if he names none.
pub(crate) const MARKS: [&str; 3] = ["vtkGhostType", "vtkGhostLevels", "vtkValidPointMask"];

/// The array called `field`; else the active one, else the only one, of the points or, without any, of the cells.
fn choose<'a>(path: &Path, arrays: &'a [Array], field: Option<&str>) -> Result<&'a Array, ReadError> {
    let path = || path.to_owned();
    let at = |place| arrays.iter().filter(move |a| a.place == place);
    let names = || listed(arrays.iter().map(|a| a.name.as_str()));
    if let Some(name) = field {
        let mut found = at(Place::Points).chain(at(Place::Cells)).filter(|a| a.name == name);
        let none = || ReadError::NoSuchField { path: path(), chosen: name.to_owned(), names: names() };
        return found.next().ok_or_else(none);
    }
    for place in [Place::Points, Place::Cells] {
        let mut active = at(place).filter(|a| a.active);
        if let (Some(array), None) = (active.next(), active.next()) {
            return Ok(array);
        }
        let mut candidates = at(place).filter(|a| !MARKS.contains(&a.name.as_str()));
        match (candidates.next(), candidates.next()) {
            (Some(array), None) => return Ok(array),
            (None, _) => {}
            _ => return Err(ReadError::ChooseField { path: path(), names: names() }),
        }
    }
    Err(ReadError::ChooseField { path: path(), names: names() })
}

/// Most components of an array; the size of all of them is then checked without an overflow.
const MOST_COMPONENTS: u64 = 1 << 16;

/// Checks the number of components of an array.
fn components(path: &Path, found: u64) -> Result<u64, ReadError> {
    if (1..=MOST_COMPONENTS).contains(&found) {
        Ok(found)
    } else {
        Err(ReadError::field(path, "number of components", "1 to 65536", found))
    }
}
