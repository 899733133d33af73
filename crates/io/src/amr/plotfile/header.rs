//! The file `Header` of a plotfile.

use std::path::{Component, Path, PathBuf};

use super::notation::Notation;
use crate::amr::kind::PLOTFILE_MAGIC;
use crate::amr::levels::check_ratio;
use crate::amr::{IndexBox, MOST_LEVELS};
use crate::error::ReadError;
use crate::lines::{HeaderLines, numbers};

/// Longest `Header` or `Cell_H` that is read, in bytes: some ten million boxes.
pub(super) const MOST_TEXT: u64 = 1 << 30;

/// What the `Header` says.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) components: Vec<String>,
    pub(super) levels: Vec<HeaderLevel>,
    /// World position of the domain's lowest and highest corner.
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
}

/// World position of the low and the high corner of a box, one axis after the other.
type Place = [[f64; 2]; 3];

/// What it says of one level.
#[derive(Debug)]
pub(super) struct HeaderLevel {
    /// Of this level to the next; none at the finest.
    pub(super) ratio: Option<u32>,
    pub(super) domain: IndexBox,
    /// Edges of a cell.
    pub(super) cell: [f64; 3],
    /// Where each box is.
    pub(super) places: Vec<Place>,
    /// The files of the level, for instance `Level_0/Cell`.
    pub(super) files: PathBuf,
}

/// Reads the file at `path`.
pub(super) fn read(path: &Path) -> Result<Header, ReadError> {
    Reader { path, lines: HeaderLines::open_within(path, MOST_TEXT)? }.read()
}

struct Reader<'a> {
    path: &'a Path,
    lines: HeaderLines,
}

impl Reader<'_> {
    fn read(&mut self) -> Result<Header, ReadError> {
        let path = self.path;
        let first = self.lines.required("HyperCLaw-V1.1")?;
        let version = PLOTFILE_MAGIC.iter().find_map(|magic| first.trim().strip_prefix(magic));
        if version != Some("1.1") {
            return Err(ReadError::field(path, "first line", "HyperCLaw-V1.1 or NavierStokes-V1.1", first));
        }
        let components: u64 = self.number("number of components")?;
        // The file must hold so many lines.
        let mut names = Vec::new();
        for _ in 0..components {
            names.push(self.lines.required("the name of a component")?.trim().to_owned());
        }
        let dimensions: u32 = self.number("number of dimensions")?;
        if dimensions != 3 {
            let feature = "a plotfile of fewer dimensions";
            return Err(ReadError::unsupported(path, feature, "3 dimensions", dimensions));
        }
        let _time: f64 = self.number("time")?;
        let finest: usize = self.number("finest level")?;
        if finest >= MOST_LEVELS {
            return Err(ReadError::field(path, "finest level", "fewer than 30", finest));
        }
        let low = self.three("lowest corner of the domain")?;
        let high = self.three("highest corner of the domain")?;
        let mut levels = self.levels(finest)?;
        let coordinates: u32 = self.number("coordinate system")?;
        if coordinates != 0 {
            let expected = "0, Cartesian";
            return Err(ReadError::unsupported(path, "this coordinate system", expected, coordinates));
        }
        let _border: i64 = self.number("width of the border")?;
        for number in 0..=finest {
            let (places, files) = self.level(number)?;
            (levels[number].places, levels[number].files) = (places, files);
        }
        Ok(Header { components: names, levels, low, high })
    }

    /// The lines with a value for each level: ratios, domains, steps, edges of cells.
    fn levels(&mut self, finest: usize) -> Result<Vec<HeaderLevel>, ReadError> {
        let path = self.path;
        let mut line = self.lines.required("the refinement ratios")?;
        let mut ratios = Vec::new();
        // Some writers leave away the line of the ratios where there are none.
        if finest > 0 || !line.trim_start().starts_with("((") {
            ratios = self::ratios(path, &line, finest)?;
            line = self.lines.required("the domains")?;
        }
        let mut domains = Notation::new(&line);
        let mut levels: Vec<HeaderLevel> = Vec::new();
        for number in 0..=finest {
            let domain = domains.typed_box().and_then(|b| b.cells()).ok_or_else(|| {
                let expected = "a box of cells for each level, ((0,0,0) (15,15,31) (0,0,0))";
                ReadError::field(path, "domain", expected, domains.rest())
            })?;
            let ratio = ratios.get(number).copied();
            if let Some(coarse) = levels.last() {
                let refined = coarse.ratio.and_then(|r| coarse.domain.refine(r));
                if refined != Some(domain) {
                    let expected = match refined {
                        Some(cells) => format!("that of the coarser one, refined: {cells}"),
                        None => "fewer than 2^30 cells along each axis".to_owned(),
                    };
                    return Err(ReadError::mesh(path, format!("domain of level {number}"), expected, domain));
                }
            }
            let (cell, places, files) = ([0.0; 3], Vec::new(), PathBuf::new());
            levels.push(HeaderLevel { ratio, domain, cell, places, files });
        }
        let _steps = self.lines.required("the steps of the levels")?;
        for level in &mut levels {
            level.cell = self.three("edges of a cell")?;
        }
        Ok(levels)
    }

    /// Where the boxes of level `number` are, and its files.
    fn level(&mut self, number: usize) -> Result<(Vec<Place>, PathBuf), ReadError> {
        let path = self.path;
        let line = self.lines.required("the number of boxes of a level")?;
        let mut words = line.split_whitespace().map(str::parse::<u64>);
        let (Some(Ok(found)), Some(Ok(boxes))) = (words.next(), words.next()) else {
            return Err(ReadError::field(
                path,
                "level",
                "its number, its number of boxes and its time",
                line,
            ));
        };
        if found != number as u64 || boxes == 0 {
            let expected = format!("level {number} with at least one box");
            return Err(ReadError::mesh(path, "boxes of a level", expected, format!("'{line}'")));
        }
        let _steps = self.lines.required("the step of a level")?;
        // The file must hold so many lines.
        let mut places = Vec::new();
        for _ in 0..boxes {
            let mut place = [[0.0; 2]; 3];
            for axis in &mut place {
                let line = self.lines.required("the place of a box")?;
                *axis = numbers(path, "place of a box", "two numbers for each axis", &line)?;
            }
            places.push(place);
        }
        let line = self.lines.required("the files of a level")?;
        let files = PathBuf::from(line.trim());
        if !is_inside(&files) {
            return Err(ReadError::field(path, "files of a level", "a path inside the plotfile", line));
        }
        Ok((places, files))
    }

    fn number<T: std::str::FromStr>(&mut self, field: &'static str) -> Result<T, ReadError> {
        let line = self.lines.required(field)?;
        line.trim().parse().map_err(|_| ReadError::field(self.path, field, "a number", line))
    }

    fn three(&mut self, field: &'static str) -> Result<[f64; 3], ReadError> {
        let line = self.lines.required(field)?;
        numbers(self.path, field, "three numbers", &line)
    }
}

/// Whether a path leads to a file below the folder that it starts from.
pub(super) fn is_inside(path: &Path) -> bool {
    let mut parts = path.components().filter(|part| *part != Component::CurDir).peekable();
    parts.peek().is_some() && parts.all(|part| matches!(part, Component::Normal(_)))
}

/// The ratio of each level but the finest; the list may go on.
fn ratios(path: &Path, line: &str, finest: usize) -> Result<Vec<u32>, ReadError> {
    let mut list = Notation::new(line);
    let mut ratios = Vec::new();
    for level in 0..finest {
        let ratio = if list.rest().starts_with('(') { list.vector() } else { list.number().map(|n| vec![n]) };
        let ratio = ratio.ok_or_else(|| {
            let expected = "one for each level but the finest";
            ReadError::field(path, "refinement ratios", expected, line)
        })?;
        if ratio.len() != 1 && ratio.len() != 3 {
            let expected = "one or three numbers for each level";
            return Err(ReadError::field(path, "refinement ratios", expected, line));
        }
        ratios.push(check_ratio(path, level, &ratio)?);
    }
    Ok(ratios)
}
