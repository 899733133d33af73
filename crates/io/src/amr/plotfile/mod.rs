//! AMReX and BoxLib plotfiles: a folder with a file `Header`, and a folder for each level.
//!
//! Format: <https://amrex-codes.github.io/amrex/docs_html/IO.html>.

mod fab;
mod header;
mod multifab;
mod notation;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};
use isoray_amr::{Centering, Patch, Values};

use self::fab::{FabFile, Part, check_room};
use self::header::{Header, HeaderLevel};
use self::multifab::MultiFab;
use super::levels::{PRINTED, check_inside};
use super::{AmrField, AmrLevel, IndexBox, Outline, patch};
use crate::error::ReadError;
use crate::layout::axis_aligned;
use crate::sample::Losses;

/// Name of the format.
const FORMAT: &str = "AMReX plotfile";

/// A plotfile whose text has been read.
#[derive(Clone, Debug)]
pub(super) struct Plotfile {
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    /// The file that describes the boxes.
    path: PathBuf,
    cells: Vec<IndexBox>,
    fabs: MultiFab,
}

impl Plotfile {
    /// Reads all text of `folder`.
    pub(super) fn open(folder: &Path) -> Result<(Outline, Self), ReadError> {
        let path = folder.join("Header");
        let header = header::read(&path)?;
        let mut levels = Vec::new();
        let mut at_corners = None;
        for (number, described) in header.levels.iter().enumerate() {
            let level = Level::open(folder, number, described, header.components.len(), &mut at_corners)?;
            levels.push(level);
        }
        let index_to_world = place(&path, &header, &levels)?;
        let centering = if at_corners == Some(true) { Centering::Vertices } else { Centering::Cells };
        let field = |name: &String| AmrField { name: name.clone(), centering, active: false };
        let outline = Outline {
            format: FORMAT,
            fields: header.components.iter().map(field).collect(),
            levels: header.levels.iter().zip(&levels).map(|(h, l)| l.outline(h.ratio)).collect(),
            domain: header.levels[0].domain,
            index_to_world,
        };
        Ok((outline, Self { levels }))
    }

    /// Reads component `chosen`.
    pub(super) fn read(&self, chosen: usize, losses: &mut Losses) -> Result<Vec<Patch>, ReadError> {
        let mut patches = Vec::new();
        let mut buffer = Vec::new();
        for (number, level) in self.levels.iter().enumerate() {
            let mut open: Option<(usize, FabFile)> = None;
            let (mut all, mut counts) = (Vec::new(), Vec::new());
            for index in 0..level.cells.len() {
                let file = level.file(index, &mut open)?;
                let (start, format) = level.start(file, index)?;
                let part = level.part(index, chosen as u64);
                let values = file.values(start, format, part, &mut buffer, losses)?;
                all.extend_from_slice(&values);
                counts.push(values.len());
            }
            let values = Values::parts(all, counts);
            patches
                .extend(level.cells.iter().zip(values).map(|(cells, values)| patch(number, cells, values)));
        }
        Ok(patches)
    }
}

impl Level {
    /// Reads the boxes of level `number`; all have values at corners of cells, or none, once `at_corners` is known.
    fn open(
        folder: &Path,
        number: usize,
        described: &HeaderLevel,
        components: usize,
        at_corners: &mut Option<bool>,
    ) -> Result<Self, ReadError> {
        let mut path = folder.join(&described.files).into_os_string();
        path.push("_H");
        let path = PathBuf::from(path);
        let fabs = multifab::read(&path)?;
        if fabs.components != components as u64 {
            let what = format!("components of level {number}");
            return Err(ReadError::mesh(&path, what, format!("{components} as in Header"), fabs.components));
        }
        let boxes = described.places.len();
        if fabs.boxes.len() != boxes {
            let what = format!("boxes of level {number}");
            return Err(ReadError::mesh(&path, what, format!("{boxes} as in Header"), fabs.boxes.len()));
        }
        let mut cells = Vec::new();
        for (index, typed) in fabs.boxes.iter().enumerate() {
            let wrong = |expected: &str| {
                ReadError::mesh(&path, format!("level {number}, box {index}"), expected, typed)
            };
            let found = typed.at_corners();
            if typed.dimensions() != 3 {
                return Err(wrong("three dimensions"));
            }
            if found.is_none() || found != Some(*at_corners.get_or_insert(found == Some(true))) {
                return Err(wrong(
                    "values in cells (0,0,0) or at their corners (1,1,1), the same for all boxes",
                ));
            }
            let expected = "a box that is not empty, of cells up to 2^30";
            let one = typed.cells().ok_or_else(|| wrong(expected))?;
            check_inside(&path, number, index, &one, &described.domain)?;
            cells.push(one);
        }
        let level = Self { path, cells, fabs };
        level.check_files(number)?;
        Ok(level)
    }

    fn outline(&self, ratio: Option<u32>) -> AmrLevel {
        let cells = self.cells.iter().fold(0u64, |sum, b| sum.saturating_add(b.cells()));
        AmrLevel { ratio, boxes: self.cells.len(), cells }
    }

    /// Checks that the files are there and long enough, and that no two boxes claim the same values.
    fn check_files(&self, number: usize) -> Result<(), ReadError> {
        let mut needed = Vec::new();
        for data in &self.fabs.files {
            let file = FabFile::open(data).map_err(|e| match e {
                ReadError::Io { source, .. } => {
                    ReadError::DataFile { path: self.path.clone(), data: data.clone(), source }
                }
                other => other,
            })?;
            needed.push((data, file.length(), 0u128));
        }
        // The first box tells the size of the numbers; that of others is checked as they are read.
        let format =
            if self.cells.is_empty() { return Ok(()) } else { self.start(self.file(0, &mut None)?, 0)?.1 };
        let mut known = HashSet::new();
        for (index, &(file, offset)) in self.fabs.places.iter().enumerate() {
            if !known.insert((file, offset)) {
                let what = format!("level {number}, box {index}");
                let found = format!("those of another box, at byte {offset}");
                return Err(ReadError::mesh(&self.path, what, "values of its own", found));
            }
            let bytes = self.part(index, 0).bytes(format, self.fabs.components);
            let (data, length, sum) = &mut needed[file];
            check_room(data, *length, offset, bytes)?;
            *sum = sum.saturating_add(bytes);
        }
        // Boxes that overlap in a file would need more memory than it has bytes.
        needed.into_iter().try_for_each(|(data, length, sum)| check_room(data, length, 0, sum))
    }

    /// The file of box `index`, which stays open for the next one.
    fn file<'a>(
        &self,
        index: usize,
        open: &'a mut Option<(usize, FabFile)>,
    ) -> Result<&'a mut FabFile, ReadError> {
        let wanted = self.fabs.places[index].0;
        if open.as_ref().is_none_or(|(file, _)| *file != wanted) {
            *open = None;
        }
        Ok(match open {
            Some((_, file)) => file,
            None => &mut open.insert((wanted, FabFile::open(&self.fabs.files[wanted])?)).1,
        })
    }

    /// The byte at which the values of box `index` begin, and how they are written.
    fn start(&self, file: &mut FabFile, index: usize) -> Result<(u64, notation::RealFormat), ReadError> {
        let (_, offset) = self.fabs.places[index];
        if let Some(format) = self.fabs.bare {
            return Ok((offset, format));
        }
        let header = file.header(offset)?;
        let wrong = |expected: String, found: &dyn std::fmt::Display| {
            ReadError::mesh(file.path(), format!("byte {offset}"), expected, found)
        };
        let corners = self.fabs.boxes[index].grown(self.fabs.ghosts);
        match corners {
            Some(corners) if corners == header.corners => {}
            Some(corners) => return Err(wrong(format!("a FAB of the box {corners}"), &header.corners)),
            None => return Err(wrong("a box of three dimensions".to_owned(), &header.corners)),
        }
        if header.components != self.fabs.components {
            let expected = format!("a FAB with {} components", self.fabs.components);
            return Err(wrong(expected, &header.components));
        }
        Ok((header.start, header.format))
    }

    fn part(&self, index: usize, component: u64) -> Part {
        let more = u32::from(self.fabs.boxes[index].at_corners() == Some(true));
        let size = self.cells[index].size().map(|n| n + more);
        Part { component, size, ghosts: self.fabs.ghosts }
    }
}

/// The map of level 0 to the world; checks that the statements of the header about it agree.
fn place(path: &Path, header: &Header, levels: &[Level]) -> Result<DAffine3, ReadError> {
    let Header { low, high, .. } = header;
    let coarsest = &header.levels[0];
    let (first, size) = (coarsest.domain.low(), coarsest.domain.size());
    for axis in 0..3 {
        let (length, stated) = (coarsest.cell[axis] * f64::from(size[axis]), high[axis] - low[axis]);
        let rounding = PRINTED * (stated.abs() + low[axis].abs() + high[axis].abs());
        let difference = (length - stated).abs();
        if difference.is_nan() || difference > rounding {
            let expected = format!("{} cells along {stated}", size[axis]);
            return Err(ReadError::mesh(path, "edges of a cell", expected, coarsest.cell[axis]));
        }
    }
    let cell = [0, 1, 2].map(|i| (high[i] - low[i]) / f64::from(size[i]));
    let shifted = [0, 1, 2].map(|i| low[i] - cell[i] * f64::from(first[i]));
    // AMReX puts the corner with index 0 at the stated one. Others put the lowest corner of the domain there:
    // the places of the boxes tell.
    let misplaced = |origin: [f64; 3]| {
        let (place, cells) = (coarsest.places[0], levels[0].cells[0].low());
        let off = (0..3).map(|i| (place[i][0] - origin[i] - cell[i] * f64::from(cells[i])).abs() / cell[i]);
        off.sum::<f64>()
    };
    let origin = if misplaced(shifted) < misplaced(*low) { shifted } else { *low };
    let wrong = || ReadError::mesh(path, "domain", "finite positive edges", format!("{low:?} to {high:?}"));
    let map = axis_aligned(cell, origin).filter(|_| cell.iter().all(|&h| h > 0.0)).ok_or_else(wrong)?;
    let mut edges = DVec3::from(cell);
    for (number, (described, level)) in header.levels.iter().zip(levels).enumerate() {
        check_places(path, number, described, level, edges, map.translation)?;
        edges /= f64::from(described.ratio.unwrap_or(1));
    }
    Ok(map)
}

/// Checks that the `Header` places the boxes of a level, with cells of `edges`, within half a cell of their indices.
fn check_places(
    path: &Path,
    number: usize,
    described: &HeaderLevel,
    level: &Level,
    edges: DVec3,
    origin: DVec3,
) -> Result<(), ReadError> {
    for (index, (place, cells)) in described.places.iter().zip(&level.cells).enumerate() {
        let low = DVec3::from(place.map(|[low, _]| low));
        let expected = origin + edges * DVec3::from(cells.low().map(f64::from));
        let rounding = 0.5 * edges + PRINTED * expected.abs();
        if !(low - expected).abs().cmple(rounding).all() {
            let what = format!("level {number}, place of box {index}");
            return Err(ReadError::mesh(path, what, format!("{expected}, as its cells {cells} say"), low));
        }
    }
    Ok(())
}
