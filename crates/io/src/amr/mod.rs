//! Meshes of several levels.

mod hexahedra;
mod kind;
mod levels;
mod pieces;
mod plotfile;

use std::path::{Path, PathBuf};

use glam::DAffine3;
use isoray_amr::{Centering, Patch, Patches, Values};

use self::hexahedra::Hexahedra;
use self::kind::Kind;
pub(crate) use self::levels::{IndexBox, MOST_LEVELS};
use self::pieces::Pieces;
use self::plotfile::Plotfile;
use crate::decode::open_at;
use crate::error::{ReadError, Warning, listed};
use crate::sample::Losses;

/// A field of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AmrField {
    /// Its name; one component of an array with several is called `NAME:0`, `NAME:1`, ….
    pub name: String,
    /// Where its values are.
    pub centering: Centering,
    /// The file says that it is the one to look at.
    active: bool,
}

/// One level of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AmrLevel {
    /// Cells of the next finer level along the edge of one of this level; none at the finest.
    pub ratio: Option<u32>,
    /// Boxes of cells.
    pub boxes: usize,
    /// Cells in them; those that finer levels cover count, too.
    pub cells: u64,
}

/// A mesh whose headers have been read and checked, and whose values have not been read.
///
/// What a file says is checked, not whether boxes overlap, cut coarse cells or leave gaps.
#[derive(Clone, Debug)]
pub struct AmrDataset {
    path: PathBuf,
    outline: Outline,
    source: Source,
}

/// A mesh without its values.
#[derive(Clone, Debug)]
struct Outline {
    format: &'static str,
    fields: Vec<AmrField>,
    levels: Vec<AmrLevel>,
    /// In cells of level 0.
    domain: IndexBox,
    index_to_world: DAffine3,
}

/// Where the values are.
#[derive(Clone, Debug)]
enum Source {
    Plotfile(Plotfile),
    Pieces(Pieces),
    Hexahedra(Hexahedra),
}

impl AmrDataset {
    /// Whether `path` is a file or folder with a mesh of several levels, as far as its first bytes or the names in it tell.
    ///
    /// Enzo and RAMSES output counts, although [`open`](Self::open) only says that it is not read yet.
    pub fn recognises(path: &Path) -> bool {
        kind::kind(path).is_some()
    }

    /// Reads and checks the headers of a plotfile (its folder, or the `Header` in it), a VTK overlapping AMR file
    /// or legacy VTK hexahedra; of the last also points and cells.
    ///
    /// # Errors
    /// A file that cannot be read, holds no mesh, contradicts itself, or is shorter than it says; a file that is
    /// missing; a mesh that is not three-dimensional, or refined by another ratio than 2 or 4; boxes outside the
    /// domain that the file states; a hexahedron that is no cube of an octree.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let not_yet = |format| Err(ReadError::NotYet { path: path.to_owned(), format });
        let (outline, source) = match kind::kind(path) {
            Some(Kind::Plotfile(folder)) => {
                let (outline, plotfile) = Plotfile::open(&folder)?;
                (outline, Source::Plotfile(plotfile))
            }
            Some(Kind::Hierarchy) => {
                let (outline, pieces) = Pieces::open(path)?;
                (outline, Source::Pieces(pieces))
            }
            Some(Kind::Hexahedra) => {
                let (outline, hexahedra) = Hexahedra::open(path)?;
                (outline, Source::Hexahedra(hexahedra))
            }
            Some(Kind::Enzo) => return not_yet("Enzo output"),
            Some(Kind::Ramses) => return not_yet("RAMSES output"),
            None => {
                // A file that is not there gets that error.
                open_at(path, 0)?;
                return Err(ReadError::NoMesh { path: path.to_owned() });
            }
        };
        Ok(Self { path: path.to_owned(), outline, source })
    }

    /// Name of the format, for reports.
    pub fn format(&self) -> &str {
        self.outline.format
    }

    /// The file or folder that was opened.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The fields of which one can be read.
    pub fn fields(&self) -> &[AmrField] {
        &self.outline.fields
    }

    /// The coarsest level first.
    pub fn levels(&self) -> &[AmrLevel] {
        &self.outline.levels
    }

    /// The map from coordinates of level 0, in which its cells are unit cubes, to the world of the file.
    pub fn index_to_world(&self) -> DAffine3 {
        self.outline.index_to_world
    }

    /// The box of level 0: its lowest cell, and the number of its cells along each axis.
    pub fn domain(&self) -> ([i32; 3], [u32; 3]) {
        (self.outline.domain.low(), self.outline.domain.size())
    }

    /// The field called `name`; without a name the active one, else the only one.
    ///
    /// # Errors
    /// A name that the file does not have, or several fields and no choice; both list the names.
    pub fn field(&self, name: Option<&str>) -> Result<&AmrField, ReadError> {
        Ok(&self.outline.fields[self.choose(name)?])
    }

    fn choose(&self, name: Option<&str>) -> Result<usize, ReadError> {
        let fields = &self.outline.fields;
        let names = || listed(fields.iter().map(|f| f.name.as_str()));
        let path = || self.path.clone();
        if let Some(name) = name {
            let none = || ReadError::NoSuchField { path: path(), chosen: name.to_owned(), names: names() };
            return fields.iter().position(|f| f.name == name).ok_or_else(none);
        }
        let mut active = (0..fields.len()).filter(|&i| fields[i].active);
        match (active.next(), active.next()) {
            (Some(field), None) => Ok(field),
            _ if fields.len() == 1 => Ok(0),
            _ => Err(ReadError::ChooseField { path: path(), names: names() }),
        }
    }

    /// Reads the values of a field, chosen as [`field`](Self::field) does, on all levels.
    ///
    /// # Errors
    /// As [`field`](Self::field); also values that are missing, too few, or cannot be decoded.
    pub fn read(&self, field: Option<&str>) -> Result<Patches, ReadError> {
        self.read_with_warnings(field).map(|(patches, _)| patches)
    }

    /// [`read`](Self::read), and what the user should know: how many values lost digits in the conversion to `f32`.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn read_with_warnings(&self, field: Option<&str>) -> Result<(Patches, Vec<Warning>), ReadError> {
        let chosen = self.choose(field)?;
        let mut losses = Losses::default();
        let patches = match &self.source {
            Source::Plotfile(plotfile) => plotfile.read(chosen, &mut losses)?,
            Source::Pieces(pieces) => pieces.read(chosen, &mut losses)?,
            Source::Hexahedra(hexahedra) => hexahedra.read(&self.path, chosen, &mut losses)?,
        };
        let patches = Patches {
            centering: self.outline.fields[chosen].centering,
            ratios: self.outline.levels.iter().filter_map(|l| l.ratio).collect(),
            index_to_world: self.outline.index_to_world,
            domain: self.domain(),
            patches,
        };
        Ok((patches, losses.warnings(&self.path)))
    }
}

/// A patch of `cells`.
fn patch(level: usize, cells: &IndexBox, values: Values) -> Patch {
    // There are at most `MOST_LEVELS`.
    Patch { level: level as u32, low: cells.low(), cells: cells.size(), values }
}

/// Most components of an array that become fields; a tensor has nine.
const MOST_COMPONENTS: u64 = 64;

/// The names of the fields that the components of an array become, and the number of each.
fn component_names(array: &str, components: u64) -> Vec<(String, usize)> {
    match components {
        1 => vec![(array.to_owned(), 0)],
        // A bound, so that a header's number makes no list of any length.
        n => (0..n.min(MOST_COMPONENTS) as usize).map(|i| (format!("{array}:{i}"), i)).collect(),
    }
}
