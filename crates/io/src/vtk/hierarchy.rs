//! VTK overlapping AMR in XML: `.vthb`, and the older `.vtm`, whose pieces are `.vti` files.
//!
//! Newer files have a `Block` for each level, with its spacing, and in it a `DataSet` for each box. In older ones
//! a `DataSet` names its level as `group`, and a `RefinementRatio` stands for each level but the finest.

use std::path::{Path, PathBuf};

use glam::DVec3;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::xml::{Element, Source, malformed};
use crate::amr::{IndexBox, MOST_LEVELS};
use crate::error::ReadError;

/// Types of files that hold meshes of several levels or boxes.
pub(crate) const TYPES: [&str; 4] =
    ["vtkOverlappingAMR", "vtkHierarchicalBoxDataSet", "vtkNonOverlappingAMR", "vtkMultiBlockDataSet"];
/// How many of them are read.
const READ: usize = 2;
/// Longest file that is read, in bytes: some hundred thousand boxes.
const MOST_TEXT: u64 = 64 << 20;

/// What a file says.
#[derive(Debug, Default)]
pub(crate) struct Hierarchy {
    /// World position of the corner with index 0.
    pub(crate) origin: Option<DVec3>,
    /// The coarsest first.
    pub(crate) levels: Vec<HierarchyLevel>,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct HierarchyLevel {
    /// World edges of a cell.
    pub(crate) spacing: Option<DVec3>,
    /// Of this level to the next.
    pub(crate) ratio: Option<u32>,
    pub(crate) pieces: Vec<PieceFile>,
}

/// A box and its file.
#[derive(Clone, Debug)]
pub(crate) struct PieceFile {
    pub(crate) cells: IndexBox,
    pub(crate) file: PathBuf,
}

/// Reads `path`.
pub(crate) fn read(path: &Path) -> Result<Hierarchy, ReadError> {
    let mut reader = Reader::from_reader(Source::open(path, MOST_TEXT)?);
    let mut hierarchy = Hierarchy::default();
    let mut level = None;
    let mut known = false;
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        let event = reader.read_event_into(&mut buffer).map_err(|e| malformed(path, &e))?;
        match &event {
            Event::Start(element) | Event::Empty(element) => {
                known |= element.name().as_ref() == "VTKFile";
                hierarchy.element(path, element, &mut level)?;
            }
            Event::End(element) if element.name().as_ref() == "Block" => level = None,
            Event::Eof => break,
            _ => {}
        }
    }
    if known { Ok(hierarchy) } else { Err(ReadError::missing(path, "VTKFile")) }
}

impl Hierarchy {
    /// Takes up an element; `block` is the level of the block that it stands in.
    fn element(
        &mut self,
        path: &Path,
        element: &BytesStart,
        block: &mut Option<usize>,
    ) -> Result<(), ReadError> {
        let element = Element { path: path.to_owned(), element };
        match element.element.name().as_ref() {
            "VTKFile" => {
                let kind = element.required("type", "VTKFile type")?;
                if !TYPES[..READ].contains(&kind.as_str()) {
                    let expected = "vtkOverlappingAMR or vtkHierarchicalBoxDataSet";
                    return Err(ReadError::unsupported(path, "this VTK data set", expected, kind));
                }
            }
            "vtkOverlappingAMR" | "vtkHierarchicalBoxDataSet" => {
                self.origin = element.three("origin")?;
                if let Some(axes) = element.get("grid_description")?.filter(|axes| axes != "XYZ") {
                    let (feature, expected) = ("a mesh of fewer dimensions", "grid_description=\"XYZ\"");
                    return Err(ReadError::unsupported(path, feature, expected, axes));
                }
            }
            "RefinementRatio" => {
                let ratio = element.parsed("refinement")?;
                self.level(path, element.parsed("level")?)?.1.ratio = ratio;
            }
            "Block" => {
                let (spacing, ratio) = (element.three("spacing")?, element.parsed("refinement_ratio")?);
                let (number, level) = self.level(path, element.parsed("level")?)?;
                (level.spacing, level.ratio) = (spacing, ratio.or(level.ratio));
                *block = Some(number);
            }
            "DataSet" => {
                let number = block.map_or_else(|| element.parsed("group"), |level| Ok(Some(level)))?;
                let piece = piece(path, &element)?;
                self.level(path, number)?.1.pieces.push(piece);
            }
            _ => {}
        }
        Ok(())
    }

    /// The level with this number, which is made if need be.
    fn level(
        &mut self,
        path: &Path,
        number: Option<usize>,
    ) -> Result<(usize, &mut HierarchyLevel), ReadError> {
        let number = number.ok_or_else(|| ReadError::missing(path, "level"))?;
        if number >= MOST_LEVELS {
            return Err(ReadError::field(path, "level", "fewer than 30", number));
        }
        let count = self.levels.len().max(number + 1);
        self.levels.resize(count, HierarchyLevel::default());
        Ok((number, &mut self.levels[number]))
    }
}

/// A `DataSet`.
fn piece(path: &Path, element: &Element) -> Result<PieceFile, ReadError> {
    let corners = element.extent("amr_box", "amr_box")?;
    let cells = IndexBox::new(corners.map(|[low, _]| low), corners.map(|[_, high]| high));
    let cells = cells.ok_or_else(|| {
        let expected = "a box of cells, xmin xmax ymin ymax zmin zmax";
        ReadError::field(path, "amr_box", expected, format!("{corners:?}"))
    })?;
    let file = element.required("file", "DataSet file")?;
    // A path beginning at the root stays as it is.
    Ok(PieceFile { cells, file: path.parent().unwrap_or(Path::new("")).join(file) })
}
